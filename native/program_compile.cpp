// SPDX-License-Identifier: GPL-3.0-or-later
// One shader to the programs of its three parts: surface, emission, transparency.
// Values are folded and shared in program_graph.cpp; instructions are written in program_writer.cpp.
#include "program_compile.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include "../kernels/program/ops.h"
#include "../kernels/program/table_ops.h"
#include "program_graph.h"
#include "program_writer.h"

namespace cotorra {
namespace {

using Value = ProgramGraph::Value;

// ---- Checks

[[noreturn]] void fail(const ShaderInput &in, const std::string &what) {
  throw std::invalid_argument("shader '" + in.name + "': " + what);
}

// ---- Reading

// A closure of the surface whose weight is not 0.
struct Closure {
  uint kind;
  uint mode;
  Value weight;
  std::vector<Value> arguments;
  std::optional<Value> own_normal;
  uint row;  // of the shader's closures
};

class Compiler {
 public:
  Compiler(const ShaderInput &in, std::span<const char> opaque_images)
      : in_(in), opaque_images_(opaque_images), graph_(in.tables) {}

  CompiledShader compile(ProgramLibrary &library) {
    read_values();
    read_closures();
    split();
    CompiledShader out;
    out.program.constants = static_cast<uint>(library.constants.size());
    out.grey = grey_;
    ProgramWriter writer(in_, graph_, library, out);
    if (graph_.is_constant(transparency_) && out.grey) {  // what has a colour is a program's in any case
      out.transparency = graph_[transparency_].constant;
    } else {
      out.program.transparency = writer.value(transparency_);
      out.transparency_needs = writer.needs();
      if (!out.transparency_needs.point) out.program.flags |= PROGRAM_PLACE;
      notes_.transparency_sources = writer.sources();
    }
    if (graph_.is_constant(emission_)) {
      out.emission = graph_[emission_].constant;
    } else {
      out.program.emission = writer.value(emission_);
      out.emission_needs = writer.needs();
      notes_.emission_sources = writer.sources();
      find_dark_sides(out);
    }
    out.surface = plain_surface();
    if (!out.grey) out.surface.plain = false;  // one of the things that a ray may do here is to go on
    for (const Closure &c : surface_) {
      out.lobes |= 1u << c.kind;
      out.sharp |= is_sharp(c) || c.own_normal.has_value();  // a bent normal hides lamps that bounces find
      out.asks_lobes |= asks_lobe(c);
      out.transmits |= transmits(c);
    }
    if (!out.surface.plain) write_surface(writer, out);
    out.notes = std::move(notes_);
    library.tables.insert(library.tables.end(), in_.tables.begin(), in_.tables.end());
    return out;
  }

 private:
  Value value_of(int reference) const {
    if (reference >= 0) return values_[static_cast<std::size_t>(reference)];
    return constants_[static_cast<std::size_t>(~reference)];
  }
  // A reference to one of the values before number `before`, or to a constant.
  void check(int reference, std::size_t before, const char *what) const {
    const bool good = reference >= 0 ? static_cast<std::size_t>(reference) < before
                                     : static_cast<std::size_t>(~reference) < in_.constants.size();
    if (!good) fail(in_, std::string(what) + " refers to " + std::to_string(reference) + ", which is not there");
  }

  // Ops that read tables or images: only what is there. Images that are computed are held within by the kernels.
  void check_table(const OpInfo &op, std::size_t index, std::span<const Value> arguments) const {
    const auto refuse = [&](const char *what) {
      fail(in_, "op " + std::to_string(index) + " (" + op.name + ") reads " + what);
    };
    const auto number = [&](std::size_t k) { return static_cast<double>(graph_[arguments[k]].constant.x); };
    const bool known = graph_.is_constant(arguments[1]);
    if (op.number >= OP_IMAGE_V && op.number <= OP_ENVIRONMENT_V) {
      const double images = static_cast<double>(opaque_images_.size());
      if (images == 0.0 || (known && !(number(1) >= 0.0 && number(1) < images))) refuse("an image that is not there");
      return;
    }
    const bool ramp = op.number == OP_RAMP_V || op.number == OP_RAMP_ALPHA;
    const bool ies = op.number == OP_IES_F;
    const bool sized = (!ramp && !ies) || graph_.is_constant(arguments[2]);
    if (!known || !sized || (ies && !graph_.is_constant(arguments[3]))) refuse("a table whose place is no constant");
    double size = op.number == OP_CURVE_F ? CURVE_ENTRIES : 3.0 * CURVE_ENTRIES;
    if (ramp) size = 4.0 * number(2);
    if (ies)
      size = number(2) < 2.0 || number(3) < 2.0 ? 0.0 : number(2) + number(3) + (number(2) + 2.0) * (number(3) + 2.0);
    const bool inside = number(1) >= 0.0 && size >= 1.0 && number(1) + size <= static_cast<double>(in_.tables.size());
    if (!inside) refuse("beyond its tables");
  }

  // Alpha of an image that has no holes, wherever it is read.
  bool is_one(const OpInfo &op, uint mode, std::span<const Value> arguments) const {
    if (op.number != OP_IMAGE_F || ((mode >> 2) & 3u) == EXTENSION_CLIP || !graph_.is_constant(arguments[1])) {
      return false;
    }
    return opaque_images_[static_cast<std::size_t>(graph_[arguments[1]].constant.x)] != 0;
  }

  void read_values() {
    // NaN would spread through the whole picture; what is beyond the range of colours is held back.
    for (vec3 c : in_.constants) {
      const auto finite = [](float x) { return std::isnan(x) ? 0.0f : std::clamp(x, -3e38f, 3e38f); };
      constants_.push_back(graph_.constant(vec3(finite(c.x), finite(c.y), finite(c.z))));
    }
    if (in_.modes.size() != in_.ops.size()) fail(in_, "ops and modes differ in length");
    std::size_t next = 0;
    for (std::size_t i = 0; i < in_.ops.size(); ++i) {
      const OpInfo *op = find_op(in_.ops[i]);
      if (op == nullptr) fail(in_, "ops[" + std::to_string(i) + "] = " + std::to_string(in_.ops[i]) + " is no op");
      if (next + op->arguments.size() > in_.args.size()) fail(in_, "args end within op " + std::to_string(i));
      std::vector<Value> arguments;
      for (const char type : op->arguments) {
        check(in_.args[next], i, op->name);
        Value v = value_of(in_.args[next++]);
        // A constant of an argument that is one number is that number, however it came.
        if (type == 'f' && graph_.is_constant(v)) v = graph_.constant(graph_[v].constant.x);
        if (!graph_.is_constant(v) && graph_.is_vector(v) != (type == 'v')) {
          fail(in_, "op " + std::to_string(i) + " (" + op->name + ") takes an argument of the other type");
        }
        arguments.push_back(v);
      }
      if (op->table) check_table(*op, i, arguments);
      const bool one = is_one(*op, in_.modes[i], arguments);
      values_.push_back(one ? graph_.constant(1.0f) : graph_.op(op->number, in_.modes[i], std::move(arguments)));
      if (!graph_.is_constant(values_.back())) {
        graph_.set_source(values_.back(), i);
      } else {
        notes_.folded.push_back({static_cast<uint>(i), graph_[values_.back()].constant});
      }
    }
  }

  void read_closures() {
    for (std::size_t i = 0; i < in_.closures.size(); ++i) {
      const ShaderInput::Closure &row = in_.closures[i];
      if (row.kind >= CLOSURE_KINDS) fail(in_, "a closure is of kind " + std::to_string(row.kind));
      const ClosureInfo &info = program_closures()[row.kind];
      const std::string types = info.arguments;
      std::size_t next = row.first_argument;
      if (next + types.size() > in_.closure_args.size()) fail(in_, "closure_args end within a closure");
      check(row.weight, values_.size(), info.name);
      Closure c{info.kind, row.mode, value_of(row.weight), {}, {}, static_cast<uint>(i)};
      if (!graph_.is_constant(c.weight) && !graph_.is_vector(c.weight)) c.weight = graph_.splat(c.weight);
      for (const char type : types) {
        check(in_.closure_args[next], values_.size(), info.name);
        Value v = value_of(in_.closure_args[next++]);
        if (type == 'f' && graph_.is_constant(v)) v = graph_.constant(graph_[v].constant.x);
        if (!graph_.is_constant(v) && graph_.is_vector(v) != (type == 'v')) {
          fail(in_, std::string("closure ") + info.name + " takes an argument of the other type");
        }
        c.arguments.push_back(v);
      }
      if ((row.mode & CLOSURE_BENT_NORMAL) != 0) {
        if (next == in_.closure_args.size()) fail(in_, "closure_args end within a closure");
        check(in_.closure_args[next], values_.size(), info.name);
        c.own_normal = value_of(in_.closure_args[next]);
        if (graph_.is_constant(*c.own_normal) || !graph_.is_vector(*c.own_normal)) {
          fail(in_, "a surface's own normal is no computed vector");
        }
      }
      if (is_nothing(c.weight)) {
        notes_.dropped.push_back({c.row, 0});
      } else if (is_black(c)) {
        notes_.dropped.push_back({c.row, 2});
      } else {
        closures_.push_back(std::move(c));
      }
    }
  }

  // Many set up lights that shine to one side, by Geometry's Backfacing.
  void find_dark_sides(CompiledShader &out) {
    const Value front = graph_.with(emission_, OP_BACKFACING, vec3(0.0f));
    const Value back = graph_.with(emission_, OP_BACKFACING, vec3(1.0f));
    if (is_nothing_at_all(front)) out.dark |= MATERIAL_FRONT_DARK;
    if (is_nothing_at_all(back)) out.dark |= MATERIAL_BACK_DARK;
    const Value lit = (out.dark & MATERIAL_FRONT_DARK) != 0 ? back : front;
    if (out.dark == 0 || !graph_.is_constant(lit)) return;
    out.lit_evenly = true;
    out.lit = graph_[lit].constant;
  }

  bool is_nothing_at_all(Value v) const { return graph_.is_constant(v, 0.0f); }

  // A closure that reflects or lets through nothing of what arrives, since its colour is black.
  bool is_black(const Closure &c) const {
    return (c.kind == CLOSURE_DIFFUSE || c.kind == CLOSURE_TRANSLUCENT) && is_nothing(c.arguments[0]);
  }

  bool is_nothing(Value weight) const {
    if (!graph_.is_constant(weight)) return false;
    const vec3 w = graph_[weight].constant;
    return !(std::max({w.x, w.y, w.z}) > 0.0f);
  }

  // All values where what mixes closures, and is neither a constant nor computed from such, is 0, 1 or a number
  // between, drawn at random. Of colours the first component.
  std::vector<float> tried(std::minstd_rand &random) const {
    std::vector<float> values(graph_.size());
    for (std::size_t v = 0; v < values.size(); ++v) {
      const ProgramGraph::Node &n = graph_[static_cast<Value>(v)];
      const auto argument = [&](std::size_t k) { return values[static_cast<std::size_t>(n.arguments[k])]; };
      const float drawn = static_cast<float>(random() % 1024u) / 1023.0f;
      values[v] = drawn < 0.3f ? 0.0f : drawn > 0.7f ? 1.0f : drawn;
      if (n.op == nullptr) {
        values[v] = n.constant.x;
      } else if (n.op->number == OP_SPLAT) {
        values[v] = argument(0);
      } else if (n.op->number == OP_CLAMP_F) {
        values[v] = std::min(std::max(argument(0), argument(1)), argument(2));
      } else if (n.op->number == OP_MATH || n.op->number == OP_VECTOR_MATH_V) {
        if (n.mode == MATH_ADD) values[v] = argument(0) + argument(1);
        if (n.mode == MATH_SUBTRACT) values[v] = argument(0) - argument(1);
        if (n.mode == MATH_MULTIPLY) values[v] = argument(0) * argument(1);
      }
    }
    return values;
  }

  // May all be let through where another closure keeps a weight, as Add Shader can make it? Weights are sums and
  // products of mix factors, so that a few tries tell.
  bool keeps_beside_all() const {
    if (graph_.is_constant(transparency_) && graph_[transparency_].constant.x < 1.0f) return false;
    std::vector<Value> kept;
    for (const Closure &c : surface_) kept.push_back(c.weight);
    for (const Closure &c : closures_) {
      if (c.kind == CLOSURE_EMISSION) kept.push_back(c.weight);
    }
    std::minstd_rand random;
    for (int k = 0; k < 64 && !kept.empty(); ++k) {
      const std::vector<float> values = tried(random);
      float most = 0.0f;
      for (const Value w : kept) most = std::max(most, values[static_cast<std::size_t>(w)]);
      if (values[static_cast<std::size_t>(transparency_)] + most > 1.001f && most > 0.0f) return true;
    }
    return false;
  }

  bool traces_rays(Value v) const {
    std::vector<char> met(graph_.size(), 0);
    std::vector<Value> waiting{v};
    while (!waiting.empty()) {
      const Value at = waiting.back();
      waiting.pop_back();
      if (std::exchange(met[static_cast<std::size_t>(at)], 1) != 0 || graph_.is_constant(at)) continue;
      if (program_group(graph_[at].op->number) == GROUP_RAYS) return true;
      waiting.insert(waiting.end(), graph_[at].arguments.begin(), graph_[at].arguments.end());
    }
    return false;
  }

  // Does the share that is not let through say how much of the surface is there? Not where what is let through has a
  // colour, nor where it may be all while others are there, too.
  bool hides_what_it_keeps() const { return graph_.is_grey(transparency_) && !keeps_beside_all(); }

  // Takes emission and what lies behind out of the closures, and leaves the lobes.
  void split() {
    emission_ = transparency_ = graph_.constant(0.0f);
    for (Closure c : closures_) {
      switch (c.kind) {
        case CLOSURE_EMISSION:
          emission_ = graph_.add(emission_, graph_.multiply(c.weight, c.arguments[0]));
          break;
        case CLOSURE_TRANSPARENT:
          transparency_ = graph_.add(transparency_, graph_.multiply(c.weight, c.arguments[0]));
          break;
        case CLOSURE_PRINCIPLED: {
          const Value alpha = graph_.splat(graph_.saturate(c.arguments[PRINCIPLED_ALPHA]));
          const Value clear = graph_.subtract(graph_.constant(1.0f), alpha);
          transparency_ = graph_.add(transparency_, graph_.multiply(c.weight, clear));
          c.weight = graph_.multiply(c.weight, alpha);
          emission_ = graph_.add(emission_, graph_.multiply(c.weight, emitted(c)));
          if (is_nothing(c.weight)) {
            notes_.dropped.push_back({c.row, 1});
          } else {
            surface_.push_back(std::move(c));
          }
          break;
        }
        default:
          surface_.push_back(std::move(c));
      }
    }
    // What asks rays is asked where the surface is shaded, since Embree's filters trace none.
    grey_ = hides_what_it_keeps() && !traces_rays(transparency_);
    if (!grey_ || is_nothing(transparency_)) return;
    // Rays are let through before the surface is shaded: what it does, it does with the share that is stopped.
    const Value opacity = graph_.subtract(graph_.constant(1.0f), transparency_);
    const auto of_opacity = [&](Value v) {
      if (is_nothing(v)) return v;
      return v == opacity ? graph_.constant(1.0f) : graph_.divide(v, opacity);
    };
    emission_ = of_opacity(emission_);
    for (Closure &c : surface_) c.weight = of_opacity(c.weight);
  }

  // What a Principled closure emits, through its sheen and coat.
  Value emitted(const Closure &c) {
    const auto a = [&c](uint k) { return c.arguments[k]; };
    const Value emission = a(PRINCIPLED_EMISSION);
    const auto none = [&](uint k) { return graph_.is_constant(a(k)) && !(number(c, k) > 0.0f); };
    if (is_nothing(emission) || (none(PRINCIPLED_COAT) && none(PRINCIPLED_SHEEN))) return emission;
    const Value through = graph_.op(OP_LAYERS, 0,
                                    {a(PRINCIPLED_COAT), a(PRINCIPLED_COAT_ROUGHNESS), a(PRINCIPLED_COAT_IOR),
                                     a(PRINCIPLED_COAT_TINT), a(PRINCIPLED_COAT_NORMAL), a(PRINCIPLED_SHEEN),
                                     a(PRINCIPLED_SHEEN_ROUGHNESS), a(PRINCIPLED_SHEEN_TINT), a(PRINCIPLED_NORMAL)});
    return graph_.multiply(emission, through);
  }

  // ---- A surface of constants

  bool all_constant(const Closure &c, std::initializer_list<uint> arguments) const {
    return std::all_of(arguments.begin(), arguments.end(), [&](uint k) { return graph_.is_constant(c.arguments[k]); });
  }
  bool is_smooth_normal(Value v) const { return !graph_.is_constant(v) && graph_[v].op->number == OP_NORMAL; }
  float number(const Closure &c, uint k) const { return graph_[c.arguments[k]].constant.x; }
  vec3 color(const Closure &c, uint k) const { return graph_[c.arguments[k]].constant; }

  // Does a Principled closure do without all that Material has no place for?
  bool is_simple(const Closure &c) const {
    for (const uint k :
         {PRINCIPLED_DIFFUSE_ROUGHNESS, PRINCIPLED_SUBSURFACE, PRINCIPLED_ANISOTROPIC, PRINCIPLED_TRANSMISSION,
          PRINCIPLED_COAT, PRINCIPLED_SHEEN, PRINCIPLED_FILM_THICKNESS, PRINCIPLED_THIN_WALL}) {
      if (!graph_.is_constant(c.arguments[k]) || number(c, k) > 0.0f) return false;
    }
    return true;
  }

  bool asks_lobe(const Closure &c) const {
    if (c.kind == CLOSURE_PRINCIPLED) return !is_simple(c);
    if (c.kind == CLOSURE_DIFFUSE) return !graph_.is_constant(c.arguments[1], 0.0f);
    return c.kind != CLOSURE_HOLDOUT;
  }

  // May it send light through the surface, bent or scattered?
  bool transmits(const Closure &c) const {
    if (c.kind != CLOSURE_PRINCIPLED) {
      return c.kind == CLOSURE_GLASS || c.kind == CLOSURE_REFRACTION || c.kind == CLOSURE_TRANSLUCENT;
    }
    const auto some = [&](uint k) { return !graph_.is_constant(c.arguments[k]) || number(c, k) > 0.0f; };
    return some(PRINCIPLED_TRANSMISSION) || (some(PRINCIPLED_THIN_WALL) && some(PRINCIPLED_SUBSURFACE));
  }

  PlainSurface plain_surface() const {
    PlainSurface s;
    if (surface_.empty()) {  // it only emits or lets through: a diffuse black
      s.plain = true;
      s.base_color = vec3(0.0f);
      s.ior = 1.0f;
      s.specular_level = 0.0f;
      s.roughness = 1.0f;
      return s;
    }
    const Closure &c = surface_.front();
    if (surface_.size() > 1) return s;
    if (c.kind == CLOSURE_GLASS) s.transmission = 1.0f;
    if (c.kind == CLOSURE_PRINCIPLED && graph_.is_constant(c.arguments[PRINCIPLED_TRANSMISSION])) {
      s.transmission = std::clamp(number(c, PRINCIPLED_TRANSMISSION), 0.0f, 1.0f);
    }
    if (c.kind == CLOSURE_DIFFUSE) {
      if (!all_constant(c, {0, 1}) || number(c, 1) > 0.0f || !is_smooth_normal(c.arguments[2])) return s;
      if (!graph_.is_constant(c.weight)) return s;
      s.plain = true;
      s.base_color = max(color(c, 0), vec3(0.0f)) * graph_[c.weight].constant;
      s.ior = 1.0f;
      s.specular_level = 0.0f;
      s.roughness = 1.0f;
      return s;
    }
    if (c.kind != CLOSURE_PRINCIPLED || !graph_.is_constant(c.weight, 1.0f)) return s;
    if (!is_simple(c) || !is_smooth_normal(c.arguments[PRINCIPLED_NORMAL])) return s;
    s.plain = all_constant(c, {PRINCIPLED_BASE, PRINCIPLED_METALLIC, PRINCIPLED_ROUGHNESS, PRINCIPLED_IOR,
                               PRINCIPLED_SPECULAR_LEVEL, PRINCIPLED_SPECULAR_TINT});
    if (!s.plain) return s;
    // Clamped as Cycles does.
    s.base_color = max(color(c, PRINCIPLED_BASE), vec3(0.0f));
    s.metallic = clamp(number(c, PRINCIPLED_METALLIC), 0.0f, 1.0f);
    s.roughness = clamp(number(c, PRINCIPLED_ROUGHNESS), 0.0f, 1.0f);
    s.ior = std::max(number(c, PRINCIPLED_IOR), 1e-5f);
    s.specular_level = std::max(number(c, PRINCIPLED_SPECULAR_LEVEL), 0.0f);
    s.specular_tint = max(color(c, PRINCIPLED_SPECULAR_TINT), vec3(0.0f));
    s.multi_ggx = (c.mode & PRINCIPLED_MULTI_GGX) != 0;
    return s;
  }

  // May a lobe be narrower than a usual lamp?
  bool is_sharp(const Closure &c) const {
    const auto below = [&](std::size_t k) {
      return !graph_.is_constant(c.arguments[k]) || graph_[c.arguments[k]].constant.x < 0.25f;
    };
    switch (c.kind) {
      case CLOSURE_GLOSSY:
      case CLOSURE_GLASS:
      case CLOSURE_REFRACTION:
        return below(1);
      case CLOSURE_METALLIC:
        return below(4);
      case CLOSURE_PRINCIPLED:
        return below(PRINCIPLED_ROUGHNESS) ||
               (!graph_.is_constant(c.arguments[PRINCIPLED_COAT], 0.0f) && below(PRINCIPLED_COAT_ROUGHNESS));
      default:
        return false;
    }
  }

  void write_surface(ProgramWriter &writer, CompiledShader &out) {
    std::vector<ProgramWriter::Row> rows;
    for (const Closure &c : surface_) {
      rows.push_back({c.kind, c.mode, c.weight, c.arguments, c.own_normal});
      notes_.closure_sources.push_back(static_cast<int>(c.row));
    }
    // What is let through and has a colour is one of the things that a ray may do here.
    if (!out.grey) {
      rows.push_back({CLOSURE_TRANSPARENT, 0, transparency_, {graph_.constant(1.0f)}});
      notes_.closure_sources.push_back(-1);
      out.lobes |= 1u << CLOSURE_TRANSPARENT;
    }
    out.program.surface = writer.closures(rows);
    out.surface_needs = writer.needs();
    if (out.surface_needs.footprint || (out.surface_needs.groups & GROUP_RAYS) != 0u)
      out.program.flags |= PROGRAM_FOOTPRINT;
    const bool plain = rows.size() == 1 && rows[0].kind == CLOSURE_PRINCIPLED && !out.asks_lobes;
    if (plain) out.program.flags |= PROGRAM_PLAIN;
    notes_.surface_sources = writer.sources();
  }

  const ShaderInput &in_;
  std::span<const char> opaque_images_;
  ProgramGraph graph_;
  std::vector<Value> values_;
  std::vector<Value> constants_;
  std::vector<Closure> closures_;
  std::vector<Closure> surface_;
  Value emission_ = 0;
  Value transparency_ = 0;
  bool grey_ = true;  // rays are let through before the surface is shaded
  CompileNotes notes_;
};

}  // namespace

CompiledShader ProgramLibrary::add(const ShaderInput &shader) {
  CompiledShader compiled = Compiler(shader, opaque_images).compile(*this);
  return compiled;
}

}  // namespace cotorra

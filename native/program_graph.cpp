// SPDX-License-Identifier: GPL-3.0-or-later
// Makes values of a shader's graph: folds, shares, and leaves out what changes nothing.
// What the ops compute is told in kernels/program/.
#include "program_graph.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "../kernels/program/ops.h"

namespace cotorra {
namespace {

using Value = ProgramGraph::Value;

// Operation of Vector Math; and the first way to mix colours.
constexpr uint VECTOR_SCALE = 10;
constexpr uint BLEND_MIX = 0;
constexpr uint MAPPING_VECTOR = 2;  // the last of Mapping's types that are affine maps: point, texture, vector

std::vector<uint> bits_of(vec3 v) {
  return {std::bit_cast<uint>(v.x), std::bit_cast<uint>(v.y), std::bit_cast<uint>(v.z)};
}

}  // namespace

Value ProgramGraph::constant(vec3 value) {
  const auto [place, made] = known_constants_.try_emplace(bits_of(value), static_cast<Value>(nodes_.size()));
  if (made) {
    nodes_.push_back({nullptr, 0, {}, value});
    grey_.push_back(value.x == value.y && value.y == value.z ? 1 : 0);
  }
  return place->second;
}

bool ProgramGraph::is_constant(Value v, float x) const {
  const Node &n = (*this)[v];
  return n.op == nullptr && n.constant.x == x && n.constant.y == x && n.constant.z == x;
}

bool ProgramGraph::is_grey(Value v) const { return grey_[static_cast<std::size_t>(v)] != 0; }

Value ProgramGraph::op(uint number, uint mode, std::vector<Value> arguments) {
  const OpInfo &info = *find_op(number);
  // 1. A constant, where it depends on nothing else.
  const bool folds = info.pure && (number < OP_IMAGE_V || number > OP_ENVIRONMENT_V) &&
                     std::all_of(arguments.begin(), arguments.end(), [&](Value a) { return is_constant(a); });
  if (folds) {
    std::vector<float> numbers;
    for (std::size_t k = 0; k < arguments.size(); ++k) {
      const vec3 c = (*this)[arguments[k]].constant;
      numbers.push_back(c.x);
      if (info.arguments[k] == 'v') numbers.insert(numbers.end(), {c.y, c.z});
    }
    const vec3 value = program_fold(number, mode, numbers, tables_);
    return info.result == 'v' ? constant(value) : constant(value.x);
  }
  // 2. One of its arguments, where it changes nothing.
  const Value simple = simplified(number, mode, arguments);
  if (simple >= 0) return simple;
  if (number == OP_MAPPING && mode <= MAPPING_VECTOR) {
    const Value mapped = affine(mode, arguments);
    if (mapped >= 0) return mapped;
  }
  // 3. What was there before.
  std::vector<uint> key{number, mode};
  for (const Value a : arguments) key.push_back(static_cast<uint>(a));
  const auto [place, made] = known_.try_emplace(std::move(key), static_cast<Value>(nodes_.size()));
  if (made) {
    const auto grey = [&](std::size_t k) { return is_grey(arguments[k]); };
    const bool plain = number == OP_VECTOR_MATH_V && mode <= MATH_DIVIDE && grey(0) && grey(1);
    const bool mixed = (number == OP_MIX_V && grey(0) && grey(1) && grey(2)) ||
                       (number == OP_MIX_COLOR && (mode & 255u) == BLEND_MIX && grey(1) && grey(2));
    const bool is_number = info.result == 'f';
    grey_.push_back(is_number || number == OP_SPLAT || plain || mixed ? 1 : 0);
    nodes_.push_back({&info, mode, std::move(arguments)});
  }
  return place->second;
}

Value ProgramGraph::with(Value v, uint number, vec3 value) {
  const auto count = static_cast<std::size_t>(v) + 1;
  std::vector<char> asked(count, 0);
  asked.back() = 1;
  for (std::size_t i = count; i-- > 0;) {  // arguments come before what they are arguments of
    if (asked[i] == 0) continue;
    for (const Value a : nodes_[i].arguments) asked[static_cast<std::size_t>(a)] = 1;
  }
  std::vector<Value> became(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    if (asked[i] == 0) continue;
    const Node node = nodes_[i];  // making values moves them
    if (node.op == nullptr) {
      became[i] = static_cast<Value>(i);
    } else if (node.op->number == number) {
      became[i] = constant(value);
    } else {
      std::vector<Value> arguments;
      for (const Value a : node.arguments) arguments.push_back(became[static_cast<std::size_t>(a)]);
      became[i] = op(node.op->number, node.mode, std::move(arguments));
    }
  }
  return became.back();
}

// The value that an op's can only be, -1 where there is none such.
Value ProgramGraph::simplified(uint number, uint mode, const std::vector<Value> &arguments) {
  if (number == OP_VECTOR_MATH_V || number == OP_MATH) {
    const Value a = arguments[0];
    const Value b = arguments[1];
    // Both ops count their first four operations alike. Numbers have all components alike, so that one test does.
    if (mode == MATH_ADD && is_constant(b, 0.0f)) return a;
    if (mode == MATH_ADD && is_constant(a, 0.0f)) return b;
    if (mode == MATH_SUBTRACT && is_constant(b, 0.0f)) return a;
    if (mode == MATH_SUBTRACT && is_constant(a)) {  // c - (c - x) is x
      const Node &inner = (*this)[b];
      if (inner.op != nullptr && inner.op->number == number && inner.mode == MATH_SUBTRACT && inner.arguments[0] == a) {
        return inner.arguments[1];
      }
    }
    if (mode == MATH_MULTIPLY && (is_constant(a, 0.0f) || is_constant(b, 1.0f))) return a;
    if (mode == MATH_MULTIPLY && (is_constant(b, 0.0f) || is_constant(a, 1.0f))) return b;
    if (mode == MATH_DIVIDE && (is_constant(b, 1.0f) || is_constant(a, 0.0f))) return a;
    if (number == OP_VECTOR_MATH_V && mode == VECTOR_SCALE) {
      const Value factor = arguments[3];
      if (is_constant(factor, 1.0f) || is_constant(a, 0.0f)) return a;
      if (is_constant(factor, 0.0f)) return factor;
    }
  }
  if (number == OP_MIX_V || number == OP_MIX_F) {
    if (is_constant(arguments[0], 0.0f) || arguments[1] == arguments[2]) return arguments[1];
    if (is_constant(arguments[0], 1.0f)) return arguments[2];
  }
  if (number == OP_MIX_COLOR && (mode & 0x200u) == 0u) {
    if (is_constant(arguments[0], 0.0f)) return arguments[1];
    if ((mode & 255u) == BLEND_MIX && is_constant(arguments[0], 1.0f)) return arguments[2];
  }
  if (number == OP_COMPONENT || number == OP_AVERAGE) {
    const Node &inner = (*this)[arguments[0]];
    if (inner.op != nullptr && inner.op->number == OP_SPLAT) return inner.arguments[0];
    if (number == OP_COMPONENT && inner.op != nullptr && inner.op->number == OP_COMBINE) {
      return inner.arguments[std::min(mode, 2u)];
    }
  }
  return -1;
}

// A mapping by constants is an affine map, whose sines and cosines need not be found at each point; -1: it is none.
Value ProgramGraph::affine(uint mode, const std::vector<Value> &arguments) {
  if (!std::all_of(arguments.begin() + 1, arguments.end(), [&](Value a) { return is_constant(a); })) return -1;
  const auto mapped = [&](vec3 p, vec3 location) {
    std::vector<float> numbers{p.x, p.y, p.z, location.x, location.y, location.z};
    for (std::size_t k = 2; k < arguments.size(); ++k) {
      const vec3 c = (*this)[arguments[k]].constant;
      numbers.insert(numbers.end(), {c.x, c.y, c.z});
    }
    return program_fold(OP_MAPPING, mode, numbers, tables_);
  };
  const vec3 none(0.0f);
  const vec3 origin = mapped(none, (*this)[arguments[1]].constant);
  const vec3 x = mapped(vec3(1.0f, 0.0f, 0.0f), none);
  const vec3 y = mapped(vec3(0.0f, 1.0f, 0.0f), none);
  const vec3 z = mapped(vec3(0.0f, 0.0f, 1.0f), none);
  const auto is = [](vec3 a, float i, float j, float k) { return a.x == i && a.y == j && a.z == k; };
  if (is(origin, 0, 0, 0) && is(x, 1, 0, 0) && is(y, 0, 1, 0) && is(z, 0, 0, 1)) return arguments[0];
  return op(OP_AFFINE, 0,
            {arguments[0], constant(vec3(x.x, y.x, z.x)), constant(vec3(x.y, y.y, z.y)), constant(vec3(x.z, y.z, z.z)),
             constant(origin)});
}

Value ProgramGraph::vector_math(uint operation, Value a, Value b) {
  const Value zero = constant(0.0f);
  return op(OP_VECTOR_MATH_V, operation, {a, b, zero, zero});
}
Value ProgramGraph::add(Value a, Value b) { return vector_math(MATH_ADD, a, b); }
Value ProgramGraph::subtract(Value a, Value b) { return vector_math(MATH_SUBTRACT, a, b); }
Value ProgramGraph::multiply(Value a, Value b) { return vector_math(MATH_MULTIPLY, a, b); }
Value ProgramGraph::divide(Value a, Value b) { return vector_math(MATH_DIVIDE, a, b); }
Value ProgramGraph::splat(Value number) {
  return is_constant(number) ? constant((*this)[number].constant.x) : op(OP_SPLAT, 0, {number});
}
Value ProgramGraph::saturate(Value number) { return op(OP_CLAMP_F, 0, {number, constant(0.0f), constant(1.0f)}); }

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Programs, constants, and what was folded and dropped, as Python's own types. Nothing is computed but the cost.
#include "python_explain.h"

#include <nanobind/stl/string.h>

#include "program_listing.h"

namespace nb = nanobind;

namespace cotorra {
namespace {

nb::tuple triple(vec3 v) { return nb::make_tuple(v.x, v.y, v.z); }

// The number of an instruction, or a constant.
nb::object value_of(const ListedValue &v) {
  if (v.instruction >= 0) return nb::int_(v.instruction);
  if (v.vector) return triple(v.constant);
  return nb::float_(static_cast<double>(v.constant.x));
}

nb::list values_of(const std::vector<ListedValue> &values) {
  nb::list list;
  for (const ListedValue &v : values) list.append(value_of(v));
  return list;
}

nb::dict program_of(const Scene &scene, const CompiledShader &shader, const ProgramPart &part,
                    const std::vector<int> &sources) {
  const ProgramListing listing = list_program(scene.programs(), shader.program, part, sources);
  nb::list instructions, closures;
  for (const ListedInstruction &line : listing.instructions) {
    instructions.append(nb::make_tuple(line.op->name, line.mode, values_of(line.arguments), line.source));
  }
  for (std::size_t i = 0; i < listing.closures.size(); ++i) {
    const ListedClosure &row = listing.closures[i];
    closures.append(nb::make_tuple(row.kind->name, row.mode, value_of(row.weight), values_of(row.arguments),
                                   shader.notes.closure_sources.at(i)));
  }
  nb::dict d;
  d["instructions"] = instructions;
  d["registers"] = listing.registers;
  d["closures"] = closures;
  d["result"] = value_of(listing.result);
  d["nanoseconds"] = program_cost(scene, shader.program, part);
  return d;
}

nb::object surface_of(const Scene &scene, const CompiledShader &shader) {
  if (shader.program.surface.first != NO_PROGRAM) {
    return program_of(scene, shader, shader.program.surface, shader.notes.surface_sources);
  }
  if (shader.lobes == 0) return nb::none();
  const PlainSurface &s = shader.surface;
  nb::dict d;
  const bool diffuse = (shader.lobes & 1u << CLOSURE_DIFFUSE) != 0;
  d["closure"] = diffuse ? "diffuse" : "principled";
  d["base"] = triple(s.base_color);
  if (diffuse) return d;
  d["metallic"] = s.metallic;
  d["roughness"] = s.roughness;
  d["ior"] = s.ior;
  d["specular_level"] = s.specular_level;
  d["specular_tint"] = triple(s.specular_tint);
  return d;
}

}  // namespace

nb::dict explain_shader(const Scene &scene, std::size_t index) {
  const CompiledShader &shader = scene.shader(index);
  nb::list folded, dropped;
  for (const CompileNotes::Folded &f : shader.notes.folded) folded.append(nb::make_tuple(f.op, triple(f.value)));
  for (const CompileNotes::Dropped &c : shader.notes.dropped) dropped.append(nb::make_tuple(c.closure, c.why));
  nb::dict d;
  d["folded"] = folded;
  d["dropped"] = dropped;
  d["surface"] = surface_of(scene, shader);
  const auto value = [&](const ProgramPart &part, const std::vector<int> &sources, vec3 constant) -> nb::object {
    if (part.first == NO_PROGRAM) return triple(constant);
    return program_of(scene, shader, part, sources);
  };
  d["emission"] = value(shader.program.emission, shader.notes.emission_sources, shader.emission);
  d["transparency"] = value(shader.program.transparency, shader.notes.transparency_sources, shader.transparency);
  return d;
}

}  // namespace cotorra

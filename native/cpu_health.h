// SPDX-License-Identifier: GPL-3.0-or-later
// How a batch counts its bad samples, where FEATURE_HEALTH is built: each sample once for each BAD_*, with the first
// place that it was bad at. Included by cpu_kernel.cpp alone.
#pragma once

#include <algorithm>
#include <cmath>

#include "../kernels/closure/lobe_types.h"
#include "../kernels/health.h"
#include "../kernels/light/found.h"
#include "cpu_program.h"
#include "cpu_visibility.h"
#include "health.h"

namespace cotorra {
namespace {

bool is_noted(const Tracer &t, std::size_t slot, uint kind) { return (t.batch.unwell[slot] & (1u << kind)) != 0; }

void note_bad(const Tracer &t, std::size_t slot, const BadSample &bad) {
  Batch &b = t.batch;
  if (is_noted(t, slot, bad.kind)) return;
  const auto bit = static_cast<std::uint8_t>(1u << bad.kind);
  b.unwell[slot] = static_cast<std::uint8_t>(b.unwell[slot] | bit);
  ++t.counts.bad[bad];
  if (!t.job.passes.health) return;
  vec3 &pixel = b.staged.health[b.pixel[slot]];
  (bad.kind == BAD_NEGATIVE ? pixel.y : bad.kind == BAD_FIREFLY ? pixel.z : pixel.x) += 1.0f;
}

void note_light(const Tracer &t, std::size_t slot, vec3 light, BadSample bad) {
  bad.kind = bad_light(light, bad.bounce > 0 ? t.job.firefly_limit : INFINITE_DISTANCE);
  if (bad.kind != BAD_KINDS) note_bad(t, slot, bad);
}

// The lobe that a lane's surface scatters by, as BadSample tells it; `lobes`: BSDF_*.
std::uint32_t lobe_name(const Tracer &t, std::size_t i, uint lobes) {
  const uint kind = FEATURE(FEATURE_LOBES) ? t.batch.shading.lobe[i].kind : LOBE_NONE;
  if (kind != LOBE_NONE) return kind;
  return (lobes & BSDF_DIFFUSE) != 0u ? kLobeDiffuse : kLobeGlossy;
}

// Light of a lamp (kNobody: not known) or emitter at the surface of lane i.
void note_lit(const Tracer &t, std::size_t i, std::size_t slot, vec3 light, std::uint32_t lamp) {
  const Batch &b = t.batch;
  const uint material = b.surface[i].material;
  note_light(t, slot, light,
             {0, HEALTH_LIT, material, lamp, b.path[i].bounce, lobe_name(t, i, b.shading.lobes[i]), kWeightArgument});
}

// A path that its surface sent on.
void note_scatter(const Tracer &t, std::size_t i, std::size_t slot, const PathState &path, const BsdfSample &sample) {
  const vec3 carried = sample.pdf == sample.pdf ? path.throughput : vec3(sample.pdf);
  const uint kind = bad_light(carried, INFINITE_DISTANCE);
  if (kind == BAD_KINDS) return;
  const uint bounce = t.batch.path[i].bounce;
  note_bad(t, slot,
           {kind, HEALTH_SCATTER, t.batch.surface[i].material, kNobody, bounce, lobe_name(t, i, sample.lobe),
            kWeightArgument});
}

bool bad_numbers(vec3 a) { return bad_number(a.x) || bad_number(a.y) || bad_number(a.z); }

// The op of a program that makes a number bad at this point, an instruction at a time: the first whose result is not
// finite, else the first whose result is too large; kNobody: a constant is.
std::uint32_t bad_op(const SceneData &scene, const ShaderPoint &at, const ProgramPart &part, uint constants) {
  ProgramRegisters registers;
  ProgramPart one = part;
  std::uint32_t large = kNobody;
  for (uint word = part.first; word < part.end; word = one.end) {
    const uint head = scene.program_code.v[word];
    one.first = word;
    one.end = word + 2u + ((head >> PROGRAM_COUNT_SHIFT) & PROGRAM_COUNT_MASK);
    program_run(scene, at, one, constants, registers);
    const float *result = registers.v + (head >> PROGRAM_RESULT_SHIFT);
    const int count = (head & PROGRAM_VECTOR) != 0u ? 3 : 1;
    if (!std::all_of(result, result + count, [](float a) { return std::isfinite(a); })) return head & PROGRAM_OP_MASK;
    if (large == kNobody && std::any_of(result, result + count, bad_number)) large = head & PROGRAM_OP_MASK;
  }
  return large;
}

// A program of one value, that of `bad`, at this point: what it comes to before it is mended.
void note_program_numbers(const Tracer &t, std::size_t slot, const ShaderPoint &at, const ProgramPart &part,
                          uint constants, BadSample bad) {
  const SceneData &scene = *t.job.scene;
  bad.kind = BAD_NUMBER;
  if (is_noted(t, slot, BAD_NUMBER) || !bad_numbers(program_value(scene, at, part, constants))) return;
  bad.op = bad_op(scene, at, part, constants);
  note_bad(t, slot, bad);
}

// What surfaces emit, lamps that have a program, and the world.
void note_emission_numbers(const Tracer &t, std::size_t slot, const PathState &path, const Surface &s, vec3 wo) {
  const SceneData &scene = *t.job.scene;
  const Material &material = scene.materials.v[s.material];
  if (!material_varies(material) || scene.programs.v[s.material].emission.first == NO_PROGRAM) return;
  const MaterialProgram &program = scene.programs.v[s.material];
  note_program_numbers(t, slot, path_point(scene, path, s, wo, s.t), program.emission, program.constants,
                       {BAD_NUMBER, HEALTH_EMISSION, s.material, kNobody, path.bounce});
}

// `wi`, `distance`: from the point p that the lamp lights.
void note_lamp_numbers(const Tracer &t, std::size_t slot, const PathState &path, uint lamp, vec3 p, vec3 wi,
                       float distance) {
  const SceneData &scene = *t.job.scene;
  const Light &light = scene.lights.v[lamp];
  if (!FEATURE(FEATURE_PROGRAMS) || (light.flags & LIGHT_PROGRAM) == 0u) return;
  const LightProgram &program = scene.light_programs.v[lamp];
  ShaderPoint at = light_point(lamp, light, program, p, wi, distance);
  path_counts(path, at);
  note_program_numbers(t, slot, at, program.emission, program.constants,
                       {BAD_NUMBER, HEALTH_LAMP, kNobody, lamp, path.bounce});
}

void note_world_numbers(const Tracer &t, std::size_t slot, const PathState &path, vec3 direction) {
  const SceneData &scene = *t.job.scene;
  if (!FEATURE(FEATURE_PROGRAMS) || scene.world_program.end == 0u) return;
  note_program_numbers(t, slot, path_background(path, direction), scene.world_program, scene.world_constants,
                       {BAD_NUMBER, HEALTH_WORLD, kNobody, kNobody, path.bounce});
}

// One light sample of lane i, sent or not: what is no number brings nothing and is not sent.
void note_sample(const Tracer &t, std::size_t i, const ShadowRay &ray, std::uint32_t lamp) {
  const std::size_t slot = t.batch.slot[i];
  if (lamp != kNobody)
    note_lamp_numbers(t, slot, t.batch.path[i], lamp, t.batch.surface[i].p, ray.direction, ray.t_max);
  if (bad_light(ray.contribution, INFINITE_DISTANCE) != BAD_KINDS) note_lit(t, i, slot, ray.contribution, lamp);
}

// What a program left for closures at point k, which is lane i, before it is mended.
void note_closure_numbers(const Tracer &t, const ProgramBatch &batch, const ProgramPart &part, std::size_t k,
                          std::size_t i) {
  const SceneData &scene = *t.job.scene;
  const auto bad = [&](uint reference) {
    if ((reference & REFERENCE_CONSTANT) != 0u) return false;  // compiling mended those
    const float *first = batch.registers + std::size_t{reference & REFERENCE_MASK} * kProgramStride + k;
    if (bad_number(first[0])) return true;
    return (reference & REFERENCE_VECTOR) != 0u &&
           (bad_number(first[kProgramStride]) || bad_number(first[2 * kProgramStride]));
  };
  for (uint c = 0; c < part.closures; ++c) {
    const ClosureRow &row = scene.program_closures.v[part.result + c];
    if (is_noted(t, t.batch.slot[i], BAD_NUMBER)) return;
    BadSample found{BAD_NUMBER, HEALTH_SHADER, t.batch.surface[i].material, kNobody, t.batch.path[i].bounce, row.kind};
    bool any = bad(row.weight);
    for (std::uint32_t a = 0; !any && a < closure_arguments(row.kind); ++a) {
      any = bad(scene.program_code.v[row.arguments + a]);
      found.argument = a;
    }
    if (!any) continue;
    found.op = bad_op(scene, batch.points[k], part, batch.constants[k]);
    note_bad(t, t.batch.slot[i], found);
  }
}

}  // namespace
}  // namespace cotorra

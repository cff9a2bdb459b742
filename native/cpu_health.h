// SPDX-License-Identifier: GPL-3.0-or-later
// How a batch counts its bad samples, where FEATURE_HEALTH is built: each sample once for each BAD_*, with the first
// place that it was bad at. Included by cpu_kernel.cpp alone.
#pragma once

#include "../kernels/closure/lobe_types.h"
#include "../kernels/health.h"
#include "../kernels/light/found.h"
#include "cpu_program.h"
#include "cpu_visibility.h"
#include "health.h"

namespace cotorra {
namespace {

void note_bad(const Tracer &t, std::size_t slot, const BadSample &bad) {
  Batch &b = t.batch;
  const auto bit = static_cast<std::uint8_t>(1u << bad.kind);
  if ((b.unwell[slot] & bit) != 0) return;
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

// What surfaces emit, and the world, before it is mended.
void note_emission_numbers(const Tracer &t, std::size_t slot, const PathState &path, const Surface &s, vec3 wo) {
  const SceneData &scene = *t.job.scene;
  const Material &material = scene.materials.v[s.material];
  if (!material_varies(material) || scene.programs.v[s.material].emission.first == NO_PROGRAM) return;
  const MaterialProgram &program = scene.programs.v[s.material];
  if (bad_numbers(program_value(scene, path_point(scene, path, s, wo, s.t), program.emission, program.constants))) {
    note_bad(t, slot, {BAD_NUMBER, HEALTH_EMISSION, s.material, kNobody, path.bounce, 0, kWeightArgument});
  }
}

void note_world_numbers(const Tracer &t, std::size_t slot, const PathState &path, vec3 direction) {
  const SceneData &scene = *t.job.scene;
  if (!FEATURE(FEATURE_PROGRAMS) || scene.world_program.end == 0u) return;
  ShaderPoint at = background_point(direction);
  path_counts(path, at);
  if (bad_numbers(program_value(scene, at, scene.world_program, scene.world_constants))) {
    note_bad(t, slot, {BAD_NUMBER, HEALTH_WORLD, kNobody, kNobody, path.bounce, 0, kWeightArgument});
  }
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
    BadSample found{BAD_NUMBER, HEALTH_SHADER,  t.batch.surface[i].material, kNobody, t.batch.path[i].bounce,
                    row.kind,   kWeightArgument};
    if (bad(row.weight)) note_bad(t, t.batch.slot[i], found);
    for (std::uint32_t a = 0; a < closure_arguments(row.kind); ++a) {
      if (!bad(scene.program_code.v[row.arguments + a])) continue;
      found.argument = a;
      note_bad(t, t.batch.slot[i], found);
    }
  }
}

}  // namespace
}  // namespace cotorra

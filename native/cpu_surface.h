// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch's surfaces are: runs the programs of those that vary, all points of one program together, and draws the
// closure that each path meets. Included by cpu_kernel.cpp alone.
#pragma once

#include <algorithm>

#include "cpu_batch.h"
#include "cpu_program.h"
#include "cpu_visibility.h"

namespace cotorra {

extern const RunProgram COTORRA_PROGRAM_NAME;

namespace {

static_assert(kProgramLanes == kLanes);

// Points that run one program, in the order of the batch; in order of programs where a batch has several.
struct ProgramLanes {
  std::vector<float> registers;
  Array<ShaderPoint, kLanes> point;
  Array<uint, kLanes> lane;
  Array<uint, kLanes> constants;
  Array<uint, kLanes> first;  // of the code
  Array<uint, kLanes> order;
};

// The material at a lane's surface, with what its program found there.
Material lane_material(const Tracer &t, std::size_t lane) {
  const uint index = t.batch.surface[lane].material;
  return FEATURE(FEATURE_PROGRAMS) ? t.batch.shaded[lane].material : t.job.scene->materials.v[index];
}

// Runs a part of the materials of those lanes that `part_of` names one for, and calls take(lane, point, registers) for
// each of them.
template <class PartOf, class Take>
void run_programs(const Tracer &t, int lanes, PartOf part_of, Take take) {
  Batch &b = t.batch;
  const SceneData &scene = *t.job.scene;
  ProgramLanes &p = *b.programs;
  // 1. Who takes part, sorted by program; materials of one program may differ in their constants.
  std::size_t n = 0;
  uint last = NO_PROGRAM;
  bool sorted = true;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    const ProgramPart *part = part_of(i);
    if (part == nullptr) continue;
    sorted &= n == 0 || last <= part->first;
    last = part->first;
    p.lane[n] = static_cast<uint>(i);
    p.first[n] = part->first;
    p.order[n] = static_cast<uint>(n);
    ++n;
  }
  if (!sorted) {
    std::stable_sort(p.order.data(), p.order.data() + n, [&](uint a, uint c) { return p.first[a] < p.first[c]; });
  }
  // 2. Program by program.
  for (std::size_t begin = 0; begin < n;) {
    const uint first = p.first[p.order[begin]];
    std::size_t count = 0;
    const ProgramPart part = *part_of(p.lane[p.order[begin]]);
    for (; begin + count < n && p.first[p.order[begin + count]] == first; ++count) {
      const std::size_t i = p.lane[p.order[begin + count]];
      const Surface &s = b.surface[i];
      p.constants[count] = scene.programs.v[s.material].constants;
      p.point[count] = path_point(scene, b.path[i], s, b.shading.wo.get(i), s.t);
    }
    const ProgramBatch batch{&scene, p.point.data(), p.constants.data(), static_cast<int>(count), p.registers.data()};
    COTORRA_PROGRAM_NAME(batch, part.first, part.end);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = p.lane[p.order[begin + k]];
      take(i, p.point[k], lane_registers(batch, k));
    }
    begin += count;
  }
}

// The closures that the lanes' paths meet, set up for shading; `u` chooses where a surface has several. Surfaces
// whose `shaded` is of no kind are left as they are.
void draw_surfaces(const Tracer &t, int lanes, const float *u) {
  Batch &b = t.batch;
  const SceneData &scene = *t.job.scene;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) surface_begin(scene, b.surface[i], b.shaded[i]);
  if (b.programs == nullptr) return;
  const auto part_of = [&](std::size_t i) -> const ProgramPart * {
    const bool varies = surface_varies(scene, b.surface[i], b.shaded[i].material);
    return varies ? &scene.programs.v[b.surface[i].material].surface : nullptr;
  };
  run_programs(t, lanes, part_of, [&](std::size_t i, const ShaderPoint &at, const LaneRegisters &registers) {
    Bsdf bsdf;
    Lobe lobe;
    surface_take(scene, scene.programs.v[b.surface[i].material], at, u[i], b.surface[i], b.shaded[i], bsdf, lobe,
                 registers);
    b.shading.set_bsdf(i, bsdf);
    if (FEATURE(FEATURE_LOBES)) b.shading.set_lobe(i, lobe);
    const vec3 throughput = b.path[i].throughput * b.shaded[i].weight;
    b.path[i].throughput = throughput;
    b.shading.throughput.set(i, throughput);
  });
}

}  // namespace
}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch's surfaces are: runs the programs of those that vary, all points of one program together, and draws the
// closure that each path meets. Included by cpu_kernel.cpp alone.
#pragma once

#include <algorithm>
#include <new>

#include "cpu_batch.h"
#include "cpu_health.h"
#include "cpu_program.h"
#include "cpu_visibility.h"

namespace cotorra {

extern const RunProgram COTORRA_PROGRAM_NAME;

namespace {

static_assert(kProgramLanes == kLanes);

// Inputs of plain Principled closures (PROGRAM_PLAIN).
struct PlainLanes {
  Vec3s weight, base, tint, normal;
  Floats metallic, roughness, ior, level;
};

// Points that run one program, in the order of the batch; in order of programs where a batch has several.
struct ProgramLanes {
  std::vector<float> registers;
  Array<ShaderPoint, kLanes> point;
  Array<uint, kLanes> lane;
  Array<uint, kLanes> sorted;  // lanes of the program that runs
  Array<uint, kLanes> constants;
  Array<uint, kLanes> rows;  // where closures stand: programs never share it, as they do the place of no code
  Array<uint, kLanes> order;
  PlainLanes plain;
};

// The material at a lane's surface, with what its program found there.
Material lane_material(const Tracer &t, std::size_t lane) {
  const uint index = t.batch.surface[lane].material;
  return FEATURE(FEATURE_PROGRAMS) ? t.batch.shaded[lane].material : t.job.scene->materials.v[index];
}

// The lanes' points; how wide their rays are is left out where no program asks.
ShaderPoint counted_point(const PathState &path, const Surface &s, vec3 wo) {
  ShaderPoint at = shader_point(s, wo, s.t);
  path_counts(path, at);
  return at;
}
ShaderPoint lane_point(const Tracer &t, std::size_t i, bool footprint) {
  const Batch &b = t.batch;
  const Surface &s = b.surface[i];
  const vec3 wo = b.shading.wo.get(i);
  return footprint ? path_point(*t.job.scene, b.path[i], s, wo, s.t) : counted_point(b.path[i], s, wo);
}

// Runs the surface part of the materials of those lanes that `part_of` names one for, and calls take(batch, lanes) for
// all of a program, where lanes[k] is the lane of point k.
template <class PartOf, class Take>
void run_programs(const Tracer &t, int lanes, PartOf part_of, Take take) {
  Batch &b = t.batch;
  const SceneData &scene = *t.job.scene;
  ProgramLanes &p = *b.programs;
  // 1. Who takes part, sorted by program; materials of one program may differ in their constants.
  std::size_t n = 0;
  uint last = 0;
  bool sorted = true;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    const ProgramPart *part = part_of(i);
    if (part == nullptr) continue;
    sorted &= last <= part->result;
    last = part->result;
    p.lane[n] = static_cast<uint>(i);
    p.rows[n] = part->result;
    p.order[n] = static_cast<uint>(n);
    ++n;
  }
  if (!sorted) {
    std::stable_sort(p.order.data(), p.order.data() + n, [&](uint a, uint c) { return p.rows[a] < p.rows[c]; });
  }
  // 2. Program by program.
  for (std::size_t begin = 0; begin < n;) {
    const uint rows = p.rows[p.order[begin]];
    std::size_t count = 0;
    const ProgramPart part = *part_of(p.lane[p.order[begin]]);
    for (; begin + count < n && p.rows[p.order[begin + count]] == rows; ++count) {
      const std::size_t i = p.lane[p.order[begin + count]];
      const MaterialProgram &program = scene.programs.v[b.surface[i].material];
      p.sorted[count] = static_cast<uint>(i);
      p.constants[count] = program.constants;
      // Made in its place: a copy would read what was just written, in larger pieces, and wait for it.
      ::new (static_cast<void *>(&p.point[count]))
          ShaderPoint(lane_point(t, i, (program.flags & PROGRAM_FOOTPRINT) != 0u));
    }
    const ProgramBatch batch{&scene, p.point.data(), p.constants.data(), static_cast<int>(count), p.registers.data()};
    COTORRA_PROGRAM_NAME(batch, part.first, part.end);
    take(batch, p.sorted.data());
    begin += count;
  }
}

// Numbers that a reference names, of all points.
void gather_reference(const ProgramBatch &batch, uint reference, Floats *const *out, std::size_t size) {
  const auto n = static_cast<std::size_t>(batch.n);
  for (std::size_t c = 0; c < size; ++c) {
    const std::size_t place = (reference & REFERENCE_MASK) + c;
    float *column = out[c]->data();
    if ((reference & REFERENCE_CONSTANT) == 0u) {
      std::copy_n(batch.registers + place * kProgramStride, n, column);
      continue;
    }
    const float *numbers = batch.scene->program_constants.v + place;
    for (std::size_t k = 0; k < n; ++k) column[k] = numbers[batch.constants[k]];
  }
}
void gather_number(const ProgramBatch &batch, uint reference, Floats &out) {
  Floats *const columns[] = {&out};
  gather_reference(batch, reference, columns, 1);
}
void gather_vector(const ProgramBatch &batch, uint reference, Vec3s &out) {
  Floats *const columns[] = {&out.x, &out.y, &out.z};
  gather_reference(batch, reference, columns, 3);
}

void gather_plain(const ProgramBatch &batch, const ClosureRow &row, PlainLanes &out) {
  const uint *arguments = batch.scene->program_code.v + row.arguments;
  gather_vector(batch, row.weight, out.weight);
  gather_vector(batch, arguments[PRINCIPLED_BASE], out.base);
  gather_vector(batch, arguments[PRINCIPLED_SPECULAR_TINT], out.tint);
  gather_vector(batch, arguments[PRINCIPLED_NORMAL], out.normal);
  gather_number(batch, arguments[PRINCIPLED_METALLIC], out.metallic);
  gather_number(batch, arguments[PRINCIPLED_ROUGHNESS], out.roughness);
  gather_number(batch, arguments[PRINCIPLED_IOR], out.ior);
  gather_number(batch, arguments[PRINCIPLED_SPECULAR_LEVEL], out.level);
}

// The same limits as pick_principled's and pick_normal's.
COTORRA_FLATTEN void clamp_plain(const ProgramBatch &batch, PlainLanes &p) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(batch.n); ++k) {
    p.weight.set(k, max(light_numbers(p.weight.get(k)), vec3(0.0f)));
    p.base.set(k, max(light_numbers(p.base.get(k)), vec3(0.0f)));
    p.tint.set(k, max(light_numbers(p.tint.get(k)), vec3(0.0f)));
    p.metallic[k] = unit_clamp(light_number(p.metallic[k]));
    p.roughness[k] = unit_clamp(light_number(p.roughness[k]));
    p.ior[k] = max(light_number(p.ior[k]), 1e-5f);
    p.level[k] = max(light_number(p.level[k]), 0.0f);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(batch.n); ++k) {
    p.normal.set(k, normalize_or(light_numbers(p.normal.get(k)), batch.points[k].n));
  }
}

// surface_take for a surface that is one plain Principled closure, whose weight is not 0.
void take_plain(const SceneData &scene, const ClosureRow &row, const PlainLanes &p, std::size_t k, vec3 wo, Surface &s,
                SurfaceShading &shading, Bsdf &bsdf) {
  Material &m = shading.material;
  m.base_color = p.base.get(k);
  m.metallic = p.metallic[k];
  m.roughness = p.roughness[k];
  m.ior = p.ior[k];
  m.specular_level = p.level[k];
  m.specular_tint = p.tint.get(k);
  m.flags &= ~MATERIAL_MULTI_GGX;
  if ((row.mode & PRINCIPLED_MULTI_GGX) != 0u) m.flags |= MATERIAL_MULTI_GGX;
  if ((m.flags & MATERIAL_MODEL) == 0u && m.roughness >= SHARP_ROUGHNESS) m.flags &= ~MATERIAL_SHARP;
  const vec3 smooth = s.n;
  s.n = p.normal.get(k);
  shading.weight = p.weight.get(k);
  shading.kind = CLOSURE_PRINCIPLED;
  bsdf_prepare(scene, m, s.n, s.ng, wo, bsdf);
  bsdf.n_smooth = select((row.mode & CLOSURE_OWN_NORMAL) != 0u, s.n, smooth);
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
  run_programs(t, lanes, part_of, [&](const ProgramBatch &batch, const uint *order) {
    if (FEATURE(FEATURE_HEALTH)) {
      const ProgramPart &ran = scene.programs.v[b.surface[order[0]].material].surface;
      for (std::size_t k = 0; k < static_cast<std::size_t>(batch.n); ++k) {
        note_closure_numbers(t, batch, ran, k, order[k]);
      }
    }
    // 1. What the commonest shape of all reads, for all points at once; the constants of another material may ask more.
    PlainLanes &plain = b.programs->plain;
    const ProgramPart &part = scene.programs.v[b.surface[order[0]].material].surface;
    const ClosureRow row = scene.program_closures.v[part.result];
    const bool alone = part.closures == 1u && row.kind == CLOSURE_PRINCIPLED && (row.mode & CLOSURE_BENT_NORMAL) == 0u;
    if (alone) {
      gather_plain(batch, row, plain);
      clamp_plain(batch, plain);
    }
    // 2. The closures.
    for (std::size_t k = 0; k < static_cast<std::size_t>(batch.n); ++k) {
      const std::size_t i = order[k];
      const MaterialProgram &program = scene.programs.v[b.surface[i].material];
      Bsdf bsdf;
      if (alone && (program.flags & PROGRAM_PLAIN) != 0u && max_component(plain.weight.get(k)) > 0.0f) {
        take_plain(scene, row, plain, k, batch.points[k].wo, b.surface[i], b.shaded[i], bsdf);
        if (FEATURE(FEATURE_LOBES)) b.shading.lobe[i].kind = LOBE_NONE;
      } else {
        Lobe lobe;
        const LaneRegisters registers = lane_registers(batch, k);
        surface_take(scene, program, batch.points[k], u[i], b.surface[i], b.shaded[i], bsdf, lobe, registers);
        if (FEATURE(FEATURE_LOBES)) b.shading.set_lobe(i, lobe);
      }
      b.shading.set_bsdf(i, bsdf);
      const vec3 throughput = b.path[i].throughput * b.shaded[i].weight;
      b.path[i].throughput = throughput;
      b.shading.throughput.set(i, throughput);
    }
  });
}

}  // namespace
}  // namespace cotorra

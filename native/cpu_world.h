// SPDX-License-Identifier: GPL-3.0-or-later
// The background on a CPU: what it shows all rays of a batch that met nothing, and its samples for all lanes. Included
// by cpu_kernel.cpp alone.
#pragma once

#include <new>

#include "cpu_surface.h"

namespace cotorra {
namespace {

// Does a program tell what the background shows, and is there room to run it for many points at once?
bool world_runs_in_batches(const Tracer &t) {
  return FEATURE(FEATURE_PROGRAMS) && t.batch.programs != nullptr && t.job.scene->world_program.end != 0u;
}

// What the background shows at point_of(lane) for each of the n lanes of `order`: take(lane, radiance).
template <class PointOf, class Take>
void run_background(const Tracer &t, const uint *order, std::size_t n, PointOf point_of, Take take) {
  const SceneData &scene = *t.job.scene;
  if (n == 0) return;
  ProgramLanes &p = *t.batch.programs;
  for (std::size_t k = 0; k < n; ++k) {
    ::new (static_cast<void *>(&p.point[k])) ShaderPoint(point_of(order[k]));  // in its place, as run_programs does
    p.constants[k] = scene.world_constants;
  }
  const ProgramBatch batch{&scene, p.point.data(), p.constants.data(), static_cast<int>(n), p.registers.data()};
  const ProgramPart &part = scene.world_program;
  COTORRA_PROGRAM_NAME(batch, part.first, part.end);
  gather_vector(batch, part.result, p.plain.base);
  for (std::size_t k = 0; k < n; ++k) take(order[k], light_numbers(p.plain.base.get(k)));
}

// For all lanes whose rays met nothing: Batch.sky.
void see_background(const Tracer &t, int lanes) {
  if (!world_runs_in_batches(t)) return;
  Batch &b = t.batch;
  uint *missed = b.programs->lane.data();
  std::size_t n = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    if (b.found[i].instance == INVALID_ID && path_sees_world(*t.job.scene, b.path[i])) {
      missed[n++] = static_cast<uint>(i);
    }
  }
  run_background(
      t, missed, n,
      [&](std::size_t i) { return path_background(b.path[i], packet_direction(b.packets[i / kWidth], i % kWidth)); },
      [&](std::size_t i, vec3 sky) { b.sky.set(i, sky); });
}

// ---- Samples by the background's table: what each brings if nothing stands between, in LightLanes.contribution.

COTORRA_FLATTEN void share_background(const ShadingLanes &in, int n, LightLanes &out) {
  COTORRA_EACH {
    float pdf;
    const vec3 f = bsdf_eval(in.principled(i), in.wo.get(i), out.wi.get(i), pdf);
    out.contribution.set(i, in.throughput.get(i) * world_share(f, pdf, out.pdf[i]));
  }
}

template <uint kModel>
COTORRA_UNTHREADED COTORRA_FLATTEN void share_background_model(const ShadingLanes &in, int n, LightLanes &out) {
  COTORRA_EACH {
    Bsdf bsdf;
    in.model_bsdf(i, kModel, bsdf);
    float pdf;
    const vec3 f = bsdf_eval(bsdf, in.wo.get(i), out.wi.get(i), pdf);
    const vec3 light = in.throughput.get(i) * world_share(f, pdf, out.pdf[i]);
    out.contribution.set(i, select(in.model.model[i] == kModel, light, out.contribution.get(i)));
  }
}

// Lanes whose surface is a Lobe; or all of them, where not every kind of ray sees the background.
COTORRA_APART void share_background_singly(const SceneData &scene, const ShadingLanes &in, int n, bool all,
                                           LightLanes &out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    if (!all && !has_lobe(in.lobe_of(i))) continue;
    float pdf;
    const vec3 f =
        visible_scattering(scene, in.bsdf(i), in.lobe_of(i), in.wo.get(i), out.wi.get(i), scene.world_sampled, pdf);
    out.contribution.set(i, in.throughput.get(i) * world_share(f, pdf, out.pdf[i]));
  }
}

void sample_background(const Tracer &t, int lanes, const float *u, const float *v, uint bounce) {
  const SceneData &scene = *t.job.scene;
  Batch &b = t.batch;
  const auto n = static_cast<std::size_t>(lanes);
  // 1. Directions.
  for (std::size_t i = 0; i < n; ++i) b.light.wi.set(i, world_sample(scene, vec2(u[i], v[i]), b.light.pdf[i]));
  // 2. What the surfaces make of them.
  const bool every_kind = (scene.world_sampled & VISIBLE_SCATTERED) == VISIBLE_SCATTERED;
  if (every_kind) {
    share_background(b.shading, lanes, b.light);
    if (FEATURE(FEATURE_MODELS)) {
      each_model(b.shading.model, [&](auto model) { share_background_model<model()>(b.shading, lanes, b.light); });
    }
  }
  if (FEATURE(FEATURE_LOBES) || !every_kind) {
    share_background_singly(scene, b.shading, lanes, !every_kind, b.light);
  }
  // 3. What the background shows there.
  if (bounce > scene.world_max_bounces) {
    for (std::size_t i = 0; i < n; ++i) b.light.contribution.set(i, vec3(0.0f));
    return;
  }
  const auto point_of = [&](std::size_t i) {
    return path_world_point(scene, b.path[i], b.shading.lobe_of(i), b.light.wi.get(i));
  };
  const auto take = [&](std::size_t i, vec3 sky) { b.light.contribution.set(i, b.light.contribution.get(i) * sky); };
  const bool in_batches = world_runs_in_batches(t);
  Array<uint, kLanes> lit;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!carries_light(b.light.contribution.get(i))) continue;
    if (in_batches) {
      lit[count++] = static_cast<uint>(i);
    } else {
      take(i, world_radiance(scene, point_of(i)));
    }
  }
  if (in_batches) run_background(t, lit.data(), count, point_of, take);
}

}  // namespace
}  // namespace cotorra

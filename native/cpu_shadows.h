// SPDX-License-Identifier: GPL-3.0-or-later
// Shadow rays on a CPU: they wait until they fill a packet, and bring home what comes through.
// Which lights they go to is the renderer's (cpu_kernel.cpp). Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_lane.h"
#include "cpu_passes.h"
#include "cpu_visibility.h"
#include "cpu_whitted.h"

namespace cotorra {
namespace {

// Traces those that wait, at the vertex after so many bounces.
void flush_shadow(const Tracer &t, uint bounce) {
  const RenderJob &job = t.job;
  Batch &b = t.batch;
  if (b.shadow_count == 0) return;
  alignas(64) int valid[kWidth];
  for (int k = 0; k < kWidth; ++k) valid[k] = k < b.shadow_count ? -1 : 0;
  if (b.recording) b.recorded.push_back({{b.shadow, {}}, b.shadow_count, t.arguments.flags, true});
  embree::Ray<kWidth> asked;
  if (FEATURE(FEATURE_WHITTED)) asked = b.shadow;
  if (FEATURE(FEATURE_TRANSPARENCY)) b.alpha_context.shadow_paths = b.shadow_paths;
  occluded(*job.rtc, valid, job.bvh, &b.shadow, &t.arguments);
  if (FEATURE(FEATURE_WHITTED) && job.classic.transparent_shadows) {
    see_through(t, asked, b.shadow_count, b.shadow, b.shadow_contribution.data());
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(b.shadow_count); ++k) {
    // Embree sets tfar to -infinity where something is in the way.
    const vec3 kept = b.shadow.tfar[k] >= 0.0f ? light_kept(t.arguments, k) : vec3(0.0f);
    arrive(lane_at(t, b.shadow_lane[k]), bounce == 0, b.shadow_contribution[k], kept, b.shadow_group[k]);
  }
  t.counts.shadow += static_cast<std::uint64_t>(b.shadow_count);
  b.shadow_count = 0;
}

// Sends a ray of a lane, with as many others as fill a packet. `slot`: which light sample of the vertex it is.
void queue_shadow(const Tracer &t, const ShadowRay &sent, std::size_t lane, uint slot, uint bounce) {
  Batch &b = t.batch;
  ShadowRay ray = sent;
  if (t.data.integrator.shadow_roulette > 0.0f) {
    if (!shadow_survives(lane_at(t, lane), slot, b.weak[lane], ray)) return;
  }
  if (ray.visibility == 0u) {
    arrive(lane_at(t, lane), bounce == 0, ray.contribution, vec3(1.0f), ray.group);
    return;
  }
  const auto k = static_cast<std::size_t>(b.shadow_count);
  embree::set_ray(b.shadow, k, ray.origin, ray.direction, 0.0f, ray.t_max, ray.visibility);
  set_left(b.shadow, k, surface_left(*t.job.scene, b.surface[lane], ray.origin, ray.direction));
  b.shadow_lane[k] = static_cast<uint>(lane);
  b.shadow_contribution[k] = ray.contribution;
  b.shadow_group[k] = ray.group;
  if (FEATURE(FEATURE_TRANSPARENCY)) b.shadow_paths[k] = &b.path[lane];
  if (++b.shadow_count == kWidth) flush_shadow(t, bounce);
}

}  // namespace
}  // namespace cotorra

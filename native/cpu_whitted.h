// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion on a CPU: both children of each surface wait in a store by depth, and the deepest are traced
// first, so that memory is bounded by the depth and nothing is left to chance. Shading is the renderer's
// (cpu_kernel.cpp). Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_lane.h"
#include "cpu_surface.h"

namespace cotorra {
namespace {

// The rays that go on from the surfaces of the lanes.
void store_children(const Tracer &t, int lanes) {
  const Batch &b = t.batch;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    push_children(lane_at(t, i), b.path[i], b.surface[i], lane_material(t, i), b.shading.bsdf(i), b.shading.wo.get(i));
  }
}

// Starts the deepest of the waiting rays, all of one depth. Returns how many; 0: none is left.
int start_pending(const Tracer &t) {
  Batch &b = t.batch;
  std::vector<std::vector<PendingRay>> &pending = b.classic->pending;
  auto level = pending.size();
  while (level > 0 && pending[level - 1].empty()) --level;
  if (level == 0) return 0;
  std::vector<PendingRay> &rays = pending[level - 1];
  const std::size_t lanes = std::min<std::size_t>(rays.size(), kLanes);
  for (std::size_t i = 0; i < lanes; ++i) {
    const PendingRay &ray = rays[rays.size() - lanes + i];
    b.path[i] = ray.path;
    b.slot[i] = ray.slot;
    b.classic->medium[i] = ray.medium;
    start_ray(b.packets[i / kWidth], i % kWidth, ray.origin, ray.direction, 0.0f, INFINITE_DISTANCE,
              ray.path.ray_kind & VISIBLE_ALL);
  }
  rays.resize(rays.size() - lanes);
  return static_cast<int>(lanes);
}

constexpr uint kMostCrossings = 1024;  // of surfaces that a ray starts anew behind, where rounding might hold it up

// Sends those of the shadow rays that are not free through the glass in their way. `asked` are the rays as they were,
// `answered` as Embree left them; rays that come through are marked as free, their light in `light` dimmed.
void see_through(const Tracer &t, const embree::Ray<kWidth> &asked, int count, embree::Ray<kWidth> &answered,
                 vec3 *light) {
  const SceneData &scene = *t.job.scene;
  embree::RayHit<kWidth> p{};
  alignas(64) int valid[kWidth];
  std::array<ShadowRay, kWidth> rays{};
  std::array<Passage, kWidth> passages;
  bool any = false;
  p.ray = asked;
  for (std::size_t k = 0; k < kWidth; ++k) {
    valid[k] = static_cast<int>(k) < count && !(answered.tfar[k] >= 0.0f) ? -1 : 0;
    p.hit.geom_id[k] = p.hit.inst_id[k] = embree::kInvalidId;
    if (valid[k] == 0) continue;
    any = true;
    rays[k].direction = packet_direction(p, k);
    rays[k].t_max = asked.tfar[k];
    passages[k] = {light[k], 0u, vec3(1.0f), 0u};
  }
  // Every surface is met here: the filter of the first query knows nothing of glass.
  embree::QueryArguments arguments = t.arguments;
  arguments.context = nullptr;
  arguments.filter = nullptr;
  for (uint step = 0; any && step < kMostCrossings; ++step) {
    intersect(*t.job.rtc, valid, t.job.bvh, &p, &arguments);
    any = false;
    for (std::size_t k = 0; k < kWidth; ++k) {
      if (valid[k] == 0) continue;
      const Hit hit = packet_hit(t.job, p, k);
      ShadowRay &ray = rays[k];
      float t_min;
      valid[k] = 0;
      if (hit.instance == INVALID_ID) {
        answered.tfar[k] = 0.0f;
        light[k] = passages[k].light;
        if (FEATURE(FEATURE_TRANSPARENCY) && t.arguments.context != nullptr) {
          alpha_of(t.arguments)->kept[k] = passages[k].kept;
        }
      } else if (shadow_passes(lane_at(t, t.batch.shadow_lane[k]), t.batch.path[t.batch.shadow_lane[k]], hit, true, ray,
                               t_min, passages[k])) {
        if (t_min > 0.0f) {  // packets start at surfaces, not behind a distance
          Surface s;
          surface_from_hit(scene, hit, ray.direction, s);
          ray.origin = surface_ray_origin(s.p, s.ng, s.epsilon, ray.direction);
          ray.t_max -= t_min;
        }
        start_ray(p, k, ray.origin, ray.direction, 0.0f, ray.t_max, p.ray.mask[k]);
        valid[k] = -1;
        any = true;
      }
    }
  }
}

}  // namespace
}  // namespace cotorra

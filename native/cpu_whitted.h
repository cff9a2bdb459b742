// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion on a CPU: both children of each surface wait in a store by depth, and the deepest are traced
// first, so that memory is bounded by the depth and nothing is left to chance. Shading is the renderer's
// (cpu_kernel.cpp). Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_visibility.h"

namespace cotorra {
namespace {

// What the media that the rays ran inside of have left of them.
void absorb(const Tracer &t, int lanes) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    const uint medium = t.batch.classic->medium[i];
    if (medium == INVALID_ID) continue;
    const float distance = t.batch.packets[i / kWidth].ray.tfar[i % kWidth];
    t.batch.path[i].throughput *= medium_transmittance(t.job.scene->classic.v[medium].absorption, distance);
  }
}

void store_child(const Tracer &t, std::size_t lane, vec3 direction, vec3 weight, uint kind) {
  PendingRay ray;
  ray.path = t.batch.path[lane];
  const Surface &s = t.batch.surface[lane];
  if (!whitted_advance(ray.path, s, direction, weight, kind, t.job.classic.threshold, ray.origin)) return;
  ray.slot = t.batch.slot[lane];
  ray.direction = direction;
  ray.medium = whitted_medium(t.job.scene->classic.v[s.material], s, kind);
  t.batch.classic->pending[ray.path.bounce].push_back(ray);
}

// The rays that go on from the surfaces of the lanes.
void store_children(const Tracer &t, int lanes) {
  const Batch &b = t.batch;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    if (b.path[i].bounce >= t.job.classic.depth) continue;
    const Surface &s = b.surface[i];
    WhittedChildren children;
    whitted_children(lane_material(t, i), t.job.scene->classic.v[s.material], s, b.shading.bsdf(i), b.shading.wo.get(i),
                     children);
    store_child(t, i, children.reflected, children.reflected_weight, VISIBLE_GLOSSY);
    store_child(t, i, children.transmitted, children.transmitted_weight, VISIBLE_TRANSMISSION);
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

constexpr uint kMostCrossings = 1024;  // of surfaces with alpha below 1, where the user sets no limit

// A shadow ray on its way through glass and surfaces that let light through.
struct Passage {
  vec3 light{1.0f, 1.0f, 1.0f};  // share that glass leaves
  float kept = 1.0f;             // share that surfaces with alpha below 1 leave
  float left = 0.0f;             // distance to the light
  uint panes = 0;
  uint crossed = 0;  // surfaces with alpha below 1
};

// Takes a shadow ray that met `hit` across it, straight on. Returns false where the surface stops it.
bool cross_surface(const RenderJob &job, const Hit &hit, const PathState *path, embree::RayHit<kWidth> &p,
                   std::size_t k, Passage &passage) {
  const SceneData &scene = *job.scene;
  const vec3 direction = packet_direction(p, k);
  Surface s;
  surface_from_hit(scene, hit, direction, s);
  float alpha = 1.0f;
  if (FEATURE(FEATURE_TRANSPARENCY)) alpha = hit_alpha(scene, hit, direction, *path, true, passage.crossed);
  if (alpha < 1.0f) {
    passage.kept *= 1.0f - alpha;
    const uint most = job.limits.transparent_bounces;
    const uint limit = most < TRANSPARENT_UNLIMITED ? most : kMostCrossings;
    if (path->transparent_bounces + ++passage.crossed > limit || !(passage.kept > 0.0f)) return false;
  } else {
    const ClassicMaterial &classic = scene.classic.v[s.material];
    if (++passage.panes > WHITTED_PANES) return false;
    ShaderPoint at = shader_point(s, -direction, hit.t);
    at.ray_kind = VISIBLE_SHADOW;
    SurfaceShading shading;
    Bsdf bsdf;
    Lobe lobe;
    surface_shading(scene, at, 0.5f, s, shading, bsdf, lobe);
    if (!whitted_cross_pane(shading.material, classic, s, direction, hit.t, passage.light)) return false;
  }
  passage.left -= hit.t;
  start_ray(p, k, surface_ray_origin(s.p, s.ng, s.epsilon, direction), direction, 0.0f, passage.left, p.ray.mask[k]);
  return true;
}

// Sends those of the shadow rays that are not free through the glass in their way. `asked` are the rays as they were,
// `answered` as Embree left them; rays that come through are marked as free, their light in `light` dimmed.
void see_through(const Tracer &t, const embree::Ray<kWidth> &asked, int count, embree::Ray<kWidth> &answered,
                 vec3 *light) {
  embree::RayHit<kWidth> p{};
  alignas(64) int valid[kWidth];
  std::array<Passage, kWidth> passages;
  bool any = false;
  p.ray = asked;
  for (std::size_t k = 0; k < kWidth; ++k) {
    valid[k] = static_cast<int>(k) < count && !(answered.tfar[k] >= 0.0f) ? -1 : 0;
    passages[k].left = asked.tfar[k];
    p.hit.geom_id[k] = p.hit.inst_id[k] = embree::kInvalidId;
    any |= valid[k] != 0;
  }
  // Every surface is met here: the filter of the first query knows nothing of glass.
  embree::QueryArguments arguments = t.arguments;
  arguments.context = nullptr;
  arguments.filter = nullptr;
  while (any) {
    intersect(*t.job.rtc, valid, t.job.bvh, &p, &arguments);
    any = false;
    for (std::size_t k = 0; k < kWidth; ++k) {
      if (valid[k] == 0) continue;
      const Hit hit = packet_hit(t.job, p, k);
      valid[k] = 0;
      if (hit.instance == INVALID_ID) {
        answered.tfar[k] = 0.0f;
        light[k] *= passages[k].light;
        if (FEATURE(FEATURE_TRANSPARENCY) && t.arguments.context != nullptr) {
          alpha_of(t.arguments)->kept[k] = vec3(passages[k].kept);
        }
      } else if (cross_surface(t.job, hit, t.batch.shadow_paths[k], p, k, passages[k])) {
        valid[k] = -1;
        any = true;
      }
    }
  }
}

}  // namespace
}  // namespace cotorra

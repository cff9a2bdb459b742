// SPDX-License-Identifier: GPL-3.0-or-later
// Tracing for the integrators beside Direct and Path: packets of rays that ask whether something is in the way, and
// what an answered packet says. Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_batch.h"
#include "job_data.h"

#if defined(__GNUC__)
#define COTORRA_PREFETCH(ADDRESS) __builtin_prefetch(ADDRESS)
#else
#define COTORRA_PREFETCH(ADDRESS) static_cast<void>(ADDRESS)
#endif

namespace cotorra {
namespace {

// What a batch is traced with.
struct Tracer {
  const RenderJob &job;
  Batch &batch;
  embree::QueryArguments &arguments;
  RayCounts &counts;
  const JobData &data;
};

// Collects shadow rays to packets. answer(target, kept) is called for each ray, in the order of push: what reaches the
// other end of it, 0 to 1.
template <class Answer>
class VisibilityQueue {
 public:
  VisibilityQueue(const Tracer &tracer, Answer answer) : t_(tracer), answer_(answer) {}

  // The ray leaves surface s; `path`: the ray's, which must stay until the packet was traced.
  void push(const ShadowRay &ray, const Surface &s, uint target, const PathState &path) {
    const auto k = static_cast<std::size_t>(count_);
    embree::set_ray(rays_, k, ray.origin, ray.direction, 0.0f, ray.t_max, ray.visibility);
    set_left(rays_, k, surface_left(*t_.job.scene, s, ray.origin, ray.direction));
    target_[k] = target;
    paths_[k] = &path;
    if (++count_ == kWidth) flush();
  }

  void flush() {
    if (count_ == 0) return;
    alignas(64) int valid[kWidth];
    for (int k = 0; k < kWidth; ++k) valid[k] = k < count_ ? -1 : 0;
    if (t_.batch.recording) t_.batch.recorded.push_back({{rays_, {}}, count_, t_.arguments.flags, true});
    if (FEATURE(FEATURE_TRANSPARENCY)) alpha_of(t_.arguments)->shadow_paths = paths_;
    occluded(*t_.job.rtc, valid, t_.job.bvh, &rays_, &t_.arguments);
    // Embree sets tfar to -infinity where something is in the way.
    for (std::size_t k = 0; k < static_cast<std::size_t>(count_); ++k) {
      answer_(target_[k], rays_.tfar[k] >= 0.0f ? max_component(light_kept(t_.arguments, k)) : 0.0f);
    }
    t_.counts.shadow += static_cast<std::uint64_t>(count_);
    count_ = 0;
  }

 private:
  const Tracer &t_;
  Answer answer_;
  embree::Ray<kWidth> rays_{};
  std::array<uint, kWidth> target_{};
  std::array<const PathState *, kWidth> paths_{};
  int count_ = 0;
};

// What ray k of a packet met; instance is INVALID_ID where it met nothing.
Hit packet_hit(const RenderJob &job, const embree::RayHit<kWidth> &p, std::size_t k) {
  const embree::Hit<kWidth> &h = p.hit;
  if (h.geom_id[k] == embree::kInvalidId) return {p.ray.tfar[k], 0.0f, 0.0f, INVALID_ID, INVALID_ID, 0u};
  return traced_hit(job.geometries.data(), {vec3(h.ng_x[k], h.ng_y[k], h.ng_z[k]), p.ray.tfar[k], h.u[k], h.v[k],
                                            h.prim_id[k], h.geom_id[k], h.inst_id[k], h.inst_prim_id[k]});
}

vec3 packet_direction(const embree::RayHit<kWidth> &p, std::size_t k) {
  return {p.ray.dir_x[k], p.ray.dir_y[k], p.ray.dir_z[k]};
}

// The nearest surfaces of the first `rays` rays of `packets`. `count`: they are the paths' own, and what they cross
// counts.
void trace_packets(const Tracer &t, embree::RayHit<kWidth> *packets, int rays, bool count) {
  alignas(64) int valid[kWidth];
  for (int first = 0; first < rays; first += kWidth) {
    embree::RayHit<kWidth> &packet = packets[first / kWidth];
    for (int k = 0; k < kWidth; ++k) valid[k] = first + k < rays ? -1 : 0;
    if (t.batch.recording)
      t.batch.recorded.push_back({packet, std::min(kWidth, rays - first), t.arguments.flags, false});
    if (FEATURE(FEATURE_TRANSPARENCY)) alpha_of(t.arguments)->paths = &t.batch.path[static_cast<std::size_t>(first)];
    intersect(*t.job.rtc, valid, t.job.bvh, &packet, &t.arguments);
    if (!FEATURE(FEATURE_TRANSPARENCY) || !count) continue;
    for (int k = 0; k < kWidth && first + k < rays; ++k) {
      t.batch.path[static_cast<std::size_t>(first + k)].transparent_bounces +=
          alpha_of(t.arguments)->crossed_by_path[static_cast<std::size_t>(k)];
    }
  }
}

// What the rays of all lanes met. Triangles lie anywhere in memory, and a lane alone would wait for its own: in loops
// as short as these the processor fetches those of many at once.
void find_hits(const Tracer &t, int lanes) {
  Batch &b = t.batch;
  const SceneData &scene = *t.job.scene;
  const auto mesh_of = [&](const Hit &hit) { return scene.meshes.v + scene.instances.v[hit.instance].mesh; };
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    const Hit hit = packet_hit(t.job, b.packets[i / kWidth], i % kWidth);
    b.found[i] = hit;
    if (hit.instance != INVALID_ID) COTORRA_PREFETCH(mesh_of(hit)->triangles.v + hit.triangle);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    const Hit &hit = b.found[i];
    if (hit.instance == INVALID_ID) continue;
    const Mesh &mesh = *mesh_of(hit);
    const uvec3 id = mesh.triangles.v[hit.triangle];
    for (const uint vertex : {id.x, id.y, id.z}) {
      COTORRA_PREFETCH(mesh.positions.v + vertex);
      if ((mesh.flags & MESH_SMOOTH_VERTEX) != 0u) COTORRA_PREFETCH(mesh.normals.v + vertex);
    }
  }
}

// `left`: the triangle that it cannot meet, see surface_left.
void start_ray(embree::RayHit<kWidth> &p, std::size_t k, vec3 origin, vec3 direction, float t_min, float t_max,
               uint mask, uvec2 left = {INVALID_ID, INVALID_ID}) {
  embree::set_ray(p.ray, k, origin, direction, t_min, t_max, mask);
  embree::set_missed(p.hit, k);
  set_left(p.ray, k, left);
}

}  // namespace
}  // namespace cotorra

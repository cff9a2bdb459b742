// SPDX-License-Identifier: GPL-3.0-or-later
// Embree's filter functions, for scenes where light goes through surfaces. A ray does not meet the triangle that it
// left. At surfaces that let rays through, rays of paths are stopped or not, at random; shadow rays carry on what is
// left of their light. Included by cpu_batch.h alone; without FEATURE_TRANSPARENCY and
// FEATURE_LOBES nothing of it is called.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "../kernels/alpha.h"
#include "../kernels/integrator.h"
#include "cpu_kernel.h"

namespace cotorra {
namespace {

// What the filters know of the packet that is being traced. Rays are told apart by their id, their place in it.
template <int kWidth>
struct AlphaContext {
  embree::QueryContext query;  // comes first: Embree hands a pointer to it on
  const SceneData *scene = nullptr;
  const EmbreeGeometry *geometries = nullptr;
  const PathState *paths = nullptr;  // of the packet's rays
  uint block_seed = 0;
  IntegratorData limits{};  // of which the transparent surfaces count that a path may cross, shadow rays included
  bool transparency = false;         // some material lets rays through
  std::array<uint, kWidth> left_instance{};  // and left_triangle: the triangle that the ray left, see surface_left
  std::array<uint, kWidth> left_triangle{};
  std::array<const PathState *, kWidth> shadow_paths{};  // of the packet's shadow rays
  std::array<uint, kWidth> passed{};   // by the ray itself, whatever stops it later
  std::array<uint, kWidth> crossed_by_path{};  // paths: of those, what lies before the surface that was met
  std::array<vec3, kWidth> kept{};  // shadow rays: share of their light that is left
  std::array<std::array<std::uint64_t, 16>, kWidth> crossed{};  // triangles that were passed last
  // Paths: distances to the surfaces passed, the nearest limit + 1 of each ray, in order.
  std::vector<float> distances;
};

// Number `field` of ray or hit k of N, which lie field by field: Embree may hand over fewer rays than a packet has.
template <class T>
T filter_field(const void *records, unsigned int field, const embree::FilterArguments &a, std::size_t k) {
  return static_cast<const T *>(records)[field * a.count + k];
}
constexpr unsigned int kRayDirection = 4, kRayFar = 8, kRayId = 10, kRayFlags = 11;
constexpr unsigned int kHitNg = 0, kHitU = 3, kHitV = 4, kHitPrimitive = 5, kHitGeometry = 6, kHitInstance = 7,
                       kHitPlace = 8;

inline EmbreeHit filtered(const embree::FilterArguments &a, std::size_t k) {
  const auto id = [&](unsigned int field) { return filter_field<std::uint32_t>(a.hit, field, a, k); };
  const auto number = [&](unsigned int field) { return filter_field<float>(a.hit, field, a, k); };
  return {vec3(number(kHitNg), number(kHitNg + 1), number(kHitNg + 2)),
          filter_field<float>(a.ray, kRayFar, a, k),
          number(kHitU),
          number(kHitV),
          id(kHitPrimitive),
          id(kHitGeometry),
          id(kHitInstance),
          id(kHitPlace)};
}

// The ray's direction in world space. Within an instance Embree has turned the ray into the space of the mesh.
inline vec3 filtered_direction(const SceneData &scene, const embree::FilterArguments &a, std::size_t k, const Hit &at) {
  const auto number = [&](unsigned int axis) { return filter_field<float>(a.ray, kRayDirection + axis, a, k); };
  const vec3 direction(number(0), number(1), number(2));
  if (filter_field<std::uint32_t>(a.hit, kHitInstance, a, k) == embree::kInvalidId) return direction;
  return instance_vector(scene.instances.v[at.instance], direction);
}

// Notes the distance of a surface that ray `id` passed.
template <int kWidth>
void note_pass(AlphaContext<kWidth> &c, std::size_t id, float t) {
  const std::size_t most = path_crossings(c.limits) + 1;
  float *first = c.distances.data() + id * most;
  const std::size_t count = std::min<std::size_t>(c.passed[id], most);
  ++c.passed[id];
  std::size_t i = count < most ? count : most - 1;
  if (count == most && t >= first[i]) return;
  for (; i > 0 && first[i - 1] > t; --i) first[i] = first[i - 1];
  first[i] = t;
}

// Did ray `id` pass this triangle before? Embree's packets ask of one in ten twice.
template <int kWidth>
bool crossed_before(AlphaContext<kWidth> &c, std::size_t id, const Hit &at) {
  const std::uint64_t key = std::uint64_t{at.instance} << 32 | at.triangle;
  auto &crossed = c.crossed[id];
  const auto end = crossed.begin() + std::min<std::ptrdiff_t>(c.passed[id], std::ssize(crossed));
  if (std::find(crossed.begin(), end, key) != end) return true;
  crossed[c.passed[id] % crossed.size()] = key;
  return false;
}

// Where nothing lets rays through: the rays still say which triangle they left, as set_left noted it.
template <int kWidth>
void filter_left(const embree::FilterArguments *a) {
  const auto &c = *reinterpret_cast<const AlphaContext<kWidth> *>(a->context);
  for (std::size_t k = 0; k < a->count; ++k) {
    if (a->valid[k] == 0) continue;
    const EmbreeHit at = filtered(*a, k);
    if (traced_instance(c.geometries, at) != filter_field<std::uint32_t>(a->ray, kRayId, *a, k)) continue;
    if (traced_hit(c.geometries, at).triangle == filter_field<std::uint32_t>(a->ray, kRayFlags, *a, k)) a->valid[k] = 0;
  }
}

// For rays of paths.
template <int kWidth>
void filter_path(const embree::FilterArguments *a) {
  auto &c = *reinterpret_cast<AlphaContext<kWidth> *>(a->context);
  for (std::size_t k = 0; k < a->count; ++k) {
    if (a->valid[k] == 0) continue;
    const Hit at = traced_hit(c.geometries, filtered(*a, k));
    const auto id = filter_field<std::uint32_t>(a->ray, kRayId, *a, k);
    if (at.triangle == c.left_triangle[id] && at.instance == c.left_instance[id]) {
      a->valid[k] = 0;
      continue;
    }
    const PathState &path = c.paths[id];
    if (!lets_through(*c.scene, at, filtered_direction(*c.scene, *a, k, at), path, c.passed[id], c.block_seed))
      continue;
    a->valid[k] = 0;
    if (c.limits.transparent_bounces < TRANSPARENT_UNLIMITED && !crossed_before(c, id, at)) {
      note_pass(c, id, filter_field<float>(a->ray, kRayFar, *a, k));
    }
  }
}

// For shadow rays.
template <int kWidth>
void filter_shadow(const embree::FilterArguments *a) {
  auto &c = *reinterpret_cast<AlphaContext<kWidth> *>(a->context);
  for (std::size_t k = 0; k < a->count; ++k) {
    if (a->valid[k] == 0) continue;
    const Hit at = traced_hit(c.geometries, filtered(*a, k));
    const auto id = filter_field<std::uint32_t>(a->ray, kRayId, *a, k);
    if (at.triangle == c.left_triangle[id] && at.instance == c.left_instance[id]) {
      a->valid[k] = 0;
      continue;
    }
    const PathState &path = *c.shadow_paths[id];
    const vec3 share =
        hit_transparency(*c.scene, at, filtered_direction(*c.scene, *a, k, at), path, true, c.passed[id]);
    if (max_component(share) > 0.0f && crossed_before(c, id, at)) {
      a->valid[k] = 0;
      continue;
    }
    c.kept[id] *= share;
    const uint crossed = path.transparent_bounces + ++c.passed[id];
    if (shadow_kept(c.limits, crossed, max_component(c.kept[id])) > 0.0f) a->valid[k] = 0;
  }
}

// Notes at ray k which triangle it left, for set_filter.
template <int kWidth>
void set_left(embree::Ray<kWidth> &ray, std::size_t k, uvec2 left) {
  ray.id[k] = left.x;
  ray.flags[k] = left.y;
  ray.tnear[k] = ray_begin(left, ray.tnear[k]);
}

template <int kWidth>
void set_filter(AlphaContext<kWidth> &c, embree::Ray<kWidth> &ray, embree::Filter filter,
                embree::QueryArguments &arguments) {
  if (!c.transparency) {
    std::uint32_t none = INVALID_ID;  // where no ray left a triangle, none is asked about
    for (std::size_t k = 0; k < kWidth; ++k) none &= ray.id[k];
    arguments.filter = none == INVALID_ID ? nullptr : reinterpret_cast<void *>(filter_left<kWidth>);
    return;
  }
  for (std::size_t k = 0; k < kWidth; ++k) {
    c.left_instance[k] = ray.id[k];
    c.left_triangle[k] = ray.flags[k];
    ray.id[k] = static_cast<std::uint32_t>(k);
    ray.flags[k] = 0;
  }
  c.passed.fill(0);
  arguments.filter = reinterpret_cast<void *>(filter);
}

// Counts the surfaces that rays of paths crossed, and ends those that crossed more than they may: their mask becomes 0.
template <int kWidth>
void end_passes(AlphaContext<kWidth> &c, embree::RayHit<kWidth> &p) {
  if (!c.transparency) return;
  const std::size_t most = path_crossings(c.limits) + 1;
  c.crossed_by_path.fill(0);
  if (c.limits.transparent_bounces >= TRANSPARENT_UNLIMITED) return;
  for (std::size_t k = 0; k < kWidth; ++k) {
    if (c.passed[k] == 0) continue;
    const float *first = c.distances.data() + k * most;
    const std::size_t noted = std::min<std::size_t>(c.passed[k], most);
    c.crossed_by_path[k] = static_cast<uint>(std::lower_bound(first, first + noted, p.ray.tfar[k]) - first);
    const uint crossed = c.paths[k].transparent_bounces + c.crossed_by_path[k];
    if (path_crossed_too_many(c.limits, crossed)) p.ray.mask[k] = 0;
  }
}

}  // namespace
}  // namespace cotorra

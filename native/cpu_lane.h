// SPDX-License-Identifier: GPL-3.0-or-later
// How the bodies of stages (kernels/stage/) reach the lane of a batch that they work on, as entry/vulkan/lane.glsl
// tells it for a GPU; and these bodies. Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_health.h"
#include "cpu_passes.h"
#include "cpu_visibility.h"
#include "cpu_world.h"

namespace cotorra {
namespace {

// A lane, by its place in the batch, and the sample that it belongs to.
struct Lane {
  const Tracer &t;
  std::size_t i;
  uint slot;
};

// The Bsdf at the lane's surface, gathered where it is asked for alone.
struct LaneBsdf {
  const ShadingLanes &shading;
  std::size_t i;
  operator Bsdf() const { return shading.bsdf(i); }
};

Lane lane_at(const Tracer &t, std::size_t i) { return {t, i, t.batch.slot[i]}; }
// For what concerns the sample alone.
Lane lane_of_sample(const Tracer &t, std::size_t slot) { return {t, 0, static_cast<uint>(slot)}; }

// ---- What passes are told. Records of the tile that is being sampled are sums already.

std::size_t pixel_of(const Lane &lane) { return lane.t.batch.pixel[lane.slot]; }

void note_emission(const Lane &lane, vec3 light) {
  if (lane.t.job.passes.emission) lane.t.batch.staged.emission[pixel_of(lane)] += film_vector(light);
}

void note_environment(const Lane &lane, vec3 light) {
  if (lane.t.job.passes.environment) lane.t.batch.staged.environment[pixel_of(lane)] += film_vector(light);
}

void note_shadow(const Lane &lane, float arrived, float sent) {
  if (!lane.t.job.passes.shadow) return;
  ShadowRecord &r = lane.t.batch.staged.shadow[pixel_of(lane)];
  r.unshadowed += film_number(sent);
  r.lit += film_number(arrived);
}

void note_sky(const Lane &lane, float sky) { lane.t.batch.staged.occlusion[pixel_of(lane)] += sky; }

void note_terms(const Lane &lane, float d, float g, vec3 f) {
  TermRecord &r = lane.t.batch.staged.terms[pixel_of(lane)];
  r.d += film_number(d);
  r.g += film_number(g);
  r.f += film_vector(f);
}

void note_surface(const Lane &lane, const FirstSurface &first) {
  const PassSelection &passes = lane.t.job.passes;
  FilmTile &staged = lane.t.batch.staged;
  if (passes.nearest) {
    NearestRecord &r = staged.nearest[pixel_of(lane)];
    if (first.distance2 < r.distance2) {
      r.distance2 = first.distance2;
      r.depth = film_number(first.depth);
      r.position = film_vector(first.position);
      r.object_index = first.object_index;
      r.material_index = first.material_index;
    }
  }
  if (passes.surface) {
    SurfaceRecord &r = staged.surface[pixel_of(lane)];
    r.normal += film_vector(first.normal);
    r.uv = r.uv + vec2(film_number(first.uv.x), film_number(first.uv.y));
    r.uv_coverage += first.uv_coverage;
    r.diffuse_color += film_vector(first.diffuse_color);
  }
}

void note_features(const Lane &lane, vec3 albedo, vec3 normal) {
  FeatureRecord &r = lane.t.batch.staged.features[pixel_of(lane)];
  r.albedo += film_vector(albedo);
  r.normal += film_vector(normal);
}

// Light as it counts where it is clamped; how much that holds back is counted, and how much are caustics: what comes to
// a rough surface by way of gloss or glass.
vec3 clamped(const Lane &lane, vec3 light, float limit) {
  const IntegratorData &integrator = lane.t.data.integrator;
  const bool clamps = min(integrator.clamp_direct, integrator.clamp_indirect) < INFINITE_DISTANCE;
  if (!clamps && !(integrator.filter_glossy > 0.0f)) return light;
  const PathState &path = lane.t.batch.path[lane.i];
  const bool caustic = path.diffuse_bounces > 0u && (path.ray_kind & (VISIBLE_GLOSSY | VISIBLE_TRANSMISSION)) != 0u;
  return count_clamped(light, limit, caustic, lane.t.counts);
}

void note_found(const Lane &lane, const PathState &path, vec3 light, uint place, uint id) {
  const bool lamp = place == HEALTH_LAMP;
  note_light(lane.t, lane.slot, light,
             {0, place, lamp ? kNobody : id, lamp ? id : kNobody, path.bounce, 0, kWeightArgument});
}

// What the background shows the lane's ray, which met nothing.
vec3 world_seen(const Lane &lane, const PathState &path, vec3 direction) {
  if (world_runs_in_batches(lane.t)) return lane.t.batch.sky.get(lane.i);
  return world_radiance(*lane.t.job.scene, path_background(path, direction));
}

// Whitted's rays wait by depth; see cpu_whitted.h.
void push_ray(const Lane &lane, const PendingRay &ray) {
  lane.t.batch.classic->pending[ray.path.bounce].push_back(ray);
}

}  // namespace
}  // namespace cotorra

#define LANE const Lane &
#define LANE_BSDF const LaneBsdf &
#define SCENE (*lane.t.job.scene)
#define JOB lane.t.data
#define FLAG(BIT) ((JOB.flags & (BIT)) != 0u)
#define SLOT(lane) (lane).slot
#define RADIANCE(lane) (lane).t.batch.radiance[(lane).slot]
#define ALPHA(lane) (lane).t.batch.alpha[(lane).slot]
#define FILTER_OFFSET(lane) vec2((lane).t.batch.u[(lane).slot], (lane).t.batch.v[(lane).slot])
#define GROUP_LIGHT(lane, group) (lane).t.batch.groups[(lane).slot * JOB.light_groups + (group)]
#define LAMP_LIGHT(lane, lamp) (lane).t.batch.lamps[(lane).slot * JOB.lamp_passes + (lamp)]
#define WORLD_SEEN world_seen
#define MEDIUM(lane) (lane).t.batch.classic->medium[(lane).i]
#define NOTE_EMISSION note_emission
#define NOTE_ENVIRONMENT note_environment
#define NOTE_SKY note_sky
#define NOTE_FEATURES note_features
#define CLAMPED clamped
#define PATH_BOUNCE(lane) (lane).t.batch.path[(lane).i].bounce
#define NOTE_SHADOW note_shadow
#define NOTE_SURFACE note_surface
#define NOTE_TERMS note_terms
#define PUSH_RAY push_ray
#define NOTE_LIT(lane, light) note_lit((lane).t, (lane).i, (lane).slot, light, kNobody)
#define NOTE_FOUND note_found
#define NOTE_SCATTER(lane, path, b) note_scatter((lane).t, (lane).i, (lane).slot, path, b)

#include "../kernels/stage/arrive.h"
#include "../kernels/stage/leave.h"
#include "../kernels/stage/meet.h"
#include "../kernels/stage/recursion.h"
#include "../kernels/stage/through.h"

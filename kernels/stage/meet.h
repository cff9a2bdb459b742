// SPDX-License-Identifier: GPL-3.0-or-later
// What a path's ray met: lamps on its way, the background, a surface that emits; and what passes tell of the first
// surface. LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl).
#ifndef COTORRA_STAGE_MEET_H
#define COTORRA_STAGE_MEET_H

#include "../denoising.h"
#include "../lamp_terms.h"
#include "arrive.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Adds light that a path found by itself, on its way or where it ended.
FN void add_found(LANE lane, IN(PathState) path, vec3 found, int group) {
  add_light(lane, found, group);
  if (FEATURE(FEATURE_DATA_PASSES) && FLAG(JOB_FEATURES_PASS) && path_shows_features(path)) {
    NOTE_FEATURES(lane, light_features(found), vec3(0.0f));
  }
}

FN void meet_light(LANE lane, uint index, IN(PathState) path, vec3 origin, vec3 direction, float t) {
  int group;
  const vec3 met = path_meet_light(SCENE, index, path, origin, direction, t, group);
  if (is_black(met)) return;
  if (FEATURE(FEATURE_HEALTH)) NOTE_FOUND(lane, path, met, HEALTH_LAMP, index);
  const vec3 seen = CLAMPED(lane, met, found_limit(JOB.integrator, path));
  add_found(lane, path, seen, group);
  if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) NOTE_EMISSION(lane, seen);
}

// Lamps on the first t metres of the ray; it goes on behind them.
FN void meet_lights(LANE lane, IN(PathState) path, vec3 origin, vec3 direction, float t) {
  const bool many = FEATURE(FEATURE_LIGHT_TREE) && SCENE.light_count > LIGHTS_AT_ONCE;
  uint place = 0u;
  for (uint l = 0u; l < SCENE.light_count; ++l) {
    const uint index = many ? light_tree_next(SCENE, origin, direction, t, place) : l;
    if (index == INVALID_ID) break;
    meet_light(lane, index, path, origin, direction, t);
  }
}

// The ray met no surface. Those that let it through on its way leave of a transparent film what they took of the ray,
// as in Cycles.
FN void escape(LANE lane, IN(PathState) path, vec3 direction) {
  if (FEATURE(FEATURE_WORLD)) {
    vec3 sky = vec3(0.0f);
    if (path_sees_world(SCENE, path)) {
      sky = path_escape(SCENE, path, direction, WORLD_SEEN(lane, path, direction));
    }
    if (FEATURE(FEATURE_HEALTH)) NOTE_FOUND(lane, path, sky, HEALTH_WORLD, INVALID_ID);
    const vec3 world = CLAMPED(lane, sky, found_limit(JOB.integrator, path));
    if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) NOTE_ENVIRONMENT(lane, world);
    if (path.bounce > 0u || !FLAG(JOB_TRANSPARENT)) add_found(lane, path, world, SCENE.world_group);
  }
  if (path.bounce == 0u && FLAG(JOB_TRANSPARENT)) ALPHA(lane) = max(1.0f - mean_component(path.throughput), 0.0f);
}

// Adds the light of what the ray met on its way and, behind it, of the background. Returns whether it met a surface.
FN bool meet(LANE lane, IN(PathState) path, vec3 origin, vec3 direction, IN(Hit) hit) {
  const bool missed = hit.instance == INVALID_ID;
  const bool meets = path.bounce > 0u ? FEATURE(FEATURE_BSDF_RAYS) : FLAG(JOB_CAMERA_MEETS_LIGHTS);
  if (FEATURE(FEATURE_VISIBLE_LIGHTS) && meets) {
    meet_lights(lane, path, origin, direction, missed ? INFINITE_DISTANCE : hit.t);
  }
  if (missed) escape(lane, path, direction);
  return !missed;
}

// Adds what the surface itself emits; `material` is the scene's record.
FN void add_emission(LANE lane, IN(PathState) path, IN(Surface) s, IN(Material) material, vec3 direction) {
  if ((material.flags & MATERIAL_EMISSIVE) == 0u) return;
  const vec3 found = path_emission(SCENE, path, s, material, -direction, s.t);
  if (FEATURE(FEATURE_HEALTH)) NOTE_FOUND(lane, path, found, HEALTH_EMISSION, s.material);
  const vec3 emitted = CLAMPED(lane, found, found_limit(JOB.integrator, path));
  add_found(lane, path, emitted, LOAD(SCENE.instances, s.instance).light_group);
  if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) NOTE_EMISSION(lane, emitted);
}

// Shows denoisers the surface, or what it mirrors.
FN void show_features(LANE lane, INOUT(PathState) path, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo) {
  if (!FLAG(JOB_FEATURES_PASS) || !path_shows_features(path)) return;
  Features features;
  if (!path_features(SCENE, path, bsdf, lobe, wo, features)) return;
  NOTE_FEATURES(lane, features.albedo, features.normal);
  path.ray_kind &= ~RAY_SHOWN;
}

// Tells passes of a surface that scatters. Where paths go straight through, they tell of what is behind.
FN void describe(LANE lane, IN(PathState) path, IN(Surface) s, IN(Material) material, vec3 weight, IN(Bsdf) bsdf,
                 IN(Lobe) lobe, vec3 wo) {
  if (path.bounce != 0u || (bsdf.lobes & BSDF_THROUGH) != 0u) return;
  if ((bsdf.lobes & BSDF_HOLDOUT) != 0u) ALPHA(lane) = 1.0f - mean_component(path.throughput);
  if (FEATURE(FEATURE_DATA_PASSES)) {
    const Instance instance = LOAD(SCENE.instances, s.instance);
    const vec2 offset = FILTER_OFFSET(lane);
    FirstSurface first;
    first.position = s.p;
    first.depth = camera_depth(JOB.camera, s.p);
    first.object_index = float(instance.pass_index);
    first.material_index = float(material.pass_index);
    first.distance2 = sqr(offset.x) + sqr(offset.y);
    first.normal = s.n;
    first.uv = surface_uv(SCENE, s);
    first.uv_coverage = (LOAD(SCENE.meshes, instance.mesh).flags & MESH_HAS_UV) != 0u ? 1.0f : 0.0f;
    vec3 diffuse = bsdf.diffuse * PI;
    if (has_lobe(lobe)) diffuse = lobe_is_diffuse(lobe) ? lobe_albedo(SCENE.albedo, lobe, wo) : vec3(0.0f);
    first.diffuse_color = diffuse * weight;
    NOTE_SURFACE(lane, first);
  }
  if (FEATURE(FEATURE_TERMS) && FLAG(JOB_TERMS_PASS)) {
    float d;
    float g;
    vec3 f;
    lamp_terms(SCENE, s.p, bsdf, wo, d, g, f);
    NOTE_TERMS(lane, d, g, f);
  }
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

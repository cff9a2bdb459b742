// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4: light samples of each lane at a surface: every lamp, or a few lights that the tree picks, the background,
// and the sky for ambient occlusion. It makes shadow rays and traces none.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/leave.h"
#include "stand.glsl"
#include "whitted.glsl"

// The contribution is shade.comp's, where the ray has one.
void send_sky(uint lane, PathState path, Surface s, uint block_seed) {
  const uint place = push.sky_slot * WAVE.lanes + lane;
  ShadowRay ray;
  occlusion_ray(SCENE, s, vertex_random(path, block_seed, PAIR_OCCLUSION), JOB.occlusion_distance, ray);
  if (FLAG(JOB_AMBIENT_OCCLUDED)) ray.contribution = LOAD(WAVE.shadow_contribution, place);
  store_shadow(place, ray);
  STORE(WAVE.shadows_queue, append(WAVE_SHADOWS), place);
}

void send_to_lights(uint lane, PathState path, Surface s, uint block_seed) {
  const vec3 wo = -WAVE.rays.v[lane].direction;
  Bsdf bsdf;
  Lobe lobe;
  if (SCATTERS) scattering_at(lane, path, s, wo, bsdf, lobe);
  const uint world_slots = FEATURE(FEATURE_WORLD_LIGHT) ? 1u : 0u;  // the last
  const uint slots = push.light_slots - world_slots;
  const float fresh = vertex_random(path, block_seed, PAIR_PICK).y;
  LightWeights root;
  if (FEATURE(FEATURE_LIGHT_TREE) && SCENE.tree_picks > 0u) root = path_light_weights(SCENE, s, lobe);
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    ShadowRay ray;
    bool sent = false;
    if (FEATURE(FEATURE_TOON)) {
      sent = toon_light_ray(SCENE, slot, s, ray);
    } else if (slot < slots) {
      float scale;
      vec2 u = vertex_random(path, block_seed, light_pair(SCENE, slot));
      const uint light = light_of_slot(lane, slot, slots, s, lobe, root, fresh, u, scale);
      if (light != INVALID_ID) sent = path_sample_picked(SCENE, light, path, s, bsdf, lobe, wo, u, scale, ray);
    } else {
      const vec2 u = vertex_random(path, block_seed, PAIR_WORLD);
      sent = path_sample_world(SCENE, path, s, bsdf, lobe, wo, u, ray);
    }
    if (sent && JOB.integrator.shadow_roulette > 0.0f) {
      sent = shadow_survives(lane, slot, vertex_random(path, block_seed, PAIR_SHADOW).x, ray);
    }
    const uint place = slot * WAVE.lanes + lane;
    if (!sent) {
      STORE(WAVE.shadow_t_max, place, SHADOW_NONE);
      continue;
    }
    const bool shadow = ray.visibility != 0u;
    if (!shadow) ray.t_max = 1.0f;  // all of it arrives
    store_shadow(place, ray);
    if (shadow) STORE(WAVE.shadows_queue, append(WAVE_SHADOWS), place);
  }
}

void main() {
  if (beyond(WAVE_SHADING)) return;
  const uint lane = LOAD(WAVE.shading_queue, gl_GlobalInvocationID.x);
  if (FEATURE(FEATURE_WHITTED) && !stands_at_surface(lane)) return;
  const PathState path = load_path(lane);
  const Surface s = surface_at(lane);
  const uint block_seed = pixel_of(lane).block_seed;
  if (push.light_slots > 0u) send_to_lights(lane, path, s, block_seed);
  if (FEATURE(FEATURE_OCCLUSION) && push.sky_slot != INVALID_ID) send_sky(lane, path, s, block_seed);
}

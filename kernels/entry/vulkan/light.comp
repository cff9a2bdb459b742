// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4: light samples of each lane at a surface: every lamp or a few picked ones, a point on an emitting triangle,
// and the sky for ambient occlusion. It makes shadow rays and traces none.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/leave.h"
#include "stand.glsl"
#include "whitted.glsl"

bool sample_lamp(uint lane, uint slot, uint slots, float u_pick, uint block_seed, PathState path, Surface s, Bsdf bsdf,
                 Lobe lobe, vec3 wo, out ShadowRay ray) {
  float scale;
  const uint index = lamp_of_slot(lane, slot, slots, u_pick, s, lobe, scale);
  if (index == INVALID_ID) return false;
  const vec2 u = vertex_random(path, block_seed, lamp_pair(slot));
  return path_sample_light(SCENE, index, path, s, bsdf, lobe, wo, u, scale, ray);
}

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
  const bool emitters = FEATURE(FEATURE_EMISSIVE_MESHES) && SCENE.emitter_count > 0u;
  const uint world_slots = FEATURE(FEATURE_WORLD_LIGHT) ? 1u : 0u;  // the last
  const uint lamp_slots = push.light_slots - world_slots - (emitters ? 1u : 0u);
  const vec2 pick = vertex_random(path, block_seed, PAIR_PICK);
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    ShadowRay ray;
    bool sent;
    if (FEATURE(FEATURE_TOON)) {
      sent = toon_light_ray(SCENE, slot, s, ray);
    } else if (slot < lamp_slots) {
      sent = sample_lamp(lane, slot, lamp_slots, pick.x, block_seed, path, s, bsdf, lobe, wo, ray);
    } else if (slot + world_slots == push.light_slots) {
      const vec2 u = vertex_random(path, block_seed, PAIR_WORLD);
      sent = path_sample_world(SCENE, path, s, bsdf, lobe, wo, u, ray);
    } else {
      const vec2 u = vertex_random(path, block_seed, PAIR_EMITTER);
      sent = path_sample_emitter(SCENE, path, s, bsdf, lobe, wo, pick.y, u, ray);
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

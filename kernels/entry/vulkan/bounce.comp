// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 6: adds the light that arrived at each lane's surface, and samples the ray that takes the path on; Whitted's
// goes on with one of those that wait.
// Lanes that go on make up the queue of rays again.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/arrive.h"
#include "stage/leave.h"
#include "stand.glsl"
#include "whitted.glsl"

void gather_lights(uint lane) {
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    const uint place = slot * WAVE.lanes + lane;
    const float share = LOAD(WAVE.shadow_t_max, place);
    if (share == SHADOW_NONE) continue;
    const ShadowRay ray = load_shadow(place);
    arrive(lane, push.bounce == 0u, ray.contribution, vec3(share), ray.group);
  }
}

// Toon: the lamps that light the point fully are counted.
void gather_tone(uint lane) {
  uint lit = 0u;
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    lit += LOAD(WAVE.shadow_t_max, slot * WAVE.lanes + lane) >= 0.5f ? 1u : 0u;
  }
  const uint id = triangle_material(SCENE, WAVE.hits.v[lane].instance, WAVE.hits.v[lane].triangle);
  Material material = LOAD(SCENE.materials, id);
  material.base_color = LOAD(WAVE.base_colors, lane);
  tone_arrives(lane, id, material, lit);
}

void gather(uint lane) {
  if (FEATURE(FEATURE_TOON)) {
    gather_tone(lane);
  } else {
    gather_lights(lane);
  }
  if (FEATURE(FEATURE_OCCLUSION) && push.sky_slot != INVALID_ID) {
    const uint place = push.sky_slot * WAVE.lanes + lane;
    const ShadowRay ray = load_shadow(place);
    sky_arrives(lane, push.bounce == 0u, ray.contribution, ray.t_max);
  }
}

void main() {
  if (beyond(WAVE_SHADING)) return;
  const uint lane = LOAD(WAVE.shading_queue, gl_GlobalInvocationID.x);
  if (FEATURE(FEATURE_WHITTED)) {
    if (stands_at_surface(lane)) gather(lane);
    if (take_pending(lane)) STORE(WAVE.rays_queue, append(WAVE_RAYS), lane);
    return;
  }
  gather(lane);
  if (!FEATURE(FEATURE_BOUNCES) && !FEATURE(FEATURE_BSDF_RAYS)) return;
  PathState path = load_path(lane);
  const vec3 wo = -WAVE.rays.v[lane].direction;
  const Surface s = surface_at(lane);
  Bsdf bsdf;
  Lobe lobe;
  scattering_at(lane, path, s, wo, bsdf, lobe);
  const uint block_seed = pixel_of(lane).block_seed;
  const vec2 u = vertex_random(path, block_seed, PAIR_BSDF);
  const vec2 choice = vertex_random(path, block_seed, PAIR_CHOICE);
  BsdfSample b;
  scattering_sample(SCENE, bsdf, lobe, wo, choice.x, u, b);
  CameraRay ray;
  ray.t_min = 0.0f;
  ray.t_max = INFINITE_DISTANCE;
  if (!go_on(lane, path, s, bsdf, lobe, bsdf.lobes, wo, b, choice.y, ray.origin, ray.direction)) return;
  store_path(lane, path);
  STORE(WAVE.rays, lane, ray);
  STORE(WAVE.rays_queue, append(WAVE_RAYS), lane);
}

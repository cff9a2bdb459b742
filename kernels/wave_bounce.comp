// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 6: adds the light that arrived at each lane's surface, and samples the ray that takes the path on; Whitted's
// goes on with one of those that wait.
// Lanes that go on make up the queue of rays again.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "whitted.glsl"

void gather_lights(uint lane) {
  const float limit = light_limit(WAVE.integrator, WAVE.paths.v[lane].bounce);
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    const uint place = slot * WAVE.lanes + lane;
    const float share = WAVE.shadow_rays.v[place].t_max;
    if (share == SHADOW_NONE) continue;
    const vec3 contribution = WAVE.shadow_rays.v[place].contribution;
    const int group = WAVE.shadow_rays.v[place].group;
    if (share > 0.0f) add_light(lane, clamped_light(contribution * share, limit), group);
    if (FEATURE(FEATURE_DATA_PASSES) && push.bounce == 0u) {
      const float l = luminance(contribution);
      WAVE.records.v[lane].unshadowed += l;
      WAVE.records.v[lane].lit += l * share;
    }
  }
}

// Toon: the tone of the lamps that light the point fully.
void gather_tone(uint lane) {
  uint lit = 0u;
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    lit += WAVE.shadow_rays.v[slot * WAVE.lanes + lane].t_max >= 0.5f ? 1u : 0u;
  }
  const uint id = WAVE.surfaces.v[lane].material;
  Material material = LOAD(WAVE.scene.materials, id);
  material.base_color = LOAD(WAVE.base_colors, lane);
  add_light(lane, toon_color(material, LOAD(WAVE.scene.classic, id), lit, push.light_slots), -1);
}

void gather_sky(uint lane) {
  const uint place = push.sky_slot * WAVE.lanes + lane;
  const float sky = WAVE.shadow_rays.v[place].t_max;
  if (FEATURE(FEATURE_DATA_PASSES) && flag(WAVE_OCCLUSION_PASS) && push.bounce == 0u) {
    WAVE.records.v[lane].occlusion = sky;
  }
  if (flag(WAVE_AMBIENT_OCCLUDED)) add_light(lane, WAVE.shadow_rays.v[place].contribution * sky, -1);
  if (flag(WAVE_OCCLUSION_PICTURE)) WAVE.samples.v[lane].radiance = vec3(sky);
}

void gather(uint lane) {
  if (FEATURE(FEATURE_TOON)) {
    gather_tone(lane);
  } else {
    gather_lights(lane);
  }
  if (FEATURE(FEATURE_OCCLUSION) && push.sky_slot != INVALID_ID) gather_sky(lane);
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
  PathState path = LOAD(WAVE.paths, lane);
  const Surface s = LOAD(WAVE.surfaces, lane);
  const Bsdf bsdf = LOAD(WAVE.bsdfs, lane);
  Lobe lobe;
  if (FEATURE(FEATURE_LOBES)) lobe = LOAD(WAVE.lobes, lane);
  const vec3 wo = -WAVE.rays.v[lane].direction;
  const uint block_seed = pixel_of(lane).block_seed;
  const vec2 u = vertex_random(path, block_seed, PAIR_BSDF);
  const vec2 choice = vertex_random(path, block_seed, PAIR_CHOICE);
  CameraRay ray;
  ray.t_min = 0.0f;
  ray.t_max = INFINITE_DISTANCE;
  if (!path_bounce(WAVE.scene, WAVE.integrator, path, s, bsdf, lobe, wo, u, choice, ray.origin, ray.direction)) return;
  // A last ray can only bring light home: where there is none to find, it need not be traced.
  const bool finds =
      FEATURE(FEATURE_BSDF_RAYS) && (flag(WAVE_LAST_RAYS_FIND_LIGHT) || (path.ray_kind & RAY_MEETS_LAMPS) != 0u);
  if (!finds && path_is_last(WAVE.integrator, path)) return;
  STORE(WAVE.paths, lane, path);
  STORE(WAVE.rays, lane, ray);
  STORE(WAVE.rays_queue, append(WAVE_RAYS), lane);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 6: adds the light that arrived at each lane's surface, and samples the ray that takes the path on; Whitted's
// goes on with one of those that wait.
// Lanes that go on make up the queue of rays again.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "whitted.glsl"

void gather(uint lane) {
  for (uint slot = 0u; slot < push.light_slots; ++slot) {
    const uint place = slot * WAVE.lanes + lane;
    const float share = WAVE.shadow_rays.v[place].t_max;
    if (share == SHADOW_NONE) continue;
    const vec3 contribution = WAVE.shadow_rays.v[place].contribution;
    if (share > 0.0f) add_light(lane, contribution * share, WAVE.shadow_rays.v[place].group);
    if (FEATURE(FEATURE_DATA_PASSES) && push.bounce == 0u) {
      const float l = luminance(contribution);
      WAVE.records.v[lane].unshadowed += l;
      WAVE.records.v[lane].lit += l * share;
    }
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
  PathState path = LOAD(WAVE.paths, lane);
  const Surface s = LOAD(WAVE.surfaces, lane);
  const Bsdf bsdf = LOAD(WAVE.bsdfs, lane);
  const vec3 wo = -WAVE.rays.v[lane].direction;
  const uint block_seed = pixel_of(lane).block_seed;
  const vec2 u = vertex_random(path, block_seed, PAIR_BSDF);
  const vec2 choice = vertex_random(path, block_seed, PAIR_CHOICE);
  CameraRay ray;
  ray.t_min = 0.0f;
  ray.t_max = INFINITE_DISTANCE;
  if (!path_bounce(WAVE.integrator, path, s, bsdf, wo, u, choice, ray.origin, ray.direction)) return;
  // A last ray can only bring light home: where there is none to find, it need not be traced.
  const bool finds =
      FEATURE(FEATURE_BSDF_RAYS) && (flag(WAVE_LAST_RAYS_FIND_LIGHT) || (path.ray_kind & RAY_MEETS_LAMPS) != 0u);
  if (!finds && path_is_last(WAVE.integrator, path)) return;
  STORE(WAVE.paths, lane, path);
  STORE(WAVE.rays, lane, ray);
  STORE(WAVE.rays_queue, append(WAVE_RAYS), lane);
}

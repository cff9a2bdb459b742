// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 2: the nearest surface along each ray in the queue. The one place where such rays are traced.
// Compiled twice, with a BVH of our own and (RAY_QUERY) with the hardware's.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "alpha.h"
#include "trace.glsl"

// Does the surface let the ray through? At random, in proportion to what it keeps.
bool lets_through(Hit hit, vec3 direction, PathState path, uint crossed, uint block_seed) {
  const float alpha = hit_alpha(WAVE.scene, hit, direction, path, false, crossed);
  if (alpha >= 1.0f) return false;
  return alpha_number(path.random, path.bounce, block_seed, hit.instance, hit.triangle) >= alpha;
}

void main() {
  if (beyond(WAVE_RAYS)) return;
  const uint lane = LOAD(WAVE.rays_queue, gl_GlobalInvocationID.x);
  const CameraRay ray = LOAD(WAVE.rays, lane);
  const PathState path = LOAD(WAVE.paths, lane);
  uint crossed = 0u;
  float t_min = ray.t_min;
  Hit hit;
  while (true) {
    trace(ray.origin, ray.direction, t_min, ray.t_max, path.ray_kind & VISIBLE_ALL, false, hit);
    if (!FEATURE(FEATURE_TRANSPARENCY) || hit.instance == INVALID_ID) break;
    if (!lets_through(hit, ray.direction, path, crossed, pixel_of(lane).block_seed)) break;
    crossed += 1u;
    t_min = hit.t;
    if (!path_crossed_too_many(WAVE.integrator, path.transparent_bounces + crossed)) continue;
    hit.t = HIT_ENDED;
    break;
  }
  hit.crossed = crossed;
  STORE(WAVE.hits, lane, hit);
}

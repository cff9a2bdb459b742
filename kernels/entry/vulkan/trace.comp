// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 2: the nearest surface along each ray in the queue. The one place where such rays are traced.
// Compiled twice, with a BVH of our own and (RAY_QUERY) with the hardware's.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/through.h"
#include "trace.glsl"

void main() {
  if (beyond(WAVE_RAYS)) return;
  const uint lane = LOAD(WAVE.rays_queue, gl_GlobalInvocationID.x);
  const CameraRay ray = LOAD(WAVE.rays, lane);
  const PathState path = load_path(lane);
  uint crossed = 0u;
  uvec2 left = uvec2(INVALID_ID, INVALID_ID);
  // Whitted's rays waited while others were traced: the lane's surface is not theirs.
  if (path.vertex > 0u && !FEATURE(FEATURE_WHITTED)) {
    left = left_at(lane, ray.origin, ray.direction);
  }
  float t_min = ray_begin(left, ray.t_min);
  Hit hit;
  while (true) {
    trace(ray.origin, ray.direction, t_min, ray.t_max, path.ray_kind & VISIBLE_ALL, false, left, hit);
    if (!FEATURE(FEATURE_TRANSPARENCY) || hit.instance == INVALID_ID) break;
    if (!lets_through(SCENE, hit, ray.direction, path, crossed, pixel_of(lane).block_seed)) break;
    crossed += 1u;
    t_min = hit.t;
    if (!path_crossed_too_many(JOB.integrator, path.transparent_bounces + crossed)) continue;
    hit.t = HIT_ENDED;
    break;
  }
  hit.crossed = crossed;
  STORE(WAVE.hits, lane, hit);
}

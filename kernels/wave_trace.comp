// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 2: the nearest surface along each ray in the queue. The one place where such rays are traced.
// Compiled twice, with a BVH of our own and (RAY_QUERY) with the hardware's.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"

void main() {
  if (beyond(WAVE_RAYS)) return;
  const uint lane = LOAD(WAVE.rays_queue, gl_GlobalInvocationID.x);
  const CameraRay ray = LOAD(WAVE.rays, lane);
  const uint mask = WAVE.paths.v[lane].ray_kind & VISIBLE_ALL;
  Hit hit;
  hit.t = ray.t_max;
  hit.u = 0.0f;
  hit.v = 0.0f;
  hit.triangle = 0u;
  hit.instance = INVALID_ID;
  bvh_trace(WAVE.bvh, ray.origin, ray.direction, ray.t_min, mask, false, hit);
  STORE(WAVE.hits, lane, hit);
}

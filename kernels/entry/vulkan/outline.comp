// SPDX-License-Identifier: GPL-3.0-or-later
// Toon's outlines, between stages 2 and 3: takes in what one of the nine rays met, and starts the next, which stage 2
// traces. After the last, the camera ray and what it met stand where stage 3 looks for them. Lines are drawn by
// film.comp.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"

// The camera ray of the lane, moved as ray 0 to 8 is.
void start_moved(uint lane, uint ray_number) {
  const WavePixel pixel = pixel_of(lane);
  const vec2 offset = FILTER_OFFSET(lane);
  const vec2 move = outline_move(ray_number);
  const float x = float(pixel.x) + 0.5f + offset.x + move.x * JOB.outline_x;
  const float y = float(pixel.y) + 0.5f + offset.y + move.y * JOB.outline_y;
  CameraRay ray;
  camera_ray(JOB.camera, x, y, ray);
  STORE(WAVE.rays, lane, ray);
}

void main() {
  if (!FEATURE(FEATURE_TOON) || beyond(WAVE_RAYS)) return;
  const uint lane = LOAD(WAVE.rays_queue, gl_GlobalInvocationID.x);
  const Hit hit = LOAD(WAVE.hits, lane);
  OutlinePoint point;
  outline_point(SCENE, JOB.camera, JOB.rows, hit, WAVE.rays.v[lane].direction, point);
  OutlineSums sums;
  if (push.outline_ray == OUTLINE_MIDDLE) {
    outline_begin(sums);
    STORE(WAVE.outline_hits, lane, hit);
    STORE(WAVE.outline_points, lane, point);
  } else {
    const OutlinePoint middle = LOAD(WAVE.outline_points, lane);
    sums = LOAD(WAVE.outline_sums, lane);
    outline_add(middle, push.outline_ray, point.instance, point.p, point.n, sums);
  }
  STORE(WAVE.outline_sums, lane, sums);
  const uint next = outline_next(push.outline_ray);
  start_moved(lane, next);
  if (next == OUTLINE_MIDDLE) STORE(WAVE.hits, lane, LOAD(WAVE.outline_hits, lane));
}

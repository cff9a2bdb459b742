// SPDX-License-Identifier: GPL-3.0-or-later
// Toon on a CPU: counts the lamps that light each lane, and finds lines by tracing rays around each camera ray.
// Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_visibility.h"

namespace cotorra {
namespace {

// Lamps that light each lane's point fully.
void count_lamps(const Tracer &t, int lanes) {
  Batch &b = t.batch;
  const SceneData &scene = *t.job.scene;
  Array<uint, kLanes> &lit = b.classic->lit;
  std::fill_n(lit.data(), lanes, 0u);
  VisibilityQueue queue(t, [&lit](uint lane, float kept) { lit[lane] += kept >= 0.5f ? 1u : 0u; });
  for (uint light = 0; light < scene.light_count; ++light) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      ShadowRay ray;
      if (!toon_light_ray(scene, light, b.surface[i], ray)) continue;
      if (ray.visibility == 0u) {
        ++lit[i];
      } else {
        queue.push(ray, b.surface[i], static_cast<uint>(i), b.path[i]);
      }
    }
  }
  queue.flush();
}

// The camera rays of all lanes, moved by x, y pixels.
void start_moved(const Tracer &t, int lanes, float x, float y) {
  const Batch &b = t.batch;
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    CameraRay ray;
    // Pixel centres and filter offsets, as camera_packets left them.
    camera_ray(t.job.camera, b.u2[i] + b.u[i] + x, b.v2[i] + b.v[i] + y, ray);
    start_ray(b.classic->around[i / kWidth], i % kWidth, ray.origin, ray.direction, ray.t_min, ray.t_max,
              VISIBLE_CAMERA);
  }
}

// Gathers what the rays around each lane's camera ray meet, which is traced already.
void gather_outlines(const Tracer &t, int lanes) {
  ClassicLanes &c = *t.batch.classic;
  const auto hit_point = [&t](const embree::RayHit<kWidth> *packets, std::size_t i) {
    const embree::RayHit<kWidth> &p = packets[i / kWidth];
    const std::size_t k = i % kWidth;
    const RenderJob &job = t.job;
    OutlinePoint point;
    outline_point(*job.scene, job.camera, job.classic.rows, packet_hit(job, p, k), packet_direction(p, k), point);
    return point;
  };
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    c.middle[i] = hit_point(t.batch.packets.data(), i);
    outline_begin(c.sums[i]);
  }
  for (uint ray = outline_next(OUTLINE_MIDDLE); ray != OUTLINE_MIDDLE; ray = outline_next(ray)) {
    const vec2 move = outline_move(ray);
    start_moved(t, lanes, move.x * t.job.classic.outline_x, move.y * t.job.classic.outline_y);
    trace_packets(t, c.around.data(), lanes, false);
    t.counts.camera += static_cast<std::uint64_t>(lanes);
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const OutlinePoint point = hit_point(c.around.data(), i);
      outline_add(c.middle[i], ray, point.instance, point.p, point.n, c.sums[i]);
    }
  }
}

}  // namespace
}  // namespace cotorra

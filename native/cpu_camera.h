// SPDX-License-Identifier: GPL-3.0-or-later
// Camera rays, whole packets at once. Included by cpu_kernel.cpp alone.
#pragma once

#include "cpu_batch.h"

namespace cotorra {
namespace {

// Camera rays through u2, v2 plus the filter offsets that u, v choose and then hold. Whole packets: the last one may
// carry rays that nobody traces.
COTORRA_FLATTEN void camera_packets(const CameraData &camera_in, FloatBuffer filter_table, int n, Batch &b) {
  const CameraData camera = camera_in;
  for (std::size_t first = 0; first < static_cast<std::size_t>(n); first += kWidth) {
    embree::RayHit<kWidth> &p = b.packets[first / kWidth];
    for (std::size_t k = 0; k < kWidth; ++k) {
      const std::size_t i = first + k;
      const float x = filter_sample(filter_table, b.u[i]) * camera.filter_radius;
      const float y = filter_sample(filter_table, b.v[i]) * camera.filter_radius;
      CameraRay ray;
      camera_ray(camera, b.u2[i] + x, b.v2[i] + y, ray);
      b.u[i] = x;
      b.v[i] = y;
      embree::set_ray(p.ray, k, ray.origin, ray.direction, ray.t_min, ray.t_max, VISIBLE_CAMERA);
      embree::set_missed(p.hit, k);
      set_left(p.ray, k, {INVALID_ID, INVALID_ID});
    }
  }
}

}  // namespace
}  // namespace cotorra

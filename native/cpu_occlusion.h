// SPDX-License-Identifier: GPL-3.0-or-later
// Ambient occlusion on a CPU: one ray to the sky for each lane.
// What an answer is worth is the renderer's (cpu_kernel.cpp), which alone includes this.
#pragma once

#include "cpu_visibility.h"

namespace cotorra {
namespace {

// Which lanes' ray to the sky is free; its direction is drawn from the random pair of this seed.
void trace_sky(const Tracer &t, int lanes, uint pair_seed) {
  Batch &b = t.batch;
  Array<float, kLanes> &sky = b.classic->sky;
  fill_pairs(b.random.data(), lanes, pair_seed, b.u2.data(), b.v2.data());
  t.arguments.flags = embree::kIncoherent;
  VisibilityQueue queue(t, [&sky](uint lane, float kept) { sky[lane] = kept; });
  for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
    ShadowRay ray;
    occlusion_ray(*t.job.scene, b.surface[i], vec2(b.u2[i], b.v2[i]), t.job.classic.occlusion_distance, ray);
    queue.push(ray, b.surface[i], static_cast<uint>(i), b.path[i]);
  }
  queue.flush();
}

}  // namespace
}  // namespace cotorra

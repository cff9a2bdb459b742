// SPDX-License-Identifier: GPL-3.0-or-later
// What surrounds the stages of a batch: the sums that a call adds to its tile, and Embree's share of the time.
// Included by cpu_kernel.cpp alone.
#pragma once

#include <chrono>

#include "cpu_batch.h"

namespace cotorra {
namespace {

// Gives `staged` the shape of `tile`, all sums zero.
void clear_staged(const FilmTile &tile, const PassSelection &passes, FilmTile &staged) {
  const std::size_t n = tile.pixels.size();
  staged.pixels.assign(n, FilmPixel{vec3(0.0f), 0.0f});
  if (passes.error) staged.odd.assign(n, vec3(0.0f));
  if (passes.nearest) staged.nearest.assign(n, NearestRecord{});
  if (passes.surface) staged.surface.assign(n, SurfaceRecord{});
  if (passes.emission) staged.emission.assign(n, vec3(0.0f));
  if (passes.environment) staged.environment.assign(n, vec3(0.0f));
  if (passes.shadow) staged.shadow.assign(n, ShadowRecord{});
  if (FEATURE(FEATURE_OCCLUSION) && passes.occlusion) staged.occlusion.assign(n, 0.0f);
  if (passes.light_groups > 0) staged.groups.assign(n * passes.light_groups, vec3(0.0f));
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Traces what was recorded once more, and nothing else.
void trace_again(const RenderJob &job, Batch &batch, RayCounts &counts) {
  const auto begin = std::chrono::steady_clock::now();
  embree::QueryArguments arguments;
  arguments.feature_mask = job.embree_features;
  for (RecordedPacket &r : batch.recorded) {
    alignas(64) int valid[kWidth];
    for (int k = 0; k < kWidth; ++k) valid[k] = k < r.count ? -1 : 0;
    arguments.flags = r.flags;
    if (r.shadow) {
      occluded(*job.rtc, valid, job.bvh, &r.packet.ray, &arguments);
    } else {
      intersect(*job.rtc, valid, job.bvh, &r.packet, &arguments);
    }
  }
  counts.traced_seconds += seconds_since(begin);
}

}  // namespace
}  // namespace cotorra

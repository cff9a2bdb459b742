// SPDX-License-Identifier: GPL-3.0-or-later
// What surrounds the stages of a batch: the sums that a call adds to its tile, and Embree's share of the time.
// Included by cpu_kernel.cpp alone.
#pragma once

#include <chrono>

#include "cpu_batch.h"

namespace cotorra {
namespace {

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

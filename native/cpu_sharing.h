// SPDX-License-Identifier: GPL-3.0-or-later
// Samples that count for several pixels of their tile (kernels/sharing.h): which pixels share, and the sums of what
// they get. Included by cpu_passes.h alone.
#pragma once

#include "cpu_batch.h"

namespace cotorra {
namespace {

// Of a tile that is about to be sampled.
void begin_sharing(const FilmTile &tile, SharingLanes &s) {
  const auto width = static_cast<std::size_t>(tile.width), height = static_cast<std::size_t>(tile.height);
  s.stride = width + SHARING_SIDE - 1;
  const std::size_t all = s.stride * (height + SHARING_SIDE - 1);
  s.sampled.assign(all, 0);
  s.sums.assign(all, SharedSum{{vec3(0.0f), 0.0f}, 0.0f});
  for (const std::uint16_t i : tile.to_sample()) s.sampled[i / width * s.stride + i % width + s.middle()] = 1;
}

// The first pixel of the window around a pixel of the tile.
std::size_t sharing_corner(const SharingLanes &s, std::size_t pixel, std::size_t tile_width) {
  return pixel / tile_width * s.stride + pixel % tile_width;
}

// Those of the pixels around one that are sampled too, as sample_shares asks for them; `corner` is the first of them.
uint sharing_mask(const SharingLanes &s, std::size_t corner) {
  uint mask = 0;
  for (uint k = 0; k < SHARING_WINDOW; ++k) {
    mask |= static_cast<uint>(s.sampled[corner + k / SHARING_SIDE * s.stride + k % SHARING_SIDE]) << k;
  }
  return mask;
}

void share_sample(const RenderJob &job, SharingLanes &s, std::size_t corner, uint mask, vec2 offset, vec3 radiance,
                  float alpha) {
  SampleShares shares;
  sample_shares(job.scene->filter_table, job.camera.filter_radius, offset, mask, shares);
  SharedSum *row = s.sums.data() + corner + shares.first / SHARING_SIDE * s.stride + shares.first % SHARING_SIDE;
  for (std::size_t k = 0; k < SHARING_PIXELS; ++k) {
    shared_add(row[k / 3 * s.stride + k % 3], radiance, alpha, shares.weights[k]);
  }
}

// What the tile's pixels got.
void end_sharing(const SharingLanes &s, FilmTile &staged, const FilmTile &tile) {
  const auto width = static_cast<std::size_t>(tile.width);
  for (const std::uint16_t i : tile.to_sample()) {
    const SharedSum &sum = s.sums[i / width * s.stride + i % width + s.middle()];
    staged.shared[i] = sum;
  }
}

}  // namespace
}  // namespace cotorra

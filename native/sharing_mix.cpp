// SPDX-License-Identifier: GPL-3.0-or-later
// A pixel's own samples are well distributed, and where light is smooth the error of many of them falls much faster
// than that of as many random ones; those that it shares with its neighbours are weighted by where they lie, and lose
// that. Both estimates have the same mean, so any mix has it, too. Which one leaves the least noise is told by how far
// both have moved since half of the samples: the least squares of that over the blocks of pixels around one. Its own
// would favour the mix that happens to have moved least, which is darker where few samples are bright: up to 0.1 %.
#include "sharing_mix.h"

#include <algorithm>
#include <bit>

namespace cotorra {
namespace {

struct Squares {
  double own_step = 0.0, step_step = 0.0;
};

// dot(a, b), of light that may be as large as a float can tell.
double product(vec3 a, vec3 b) {
  const auto times = [](float x, float y) { return static_cast<double>(x) * static_cast<double>(y); };
  return times(a.x, b.x) + times(a.y, b.y) + times(a.z, b.z);
}

// Of the blocks beside one, or of itself where it is alone.
Squares around(const std::vector<Squares> &blocks, std::size_t across, std::size_t block) {
  const std::size_t x = block % across, y = block / across, down = blocks.size() / across;
  Squares sum;
  for (std::size_t v = y > 0 ? y - 1 : 0; v < std::min(y + 2, down); ++v) {
    for (std::size_t u = x > 0 ? x - 1 : 0; u < std::min(x + 2, across); ++u) {
      const Squares &s = blocks[v * across + u];
      if (u == x && v == y && blocks.size() > 1) continue;
      sum.own_step += s.own_step;
      sum.step_step += s.step_step;
    }
  }
  return sum;
}

}  // namespace

void measure_mix(FilmTile &tile, std::uint32_t samples) {
  if (samples < kMixFrom || !std::has_single_bit(samples) || tile.to_sample().empty()) return;
  const auto n = static_cast<float>(samples);
  std::vector<Squares> blocks(tile.mix_block(tile.pixels.size() - 1) + 1);
  for (const std::uint16_t i : tile.to_sample()) {
    const vec3 own = tile.pixels[i].radiance, all = tile.shared_mean(i).radiance * n;
    // How far the means have moved: of n samples against the first half.
    const vec3 own_moved = (own - tile.marks.last[i] * 2.0f) * (1.0f / n);
    const vec3 step = (all - tile.shared_marks.last[i] * 2.0f) * (1.0f / n) - own_moved;
    // By how bright it looks, as film_error has it.
    const float weight = 1.0f / (1e-4f + std::max(all.x + all.y + all.z, 0.0f) / n);
    Squares &s = blocks[tile.mix_block(i)];
    s.own_step += static_cast<double>(weight) * product(own_moved, step);
    s.step_step += static_cast<double>(weight) * product(step, step);
  }
  const std::lock_guard lock(tile.mutex);
  tile.mix.resize(blocks.size(), 1.0f);
  const std::size_t across = tile.mix_block(static_cast<std::size_t>(tile.width) - 1) + 1;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const Squares s = around(blocks, across, k);
    if (s.step_step > 0.0) tile.mix[k] = static_cast<float>(std::clamp(-s.own_step / s.step_step, 0.0, 1.0));
  }
}

}  // namespace cotorra

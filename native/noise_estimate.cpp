// SPDX-License-Identifier: GPL-3.0-or-later
// The error of n samples from the picture as it was with half of them. Samples [0, n/2) and [n/2, n) are each as well
// distributed as all of them, which every second one is not: shuffled indices make these a random choice of each pair,
// whose error is larger than that of n/2 samples. The halves of the last mark tell it once more, by other samples:
// where pixels stop, the first alone is least.
#include "noise_estimate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

namespace cotorra {
namespace {

constexpr float kLoneError = 3.0f;  // of a pixel alone, over the threshold for the mean
constexpr std::size_t kRatePixels = 64;  // fewer tell no rate
// How much the error falls where samples double, at least and at most: n^-0.4, since where few pixels have met rare
// light so far, the mean over pixels falls more slowly than each pixel's n^-0.5; and n^-1.5, what (0, 2)-nets reach
// with smooth integrands.
constexpr float kLeastFall = 1.3195079f;
constexpr float kMostFall = 2.8284271f;

struct Mark {
  vec3 sum;
  std::uint32_t samples;
};

void mark(Marks &marks, std::size_t pixel, vec3 sum) {
  if (!marks.before.empty()) marks.before[pixel] = marks.last[pixel];
  marks.last[pixel] = sum;
}

struct PixelMarks {
  vec3 before, last;
};

// Those of Combined.
PixelMarks marks_of(const FilmTile &tile, std::size_t pixel) {
  PixelMarks marks{tile.marks.before[pixel], tile.marks.last[pixel]};
  if (tile.shared.empty()) return marks;
  const float part = tile.part_shared(pixel);
  marks.before += (tile.shared_marks.before[pixel] - marks.before) * part;
  marks.last += (tile.shared_marks.last[pixel] - marks.last) * part;
  return marks;
}

// The sums that a pixel's error is measured against: a third to two thirds of its n samples, n > 1.
Mark mark_of(const FilmTile &tile, std::size_t pixel, std::uint32_t n) {
  const std::uint32_t last = std::bit_floor(n - 1);
  const PixelMarks marks = marks_of(tile, pixel);
  // Nobody has less than one sample.
  return last > 1 && 2 * n < 3 * last ? Mark{marks.before, last / 2} : Mark{marks.last, last};
}

}  // namespace

void mark_noise(FilmTile &tile, std::uint32_t first) {
  if (!std::has_single_bit(first) || first == tile.marked) return;
  const std::lock_guard lock(tile.mutex);
  tile.marked = first;
  for (const std::uint16_t i : tile.to_sample()) {
    mark(tile.marks, i, tile.pixels[i].radiance);
    if (!tile.shared.empty()) mark(tile.shared_marks, i, tile.shared_mean(i).radiance * static_cast<float>(first));
  }
}

void measure_rate(FilmTile &tile, std::uint32_t samples) {
  if (samples < 8 || !std::has_single_bit(samples) || tile.pending.size() < kRatePixels) return;
  const auto n = static_cast<float>(samples);
  double now = 0.0, before = 0.0;
  for (const std::uint16_t i : tile.pending) {
    const PixelMarks marks = marks_of(tile, i);
    now += static_cast<double>(film_error(tile.mean(i).radiance * n, n, marks.last, 0.5f * n));
    before += static_cast<double>(film_error(marks.last, 0.5f * n, marks.before, 0.25f * n));
  }
  if (!(now > 0.0)) return;
  // With an error e(n) ~ n^-r, what the halves of n samples differ by has the variance e(n)^2 (4^r - 1), and 2^r is how
  // much that difference falls when n doubles.
  const float fall = std::clamp(static_cast<float>(before / now), kLeastFall, kMostFall);
  const std::lock_guard lock(tile.mutex);
  tile.error_scale = 1.0f / std::sqrt(fall * fall - 1.0f);
  tile.error_fall = std::clamp(static_cast<float>(before / now), 1.0f / kMostFall, kMostFall);
}

float noise_left(const FilmTile &tile, std::size_t pixel) {
  const std::uint32_t n = tile.samples[pixel];
  if (n < 2) return 0.0f;
  const Mark mark = mark_of(tile, pixel, n);
  const auto all = static_cast<float>(n), part = static_cast<float>(mark.samples);
  const float now = film_error(tile.mean(pixel).radiance * all, all, mark.sum, part);
  const PixelMarks marks = marks_of(tile, pixel);
  const std::uint32_t last = std::bit_floor(n - 1);
  if (last < 4) return tile.error_scale * now;
  // What the halves of the last mark differ by was learned from other samples; it fell since then as all did.
  const float rate = std::log2(tile.error_fall);
  const auto m = static_cast<float>(last);
  const float before = film_error(marks.last, m, marks.before, 0.5f * m) * std::pow(m / all, rate);
  return tile.error_scale * 0.5f * (now + before);
}

HalfErrors half_errors(const FilmTile &tile, std::size_t pixel) {
  const std::uint32_t n = tile.samples[pixel];
  if (n < 4 || !std::has_single_bit(n)) return {0.0f, 0.0f};
  const PixelMarks marks{tile.marks.before[pixel], tile.marks.last[pixel]};  // each pixel's own
  const auto all = static_cast<float>(n), half = 0.5f * all;
  return {film_error(tile.pixels[pixel].radiance, all, marks.last, half),
          film_error(marks.last, half, marks.before, 0.5f * half)};
}

// A pixel's own estimate is as wide as it is large, and each look at it another chance to stop too soon; but one that
// is far beyond goes on, as its neighbours need not be like it.
void drop_clean_pixels(FilmTile &tile, float threshold) {
  const auto w = static_cast<std::size_t>(tile.width), h = static_cast<std::size_t>(tile.height);
  std::vector<float> error(tile.pixels.size());
  for (std::size_t i = 0; i < error.size(); ++i) error[i] = noise_left(tile, i);
  const auto is_clean = [&](std::uint16_t i) {
    const std::size_t x = i % w, y = i / w;
    float sum = 0.0f, count = 0.0f;
    for (std::size_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, h - 1); ++v) {
      for (std::size_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, w - 1); ++u, count += 1.0f) sum += error[v * w + u];
    }
    return sum < threshold * count && error[i] < kLoneError * threshold;
  };
  const std::lock_guard lock(tile.mutex);
  std::erase_if(tile.pending, is_clean);
}

}  // namespace cotorra

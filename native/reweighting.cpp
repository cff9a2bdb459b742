// SPDX-License-Identifier: GPL-3.0-or-later
// After Zirr, Hanika and Dachsbacher 2018, with two differences, both measured: a cascade is supported by all that is
// as bright or brighter around it, and one without support keeps what adds little to its surroundings, so that the bias
// vanishes as samples grow: a sample of brightness b adds b / n.
#include "reweighting.h"

#include <algorithm>
#include <array>

namespace cotorra {
namespace {

// Samples among a pixel and its eight neighbours that make a brightness certain.
constexpr float kSupport = 8.0f;
// What an uncertain cascade may add at a strength of 1, as a share of the brightness around.
constexpr float kAllowance = 0.25f;

constexpr std::size_t kCascades = BRIGHT_CASCADES;

struct Bright {
  std::array<BrightSum, kCascades> cascades{};
  float samples = 0.0f;
};

// Sums over each pixel and its neighbours, over how many of the nine there are.
std::vector<float> around(const std::vector<float> &values, std::size_t width, std::size_t height) {
  std::vector<float> rows(values.size()), sums(values.size());
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t i = y * width + x;
      float sum = values[i], count = 1.0f;
      if (x > 0) sum += values[i - 1], count += 1.0f;
      if (x + 1 < width) sum += values[i + 1], count += 1.0f;
      rows[i] = sum / count;
    }
  }
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t i = y * width + x;
      float sum = rows[i], count = 1.0f;
      if (y > 0) sum += rows[i - width], count += 1.0f;
      if (y + 1 < height) sum += rows[i + width], count += 1.0f;
      sums[i] = sum / count;
    }
  }
  return sums;
}

std::vector<Bright> gather(std::span<FilmTile> tiles, std::size_t width, std::size_t height) {
  std::vector<Bright> all(width * height);
  for (FilmTile &tile : tiles) {
    const std::lock_guard lock(tile.mutex);
    const auto w = static_cast<std::size_t>(tile.width);
    for (std::size_t i = 0; i < tile.pixels.size(); ++i) {
      const std::size_t x = static_cast<std::size_t>(tile.x0) + i % w, y = static_cast<std::size_t>(tile.y0) + i / w;
      Bright &pixel = all[y * width + x];
      std::copy_n(tile.bright.begin() + static_cast<std::ptrdiff_t>(i * kCascades), kCascades, pixel.cascades.begin());
      pixel.samples = static_cast<float>(tile.samples_of(i));
    }
  }
  return all;
}

}  // namespace

void reweight(std::span<FilmTile> tiles, int width, int height, float strength, std::span<float> combined) {
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
  const std::vector<Bright> pixels = gather(tiles, w, h);
  const auto mean = [&](std::size_t i) { return vec3(combined[4 * i], combined[4 * i + 1], combined[4 * i + 2]); };

  // What is certain: cascades that have support.
  std::vector<std::array<float, kCascades>> weights(pixels.size());
  std::vector<float> counts(pixels.size(), 0.0f), certain(pixels.size());
  for (std::size_t c = kCascades; c-- > 0;) {
    for (std::size_t i = 0; i < pixels.size(); ++i) counts[i] += pixels[i].cascades[c].count;
    const std::vector<float> support = around(counts, w, h);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const float enough =
          std::min(kSupport, 0.5f * pixels[i].samples);  // few samples: a few pixels may well be a lamp
      weights[i][c] = std::min(9.0f * support[i] / std::max(enough, 0.5f), 1.0f);
    }
  }
  const auto held = [&](std::size_t i) {
    vec3 light(0.0f);
    for (std::size_t c = 0; c < kCascades; ++c) light += pixels[i].cascades[c].light * (1.0f - weights[i][c]);
    return light * (1.0f / std::max(pixels[i].samples, 1.0f));
  };
  for (std::size_t i = 0; i < pixels.size(); ++i) certain[i] = brightness(mean(i) - held(i));

  // What is not may add a little to it.
  const std::vector<float> surroundings = around(certain, w, h);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const float allowed = kAllowance / strength * surroundings[i];
    for (std::size_t c = 0; c < kCascades; ++c) {
      const float adds = brightness(pixels[i].cascades[c].light) / std::max(pixels[i].samples, 1.0f);
      if (adds > 0.0f) weights[i][c] = std::max(weights[i][c], std::min(allowed / adds, 1.0f));
    }
    const vec3 light = held(i);
    combined[4 * i] -= light.x;
    combined[4 * i + 1] -= light.y;
    combined[4 * i + 2] -= light.z;
  }
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Brightness over cells of longitude and latitude, cumulated as kernels/light/world_light.h draws from it. How bright
// the cells are is world_table.cpp's.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

// Sine of the latitude at the lower edge of row y.
inline double world_row_edge(uint y, uint height) {
  return -std::cos(std::numbers::pi * static_cast<double>(y) / static_cast<double>(height));
}

// Numbers as their cumulated shares; all 0 where the sum is. Returns the sum.
inline double cumulate(std::span<const double> numbers, float *out) {
  double sum = 0.0;
  for (const double number : numbers) sum += number;
  double so_far = 0.0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    so_far += numbers[i];
    out[i] = sum > 0.0 ? static_cast<float>(so_far / sum) : 0.0f;
  }
  return sum;
}

// Cells of each row, then the rows by what they fill of the sphere. out: width x height + height numbers.
inline void cumulate_world(std::span<const float> cells, uint width, uint height, float *out) {
  std::vector<double> rows(height), row(width);
  for (uint y = 0; y < height; ++y) {
    const std::size_t first = std::size_t{y} * width;
    std::copy_n(cells.begin() + static_cast<std::ptrdiff_t>(first), width, row.begin());
    rows[y] = cumulate(row, out + first) * (world_row_edge(y + 1, height) - world_row_edge(y, height));
  }
  cumulate(rows, out + std::size_t{width} * height);
}

}  // namespace cotorra

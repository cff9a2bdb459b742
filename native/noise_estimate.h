// SPDX-License-Identifier: GPL-3.0-or-later
// How much noise is left in a tile's pixels, and which of them are clean: adaptive sampling.
// What is done with the answer is the session's.
#pragma once

#include <cstddef>
#include <cstdint>

#include "film.h"

namespace cotorra {

// To be called before samples from `first` on are taken: keeps the sums where the number is a power of two.
void mark_noise(FilmTile &tile, std::uint32_t first);
// To be called once each pixel of to_sample() has `samples`: how fast the error falls here.
void measure_rate(FilmTile &tile, std::uint32_t samples);

// Error that is left in a pixel (film_error), 0 for less than two samples.
float noise_left(const FilmTile &tile, std::size_t pixel);

// film_error of a pixel beside half of its samples, and of these beside half of them.
struct HalfErrors {
  float now, before;
};

// For numbers of samples that are powers of two, 4 at least; else 0.
HalfErrors half_errors(const FilmTile &tile, std::size_t pixel);

// Takes pixels out of `pending` whose error, in the mean of their neighbours in the tile, is below the threshold.
void drop_clean_pixels(FilmTile &tile, float threshold);

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Where pixels share samples: how much of what they share Combined takes, and how much of what is each pixel's own.
#pragma once

#include <cstdint>

#include "film.h"

namespace cotorra {

// Samples below which all is shared: too few to tell.
constexpr std::uint32_t kMixFrom = 8;

// To be called once each pixel of to_sample() has `samples`: finds FilmTile::mix where there are enough of them.
void measure_mix(FilmTile &tile, std::uint32_t samples);

}  // namespace cotorra

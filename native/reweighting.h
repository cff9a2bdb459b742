// SPDX-License-Identifier: GPL-3.0-or-later
// A film's Combined with fireflies held back: what a pixel's bright samples count, judged by those around it.
// How samples are sorted is kernels/reweighting.h's; the plain mean stays in the film.
#pragma once

#include <span>

#include "film.h"

namespace cotorra {

// Takes out of `combined` ([height][width][4], the plain mean, row 0 at the bottom) the light that is held back.
// strength: 1 lets samples that are rare for their brightness add half of what is around them, 2 a quarter.
void reweight(std::span<FilmTile> tiles, int width, int height, float strength, std::span<float> combined);

}  // namespace cotorra

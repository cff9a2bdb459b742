// SPDX-License-Identifier: GPL-3.0-or-later
// Samples sorted by brightness, by which fireflies are told from light: Zirr, Hanika and Dachsbacher 2018,
// "Re-weighting Firefly Samples for Improved Finite-Sample Monte Carlo Estimates", section 3.
// What a class counts in the picture is decided where all pixels are known, by native/reweighting.cpp.
#ifndef COTORRA_REWEIGHTING_H
#define COTORRA_REWEIGHTING_H

#include "film.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Cascades above the one that holds all that is darker, whose weight is 1: at 8, 64 and 512 times white. With five at
// steps of 4 errors are within 8 % of these.
const uint BRIGHT_CASCADES = 3u;
const float CASCADE_STEP = 8.0f;

// Of a cascade: the light of its samples, and how many samples are as bright as any in it or brighter.
struct BrightSum {
  vec3 light;
  float count;
};

FN float brightness(vec3 light) { return (abs(light.x) + abs(light.y) + abs(light.z)) * (1.0f / 3.0f); }

FN float cascade_level(uint cascade, float white) {
  return white * CASCADE_STEP * (cascade > 0u ? CASCADE_STEP : 1.0f) * (cascade > 1u ? CASCADE_STEP : 1.0f);
}

// Adds the part of a sample that belongs to a cascade. Between the levels of two cascades each takes a part, so that
// parts times levels sum up to the sample's size; all that is above the last belongs to it.
FN void bright_add(INOUT(BrightSum) sum, vec3 light, float size, uint cascade, float white) {
  const float level = cascade_level(cascade, white);
  const bool above = size > level;
  const bool last = cascade + 1u == BRIGHT_CASCADES;
  const float rising = (size * CASCADE_STEP - level) / (level * (CASCADE_STEP - 1.0f));
  const float falling = last ? 1.0f : (CASCADE_STEP * level - size) / (level * (CASCADE_STEP - 1.0f));
  const float part = clamp(select(above, falling, rising), 0.0f, 1.0f);
  sum.light += light * (part * select(above && last, 1.0f, level / max(size, 1e-30f)));
  sum.count += select(size * CASCADE_STEP > level, 1.0f, 0.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

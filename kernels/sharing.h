// SPDX-License-Identifier: GPL-3.0-or-later
// A sample counts for every pixel whose filter reaches it. It was drawn by the filter of one of them (filter importance
// sampling; Ernst, Stamminger and Greiner 2006), and a pixel's neighbours draw some of theirs where its own filter is
// high: a pixel's estimate takes all of these, each pixel as a technique, by the balance heuristic (Veach and Guibas
// 1995, section 3.3). With the Blackman-Harris filter of Blender's default width the variance falls to 0.45 of what
// each pixel's own samples leave. Pixels of one tile share, those of them that are still sampled.
#ifndef COTORRA_SHARING_H
#define COTORRA_SHARING_H

#include "camera.h"
#include "film.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A sample lies in its pixel or next to it, and the filter reaches from there as far: 3 x 3 pixels out of 5 x 5.
const uint SHARING_SIDE = 5u;
const uint SHARING_WINDOW = SHARING_SIDE * SHARING_SIDE;
const uint SHARING_PIXELS = 9u;
const uint SHARING_ALL = 0x1ffffffu;  // each pixel of the window
const float SHARING_RADIUS = 1.5f;  // of the widest filter that reaches no farther

// What a sample counts for 3 x 3 pixels, row by row; the sum is 1. The first is at `first` in the 5 x 5 around the
// pixel that it was drawn for.
struct SampleShares {
  uint first;
  float weights[SHARING_PIXELS];
};

// Sums over samples, each by what it counts for a pixel.
struct SharedSum {
  FilmPixel film;
  float weight;
};

FN void shared_add(INOUT(SharedSum) sum, vec3 radiance, float alpha, float weight) {
  sum.film.radiance += radiance * weight;
  sum.film.alpha += alpha * weight;
  sum.weight += weight;
}

// The filter at a distance from its middle, in filter radii, at a scale of its own.
FN float filter_density(IN(FloatBuffer) table, float distance) {
  const float x = min(abs(distance), 1.0f) * float(FILTER_TABLE_SIZE - 1u);
  const int i = min(int(x), int(FILTER_TABLE_SIZE) - 2);
  const float density =
      mix(LOAD(table, int(FILTER_TABLE_SIZE) + i), LOAD(table, int(FILTER_TABLE_SIZE) + i + 1), x - float(i));
  return select(abs(distance) < 1.0f, density, 0.0f);
}

// `offset`: of a sample to the centre of the pixel that it was drawn for, pixels; `sampled`: bit k is set where pixel k
// of the 5 x 5 around that one is sampled too, with as many samples.
FN void sample_shares(IN(FloatBuffer) table, float radius, vec2 offset, uint sampled, OUT(SampleShares) shares) {
  const int x = clamp(int(floor(offset.x + 0.5f)), -1, 1);
  const int y = clamp(int(floor(offset.y + 0.5f)), -1, 1);
  const float scale = 1.0f / radius;
  float across[3];
  float along[3];
  for (int k = 0; k < 3; ++k) {
    across[k] = filter_density(table, (offset.x - float(x + k - 1)) * scale);
    along[k] = filter_density(table, (offset.y - float(y + k - 1)) * scale);
  }
  shares.first = uint((y + 1) * int(SHARING_SIDE) + x + 1);
  // Where all are sampled, as away from a tile's edges, rows and columns go alone.
  if (sampled == SHARING_ALL) {
    const float all = 1.0f / max((across[0] + across[1] + across[2]) * (along[0] + along[1] + along[2]), 1e-30f);
    for (uint row = 0u; row < 3u; ++row) {
      const float scaled = along[row] * all;
      for (uint k = 0u; k < 3u; ++k) shares.weights[row * 3u + k] = scaled * across[k];
    }
    return;
  }
  float sum = 0.0f;
  for (uint row = 0u; row < 3u; ++row) {
    for (uint k = 0u; k < 3u; ++k) {
      const uint bit = (sampled >> (shares.first + row * SHARING_SIDE + k)) & 1u;
      const float weight = along[row] * across[k] * float(bit);
      shares.weights[row * 3u + k] = weight;
      sum += weight;
    }
  }
  // Where nothing is left of a sample at the very end of its filter, it counts for nobody.
  const float all = select(sum > 0.0f, 1.0f / max(sum, 1e-30f), 0.0f);
  for (uint k = 0u; k < SHARING_PIXELS; ++k) shares.weights[k] *= all;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// What a finished sample adds to its pixel, and how far a pixel still is from converged.
// Where pixels are kept, and how a pass is turned into what Blender reads, is the device's and native/film.cpp's.
#ifndef COTORRA_FILM_H
#define COTORRA_FILM_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Sums over the samples of one pixel.
struct FilmPixel {
  vec3 radiance;
  float alpha;
};

// What passes are told of the first surface that a sample met.
struct FirstSurface {
  vec3 position;
  float depth;
  vec3 normal;
  float uv_coverage;
  vec3 diffuse_color;
  float object_index;
  vec2 uv;
  float material_index;
  float distance2;  // of the sample to its pixel's centre, pixels squared
};

// What a sample may add to a sum. One that is infinite or not a number would spoil the pixel for good: it counts as 0.
FN float film_number(float value) { return select(abs(value) < INFINITE_DISTANCE, value, 0.0f); }
FN vec3 film_vector(vec3 value) {
  return select(abs(value.x) + abs(value.y) + abs(value.z) < INFINITE_DISTANCE, value, vec3(0.0f));
}

// Adds a sample. One that is infinite or not a number would spoil the pixel for good: it counts as black, and false is
// returned.
FN bool film_add(INOUT(FilmPixel) pixel, INOUT(vec3) radiance, float alpha) {
  const float size = abs(radiance.x) + abs(radiance.y) + abs(radiance.z);
  const bool finite = size < INFINITE_DISTANCE;
  radiance = select(finite, radiance, vec3(0.0f));
  pixel.radiance += radiance;
  pixel.alpha += film_number(alpha);
  return finite;
}

// Error of the mean of n samples, relative to how bright it looks (as Cycles scales it), from its difference to that of
// the first m. Of independent samples that difference has the variance v/m - v/n, their mean v/n. Compare with the
// noise threshold.
FN float film_error(vec3 sum, float n, vec3 part, float m) {
  const vec3 mean = sum * (1.0f / n);
  const vec3 d = abs(mean - part * (1.0f / m)) * sqrt(m / (n - m));
  const float brightness = max(mean.x + mean.y + mean.z, 0.0f);
  return (d.x + d.y + d.z) / (0.0001f + sqrt(brightness));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Perlin's gradient noise in one to four dimensions (Perlin 2002), with Blender's hash, gradients and scales.
// One octave, about 0; sums of octaves are in noise_fractal.h.
#ifndef COTORRA_PROGRAM_NOISE_H
#define COTORRA_PROGRAM_NOISE_H

#include "elementary.h"
#include "hash.h"
#include "ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const float NOISE_PERIOD = 100000.0f;  // coordinates repeat beyond, where floats get too coarse
const float NOISE_COARSE = 1000000.0f;  // from here on most coordinates are whole: moved by a half

// A coordinate within a period of 0. All else, NaN too, becomes 0.
FN float noise_wrap(float x) {
  const float r = x - trunc(x * (1.0f / NOISE_PERIOD)) * NOISE_PERIOD;
  // The quotient is rounded: one period too many or too few was taken away.
  const float sign_x = select(x < 0.0f, -1.0f, 1.0f);
  const float over = select(r * sign_x >= NOISE_PERIOD, -sign_x, select(r * sign_x < 0.0f, sign_x, 0.0f));
  const float wrapped = r + over * NOISE_PERIOD;
  return select(abs(wrapped) < NOISE_PERIOD, wrapped, 0.0f) + select(abs(x) >= NOISE_COARSE, 0.5f, 0.0f);
}

// 6 t^5 - 15 t^4 + 10 t^3
FN float noise_fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

// -a where the lowest bit of h is set.
FN float negate_by(float a, uint h) { return uintBitsToFloat(floatBitsToUint(a) ^ (h << 31)); }

FN float gradient1(uint h, float x) { return negate_by(1.0f + float(int(h & 7u)), h >> 3) * x; }

FN float gradient2(uint h, float x, float y) {
  const bool swapped = (h & 4u) != 0u;
  return negate_by(select(swapped, y, x), h) + negate_by(2.0f * select(swapped, x, y), h >> 1);
}

FN float gradient3(uint h, float x, float y, float z) {
  const float u = select((h & 8u) == 0u, x, y);
  const float v = select((h & 12u) == 0u, y, select((h & 13u) == 12u, x, z));
  return negate_by(u, h) + negate_by(v, h >> 1);
}

FN float gradient4(uint h, vec4 p) {
  const float u = select((h & 24u) == 24u, p.y, p.x);
  const float v = select((h & 16u) == 0u, p.y, p.z);
  const float s = select((h & 24u) == 0u, p.z, p.w);
  return negate_by(u, h) + negate_by(v, h >> 1) + negate_by(s, h >> 2);
}

FN float perlin1(float x) {
  const float low = floor(x);
  const uint i = uint(int(low));
  const float f = x - low;
  return lerp(gradient1(lookup3_1(i), f), gradient1(lookup3_1(i + 1u), f - 1.0f), noise_fade(f));
}

FN float perlin2(float x, float y) {
  const float low_x = floor(x);
  const float low_y = floor(y);
  const uint i = uint(int(low_x));
  const uint j = uint(int(low_y));
  const float fx = x - low_x;
  const float fy = y - low_y;
  const float u = noise_fade(fx);
  const float a = lerp(gradient2(lookup3_2(i, j), fx, fy), gradient2(lookup3_2(i + 1u, j), fx - 1.0f, fy), u);
  const float b = lerp(gradient2(lookup3_2(i, j + 1u), fx, fy - 1.0f),
                       gradient2(lookup3_2(i + 1u, j + 1u), fx - 1.0f, fy - 1.0f), u);
  return lerp(a, b, noise_fade(fy));
}

// Along an edge of the lattice in x: corners (i, j, k) and (i + 1, j, k), seen from (fx, fy, fz).
FN float perlin3_edge(uint i, uint j, uint k, vec3 f, float u) {
  return lerp(gradient3(lookup3_3(i, j, k), f.x, f.y, f.z), gradient3(lookup3_3(i + 1u, j, k), f.x - 1.0f, f.y, f.z),
              u);
}

FN float perlin3(vec3 p) {
  const vec3 low = floor(p);
  const uint i = uint(int(low.x));
  const uint j = uint(int(low.y));
  const uint k = uint(int(low.z));
  const vec3 f = p - low;
  const float u = noise_fade(f.x);
  const float v = noise_fade(f.y);
  const float a = lerp(perlin3_edge(i, j, k, f, u), perlin3_edge(i, j + 1u, k, vec3(f.x, f.y - 1.0f, f.z), u), v);
  const float b = lerp(perlin3_edge(i, j, k + 1u, vec3(f.x, f.y, f.z - 1.0f), u),
                       perlin3_edge(i, j + 1u, k + 1u, vec3(f.x, f.y - 1.0f, f.z - 1.0f), u), v);
  return lerp(a, b, noise_fade(f.z));
}

FN float perlin4_edge(uint i, uint j, uint k, uint l, vec4 f, float u) {
  return lerp(gradient4(lookup3_4(i, j, k, l), f),
              gradient4(lookup3_4(i + 1u, j, k, l), vec4(f.x - 1.0f, f.y, f.z, f.w)), u);
}

FN float perlin4(vec4 p) {
  const uint i = uint(int(floor(p.x)));
  const float fx = p.x - floor(p.x);
  const float u = noise_fade(fx);
  const float v = noise_fade(p.y - floor(p.y));
  const float t = noise_fade(p.z - floor(p.z));
  float sides[2];
  // The two cubes at both ends of w.
  UNROLL
  for (int side = 0; side < 2; ++side) {
    const uint j = uint(int(floor(p.y)));
    const uint k = uint(int(floor(p.z)));
    const uint l = uint(int(floor(p.w)) + side);
    const vec4 f = vec4(fx, p.y - floor(p.y), p.z - floor(p.z), p.w - floor(p.w) - float(side));
    const float a =
        lerp(perlin4_edge(i, j, k, l, f, u), perlin4_edge(i, j + 1u, k, l, vec4(f.x, f.y - 1.0f, f.z, f.w), u), v);
    const float b = lerp(perlin4_edge(i, j, k + 1u, l, vec4(f.x, f.y, f.z - 1.0f, f.w), u),
                         perlin4_edge(i, j + 1u, k + 1u, l, vec4(f.x, f.y - 1.0f, f.z - 1.0f, f.w), u), v);
    sides[side] = lerp(a, b, t);
  }
  return lerp(sides[0], sides[1], noise_fade(p.w - floor(p.w)));
}

// Noise in -1 ... 1 of the first `dimensions` components of p.
FN float noise_signed(uint dimensions, vec4 p) {
  if (PROGRAM_VARIANT(1u) && dimensions == 1u) return 0.25f * perlin1(noise_wrap(p.x));
  if (PROGRAM_VARIANT(2u) && dimensions == 2u) return 0.6616f * perlin2(noise_wrap(p.x), noise_wrap(p.y));
  const vec3 q = vec3(noise_wrap(p.x), noise_wrap(p.y), noise_wrap(p.z));
  if (PROGRAM_VARIANT(4u) && dimensions == 3u) return 0.982f * perlin3(q);
  if (!PROGRAM_VARIANT(8u)) return 0.0f;
  return 0.8344f * perlin4(vec4(q, noise_wrap(p.w)));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers, as Owen-scrambled Sobol pairs in screen-space order, and the warps from the unit square.
// Which pair serves what is decided by the integrator; a pdf stands beside what it belongs to.
#ifndef COTORRA_SAMPLING_H
#define COTORRA_SAMPLING_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// ---- Hashes

// A 32-bit integer hash (Wellons, "lowbias32").
FN uint hash_uint(uint x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}
FN uint hash_combine(uint a, uint b) { return hash_uint(a ^ (hash_uint(b) + 0x9e3779b9u + (a << 6) + (a >> 2))); }

// A hash in which bit i of the result depends on bits 0..i of x only: nested uniform (Owen) scrambling of the
// bit-reversed number (Laine & Karras 2011, constants by Vegdahl 2021).
FN uint owen_hash(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// ---- Pixel order

FN uint morton_spread(uint x) {
  x &= 0xffffu;
  x = (x | (x << 8)) & 0x00ff00ffu;
  x = (x | (x << 4)) & 0x0f0f0f0fu;
  x = (x | (x << 2)) & 0x33333333u;
  x = (x | (x << 1)) & 0x55555555u;
  return x;
}
FN uint morton_encode(uint x, uint y) { return morton_spread(x) | (morton_spread(y) << 1); }

// Samples of a pixel take the numbers [pixel << sample_bits, (pixel + 1) << sample_bits) of one sequence that runs over
// a block of pixels along the Morton curve: neighbours then share the error among them, which makes it blue noise
// (Ahmed & Wonka 2020). A block is as large as 32 bits leave room for: 256 x 256 pixels, 64 x 64 at the least.
const uint SAMPLE_BITS_MAX = 20u;  // of sample_bits; later samples continue in the numbers of the next pixel
FN uint sampler_block_bits(uint sample_bits) { return min(8u, (32u - sample_bits) / 2u); }

// The sequence index with its bits reversed, as sampler_pair wants it.
FN uint sampler_index(uint x, uint y, uint sample_number, uint sample_bits) {
  const uint mask = (1u << sampler_block_bits(sample_bits)) - 1u;
  return bitfieldReverse((morton_encode(x & mask, y & mask) << sample_bits) + sample_number);
}

// The seed of a pixel's block: differs from block to block, so that no pattern repeats.
FN uint sampler_block_seed(uint x, uint y, uint sample_bits, uint seed) {
  const uint bits = sampler_block_bits(sample_bits);
  return hash_combine(seed, hash_combine(x >> bits, y >> bits));
}

FN uint sampler_pair_seed(uint block_seed, uint pair) { return hash_combine(block_seed, pair); }

// A number in [0, 1) from the 24 leading bits.
FN float unit_float(uint x) { return float(int(x >> 8)) * 5.9604644775390625e-8f; }

// One point of a (0, 2)-sequence: index shuffled and both digits scrambled after Owen, by hashes (Burley 2020).
FN vec2 sampler_pair(uint reversed_index, uint pair_seed) {
  // Shuffling the index is scrambling its reversal, which is the first Sobol dimension already.
  const uint index = bitfieldReverse(owen_hash(reversed_index, pair_seed));
  // Second dimension: Pascal's triangle modulo 2, as a Kronecker power; applied here to the reversed digits.
  uint y = index;
  y ^= (y >> 1) & 0x55555555u;
  y ^= (y >> 2) & 0x33333333u;
  y ^= (y >> 4) & 0x0f0f0f0fu;
  y ^= (y >> 8) & 0x00ff00ffu;
  y ^= (y >> 16) & 0x0000ffffu;
  const uint sx = bitfieldReverse(owen_hash(index, pair_seed ^ 0x68bc21ebu));
  const uint sy = bitfieldReverse(owen_hash(y, pair_seed ^ 0x02e5be93u));
  return vec2(unit_float(sx), unit_float(sy));
}

// ---- Warps

// Unit square to unit disk, area preserving and continuous (Shirley & Chiu 1997), without branches.
FN vec2 disk_from_square(vec2 u) {
  const float a = 2.0f * u.x - 1.0f;
  const float b = 2.0f * u.y - 1.0f;
  const bool wide = abs(a) > abs(b);
  const float r = select(wide, a, b);
  const float q = select(wide, b, a);
  const float phi = 0.25f * PI * q / select(r == 0.0f, 1.0f, r);
  const float c = r * cos_quarter(phi);
  const float s = r * sin_quarter(phi);
  return vec2(select(wide, c, s), select(wide, s, c));
}

// A direction in the cone about +z with 1 - cos(half angle) = h; pdf = 1 / (2 pi h).
FN vec3 cone_from_square(vec2 u, float h) {
  const vec2 d = disk_from_square(u);
  const float z = h * dot(d, d);  // 1 - cos(theta)
  const float s = sqrt(max(h * (2.0f - z), 0.0f));
  return vec3(d.x * s, d.y * s, 1.0f - z);
}

// A direction of the upper hemisphere, pdf = cos(theta) / pi (Malley).
FN vec3 cosine_hemisphere_from_square(vec2 u) {
  const vec2 d = disk_from_square(u);
  return vec3(d.x, d.y, sqrt(max(1.0f - dot(d, d), 0.0f)));
}

// Barycentric coordinates u, v of a uniform point in a triangle (Heitz 2019, low distortion).
FN vec2 triangle_from_square(vec2 u) {
  const bool lower = u.y > u.x;
  const float x = select(lower, 0.5f * u.x, u.x - 0.5f * u.y);
  const float y = select(lower, u.y - 0.5f * u.x, 0.5f * u.y);
  return vec2(x, y);
}

// Balance of two sampling techniques by the power heuristic, exponent 2 (Veach 1997).
FN float power_heuristic(float pdf_a, float pdf_b) {
  const float a2 = pdf_a * pdf_a;
  const float b2 = pdf_b * pdf_b;
  const float sum = a2 + b2;
  // A pdf whose square overflows is as good as a delta: it takes all the weight.
  return sum < INFINITE_DISTANCE ? a2 / max(sum, 1e-38f) : (pdf_a > pdf_b ? 1.0f : 0.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

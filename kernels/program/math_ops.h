// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that make numbers of numbers: the Math, Clamp and Map Range nodes, and Mix of floats.
// Operations have the numbers of Blender's enumerations. Vectors are vector_ops.h's.
#ifndef COTORRA_PROGRAM_MATH_OPS_H
#define COTORRA_PROGRAM_MATH_OPS_H

#include "elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint MATH_CLAMP = 65536u;  // bit of the mode of math: the result is clamped to 0 ... 1
const uint MAP_RANGE_CLAMP = 256u;  // bit of the mode of map_range
const float SMALLEST_COMPARE = 1.1920929e-7f;  // 2^-23: numbers nearer than this count as equal

// Cubic smooth minimum: rounds the crease between a and b over a width of k (Quilez 2013).
FN float smooth_min(float a, float b, float k) {
  const float h = max(k - abs(a - b), 0.0f) / select(k != 0.0f, k, 1.0f);
  return min(a, b) - select(k != 0.0f, h * h * h * k * (1.0f / 6.0f), 0.0f);
}

FN float wrap(float a, float high, float low) {
  const float range = high - low;
  return select(range != 0.0f, a - range * floor((a - low) / select(range != 0.0f, range, 1.0f)), low);
}

FN float ping_pong(float a, float b) {
  const float safe = select(b != 0.0f, b, 1.0f);
  return select(b != 0.0f, abs(fraction((a - b) / (safe * 2.0f)) * b * 2.0f - b), 0.0f);
}

FN float safe_log(float a, float base) {
  const bool defined = a > 0.0f && base > 0.0f;
  return select(defined, safe_divide(log(select(defined, a, 1.0f)), log(select(defined, base, 1.0f))), 0.0f);
}

// atan2, where (0, 0) has angle 0.
FN float angle_of(float y, float x) {
  const bool null_vector = x == 0.0f && y == 0.0f;
  return atan(y, select(null_vector, 1.0f, x));
}

// The remainder with the sign of a; 0 where b is 0.
FN float safe_remainder(float a, float b) {
#ifdef __cplusplus
  return b != 0.0f ? __builtin_fmodf(a, b) : 0.0f;
#else
  return b != 0.0f ? remainder_truncated(a, b) : 0.0f;
#endif
}

// Trigonometry and its kin.
FN float math_angle(uint operation, float a, float b) {
  switch (operation) {
    case 4u:
      return sin(a);
    case 5u:
      return cos(a);
    case 6u:
      return tan(a);
    case 7u:
      return asin(clamp(a, -1.0f, 1.0f));
    case 8u:
      return acos(clamp(a, -1.0f, 1.0f));
    case 9u:
      return atan(a);
    case 19u:
      return angle_of(a, b);
    case 27u:
      return a * (PI / 180.0f);
    case 28u:
      return a * (180.0f / PI);
    case 29u:
      return sinh(a);
    case 30u:
      return cosh(a);
    default:
      return tanh(a);
  }
}

// Rounding, remainders and intervals.
FN float math_round(uint operation, float a, float b, float c) {
  switch (operation) {
    case 14u:
      return floor(a + 0.5f);
    case 17u:
      return safe_remainder(a, b);
    case 20u:
      return floor(a);
    case 21u:
      return ceil(a);
    case 22u:
      return fraction(a);
    case 32u:
      return trunc(a);
    case 33u:
      return floor(safe_divide(a, b)) * b;
    case 34u:
      return wrap(a, b, c);
    case 37u:
      return ping_pong(a, b);
    default:
      return select(b != 0.0f, a - floor(safe_divide(a, b)) * b, 0.0f);
  }
}

// Arithmetic, powers and comparisons.
FN float math_basic(uint operation, float a, float b, float c) {
  switch (operation) {
    case 0u:
      return a + b;
    case 1u:
      return a - b;
    case 2u:
      return a * b;
    case 3u:
      return safe_divide(a, b);
    case 10u:
      return safe_pow(a, b);
    case 11u:
      return safe_log(a, b);
    case 12u:
      return min(a, b);
    case 13u:
      return max(a, b);
    case 15u:
      return select(a < b, 1.0f, 0.0f);
    case 16u:
      return select(a > b, 1.0f, 0.0f);
    case 18u:
      return abs(a);
    case 23u:
      return safe_sqrt(a);
    case 24u:
      return select(a > 0.0f, 1.0f / sqrt(select(a > 0.0f, a, 1.0f)), 0.0f);
    case 25u:
      return sign(a);
    case 26u:
      return exp(a);
    case 35u:
      return select(a == b || abs(a - b) <= max(c, SMALLEST_COMPARE), 1.0f, 0.0f);
    case 36u:
      return a * b + c;
    case 38u:
      return smooth_min(a, b, c);
    case 39u:
      return -smooth_min(-a, -b, c);
    default:
      return 0.0f;
  }
}

FN float op_math(uint mode, float a, float b, float c) {
  const uint operation = mode & 0xffffu;
  const bool angle = (operation >= 4u && operation <= 9u) || operation == 19u || (operation >= 27u && operation <= 31u);
  const bool rounding = operation == 14u || operation == 17u || (operation >= 20u && operation <= 22u) ||
                        (operation >= 32u && operation <= 34u) || operation == 37u || operation == 40u;
  const float result = angle ? math_angle(operation, a, b)
                             : (rounding ? math_round(operation, a, b, c) : math_basic(operation, a, b, c));
  return (mode & MATH_CLAMP) != 0u ? saturate(result) : result;
}

FN float op_clamp_f(uint mode, float a, float low, float high) {
  const bool swapped = mode == 1u && low > high;
  return min(max(a, select(swapped, high, low)), select(swapped, low, high));
}

// 6 t^5 - 15 t^4 + 10 t^3
FN float smoother_step(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

// The way from 0 to 1, by the interpolation: linear, stepped, smooth or smoother.
FN float map_range_factor(uint interpolation, float t, float steps) {
  if (interpolation == 1u) return select(steps > 0.0f, floor(t * (steps + 1.0f)) / max(steps, 1e-30f), 0.0f);
  if (interpolation == 2u) return smoothstep01(t);
  return interpolation == 3u ? smoother_step(saturate(t)) : t;
}

FN float op_map_range_f(uint mode, float a, float from_min, float from_max, float to_min, float to_max, float steps) {
  const float factor = map_range_factor(mode & 7u, safe_divide(a - from_min, from_max - from_min), steps);
  const float result = select(from_max != from_min, to_min + factor * (to_max - to_min), 0.0f);
  return (mode & MAP_RANGE_CLAMP) != 0u ? op_clamp_f(1u, result, to_min, to_max) : result;
}

FN float op_mix_f(uint mode, float factor, float a, float b) {
  const float t = (mode & 1u) != 0u ? saturate(factor) : factor;
  return (1.0f - t) * a + t * b;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

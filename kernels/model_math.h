// SPDX-License-Identifier: GPL-3.0-or-later
// Functions of one number that the reflection models need where the built-in ones cancel or are missing.
// No directions and no light here, and no branches: loops over lanes become vector code.
#ifndef COTORRA_MODEL_MATH_H
#define COTORRA_MODEL_MATH_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// log(c) for c in 0..1 of which 1 - c is known better near 1; a large negative number at 0. There it is the series of
// -2 artanh(x / (2 - x)) with x = 1 - c, whose next term is 3e-10.
FN float log_near_one(float c, float x) {
  const float z = x / (2.0f - x);
  const float z2 = z * z;
  const float series = -2.0f * z * (1.0f + z2 * (1.0f / 3.0f + z2 * (0.2f + z2 * (1.0f / 7.0f + z2 * (1.0f / 9.0f)))));
  return select(x < 0.25f, series, log_lanes(max(c, 1e-37f)));
}
FN float log_one_minus(float x) { return log_near_one(1.0f - x, x); }

// c^e, with c as above: so that exponents of a million still see how far from 1 it is.
FN float pow_near_one(float c, float x, float e) { return exp_lanes(e * log_near_one(c, x)); }

// 1 - exp(-y) for y >= 0; near 0 by Taylor's series, whose next term is 2e-7 of it.
FN float one_minus_exp(float y) {
  const float tail = 1.0f - y * 0.2f * (1.0f - y * (1.0f / 6.0f) * (1.0f - y * (1.0f / 7.0f)));
  const float series = y * (1.0f - y * 0.5f * (1.0f - y * (1.0f / 3.0f) * (1.0f - y * 0.25f * tail)));
  return select(y < 0.5f, series, 1.0f - exp_lanes(-y));
}

// exp(x^2) erfc(x) for x >= 0. Fitted by us as a polynomial in 1 / (1 + x / 2): relative error 4e-7 up to x = 6, and
// 1 % beyond, where exp(-x^2) leaves nothing of it.
FN float erfc_scaled(float x) {
  const float t = 1.0f / (1.0f + 0.5f * x);
  const float high = -0.226936513f + t * (0.777656779f + t * (-0.696397758f + t * (0.250543737f - t * 0.0325632615f)));
  return -0.000203759854f + t * (0.28597232f + t * (0.250439939f + t * (0.391488588f + t * high)));
}

// acos(c) / sqrt(1 - c^2) for c in 0..1, fitted by us as a polynomial in 1 - c: relative error 5e-7.
FN float acos_over_sine(float c) {
  const float x = 1.0f - c;
  const float high = -0.00502054021f + x * (0.0696748495f + x * (-0.0520398468f + x * 0.0270809010f));
  return 0.99999958f + x * (0.333387464f + x * (0.132236779f + x * (0.0654764771f + x * high)));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

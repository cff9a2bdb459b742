// SPDX-License-Identifier: GPL-3.0-or-later
// Constants, bases and polynomials that the other kernels share.
// No random numbers and no light transport here.
#ifndef COTORRA_MATH_H
#define COTORRA_MATH_H

#include "language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const float PI = 3.14159265358979f;
const float INV_PI = 0.318309886183791f;
const float INFINITE_DISTANCE = 1e30f;  // finite, so that differences of distances stay numbers

FN float sqr(float a) { return a * a; }
FN float max_component(vec3 a) { return max(a.x, max(a.y, a.z)); }
FN float luminance(vec3 rgb) { return dot(rgb, vec3(0.2126f, 0.7152f, 0.0722f)); }
FN bool is_black(vec3 a) { return max_component(abs(a)) == 0.0f; }
// Some light, be it below 0 as Blender allows it; none where a part is no number.
FN bool carries_light(vec3 a) { return abs(a.x) + abs(a.y) + abs(a.z) > 0.0f; }

// 1 - cos(theta) from sin(theta)^2, without the cancellation near 0.
FN float one_minus_cos_from_sin2(float sin2) {
  const float s = clamp(sin2, 0.0f, 1.0f);
  return s / (1.0f + sqrt(1.0f - s));
}

// A unit vector in the direction of `a`, and its length; (0, 0, 1) and 0 for a null vector.
FN vec3 safe_normalize(vec3 a, OUT(float) len) {
  const float d2 = dot(a, a);
  len = sqrt(d2);
  return d2 > 0.0f ? a * (1.0f / len) : vec3(0.0f, 0.0f, 1.0f);
}

// Two unit vectors that complete the unit vector n to a right-handed basis (Duff et al. 2017, listing 3). The basis
// jumps where s changes its sign. The paper's n.z = 0 is each vertical wall, where rounding would have two devices draw
// other directions from the same numbers; few surfaces lean by the 3.5 degrees of this n.z.
FN void orthonormal_basis(vec3 n, OUT(vec3) t, OUT(vec3) b) {
  const float s = n.z >= -0.0617f ? 1.0f : -1.0f;
  const float a = -1.0f / (s + n.z);
  const float c = n.x * n.y * a;
  t = vec3(1.0f + s * n.x * n.x * a, s * c, -s * n.x);
  b = vec3(c, s + n.y * n.y * a, -n.y);
}

FN vec3 to_world(vec3 v, vec3 t, vec3 b, vec3 n) { return t * v.x + b * v.y + n * v.z; }

// sin(x) and cos(x) for |x| <= pi/4 to 1e-7: Taylor with the last terms fitted; the same bits on each device.
FN float sin_quarter(float x) {
  const float x2 = x * x;
  return x * (1.0f + x2 * (-0.166666664f + x2 * (0.00833321567f + x2 * -0.000195152956f)));
}
FN float cos_quarter(float x) {
  const float x2 = x * x;
  return 1.0f + x2 * (-0.5f + x2 * (0.0416666418f + x2 * (-0.00138873162f + x2 * 2.44331571e-5f)));
}

// atan2(y, x) without branches, to 2.5e-7 of it; the angle of (0, 0) is 0. Up to pi/8 it is Taylor with the last terms
// fitted, and up to pi/4 what is missing of that.
FN float angle_lanes(float y, float x) {
  const float ratio = min(abs(x), abs(y)) / max(max(abs(x), abs(y)), 1e-37f);
  const bool steep = ratio > 0.414213562f;
  const float a = select(steep, (ratio - 1.0f) / (ratio + 1.0f), ratio);
  const float a2 = a * a;
  const float p = a + a * a2 * (-0.333329558f + a2 * (0.199779257f + a2 * (-0.138798490f + a2 * 0.0806030482f)));
  const float to_axis = select(steep, 0.25f * PI + p, p);
  const float to_x = select(abs(y) > abs(x), 0.5f * PI - to_axis, to_axis);
  const float up = select(x < 0.0f, PI - to_x, to_x);
  return select(y < 0.0f, -up, up);
}

// exp(x) for x <= 0 without branches, so that loops over lanes become vector code: 2^n times a polynomial of the rest,
// to 2e-7 down to -87, and from there on 0. The same bits on each device.
FN float exp_lanes(float x) {
  const float safe = select(x > -87.0f, x, -87.0f);
  const float n = floor(safe * 1.44269504f + 0.5f);
  // log(2) in two parts, the first short enough for exact products with n (Cody and Waite 1980).
  const float f = (safe - n * 0.693359375f) + n * 2.12194440e-4f;
  const float high = 0.0416666667f + f * (0.00833333333f + f * (0.00138888889f + f * 0.000198412698f));
  const float p = 1.0f + f * (1.0f + f * (0.5f + f * (0.166666667f + f * high)));
  return select(x > -87.0f, p * uintBitsToFloat(uint(int(n) + 127) << 23), 0.0f);
}

// log(x) for normal numbers x > 0 in the same manner, to 2.5e-7: of x = m 2^n with m from 0.707 to 1.414, log(m) is
// 2 artanh((m - 1) / (m + 1)), whose next term is 3e-9 of it.
FN float log_lanes(float x) {
  const int n = int(floatBitsToUint(x) - 0x3f3504f3u) >> 23;
  const float m = uintBitsToFloat(floatBitsToUint(x) - uint(n << 23));
  const float z = (m - 1.0f) / (m + 1.0f);
  const float z2 = z * z;
  const float log_m = 2.0f * z * (1.0f + z2 * (1.0f / 3.0f + z2 * (0.2f + z2 * (1.0f / 7.0f + z2 * (1.0f / 9.0f)))));
  return float(n) * 0.693359375f + (log_m - float(n) * 2.12194440e-4f);
}

// Smooth step between 0 and 1 of an argument that is clamped.
FN float smoothstep01(float x) {
  const float t = clamp(x, 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

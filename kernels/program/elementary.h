// SPDX-License-Identifier: GPL-3.0-or-later
// Functions of one or two numbers that are defined for each of them, as Blender's nodes are: x / 0 = 0, and so on.
// And sine, cosine and remainder without branches, which compilers turn into vector code; no node is here.
#ifndef COTORRA_PROGRAM_ELEMENTARY_H
#define COTORRA_PROGRAM_ELEMENTARY_H

#include "../math.h"

// Before a loop of a fixed number of rounds. A file of loops over lanes defines PROGRAM_LANES: without inner loops g++
// turns them into vector code. Elsewhere, where the number is not known to the compiler, unrolling would only swell it.
#if defined(PROGRAM_LANES) && defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#elif defined(PROGRAM_LANES)
#define UNROLL _Pragma("GCC unroll 128")
#else
#define UNROLL
#endif

#ifdef __cplusplus
namespace cotorra {
#endif

const float TWO_PI = 6.28318530717959f;
const float HALF_PI = 1.57079632679490f;
const float LARGEST_INT_FLOAT = 2147483520.0f;  // the largest float below 2^31

FN float saturate(float a) { return clamp(a, 0.0f, 1.0f); }
FN vec3 saturate(vec3 a) { return vec3(saturate(a.x), saturate(a.y), saturate(a.z)); }
FN float fraction(float a) { return a - floor(a); }

// a + t (b - a): monotonic in t, unlike mix, which gives b itself at t = 1.
FN float lerp(float a, float b, float t) { return a + t * (b - a); }
FN vec3 lerp(vec3 a, vec3 b, float t) { return a + t * (b - a); }

// The integer below a, also for numbers that no integer can hold.
FN int floor_int(float a) {
  const float low = floor(a);
  return int(select(abs(low) <= LARGEST_INT_FLOAT, low, 0.0f));
}

FN float safe_divide(float a, float b) { return select(b != 0.0f, a / select(b != 0.0f, b, 1.0f), 0.0f); }
FN vec3 safe_divide(vec3 a, vec3 b) {
  return vec3(safe_divide(a.x, b.x), safe_divide(a.y, b.y), safe_divide(a.z, b.z));
}
FN float safe_sqrt(float a) { return sqrt(max(a, 0.0f)); }
FN float sign_nonzero(float a) { return select(a < 0.0f, -1.0f, 1.0f); }

// a / |a|; a null vector stays null.
FN vec3 normalize_or_zero(vec3 a) {
  const float len = sqrt(dot(a, a));
  return a * select(len != 0.0f, 1.0f / select(len != 0.0f, len, 1.0f), 1.0f);
}

// a^b, where negative a have a real power for whole b only; 0 otherwise. 0^0 = 1.
FN float safe_pow(float a, float b) {
  const bool whole = b == trunc(b);
  const bool odd = whole && abs(b) < 16777216.0f && (int(select(abs(b) < 16777216.0f, b, 0.0f)) & 1) != 0;
  const float magnitude = pow(select(a == 0.0f, 1.0f, abs(a)), b);
  const float power = select(a < 0.0f, select(whole, select(odd, -magnitude, magnitude), 0.0f), magnitude);
  return select(b == 0.0f, 1.0f, select(a == 0.0f, 0.0f, power));
}

// The remainder of a / b with the sign of a, exact while the quotient has at most 2^24 and b few digits.
FN float remainder_truncated(float a, float b) {
  const float q = trunc(a / b);
  // b in two parts of 12 digits: their products with q of up to 12 digits are exact.
  const float high = uintBitsToFloat(floatBitsToUint(b) & 0xfffff000u);
  const float low = b - high;
  const float r = (a - q * high) - q * low;
  // The quotient may have been rounded up to the next integer.
  const float up = select(a < 0.0f, -abs(b), abs(b));
  return select(r * a < 0.0f, r + up, r);
}

// Quarter turns away from x, and the angle that remains, within pi/4 of 0; good to 1e-7 up to |x| = 1e4.
FN int quarter_turns(float x, OUT(float) rest) {
  const float safe = select(abs(x) < 1e9f, x, 0.0f);
  const float n = floor(safe * 0.636619772f + 0.5f);
  // pi/2 in three parts, the first two short enough for exact products with n (Cody and Waite 1980).
  rest = ((safe - n * 1.5703125f) - n * 4.83751297e-4f) - n * 7.54978995e-8f;
  return int(n);
}

// sin and cos as vector code.
FN float sin_lanes(float x) {
  float r;
  const int n = quarter_turns(x, r);
  const float s = select((n & 1) != 0, cos_quarter(r), sin_quarter(r));
  return select((n & 2) != 0, -s, s);
}
FN float cos_lanes(float x) {
  float r;
  const int n = quarter_turns(x, r);
  const float c = select((n & 1) != 0, sin_quarter(r), cos_quarter(r));
  return select(((n + 1) & 2) != 0, -c, c);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

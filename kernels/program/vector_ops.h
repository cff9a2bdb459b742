// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that take vectors apart, put them together and reckon with them: the Vector Math node, Map Range and Mix of
// vectors, and what links between unlike sockets do. Rotations and scalings are mapping.h's.
#ifndef COTORRA_PROGRAM_VECTOR_OPS_H
#define COTORRA_PROGRAM_VECTOR_OPS_H

#include "math_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN vec3 op_splat(uint, float a) { return vec3(a, a, a); }
// The luminance of Rec.709's primaries to one digit more than math.h has it: where colours become numbers, Cycles does.
FN float op_luminance(uint, vec3 a) { return dot(a, vec3(0.2126391f, 0.7151691f, 0.0721927f)); }
FN float op_average(uint, vec3 a) { return (a.x + a.y + a.z) / 3.0f; }
FN float op_component(uint mode, vec3 a) { return mode == 0u ? a.x : (mode == 1u ? a.y : a.z); }
FN vec3 op_combine(uint, float x, float y, float z) { return vec3(x, y, z); }

FN vec3 vector_project(vec3 a, vec3 b) { return b * safe_divide(dot(a, b), dot(b, b)); }
FN vec3 vector_reflect(vec3 a, vec3 n) { return a - 2.0f * dot(a, n) * n; }

// Snell's law for a direction into the surface; 0 where all of it is reflected.
FN vec3 vector_refract(vec3 a, vec3 n, float eta) {
  const float cosine = dot(n, a);
  const float k = 1.0f - eta * eta * (1.0f - cosine * cosine);
  return select(k < 0.0f, 0.0f, 1.0f) * (eta * a - (eta * cosine + safe_sqrt(k)) * n);
}

// Operations that mix components.
FN vec3 vector_geometry(uint operation, vec3 a, vec3 b, vec3 c, float scale) {
  switch (operation) {
    case 4u:
      return cross(a, b);
    case 5u:
      return vector_project(a, b);
    case 6u:
      return vector_reflect(a, normalize_or_zero(b));
    case 10u:
      return a * scale;
    case 11u:
      return normalize_or_zero(a);
    case 24u:
      return vector_refract(a, normalize_or_zero(b), scale);
    default:
      return select(dot(c, b) < 0.0f, 1.0f, -1.0f) * a;
  }
}

// Vectors have their remainder from the rounded quotient, as Cycles computes it, numbers the exact one.
FN float vector_remainder(float a, float b) { return select(b != 0.0f, a - b * trunc(safe_divide(a, b)), 0.0f); }

// Operations that treat each component alike.
FN float vector_component(uint operation, float a, float b, float c) {
  switch (operation) {
    case 0u:
      return a + b;
    case 1u:
      return a - b;
    case 2u:
      return a * b;
    case 3u:
      return safe_divide(a, b);
    case 12u:
      return floor(safe_divide(a, b)) * b;
    case 13u:
      return floor(a);
    case 14u:
      return ceil(a);
    case 15u:
      return vector_remainder(a, b);
    case 16u:
      return fraction(a);
    case 17u:
      return abs(a);
    case 18u:
      return min(a, b);
    case 19u:
      return max(a, b);
    case 20u:
      return wrap(a, b, c);
    case 21u:
      return sin(a);
    case 22u:
      return cos(a);
    case 23u:
      return tan(a);
    case 26u:
      return a * b + c;
    case 27u:
      return safe_pow(a, b);
    case 28u:
      return sign(a);
    case 29u:
      return floor(a + 0.5f);
    default:
      return 0.0f;
  }
}

FN vec3 op_vector_math_v(uint mode, vec3 a, vec3 b, vec3 c, float scale) {
  const bool geometry = (mode >= 4u && mode <= 6u) || mode == 10u || mode == 11u || mode == 24u || mode == 25u;
  if (geometry) return vector_geometry(mode, a, b, c, scale);
  return vec3(vector_component(mode, a.x, b.x, c.x), vector_component(mode, a.y, b.y, c.y),
              vector_component(mode, a.z, b.z, c.z));
}

FN float op_vector_math_f(uint mode, vec3 a, vec3 b, vec3, float) {
  const vec3 d = a - b;
  return mode == 7u ? dot(a, b) : (mode == 8u ? sqrt(dot(d, d)) : (mode == 9u ? sqrt(dot(a, a)) : 0.0f));
}

// One component: where the interval that it comes from is empty, the result is `to_min`; of floats it is 0.
FN float map_range_component(uint mode, float a, float from_min, float from_max, float to_min, float to_max,
                             float steps) {
  const float factor = map_range_factor(mode & 7u, safe_divide(a - from_min, from_max - from_min), steps);
  const float result = to_min + factor * (to_max - to_min);
  return (mode & MAP_RANGE_CLAMP) != 0u ? op_clamp_f(1u, result, to_min, to_max) : result;
}

FN vec3 op_map_range_v(uint mode, vec3 a, vec3 from_min, vec3 from_max, vec3 to_min, vec3 to_max, vec3 steps) {
  return vec3(map_range_component(mode, a.x, from_min.x, from_max.x, to_min.x, to_max.x, steps.x),
              map_range_component(mode, a.y, from_min.y, from_max.y, to_min.y, to_max.y, steps.y),
              map_range_component(mode, a.z, from_min.z, from_max.z, to_min.z, to_max.z, steps.z));
}

FN vec3 op_mix_v(uint mode, vec3 factor, vec3 a, vec3 b) {
  return vec3(op_mix_f(mode, factor.x, a.x, b.x), op_mix_f(mode, factor.y, a.y, b.y),
              op_mix_f(mode, factor.z, a.z, b.z));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

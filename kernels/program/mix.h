// SPDX-License-Identifier: GPL-3.0-or-later
// The blend types of the Mix node: what becomes of a where b lies over it with a share of t.
// Mixes of floats and vectors, which know one type only, are in math_ops.h and vector_ops.h.
#ifndef COTORRA_PROGRAM_MIX_H
#define COTORRA_PROGRAM_MIX_H

#include "color_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint MIX_CLAMP_FACTOR = 256u;  // bits of the mode
const uint MIX_CLAMP_RESULT = 512u;

FN float mix_overlay(float t, float a, float b) {
  const float dark = a * ((1.0f - t) + 2.0f * t * b);
  const float light = 1.0f - ((1.0f - t) + 2.0f * t * (1.0f - b)) * (1.0f - a);
  return select(a < 0.5f, dark, light);
}

FN float mix_divide(float t, float a, float b) { return select(b != 0.0f, (1.0f - t) * a + t * safe_divide(a, b), a); }

FN float mix_dodge(float t, float a, float b) {
  const float rest = 1.0f - t * b;
  const float bright = min(a / select(rest > 0.0f, rest, 1.0f), 1.0f);
  return select(a == 0.0f, 0.0f, select(rest <= 0.0f, 1.0f, bright));
}

FN float mix_burn(float t, float a, float b) {
  const float rest = 1.0f - t + t * b;
  return select(rest <= 0.0f, 0.0f, saturate(1.0f - (1.0f - a) / select(rest > 0.0f, rest, 1.0f)));
}

FN float mix_soft_light(float t, float a, float b) {
  const float screen = 1.0f - (1.0f - b) * (1.0f - a);
  return (1.0f - t) * a + t * ((1.0f - a) * b * a + a * screen);
}

// Types that treat each component alike.
FN float mix_component(uint type, float t, float a, float b) {
  switch (type) {
    case 0u:
      return (1.0f - t) * a + t * b;
    case 1u:
      return a + t * b;
    case 2u:
      return a * ((1.0f - t) + t * b);
    case 3u:
      return a - t * b;
    case 4u:
      return 1.0f - ((1.0f - t) + t * (1.0f - b)) * (1.0f - a);
    case 5u:
      return mix_divide(t, a, b);
    case 6u:
      return lerp(a, abs(a - b), t);
    case 7u:
      return lerp(a, min(a, b), t);
    case 8u:
      return lerp(a, max(a, b), t);
    case 9u:
      return mix_overlay(t, a, b);
    case 10u:
      return mix_dodge(t, a, b);
    case 11u:
      return mix_burn(t, a, b);
    case 16u:
      return mix_soft_light(t, a, b);
    case 17u:
      return a + t * (2.0f * b - 1.0f);
    case 18u:
      return max(lerp(a, a + b - 2.0f * a * b, t), 0.0f);
    default:
      return 0.0f;
  }
}

// Types that take hue (12, 15), saturation (13, 15) or value (14) of b. Greys have no hue to give or to keep.
FN vec3 mix_hsv(uint type, float t, vec3 a, vec3 b) {
  const vec3 p = hsv_from_rgb(a);
  const vec3 q = hsv_from_rgb(b);
  if (type == 13u) {
    return select(p.y != 0.0f, rgb_from_hsv(vec3(p.x, (1.0f - t) * p.y + t * q.y, p.z)), a);
  }
  if (type == 14u) return rgb_from_hsv(vec3(p.x, p.y, (1.0f - t) * p.z + t * q.z));
  const vec3 changed = rgb_from_hsv(vec3(q.x, type == 15u ? q.y : p.y, p.z));
  return select(q.y != 0.0f, lerp(a, changed, t), a);
}

FN vec3 op_mix_color(uint mode, float factor, vec3 a, vec3 b) {
  const uint type = mode & 31u;
  const float t = (mode & MIX_CLAMP_FACTOR) != 0u ? saturate(factor) : factor;
  const bool by_hsv = type >= 12u && type <= 15u;
  const vec3 mixed = by_hsv ? mix_hsv(type, t, a, b)
                            : vec3(mix_component(type, t, a.x, b.x), mix_component(type, t, a.y, b.y),
                                   mix_component(type, t, a.z, b.z));
  return (mode & MIX_CLAMP_RESULT) != 0u ? saturate(mixed) : mixed;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

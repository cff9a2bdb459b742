// SPDX-License-Identifier: GPL-3.0-or-later
// Numerical health: what can be wrong with a sample, and where it came to be. Who counts is the device's; kernels that
// are built without FEATURE_HEALTH ask nothing.
#ifndef COTORRA_HEALTH_H
#define COTORRA_HEALTH_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint BAD_NOT_FINITE = 0u;  // light that is infinite or no number: the sample is dropped
const uint BAD_NEGATIVE = 1u;    // light below 0, which is kept: lamps may be negative
const uint BAD_FIREFLY = 2u;     // light of a bounce that alone turns its pixel white
const uint BAD_NUMBER = 3u;      // a number of a shader that is infinite or none, mended before it made light
const uint BAD_KINDS = 4u;

const uint HEALTH_LIT = 0u;       // a surface that a light sample lights
const uint HEALTH_SCATTER = 1u;   // a surface that sends the path on
const uint HEALTH_EMISSION = 2u;  // a surface that emits
const uint HEALTH_LAMP = 3u;      // a lamp that the path met
const uint HEALTH_WORLD = 4u;
const uint HEALTH_SHADER = 5u;    // the shader of a surface
const uint HEALTH_UNKNOWN = 6u;

// Which of BAD_* light is, BAD_KINDS: none. `limit`: of a firefly, INFINITE_DISTANCE where it cannot be one.
FN uint bad_light(vec3 light, float limit) {
  const float size = abs(light.x) + abs(light.y) + abs(light.z);
  if (!(size < INFINITE_DISTANCE)) return BAD_NOT_FINITE;
  if (light.x < 0.0f || light.y < 0.0f || light.z < 0.0f) return BAD_NEGATIVE;
  return max(max(light.x, light.y), light.z) > limit ? BAD_FIREFLY : BAD_KINDS;
}

// Is it mended by light_number (material.h)?
FN bool bad_number(float a) { return !(abs(a) <= 1e15f); }

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

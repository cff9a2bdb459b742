// SPDX-License-Identifier: GPL-3.0-or-later
// The normal that glossy lobes take where the smooth one would mirror the viewer into the surface.
// Where shadow rays start on such a surface is integrator.h's.
#ifndef COTORRA_REFLECTION_NORMAL_H
#define COTORRA_REFLECTION_NORMAL_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A smooth normal may lean so far from the triangle that the mirror direction lies below it. Glossy lobes then take a
// normal in the plane of n and ng that lifts the mirror direction to `threshold` above the triangle (as Cycles does).
// With N' = (x, 0, z) and wo = (ox, ., oz) in that plane, the condition 2 (x ox + z oz) z - oz = threshold, squared, is
// quadratic in z^2.
FN vec3 normal_for_reflection(vec3 n, vec3 ng, vec3 wo) {
  const float oz = dot(wo, ng);
  const float threshold = min(0.9f * oz, 0.01f);
  const vec3 mirror = n * (2.0f * dot(n, wo)) - wo;
  if (dot(mirror, ng) >= threshold) return n;
  float len;
  const vec3 x_axis = safe_normalize(n - ng * dot(n, ng), len);
  if (!(len > 0.0f)) return n;
  const float ox = dot(wo, x_axis);
  const float a = max(ox * ox + oz * oz, 1e-20f);
  const float b = 2.0f * (a + oz * threshold);
  const float c = sqr(threshold + oz);
  const float root = sqrt(max(b * b - 4.0f * a * c, 0.0f));
  const float z2 = clamp(0.25f * (b + select(ox < 0.0f, root, -root)) / a, 0.0f, 1.0f);
  return x_axis * sqrt(1.0f - z2) + ng * sqrt(z2);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

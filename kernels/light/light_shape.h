// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps that fall off with distance, or end at the edge of their cone, in another way than Blender's: factors on what
// light.h says. Who writes the records is told in native/scene_lights.cpp.
#ifndef COTORRA_LIGHT_SHAPE_H
#define COTORRA_LIGHT_SHAPE_H

#include "light.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The angle whose 1 - cos is v, up to 90 degrees: 2 asin(sqrt(v / 2)), the series of asin fitted to 2e-7. Small angles
// keep their digits, which acos of the cosine loses, and every device computes the same bits.
FN float angle_from_versine(float v) {
  const float z = 0.5f * clamp(v, 0.0f, 1.0f);
  const float high = 0.03900928f + z * (0.06053084f + z * (-0.054722443f + z * 0.10091151f));
  return 2.0f * sqrt(z) * (1.0f + z * (0.16665374f + z * (0.07547095f + z * high)));
}

// What the lamp sends to distance d, over what 1/d^2 would. A polynomial that is 0 gives no light.
FN float light_falloff(IN(LightShape) shape, float d) {
  const float x = min(d * shape.inverse_range, 1.0f);
  // 1 - x^4 in factors, which stays exact where x is nearly 1.
  const float window = (1.0f - x) * (1.0f + x) * (1.0f + x * x);
  const float polynomial = shape.c0 + d * (shape.c1 + d * shape.c2);
  const float ratio = select(polynomial > 1e-30f, d * d / max(polynomial, 1e-30f), 0.0f);
  return select(shape.falloff == FALLOFF_RANGED, window, select(shape.falloff == FALLOFF_POLYNOMIAL, ratio, 1.0f));
}

// Brightness of a spot's cone in direction wi (surface to light), in the lamp's own space as spot_attenuation has it.
FN float light_spot_edge(IN(LightShape) shape, IN(Light) light, vec3 wi) {
  const float versine = spot_direction_versine(light, wi);
  const bool linear = shape.edge == SPOT_EDGE_LINEAR;
  const float position = select(linear, angle_from_versine(versine), versine);
  const float ramp = clamp((shape.edge_end - position) * shape.edge_scale, 0.0f, 1.0f);
  const float k = select(versine < 1.0f, select(linear, ramp, ramp * ramp), 0.0f);
  return select(shape.edge == SPOT_EDGE_BLENDER, 1.0f, k);
}

// Factor on the light that Blender's own lamp would send to p from direction wi. Distances are to the lamp's centre, so
// that a lamp of size is dimmed as a whole and its samples keep their density.
FN float light_shape(IN(LightShape) shape, IN(Light) light, vec3 p, vec3 wi) {
  const vec3 to_light = light.position - p;
  const float d = sqrt(max(dot(to_light, to_light), 1e-20f));
  const bool inside = (light.flags & LIGHT_SOFT_FALLOFF) == 0u && d <= light.radius;
  return light_falloff(shape, d) * select(inside, 1.0f, light_spot_edge(shape, light, wi));
}

// As light_shape, for lamp `index` of a scene; 1 for lamps of Blender's own shape.
FN float scene_light_shape(IN(SceneData) scene, uint index, IN(Light) light, vec3 p, vec3 wi) {
  if ((light.flags & LIGHT_SHAPED) == 0u) return 1.0f;
  const LightShape shape = LOAD(scene.light_shapes, index);
  return light_shape(shape, light, p, wi);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

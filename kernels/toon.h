// SPDX-License-Identifier: GPL-3.0-or-later
// Toon shading: the number of lamps that light a point fully picks one of a few colours.
// Shadow rays are traced elsewhere; outlines are outline.h's.
#ifndef COTORRA_TOON_H
#define COTORRA_TOON_H

#include "integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const float TOON_FULL = 0.5f;     // n.l from which a lamp lights a point fully
const float TOON_SHADE = 0.184f;  // of materials without toon colours: half as light to the eye (L* = 50 against 100)

// The lamp at its centre: soft edges would blur the tones. Returns whether it would light the point fully, if nothing
// stands between.
FN bool toon_light_ray(IN(SceneData) scene, uint index, IN(Surface) s, OUT(ShadowRay) ray) {
  const Light light = LOAD(scene.lights, index);
  LightSample l;
  light_sample(light, s.p, s.n, vec2(0.5f, 0.5f), l);
  ray.direction = l.wi;
  ray.t_max = l.distance;
  ray.contribution = l.weight;
  ray.group = light.group;
  ray.visibility = select((light.flags & LIGHT_CAST_SHADOW) != 0u, VISIBLE_SHADOW, 0u);
  ray.origin = s.p;
  if (dot(s.n, l.wi) < TOON_FULL || !(max_component(l.weight) > 0.0f)) return false;
  ray.origin = shadow_ray_origin(scene, s, l.wi);
  return true;
}

// The colour of a point that `lit` of `lamps` light fully. Two steps: lit where these are no fewer than the others.
// Without lamps there is nothing to be in shade of.
FN vec3 toon_color(IN(Material) material, IN(ClassicMaterial) classic, uint lit, uint lamps) {
  const bool own = (classic.flags & CLASSIC_TOON) != 0u;
  const vec3 bright = select(own, classic.toon_lit, material.base_color);
  const vec3 dark = select(own, classic.toon_shade, material.base_color * TOON_SHADE);
  const uint steps = max(classic.toon_steps, 1u);
  const uint last = steps - 1u;
  if (last == 0u || lamps == 0u) return bright;
  const uint k = min(lit * steps / lamps, last);
  return mix(dark, bright, float(int(k)) / float(int(last)));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

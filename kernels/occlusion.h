// SPDX-License-Identifier: GPL-3.0-or-later
// Ambient light: a constant from all around, and the share of the sky over a surface that nothing hides within a
// distance. Rays are traced elsewhere; light between surfaces is integrator.h's.
#ifndef COTORRA_OCCLUSION_H
#define COTORRA_OCCLUSION_H

#include "whitted.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint PAIR_OCCLUSION = 255u;  // of a vertex, after the lamps' (integrator.h)

// A ray that asks whether the sky is hidden, cosine-distributed: the mean over rays is the integral of the visibility
// times cosine over pi. Where a smooth normal leans so far that the direction lies below the triangle, the ray starts
// from the lifted surface like any shadow ray (as in Cycles).
FN void occlusion_ray(IN(SceneData) scene, IN(Surface) s, vec2 u, float distance, OUT(ShadowRay) ray) {
  vec3 t;
  vec3 b;
  orthonormal_basis(s.n, t, b);
  ray.direction = to_world(cosine_hemisphere_from_square(u), t, b, s.n);
  ray.t_max = distance;
  ray.contribution = vec3(1.0f);
  ray.group = -1;
  ray.visibility = VISIBLE_SHADOW;
  ray.origin = shadow_ray_origin(scene, s, ray.direction);
}

// ka Ia C: what a surface returns of ambient light. C is the base colour, less what Whitted brings by rays instead.
FN vec3 ambient_term(IN(Material) material, IN(ClassicMaterial) classic, vec3 ambient) {
  const bool mirror = (material.flags & MATERIAL_MODEL) == 0u && is_smooth(material);
  const float metal = select(mirror, clamp(material.metallic, 0.0f, 1.0f), 0.0f);
  const float share = 1.0f - metal - glass_share(material, classic);
  return max(material.base_color, vec3(0.0f)) * ambient * (classic.ka * max(share, 0.0f));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that let rays through: how much a point keeps, and which rays it stops.
// Whoever traces asks this at each surface that a ray may meet; shading never sees what let the ray through.
#ifndef COTORRA_ALPHA_H
#define COTORRA_ALPHA_H

#include "integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Share of the light that goes on behind the surface where a ray of the path met it; or a shadow ray from the vertex
// that the path's ray met. `crossed`: surfaces that the ray itself passed before.
FN vec3 hit_transparency(IN(SceneData) scene, IN(Hit) hit, vec3 direction, IN(PathState) path, bool shadow,
                         uint crossed) {
  const uint index = triangle_material(scene, hit.instance, hit.triangle);
  const Material material = LOAD(scene.materials, index);
  if ((material.flags & MATERIAL_TRANSPARENT) == 0u) return vec3(0.0f);
  if (!material_varies(material)) return vec3(unit_clamp(1.0f - material.alpha));
  ShaderPoint at = mesh_point(hit, direction);
  if ((LOAD(scene.programs, index).flags & PROGRAM_PLACE) == 0u) {
    Surface s;
    surface_from_hit(scene, hit, direction, s);
    at = shader_point(s, -direction, hit.t);
  }
  at.footprint = path.footprint;
  path_counts(path, at);
  at.transparent_bounces += crossed;
  if (shadow) {  // one vertex further, as in Cycles
    at.ray_kind = VISIBLE_SHADOW;
    at.bounce += 1u;
  }
  return material_transparency(scene, index, at);
}

// Share that the surface stops of a ray that is let through whole or not at all. Where what is let through has a
// colour, the surface stops all of it, and its shading lets it go on.
FN float hit_alpha(IN(SceneData) scene, IN(Hit) hit, vec3 direction, IN(PathState) path, bool shadow, uint crossed) {
  const uint index = triangle_material(scene, hit.instance, hit.triangle);
  if ((LOAD(scene.materials, index).flags & MATERIAL_TINTED) != 0u) return 1.0f;
  return 1.0f - hit_transparency(scene, hit, direction, path, shadow, crossed).x;
}

// A number in [0, 1) for a path's ray at a triangle: below the alpha there, the ray is stopped. Of neighbouring samples
// it is stratified, since they share the scrambling; two triangles never share theirs. It does not depend on the order
// in which surfaces are met, nor on how often one is asked.
FN float alpha_number(uint random, uint bounce, uint block_seed, uint instance, uint triangle) {
  return sampler_pair(random, hash_combine(hash_combine(block_seed, ~bounce), hash_combine(instance, triangle))).x;
}

// Does the surface let a path's ray through? At random, in proportion to what it keeps.
FN bool lets_through(IN(SceneData) scene, IN(Hit) hit, vec3 direction, IN(PathState) path, uint crossed,
                     uint block_seed) {
  const float alpha = hit_alpha(scene, hit, direction, path, false, crossed);
  if (alpha >= 1.0f) return false;
  return alpha_number(path.random, path.bounce, block_seed, hit.instance, hit.triangle) >= alpha;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that let rays through: how much a point keeps, and which rays it stops.
// Whoever traces asks this at each surface that a ray may meet; shading never sees what let the ray through.
#ifndef COTORRA_ALPHA_H
#define COTORRA_ALPHA_H

#include "material.h"
#include "sampling.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The material of a triangle.
FN uint triangle_material(IN(SceneData) scene, uint instance_id, uint triangle) {
  const Instance instance = LOAD(scene.instances, instance_id);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  uint slot = 0u;
  if ((mesh.flags & MESH_HAS_SLOTS) != 0u) slot = min(LOAD(mesh.slots, triangle), instance.material_count - 1u);
  return LOAD(scene.material_slots, instance.material_base + slot);
}

// Share of the light that the scene keeps at a point; the rest goes on behind it.
FN float alpha_at(IN(SceneData) scene, IN(TexturePoint) at) {
  return material_alpha(scene, triangle_material(scene, at.instance, at.triangle), at);
}

// A number in [0, 1) for a path's ray at a triangle: below the alpha there, the ray is stopped. Of neighbouring samples
// it is stratified, since they share the scrambling; two triangles never share theirs. It does not depend on the order
// in which surfaces are met, nor on how often one is asked.
FN float alpha_number(uint random, uint bounce, uint block_seed, uint instance, uint triangle) {
  return sampler_pair(random, hash_combine(hash_combine(block_seed, ~bounce), hash_combine(instance, triangle))).x;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

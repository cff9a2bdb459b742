// SPDX-License-Identifier: GPL-3.0-or-later
// A material at a point: the parts that vary run their programs, the others are the scene's constants; and which of a
// surface's closures a path meets. What a closure does with light is in bsdf.h and closure/.
#ifndef COTORRA_MATERIAL_H
#define COTORRA_MATERIAL_H

#include "bsdf.h"
#include "closure/kinds.h"
#include "program/program.h"
#include "surface.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Highlights below this roughness may be narrower than a usual lamp: light sampling alone becomes noisy, and BSDF
// sampling shares the work, for a ray a sample. Where exactly the two break even was not measured yet.
const float SHARP_ROUGHNESS = 0.25f;

FN float unit_clamp(float a) { return clamp(a, 0.0f, 1.0f); }

// A number of a program as light may have it: 0 for what is no number, held back at what the film can sum
// (addon/export/bounds.py).
FN float light_number(float a) { return select(a == a, clamp(a, -1e15f, 1e15f), 0.0f); }
FN vec3 light_numbers(vec3 a) { return vec3(light_number(a.x), light_number(a.y), light_number(a.z)); }

FN bool material_varies(IN(Material) material) {
  return FEATURE(FEATURE_PROGRAMS) && PROGRAM_GROUP(GROUP_PROGRAM) && (material.flags & MATERIAL_PROGRAM) != 0u;
}

// Is the side dark from which the point is seen?
FN bool material_is_dark(IN(Material) material, float side) {
  return (material.flags & select(side < 0.0f, MATERIAL_BACK_DARK, MATERIAL_FRONT_DARK)) != 0u;
}

// What the material emits at a point. Material.emission of an emission that varies is its mean over the sides that
// are not dark, which only says how often light sampling picks the triangle.
FN vec3 material_emission(IN(SceneData) scene, uint index, IN(Material) material, IN(ShaderPoint) at) {
  if (material_is_dark(material, at.side)) return vec3(0.0f);
  if (PROGRAM_GROUP(GROUP_EMISSIONS) && material_varies(material)) {
    const MaterialProgram program = LOAD(scene.programs, index);
    if (program.emission.first != NO_PROGRAM) {
      return light_numbers(program_value(scene, at, program.emission, program.constants));
    }
  }
  return material.emission;
}

// Share of the light that goes on behind the material at a point.
FN vec3 material_transparency(IN(SceneData) scene, uint index, IN(ShaderPoint) at) {
  const Material material = LOAD(scene.materials, index);
  if ((material.flags & MATERIAL_TRANSPARENT) == 0u) return vec3(0.0f);
  if (PROGRAM_GROUP(GROUP_TRANSPARENCIES) && material_varies(material)) {
    const MaterialProgram program = LOAD(scene.programs, index);
    if (program.transparency.first != NO_PROGRAM) {
      const vec3 through = light_numbers(program_value(scene, at, program.transparency, program.constants));
      return clamp(through, vec3(0.0f), vec3(1.0f));
    }
  }
  return vec3(unit_clamp(1.0f - material.alpha));
}

// ---- Which closure a path meets

// One closure, drawn in proportion to its weight.
struct SurfacePick {
  uint kind;    // CLOSURE_*; CLOSURE_KINDS: the constants of Material
  uint mode;
  uint arguments;
  uint constants;
  vec3 weight;  // over the probability with which it was drawn
  float u;      // what is left of the random number
  uint own_normal;  // CLOSURE_OWN_NORMAL, CLOSURE_BENT_NORMAL or 0
};

FN float closure_share(vec3 weight) { return (max(weight.x, 0.0f) + max(weight.y, 0.0f) + max(weight.z, 0.0f)); }

// Draws one of a surface's closures after its program has run, with a number in [0, 1).
FN SurfacePick surface_draw(IN(SceneData) scene, IN(MaterialProgram) program, float u PROGRAM_MEMORY) {
  SurfacePick pick;
  pick.kind = CLOSURE_HOLDOUT;
  pick.mode = 0u;
  pick.own_normal = 0u;
  pick.arguments = 0u;
  pick.constants = program.constants;
  pick.weight = vec3(0.0f);
  float total = 0.0f;
  for (uint k = 0u; k < program.surface.closures; ++k) {
    const ClosureRow row = LOAD(scene.program_closures, program.surface.result + k);
    const vec3 weight = light_numbers(program_vector(scene, program.constants, row.weight PROGRAM_SAME_MEMORY));
    const float share = closure_share(weight);
    total += share;
    // Each closure takes the place of those before it with its share of the sum so far (reservoir sampling).
    const float chance = share > 0.0f ? share / total : 0.0f;
    if (u < chance) {
      u = u / chance;
      pick.kind = row.kind;
      pick.own_normal = row.mode & (CLOSURE_OWN_NORMAL | CLOSURE_BENT_NORMAL);
      pick.mode = row.mode - pick.own_normal;
      pick.arguments = row.arguments;
      pick.weight = max(weight, vec3(0.0f));
    } else {
      u = (u - chance) / max(1.0f - chance, 1e-8f);
    }
    u = min(u, 0.99999994f);
  }
  pick.u = u;
  const float share = closure_share(pick.weight);
  if (share > 0.0f && share != total) pick.weight *= total / share;
  return pick;
}

// Argument `k` of the closure that was drawn.
FN float pick_number(IN(SceneData) scene, IN(SurfacePick) pick, uint k PROGRAM_MEMORY) {
  return light_number(
      program_number(scene, pick.constants, LOAD(scene.program_code, pick.arguments + k), 0u PROGRAM_SAME_MEMORY));
}
FN vec3 pick_vector(IN(SceneData) scene, IN(SurfacePick) pick, uint k PROGRAM_MEMORY) {
  return light_numbers(
      program_vector(scene, pick.constants, LOAD(scene.program_code, pick.arguments + k) PROGRAM_SAME_MEMORY));
}

// A closure's normal, on the viewer's side.
FN vec3 pick_normal(IN(SceneData) scene, IN(SurfacePick) pick, IN(ShaderPoint) at, uint k PROGRAM_MEMORY) {
  return normalize_or(pick_vector(scene, pick, k PROGRAM_SAME_MEMORY), at.n);
}

// The surface's own normal, as a displacement bends it before a closure with CLOSURE_BENT_NORMAL does.
FN vec3 pick_own_normal(IN(SceneData) scene, IN(SurfacePick) pick, IN(ShaderPoint) at PROGRAM_MEMORY) {
  const uint place = LOAD(scene.program_code, pick.arguments - 1u);
  return normalize_or(light_numbers(program_vector(scene, pick.constants, place PROGRAM_SAME_MEMORY)), at.n);
}

// The constants of a Principled closure, clamped as Cycles does.
FN void pick_principled(IN(SceneData) scene, IN(SurfacePick) pick, INOUT(Material) m PROGRAM_MEMORY) {
  m.base_color = max(pick_vector(scene, pick, PRINCIPLED_BASE PROGRAM_SAME_MEMORY), vec3(0.0f));
  m.metallic = unit_clamp(pick_number(scene, pick, PRINCIPLED_METALLIC PROGRAM_SAME_MEMORY));
  m.roughness = unit_clamp(pick_number(scene, pick, PRINCIPLED_ROUGHNESS PROGRAM_SAME_MEMORY));
  m.ior = max(pick_number(scene, pick, PRINCIPLED_IOR PROGRAM_SAME_MEMORY), 1e-5f);
  m.specular_level = max(pick_number(scene, pick, PRINCIPLED_SPECULAR_LEVEL PROGRAM_SAME_MEMORY), 0.0f);
  m.specular_tint = max(pick_vector(scene, pick, PRINCIPLED_SPECULAR_TINT PROGRAM_SAME_MEMORY), vec3(0.0f));
  m.flags &= ~MATERIAL_MULTI_GGX;
  if ((pick.mode & PRINCIPLED_MULTI_GGX) != 0u) m.flags |= MATERIAL_MULTI_GGX;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

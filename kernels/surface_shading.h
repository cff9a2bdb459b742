// SPDX-License-Identifier: GPL-3.0-or-later
// From a surface whose program has run to what it scatters: the closure that a path meets, as a Bsdf or a Lobe.
// Which light and which rays come of it is integrator.h's.
#ifndef COTORRA_SURFACE_SHADING_H
#define COTORRA_SURFACE_SHADING_H

#include "material.h"
#include "scattering.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// What a path meets of a surface: its material there, and the closure that was drawn.
struct SurfaceShading {
  Material material;
  vec3 weight;  // a factor on the path's throughput
  uint kind;    // CLOSURE_*; CLOSURE_KINDS: the material as it is
};

// A diffuse surface as the constants of a Principled one, which then has no other lobe.
FN void material_diffuse(vec3 color, INOUT(Material) m) {
  m.base_color = color;
  m.metallic = 0.0f;
  m.specular_level = 0.0f;
  m.ior = 1.0f;
  m.roughness = 1.0f;
  m.flags &= ~(MATERIAL_SPECULAR | MATERIAL_SHARP);
}

// Cycles' switches of caustics: a ray that left a diffuse surface meets no lobe of these. Returns CAUSTICS_*.
FN uint caustics_left_out(IN(SceneData) scene, uint ray_kind) {
  return select((ray_kind & VISIBLE_DIFFUSE) != 0u, scene.no_caustics, 0u);
}

// Takes the glossy lobe from a material where such a ray meets it.
FN void material_leave_out_caustics(IN(SceneData) scene, uint ray_kind, INOUT(Material) m) {
  if ((caustics_left_out(scene, ray_kind) & CAUSTICS_REFLECTIVE) != 0u) m.flags &= ~MATERIAL_SPECULAR;
}

// All inputs of a Principled closure, where Material has no place for them.
FN void pick_principled_inputs(IN(SceneData) scene, IN(SurfacePick) pick, IN(ShaderPoint) at, IN(Material) m, vec3 n,
                               OUT(PrincipledInputs) p PROGRAM_MEMORY) {
  p.base_color = m.base_color;
  p.metallic = m.metallic;
  p.specular_tint = m.specular_tint;
  p.roughness = m.roughness;
  p.tangent = pick_vector(scene, pick, PRINCIPLED_TANGENT PROGRAM_SAME_MEMORY);
  p.ior = m.ior;
  p.n = n;
  p.specular_level = m.specular_level;
  p.coat_n = pick_normal(scene, pick, at, PRINCIPLED_COAT_NORMAL PROGRAM_SAME_MEMORY);
  p.coat = max(pick_number(scene, pick, PRINCIPLED_COAT PROGRAM_SAME_MEMORY), 0.0f);
  p.coat_tint = max(pick_vector(scene, pick, PRINCIPLED_COAT_TINT PROGRAM_SAME_MEMORY), vec3(0.0f));
  p.coat_roughness = unit_clamp(pick_number(scene, pick, PRINCIPLED_COAT_ROUGHNESS PROGRAM_SAME_MEMORY));
  p.sheen_tint = max(pick_vector(scene, pick, PRINCIPLED_SHEEN_TINT PROGRAM_SAME_MEMORY), vec3(0.0f));
  p.coat_ior = max(pick_number(scene, pick, PRINCIPLED_COAT_IOR PROGRAM_SAME_MEMORY), 1.0f);
  p.emission = vec3(0.0f);
  p.sheen = max(pick_number(scene, pick, PRINCIPLED_SHEEN PROGRAM_SAME_MEMORY), 0.0f);
  p.sheen_roughness = unit_clamp(pick_number(scene, pick, PRINCIPLED_SHEEN_ROUGHNESS PROGRAM_SAME_MEMORY));
  p.diffuse_roughness = unit_clamp(pick_number(scene, pick, PRINCIPLED_DIFFUSE_ROUGHNESS PROGRAM_SAME_MEMORY));
  p.subsurface = unit_clamp(pick_number(scene, pick, PRINCIPLED_SUBSURFACE PROGRAM_SAME_MEMORY));
  p.subsurface_anisotropy =
      clamp(pick_number(scene, pick, PRINCIPLED_SUBSURFACE_ANISOTROPY PROGRAM_SAME_MEMORY), -1.0f, 1.0f);
  p.anisotropic = unit_clamp(pick_number(scene, pick, PRINCIPLED_ANISOTROPIC PROGRAM_SAME_MEMORY));
  p.rotation = pick_number(scene, pick, PRINCIPLED_ROTATION PROGRAM_SAME_MEMORY);
  p.transmission = unit_clamp(pick_number(scene, pick, PRINCIPLED_TRANSMISSION PROGRAM_SAME_MEMORY));
  p.film = max(pick_number(scene, pick, PRINCIPLED_FILM_THICKNESS PROGRAM_SAME_MEMORY), 0.0f);
  p.film_ior = max(pick_number(scene, pick, PRINCIPLED_FILM_IOR PROGRAM_SAME_MEMORY), 1e-5f);
  const float thin = pick_number(scene, pick, PRINCIPLED_THIN_WALL PROGRAM_SAME_MEMORY);
  p.thin_wall = select(thin > 0.0f, 1u, 0u);
  p.multiscatter = select((pick.mode & PRINCIPLED_MULTI_GGX) != 0u, 1u, 0u);
  p.inside = select(at.side < 0.0f, 1u, 0u);
  p.no_caustics = caustics_left_out(scene, at.ray_kind);
}

// Does it ask for more than bsdf.h has?
FN bool principled_asks_lobes(IN(PrincipledInputs) p) {
  return p.coat > BSDF_WEIGHT_CUTOFF || p.sheen > BSDF_WEIGHT_CUTOFF || p.transmission > BSDF_WEIGHT_CUTOFF ||
         !principled_is_plain(p);
}

// A closure that is one lobe. LOBE_NONE: it is none.
FN void pick_lobe_of(IN(SceneData) scene, IN(SurfacePick) pick, IN(ShaderPoint) at, IN(Surface) s, float roughness,
                     INOUT(Lobe) l PROGRAM_MEMORY) {
  const vec3 one = vec3(1.0f);
  const bool inside = at.side < 0.0f;
  const vec3 color = pick_vector(scene, pick, 0u PROGRAM_SAME_MEMORY);
  const uint without = caustics_left_out(scene, at.ray_kind);
  const bool reflects = pick.kind == CLOSURE_GLOSSY || pick.kind == CLOSURE_METALLIC;
  if (reflects && (without & CAUSTICS_REFLECTIVE) != 0u) return;
  if (pick.kind == CLOSURE_REFRACTION && (without & CAUSTICS_REFRACTIVE) != 0u) return;
  if (pick.kind == CLOSURE_DIFFUSE) {
    diffuse_prepare(LOBE_DIFFUSE, one, color, roughness, s.n, at.wo, l);
  } else if (pick.kind == CLOSURE_TRANSLUCENT) {
    diffuse_prepare(LOBE_TRANSLUCENT, one, color, 0.0f, normal_for_reflection(s.n, s.ng, at.wo), at.wo, l);
  } else if (pick.kind == CLOSURE_GLOSSY) {
    glossy_prepare(scene.albedo, pick.mode, one, color, roughness, pick_number(scene, pick, 2u PROGRAM_SAME_MEMORY),
                   pick_number(scene, pick, 3u PROGRAM_SAME_MEMORY), s.n, s.ng,
                   pick_vector(scene, pick, 5u PROGRAM_SAME_MEMORY), at.wo, l);
  } else if (pick.kind == CLOSURE_METALLIC) {
    const uint distribution = pick.mode & 255u;
    const vec3 tangent = pick_vector(scene, pick, 8u PROGRAM_SAME_MEMORY);
    const float anisotropy = pick_number(scene, pick, 5u PROGRAM_SAME_MEMORY);
    const float rotation = pick_number(scene, pick, 6u PROGRAM_SAME_MEMORY);
    const float film = pick_number(scene, pick, 9u PROGRAM_SAME_MEMORY);
    const float film_ior = pick_number(scene, pick, 10u PROGRAM_SAME_MEMORY);
    if ((pick.mode & METALLIC_CONDUCTOR) != 0u) {
      conductor_prepare(scene.albedo, distribution, one, pick_vector(scene, pick, 2u PROGRAM_SAME_MEMORY),
                        pick_vector(scene, pick, 3u PROGRAM_SAME_MEMORY), roughness, anisotropy, rotation, s.n, s.ng,
                        tangent, at.wo, film, film_ior, l);
    } else {
      metallic_prepare(scene.albedo, distribution, one, color, pick_vector(scene, pick, 1u PROGRAM_SAME_MEMORY),
                       roughness, anisotropy, rotation, s.n, s.ng, tangent, at.wo, film, film_ior, l);
    }
  } else if (pick.kind == CLOSURE_GLASS) {
    glass_prepare(scene.albedo, pick.mode, one, color, roughness, pick_number(scene, pick, 2u PROGRAM_SAME_MEMORY), s.n,
                  s.ng, at.wo, inside, pick_number(scene, pick, 4u PROGRAM_SAME_MEMORY),
                  pick_number(scene, pick, 5u PROGRAM_SAME_MEMORY), l);
    if ((without & CAUSTICS_REFLECTIVE) != 0u) l.f1 = vec3(0.0f);
    if ((without & CAUSTICS_REFRACTIVE) != 0u) l.tint = vec3(0.0f);
  } else if (pick.kind == CLOSURE_REFRACTION) {
    refraction_prepare(pick.mode, one, color, roughness, pick_number(scene, pick, 2u PROGRAM_SAME_MEMORY), s.n, s.ng,
                       at.wo, inside, l);
  } else if (pick.kind == CLOSURE_SHEEN) {
    if (pick.mode == 0u) {
      velvet_prepare(one, color, roughness, s.n, l);
    } else {
      sheen_prepare(scene.albedo, one, color, roughness, s.n, at.wo, l);
    }
  } else if (pick.kind == CLOSURE_TOON) {
    toon_prepare(pick.mode != 0u, one, color, roughness, pick_number(scene, pick, 2u PROGRAM_SAME_MEMORY), s.n, l);
  }
}

// Where the normal of a closure is among its arguments.
FN uint closure_normal(uint kind) {
  if (kind == CLOSURE_TRANSLUCENT) return 1u;
  if (kind == CLOSURE_DIFFUSE || kind == CLOSURE_SHEEN) return 2u;
  if (kind == CLOSURE_METALLIC) return 7u;
  return kind == CLOSURE_GLOSSY || kind == CLOSURE_PRINCIPLED ? 4u : 3u;
}

// A closure without lobes, as the integrators beside Direct and Path have it: the constants of the nearest Principled.
FN void pick_nearest(IN(SceneData) scene, IN(SurfacePick) pick, float roughness, INOUT(Material) m PROGRAM_MEMORY) {
  const vec3 color = max(pick_vector(scene, pick, 0u PROGRAM_SAME_MEMORY), vec3(0.0f));
  if (pick.kind != CLOSURE_GLASS && pick.kind != CLOSURE_GLOSSY && pick.kind != CLOSURE_METALLIC) {
    m.base_color = color;
    return;
  }
  m.flags |= MATERIAL_SPECULAR;
  m.roughness = roughness;
  m.specular_tint = vec3(1.0f);
  if (pick.kind == CLOSURE_GLASS) {  // tinted once for each of its two surfaces
    m.base_color = color * color;
    m.ior = max(pick_number(scene, pick, 2u PROGRAM_SAME_MEMORY), 1e-5f);
    m.specular_level = 0.5f;
    return;
  }
  m.base_color = color;
  m.metallic = 1.0f;
  if (pick.kind == CLOSURE_METALLIC) {
    m.specular_tint = max(pick_vector(scene, pick, 1u PROGRAM_SAME_MEMORY), vec3(0.0f));
  }
}

// Draws the closure of a surface whose program has run; s.n becomes its normal.
FN void surface_take(IN(SceneData) scene, IN(MaterialProgram) program, IN(ShaderPoint) at, float u, INOUT(Surface) s,
                     INOUT(SurfaceShading) shading, OUT(Bsdf) bsdf, OUT(Lobe) lobe PROGRAM_MEMORY) {
  const SurfacePick pick = surface_draw(scene, program, u PROGRAM_SAME_MEMORY);
  const vec3 smooth_normal = s.n;
  const bool lobes = FEATURE(FEATURE_LOBES) && scene.lobes != 0u;
  shading.weight = pick.weight;
  shading.kind = pick.kind;
  lobe_clear(LOBE_NONE, vec3(0.0f), s.n, lobe);
  bool picked = false;  // a Lobe
  if (pick.kind == CLOSURE_PRINCIPLED) {
    pick_principled(scene, pick, shading.material PROGRAM_SAME_MEMORY);
    s.n = pick_normal(scene, pick, at, PRINCIPLED_NORMAL PROGRAM_SAME_MEMORY);
    material_leave_out_caustics(scene, at.ray_kind, shading.material);
    // Of other models the scene's flag holds, which is set where any texel could be sharp.
    const bool principled = (shading.material.flags & MATERIAL_MODEL) == 0u;
    if (principled && shading.material.roughness >= scene.sharp_roughness) shading.material.flags &= ~MATERIAL_SHARP;
    if (principled && lobes) {
      PrincipledInputs inputs;
      pick_principled_inputs(scene, pick, at, shading.material, s.n, inputs PROGRAM_SAME_MEMORY);
      if (principled_asks_lobes(inputs)) {
        vec3 scale;
        const uint picked_kind = principled_pick(scene, inputs, s.ng, at.wo, pick.u, bsdf, lobe, scale);
        if (picked_kind != PICK_LOBE) lobe.kind = LOBE_NONE;
        shading.weight *= scale;
        picked = true;
      }
    }
  } else {
    material_diffuse(vec3(0.0f), shading.material);
    const bool scatters = pick.kind != CLOSURE_TRANSPARENT && pick.kind != CLOSURE_HOLDOUT;
    float roughness = 0.0f;
    if (scatters) {
      s.n = pick_normal(scene, pick, at, closure_normal(pick.kind) PROGRAM_SAME_MEMORY);
      const uint place = select(pick.kind == CLOSURE_METALLIC, 4u, 1u);
      if (pick.kind != CLOSURE_TRANSLUCENT) roughness = pick_number(scene, pick, place PROGRAM_SAME_MEMORY);
    }
    const bool plain = pick.kind == CLOSURE_DIFFUSE && roughness < DIFFUSE_ROUGHNESS_MIN;
    if (scatters && lobes && !plain) {
      pick_lobe_of(scene, pick, at, s, unit_clamp(roughness), lobe PROGRAM_SAME_MEMORY);
      bsdf_prepare_nothing(s.n, at.wo, bsdf);
      picked = true;
    } else if (scatters) {
      pick_nearest(scene, pick, unit_clamp(roughness), shading.material PROGRAM_SAME_MEMORY);
    }
  }
  if (!picked) bsdf_prepare(scene, shading.material, s.n, s.ng, at.wo, bsdf);
  // What a displacement bends is the surface itself, which hides no light from itself for that (Cycles).
  bsdf.n_smooth = select(pick.own_normal == CLOSURE_OWN_NORMAL, s.n, smooth_normal);
  if (pick.own_normal == CLOSURE_BENT_NORMAL) bsdf.n_smooth = pick_own_normal(scene, pick, at PROGRAM_SAME_MEMORY);
  if (pick.kind == CLOSURE_TRANSPARENT) bsdf.lobes = BSDF_THROUGH;
  if (pick.kind == CLOSURE_HOLDOUT) bsdf.lobes |= BSDF_HOLDOUT;
}

FN void surface_begin(IN(SceneData) scene, IN(Surface) s, OUT(SurfaceShading) shading) {
  shading.material = LOAD(scene.materials, s.material);
  shading.weight = vec3(1.0f);
  shading.kind = CLOSURE_KINDS;
}

// Is the surface's closure drawn by a program?
FN bool surface_varies(IN(SceneData) scene, IN(Surface) s, IN(Material) material) {
  return PROGRAM_GROUP(GROUP_SURFACES) && material_varies(material) &&
         LOAD(scene.programs, s.material).surface.first != NO_PROGRAM;
}

// The same from the beginning, for one point, whether it varies or not. The CPU runs the programs of many at once.
FN void surface_shading(IN(SceneData) scene, IN(ShaderPoint) at, float u, INOUT(Surface) s, OUT(SurfaceShading) shading,
                        OUT(Bsdf) bsdf, OUT(Lobe) lobe) {
  surface_begin(scene, s, shading);
  if (!surface_varies(scene, s, shading.material)) {
    material_leave_out_caustics(scene, at.ray_kind, shading.material);
    bsdf_prepare(scene, shading.material, s.n, s.ng, at.wo, bsdf);
    lobe_clear(LOBE_NONE, vec3(0.0f), s.n, lobe);
    bsdf.n_smooth = s.n;
    return;
  }
  const MaterialProgram program = LOAD(scene.programs, s.material);
  PROGRAM_BEGIN_MEMORY;
  program_run(scene, at, program.surface, program.constants PROGRAM_SAME_MEMORY);
  surface_take(scene, program, at, u, s, shading, bsdf, lobe PROGRAM_SAME_MEMORY);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

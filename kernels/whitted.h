// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion at one surface: which share of the light comes along the mirror direction and along the refracted
// one, and what a medium absorbs on the way. Light from lamps, and the rays themselves, are not here.
#ifndef COTORRA_WHITTED_H
#define COTORRA_WHITTED_H

#include "integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint WHITTED_PANES = 16u;  // glass surfaces that a shadow ray may cross; the next one stops it

// The rays that go on from a surface (Whitted 1980, "An improved illumination model for shaded display", eq. 3).
struct WhittedChildren {
  vec3 reflected;  // unit direction
  float eta;  // far side over near side
  vec3 transmitted;  // unit direction
  float unused;
  vec3 reflected_weight;  // black: no such ray
  vec3 transmitted_weight;
};

// One of them, while it waits for its turn.
struct PendingRay {
  PathState path;
  vec3 origin;
  uint medium;  // material that it runs inside of, INVALID_ID: none that absorbs
  vec3 direction;
  uint slot;  // the sample that it belongs to
};

// Snell: wo refracted at a surface with normal n, eta = far side over near side. False where all is reflected: from the
// critical angle on, eta^2 - sin^2 <= 0. With eta = 1 the direction is exactly -wo.
FN bool refract_snell(vec3 wo, vec3 n, float eta, OUT(vec3) wi) {
  const float c = dot(n, wo);
  const float g2 = eta * eta - 1.0f + c * c;  // (eta times the cosine on the far side)^2
  wi = (n * (c - sqrt(max(g2, 0.0f))) - wo) * (1.0f / eta);
  return g2 > 0.0f;
}

// What clear glass reflects: Fresnel's curve, from the tinted F0 to 1 (as Cycles' Principled has it).
FN vec3 glass_reflectance(vec3 specular_tint, float ior, float eta, float c) {
  const float f0 = F0_from_ior(ior);
  const float f = F_Dielectric(c, c * c, eta);
  const float s = clamp((f - f0) / max(1.0f - f0, 1e-6f), 0.0f, 1.0f);
  return mix(min(max(specular_tint, vec3(0.0f)) * f0, vec3(1.0f)), vec3(1.0f), s);
}

// Beer and Lambert: what is left after `distance` metres in a medium.
FN vec3 medium_transmittance(vec3 absorption, float distance) {
  const vec3 depth = absorption * distance;
  return vec3(exp(-depth.x), exp(-depth.y), exp(-depth.z));
}

FN bool is_smooth(IN(Material) material) { return sqr(sqr(material.roughness)) <= MIRROR_ALPHA2; }

// The share of a Principled material that is glass; the models of the studies have constants instead.
FN float glass_share(IN(Material) material, IN(ClassicMaterial) classic) {
  const bool principled = (material.flags & MATERIAL_MODEL) == 0u;
  return select(principled, (1.0f - clamp(material.metallic, 0.0f, 1.0f)) * classic.transmission, 0.0f);
}

// Takes from the lobes what rays will bring: the base under the glass, and of smooth glass its highlight. A rough one
// keeps its highlight: it is lit by lamps alone, while what it lets through is traced as if it were clear. No bounce
// shares the work with light sampling.
FN void whitted_prepare(IN(Material) material, IN(ClassicMaterial) classic, INOUT(Bsdf) bsdf) {
  bsdf.lobes &= ~BSDF_SHARP;
  const bool principled = (material.flags & MATERIAL_MODEL) == 0u;
  const float kept = select(principled, 1.0f - classic.transmission, 1.0f);
  bsdf.diffuse *= kept;
  const float highlight = select(is_smooth(material), kept, 1.0f);
  bsdf.coating_f0 *= highlight;
  bsdf.coating_f90 *= highlight;
}

// Weights of a Principled material: smooth metal and coat reflect; glass reflects and refracts.
FN void whitted_principled(IN(Material) material, IN(ClassicMaterial) classic, IN(Bsdf) bsdf, bool refracts, float c,
                           INOUT(WhittedChildren) children) {
  const float glass = glass_share(material, classic);
  const vec3 f = glass_reflectance(material.specular_tint, max(material.ior, 1e-5f), children.eta, c);
  if ((bsdf.lobes & BSDF_SINGULAR) != 0u) children.reflected_weight = bsdf_fresnel(bsdf, c, c * c);
  if (is_smooth(material)) children.reflected_weight += select(refracts, f, vec3(1.0f)) * glass;
  const vec3 tint = sqrt(clamp(material.base_color, vec3(0.0f), vec3(1.0f)));  // twice through: the base colour
  children.transmitted_weight = select(refracts, (vec3(1.0f) - f) * tint * glass, vec3(0.0f));
}

// The rays that go on from a surface toward wo; bsdf is whitted_prepare's.
FN void whitted_children(IN(Material) material, IN(ClassicMaterial) classic, IN(Surface) s, IN(Bsdf) bsdf, vec3 wo,
                         OUT(WhittedChildren) children) {
  const vec3 n = bsdf.n_glossy;
  const float c = dot(n, wo);
  const float ior = max(material.ior, 1e-5f);
  children.eta = select(s.side > 0.0f, ior, 1.0f / ior);
  children.reflected = n * (2.0f * c) - wo;
  children.unused = 0.0f;
  children.reflected_weight = vec3(0.0f);
  children.transmitted_weight = vec3(0.0f);
  const bool refracts = refract_snell(wo, n, children.eta, children.transmitted);
  if (!(c > 0.0f)) return;
  if ((material.flags & MATERIAL_MODEL) == 0u) {
    whitted_principled(material, classic, bsdf, refracts, c, children);
  } else {
    // What cannot leave is reflected too: light is not lost at the critical angle.
    children.reflected_weight = vec3(classic.kr + select(refracts, 0.0f, classic.kt));
    children.transmitted_weight = vec3(select(refracts, classic.kt, 0.0f));
  }
  // A smooth normal may send either ray to the wrong side of the triangle.
  if (dot(children.reflected, s.ng) <= 0.0f) children.reflected_weight = vec3(0.0f);
  if (dot(children.transmitted, s.ng) >= 0.0f) children.transmitted_weight = vec3(0.0f);
}

// What a shadow ray keeps that crosses the surface straight, at cosine c: entering and leaving alike, since a ray
// through a pane leaves it as it came.
FN vec3 whitted_shadow(IN(Material) material, IN(ClassicMaterial) classic, float c) {
  if ((material.flags & MATERIAL_MODEL) != 0u) return vec3(classic.kt);
  const float ior = max(material.ior, 1e-5f);
  const vec3 f = glass_reflectance(material.specular_tint, ior, max(ior, 1.0f / ior), c);
  const vec3 tint = sqrt(clamp(material.base_color, vec3(0.0f), vec3(1.0f)));
  return (vec3(1.0f) - f) * tint * glass_share(material, classic);
}

// Takes a shadow ray that met a surface after `distance` straight across it. Returns false where nothing of it is left.
FN bool whitted_cross_pane(IN(Material) material, IN(ClassicMaterial) classic, IN(Surface) s, vec3 direction,
                           float distance, INOUT(vec3) kept) {
  kept *= whitted_shadow(material, classic, abs(dot(s.n, direction)));
  if (s.side < 0.0f) kept *= medium_transmittance(classic.absorption, distance);
  return max_component(kept) > 0.0f;
}

// The material that a ray of this kind runs inside of when it leaves the surface; INVALID_ID: none that absorbs, as
// most, which then need no exponential. A closed surface has its medium behind it: who leaves it on that side runs
// inside.
FN uint whitted_medium(IN(ClassicMaterial) classic, IN(Surface) s, uint kind) {
  const bool inside = (s.side < 0.0f) != (kind == VISIBLE_TRANSMISSION);
  return select(inside && !is_black(classic.absorption), s.material, INVALID_ID);
}

// Takes a path into one of its children. False where it carries too little to be worth a ray.
FN bool whitted_advance(INOUT(PathState) path, IN(Surface) s, vec3 direction, vec3 weight, uint kind, float threshold,
                        OUT(vec3) origin) {
  path.throughput *= weight;
  path.pdf = 0.0f;
  path.kind_pdf = 0.0f;
  path.kind_weight = vec3(1.0f);
  path.normal = s.n;
  path.bounce += 1u;
  path.vertex += 1u;
  path.ray_kind = kind | RAY_MEETS_LAMPS;
  // The transmitted branch takes its random numbers from elsewhere in the sequence than the reflected one: a digital
  // shift, which keeps them stratified.
  if (kind == VISIBLE_TRANSMISSION) path.random ^= hash_uint(path.bounce);
  origin = surface_ray_origin(s.p, s.ng, s.epsilon, direction);
  const float size = max_component(path.throughput);
  return size > 0.0f && size >= threshold;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

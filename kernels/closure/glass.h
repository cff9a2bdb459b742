// SPDX-License-Identifier: GPL-3.0-or-later
// Prepares lobes of dielectrics: glass that reflects and refracts, refraction alone, a dielectric layer and a coat.
// The choice between reflection and refraction is made by facet, in microfacet_lobe.h.
#ifndef COTORRA_GLASS_H
#define COTORRA_GLASS_H

#include "glossy.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Index of refraction behind the surface over that on the viewer's side; `inside`: the viewer looks from behind.
FN float relative_eta(float ior, bool inside) {
  const float eta = clamp(ior, 1e-5f, 1e5f);
  return inside ? 1.0f / eta : eta;
}

// Fresnel's curve from f0 to 1, its reflection and transmission tinted; f_average of it.
FN vec3 dielectric_average(vec3 f0, float eta) {
  const float own = F0_from_ior(eta);
  return f0 + (1.0f - f0) * clamp((F_DielectricAverage(eta) - own) / max(1.0f - own, 1e-6f), 0.0f, 1.0f);
}

// Glass of two tints. `f0` is that of reflection toward the normal.
FN void glass_set(FloatBuffer table, uint distribution, float roughness, float ior, bool inside, vec3 f0,
                  vec3 reflection, vec3 transmission, float film, float film_ior, vec3 wo, INOUT(Lobe) l) {
  if (distribution == CLOSURE_BECKMANN) l.mode |= LOBE_BECKMANN;
  l.mode |= LOBE_FRESNEL_DIELECTRIC;
  const float alpha = sqr(clamp(roughness, 0.0f, 1.0f));
  microfacet_set_alpha(alpha, alpha, l);
  l.eta = relative_eta(ior, inside);
  l.f0 = clamp(f0, vec3(0.0f), vec3(1.0f));
  l.f1 = reflection;
  l.tint = transmission;
  // From inside, film and glass are divided by the glass's index, as all is seen relative to the viewer's side.
  film_set(film, inside ? film_ior * l.eta : film_ior, l);
  vec3 average = transmission;
  if (is_black(transmission)) average = reflection * dielectric_average(l.f0, l.eta);
  microfacet_preserve(table, wo, distribution == CLOSURE_MULTI_GGX, average, l);
}

// Glass BSDF.
FN void glass_prepare(FloatBuffer table, uint distribution, vec3 weight, vec3 color, float roughness, float ior, vec3 n,
                      vec3 ng, vec3 wo, bool inside, float film, float film_ior, OUT(Lobe) l) {
  lobe_clear(LOBE_GLASS, weight, normal_for_reflection(n, ng, wo), l);
  const vec3 tint = max(color, vec3(0.0f));
  const vec3 f0 = vec3(F0_from_ior(clamp(ior, 1e-5f, 1e5f)));
  glass_set(table, distribution, roughness, ior, inside, f0, tint, tint, film, max(film_ior, 1e-5f), wo, l);
}

// Refraction BSDF. Its energy is not preserved, in Cycles neither.
FN void refraction_prepare(uint distribution, vec3 weight, vec3 color, float roughness, float ior, vec3 n, vec3 ng,
                           vec3 wo, bool inside, OUT(Lobe) l) {
  lobe_clear(LOBE_REFRACTION, weight * max(color, vec3(0.0f)), normal_for_reflection(n, ng, wo), l);
  if (distribution == CLOSURE_BECKMANN) l.mode |= LOBE_BECKMANN;
  const float alpha = sqr(clamp(roughness, 0.0f, 1.0f));
  microfacet_set_alpha(alpha, alpha, l);
  l.eta = relative_eta(ior, inside);
}

// A dielectric interface that only reflects: f0 as the user tints it, `preserve` its energy.
FN void dielectric_layer_set(FloatBuffer table, vec3 f0, float eta, bool preserve, vec3 wo, INOUT(Lobe) l) {
  l.mode |= LOBE_FRESNEL_DIELECTRIC;
  l.f0 = clamp(f0, vec3(0.0f), vec3(1.0f));
  l.eta = eta;
  microfacet_preserve(table, wo, preserve, dielectric_average(l.f0, eta), l);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet of glass too thin to bend light: what its two faces reflect and let through together, as OpenPBR has it.
// Reflection is an ordinary lobe; what passes is a reflection too, mirrored to the other side.
#ifndef COTORRA_THIN_WALL_H
#define COTORRA_THIN_WALL_H

#include "glass.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// By components, of bases of 0 or more; bounded, as tints above 1 may grow beyond all numbers.
FN vec3 power(vec3 base, float exponent) {
  const vec3 b = max(base, vec3(1e-30f));
  return min(vec3(pow(b.x, exponent), pow(b.y, exponent), pow(b.z, exponent)), vec3(1e6f));
}

// Roughness squared of what passes, after two refractions (Kulla & Conty 2017).
FN float thin_wall_alpha(float alpha, float ior) {
  const float bend = 3.4f * (ior - 1.0f) * sqr(ior - 0.5f) / (ior * ior * ior);
  return clamp(alpha * sqrt(max(bend, 0.0f)), 0.0f, 1.0f);
}

// What the wall reflects and lets through at cosine c: the sum over all reflections between its faces. `base` is what
// passes straight through of light that is absorbed inside.
FN void thin_wall_fresnel(FloatBuffer table, vec3 specular_tint, vec3 base, float ior, float film, float film_ior,
                          float c, OUT(vec3) reflectance, OUT(vec3) transmittance) {
  Lobe face;
  lobe_clear(LOBE_GLASS, vec3(1.0f), vec3(0.0f, 0.0f, 1.0f), face);
  face.mode |= LOBE_FRESNEL_DIELECTRIC;
  face.eta = relative_eta(ior, false);
  face.f0 = clamp(specular_tint * F0_from_ior(face.eta), vec3(0.0f), vec3(1.0f));
  face.tint = vec3(1.0f);
  film_set(film, film_ior, face);
  // 1. The front, and the way inside.
  vec3 r1;
  vec3 t1;
  lobe_fresnel(table, face, c, r1, t1);
  const float cos2 = 1.0f - (1.0f - c * c) / (face.eta * face.eta);
  const float c_inside = sqrt(max(cos2, 0.0f));
  vec3 kept = vec3(0.0f);
  if (c_inside > 0.0f) kept = power(base, 1.0f / c_inside);
  // 2. The back, which differs where there is a film.
  vec3 r2 = r1;
  vec3 t2 = t1;
  if (film > FILM_CUTOFF && c_inside > 0.0f) {
    face.film_eta = face.film_eta / face.eta;
    face.eta = 1.0f / face.eta;
    lobe_fresnel(table, face, c_inside, r2, t2);
  }
  // 3. Geometric series of the ways between.
  const vec3 loop = r2 * kept;
  transmittance = kept * t1 * t2 / max(1.0f - loop * loop, vec3(1e-6f));
  reflectance = r1 + transmittance * loop;
}

// Its reflection: the colour is in the weight, and only multiple scattering asks for the tint.
FN void thin_wall_reflection_set(FloatBuffer table, float roughness, vec3 specular_tint, vec3 wo, INOUT(Lobe) l) {
  const float alpha = sqr(clamp(roughness, 0.0f, 1.0f));
  microfacet_set_alpha(alpha, alpha, l);
  microfacet_preserve(table, wo, true, specular_tint, l);
}

FN void thin_wall_transmission_set(FloatBuffer table, float roughness, float ior, vec3 wo, INOUT(Lobe) l) {
  const float alpha = thin_wall_alpha(sqr(clamp(roughness, 0.0f, 1.0f)), relative_eta(ior, false));
  microfacet_set_alpha(alpha, alpha, l);
  microfacet_preserve(table, wo, true, vec3(1.0f), l);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

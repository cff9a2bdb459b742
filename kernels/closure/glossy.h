// SPDX-License-Identifier: GPL-3.0-or-later
// Prepares the lobes of Glossy and Metallic BSDF: microfacets that reflect a colour, as a metal of F82 or of n and k.
// Angles, tangents and anisotropy become the two alphas here; microfacet_lobe.h does the rest.
#ifndef COTORRA_GLOSSY_H
#define COTORRA_GLOSSY_H

#include "ashikhmin_shirley.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// `v` turned about the unit axis (Rodrigues).
FN vec3 rotate_about(vec3 v, vec3 axis, float angle) {
  const float c = cos(angle);
  const float s = sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1.0f - c));
}

// Alphas of Principled and Metallic: anisotropy 0 to 1 stretches the highlight along the tangent.
FN void anisotropy_set(float roughness, float anisotropy, float rotation, vec3 n, vec3 tangent, INOUT(Lobe) l) {
  const float alpha = sqr(clamp(roughness, 0.0f, 1.0f));
  const float aspect = sqrt(1.0f - 0.9f * clamp(anisotropy, 0.0f, 1.0f));
  microfacet_set_alpha(alpha / aspect, alpha * aspect, l);
  l.t = rotation == 0.0f ? tangent : rotate_about(tangent, n, rotation * (2.0f * PI));
}

// Alphas of Glossy BSDF: anisotropy -1 to 1, the other way round.
FN void glossy_anisotropy_set(float roughness, float anisotropy, float rotation, vec3 tangent, INOUT(Lobe) l) {
  const float alpha = sqr(clamp(roughness, 0.0f, 1.0f));
  const float a = clamp(anisotropy, -0.99f, 0.99f);
  const float wide = 1.0f / (1.0f - abs(a));
  if (abs(a) <= 1e-4f) {
    microfacet_set_alpha(alpha, alpha, l);
  } else if (a < 0.0f) {
    microfacet_set_alpha(alpha * wide, alpha / wide, l);
  } else {
    microfacet_set_alpha(alpha / wide, alpha * wide, l);
  }
  l.t = rotation == 0.0f ? tangent : rotate_about(tangent, l.n, rotation * (2.0f * PI));
}

FN void film_set(float thickness, float ior, INOUT(Lobe) l) {
  l.film = thickness;
  l.film_eta = clamp(ior, 1e-5f, 1e4f);
}

// Glossy BSDF. `n` is the shading normal on the viewer's side, `ng` the geometric one, `weight` the closure's.
FN void glossy_prepare(FloatBuffer table, uint distribution, vec3 weight, vec3 color, float roughness, float anisotropy,
                       float rotation, vec3 n, vec3 ng, vec3 tangent, vec3 wo, OUT(Lobe) l) {
  const bool shirley = distribution == CLOSURE_ASHIKHMIN_SHIRLEY;
  lobe_clear(shirley ? LOBE_ASHIKHMIN_SHIRLEY : LOBE_REFLECTION, weight * max(color, vec3(0.0f)),
             normal_for_reflection(n, ng, wo), l);
  if (distribution == CLOSURE_BECKMANN) l.mode |= LOBE_BECKMANN;
  glossy_anisotropy_set(roughness, anisotropy, rotation, tangent, l);
  if (shirley) {
    ashikhmin_shirley_limit(l);
  } else {
    microfacet_preserve(table, wo, distribution == CLOSURE_MULTI_GGX, color, l);
  }
}

// A metal by its colours toward the normal and at its edge (Kutz et al. 2021, "F82-tint").
FN void metal_colors_set(vec3 f0, vec3 edge_tint, INOUT(Lobe) l) {
  l.mode |= LOBE_FRESNEL_F82;
  l.f0 = clamp(f0, vec3(0.0f), vec3(1.0f));
  l.f1 = F_Schlick82Edge(l.f0, clamp(edge_tint, vec3(0.0f), vec3(1.0f)));
}

// The mean Fresnel term of n + i k: that of the F82 curve through it (Cycles).
FN vec3 conductor_average(vec3 n, vec3 k) {
  const vec3 f0 = vec3(F_Conductor(1.0f, n.x, k.x), F_Conductor(1.0f, n.y, k.y), F_Conductor(1.0f, n.z, k.z));
  const float c = 1.0f / 7.0f;
  const vec3 f82 = vec3(F_Conductor(c, n.x, k.x), F_Conductor(c, n.y, k.y), F_Conductor(c, n.z, k.z));
  const float w = F_SchlickWeight(c);
  const vec3 edge = (f0 + (1.0f - f0) * w - f82) * (49.0f / (6.0f * w));
  return clamp(F_Schlick82Average(f0, edge), vec3(0.0f), vec3(1.0f));
}

// Metallic BSDF by colours: base and edge.
FN void metallic_prepare(FloatBuffer table, uint distribution, vec3 weight, vec3 base, vec3 edge, float roughness,
                         float anisotropy, float rotation, vec3 n, vec3 ng, vec3 tangent, vec3 wo, float film,
                         float film_ior, OUT(Lobe) l) {
  lobe_clear(LOBE_REFLECTION, weight, normal_for_reflection(n, ng, wo), l);
  if (distribution == CLOSURE_BECKMANN) l.mode |= LOBE_BECKMANN;
  anisotropy_set(roughness, anisotropy, rotation, n, tangent, l);
  metal_colors_set(base, edge, l);
  film_set(film, film_ior, l);
  microfacet_preserve(table, wo, distribution == CLOSURE_MULTI_GGX, F_Schlick82Average(l.f0, l.f1), l);
}

// Metallic BSDF by index of refraction and extinction.
FN void conductor_prepare(FloatBuffer table, uint distribution, vec3 weight, vec3 index, vec3 extinction,
                          float roughness, float anisotropy, float rotation, vec3 n, vec3 ng, vec3 tangent, vec3 wo,
                          float film, float film_ior, OUT(Lobe) l) {
  lobe_clear(LOBE_REFLECTION, weight, normal_for_reflection(n, ng, wo), l);
  if (distribution == CLOSURE_BECKMANN) l.mode |= LOBE_BECKMANN;
  anisotropy_set(roughness, anisotropy, rotation, n, tangent, l);
  l.mode |= LOBE_FRESNEL_CONDUCTOR;
  l.f0 = clamp(index, vec3(0.0f), vec3(1e4f));
  l.f1 = clamp(extinction, vec3(0.0f), vec3(1e4f));
  film_set(film, film_ior, l);
  microfacet_preserve(table, wo, distribution == CLOSURE_MULTI_GGX, conductor_average(l.f0, l.f1), l);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Diffuse lobes: Lambert's and Oren & Nayar's in Fujii's form, whose lost energy multiple scattering gives back as in
// OpenPBR; and the same light mirrored through the surface, translucent.
#ifndef COTORRA_ROUGH_DIFFUSE_H
#define COTORRA_ROUGH_DIFFUSE_H

#include "../model_math.h"
#include "lobe_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Below, a surface is Lambert's.
const float DIFFUSE_ROUGHNESS_MIN = 1e-5f;

// The light that B's term reflects of a uniform hemisphere toward cosine c (Portsmouth, Kutz & Hill 2024, eq. 28, times
// pi): sin (theta - sin cos - 2/3) + 2/3 tan (1 - sin^3).
FN float oren_nayar_G(float c) {
  const float cosine = clamp(c, 0.0f, 1.0f);
  const float s2 = 1.0f - cosine * cosine;
  const float s = sqrt(max(s2, 0.0f));
  const float theta = s * acos_over_sine(cosine);
  // (1 - sin^3) / cos without its 0 / 0 at the horizon: cos (1 + s + s^2) / (1 + s).
  const float rest = cosine * (1.0f + s + s2) / (1.0f + s);
  return s * (theta - s * cosine - 2.0f / 3.0f + rest * (2.0f / 3.0f));
}

// Lambert's lobe for a roughness of 0. `color` is part of the weight; multiple scattering asks for it once more.
FN void diffuse_prepare(uint kind, vec3 weight, vec3 color, float roughness, vec3 n, vec3 wo, OUT(Lobe) l) {
  lobe_clear(kind, weight * max(color, vec3(0.0f)), n, l);
  l.alpha_x = INV_PI;
  l.alpha_y = 0.0f;
  if (!(roughness >= DIFFUSE_ROUGHNESS_MIN)) return;
  const float sigma = min(roughness, 1.0f);
  const float a = 1.0f / (PI + sigma * (0.5f * PI - 2.0f / 3.0f));
  const float b = sigma * a;
  const vec3 albedo = clamp(color, vec3(0.0f), vec3(1.0f));
  const float average = a * PI + b * (2.0f * PI - 5.6f) / 3.0f;
  const float view = a * PI + b * oren_nayar_G(dot(n, wo));
  l.alpha_x = a;
  l.alpha_y = b;
  l.f0 = albedo * albedo * (INV_PI * (1.0f - view) * average / (1.0f - average)) / (1.0f - albedo * (1.0f - average));
}

// f cos; `wi` and `wo` on one side.
FN vec3 diffuse_value(IN(Lobe) l, vec3 wo, vec3 wi) {
  const float ni = max(dot(l.n, wi), 0.0f);
  if (!(l.alpha_y > 0.0f)) return vec3(ni * INV_PI);
  const float no = max(dot(l.n, wo), 0.0f);
  const float across = dot(wi, wo) - ni * no;
  const float t = across > 0.0f ? across / max(max(ni, no), 1e-20f) : across;
  const float light = l.alpha_x * PI + l.alpha_y * oren_nayar_G(ni);
  return max(vec3(l.alpha_x + l.alpha_y * t) + l.f0 * (1.0f - light), vec3(0.0f)) * ni;
}

FN vec3 diffuse_eval(IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  vec3 to_light = wi;
  if (l.kind == LOBE_TRANSLUCENT) to_light = wi - l.n * (2.0f * dot(l.n, wi));
  pdf = max(dot(l.n, to_light), 0.0f) * INV_PI;
  return l.weight * diffuse_value(l, wo, to_light);
}

FN void diffuse_sample(IN(Lobe) l, vec3 wo, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  vec3 t;
  vec3 b;
  orthonormal_basis(l.n, t, b);
  vec3 i = cosine_hemisphere_from_square(u);
  s.pdf = i.z * INV_PI;
  if (!(s.pdf > 0.0f)) return;
  s.weight = l.weight * diffuse_value(l, wo, to_world(i, t, b, l.n)) * (1.0f / s.pdf);
  if (l.kind == LOBE_TRANSLUCENT) {
    i.z = -i.z;
    s.lobe |= BSDF_TRANSMIT;
  }
  s.wi = to_world(i, t, b, l.n);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

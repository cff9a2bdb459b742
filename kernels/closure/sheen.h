// SPDX-License-Identifier: GPL-3.0-or-later
// Sheen of cloth: a layer of microfibers (Zeltner, Burley & Chiang 2022, "Practical Multiple-Scattering Sheen Using
// Linearly Transformed Cosines"), and Ashikhmin's velvet (Ashikhmin, Premoze & Shirley 2000).
#ifndef COTORRA_SHEEN_H
#define COTORRA_SHEEN_H

#include "lobe_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// ---- Microfibers

// Albedo of the layer toward cosine x for roughness y, a Gaussian in x (Hill's fit to the paper's data).
FN float sheen_albedo(float x, float y) {
  const float width = y * (0.0206607f + 1.58491f * y) / (0.0379424f + y * (1.32227f + y));
  const float middle = y * (-0.193854f + y * (-1.14885f + y * (1.7932f - 0.95943f * y * y))) / (0.046391f + y);
  const float rest = y * (0.000654023f + y * (-0.0207818f + 0.119681f * y)) / (1.26264f + y * (-1.92021f + y));
  const float z = (x - middle) / width;
  return exp(-0.5f * z * z) * 0.398942280f / width + rest;
}

// The transformed cosine's A and B (the same).
FN vec2 sheen_transform(float x, float y) {
  const float a = (2.58126f * x + 0.813703f * y) * y / (1.0f + 0.310327f * x * x + 2.60994f * x * y);
  const float b = sqrt(max(1.0f - x, 0.0f)) * (y - 1.0f) * y * y * y /
                  (0.0000254053f + 1.71228f * x - 1.71506f * x * y + 1.34174f * y * y);
  return vec2(a, b);
}

FN void sheen_prepare(vec3 weight, vec3 color, float roughness, vec3 n, vec3 wo, OUT(Lobe) l) {
  lobe_clear(LOBE_SHEEN, weight * max(color, vec3(0.0f)), n, l);
  const float x = dot(n, wo);
  const float y = clamp(roughness, 1e-3f, 1.0f);
  const float albedo = sheen_albedo(clamp(x, 0.0f, 1.0f), y);
  const vec2 ab = sheen_transform(clamp(x, 0.0f, 1.0f), y);
  l.alpha_x = ab.x;
  l.alpha_y = ab.y;
  l.t = wo;
  l.weight *= albedo;
  if (!(abs(ab.x) >= 1e-5f) || !(albedo >= 1e-5f)) l.kind = LOBE_NONE;
}

// x toward the viewer.
FN void sheen_frame(IN(Lobe) l, OUT(vec3) t, OUT(vec3) b) {
  orthonormal_basis(l.n, t, b);
  const vec3 across = cross(l.n, l.t);
  const float d2 = dot(across, across);
  if (!(d2 > 1e-12f)) return;
  b = across * (1.0f / sqrt(d2));
  t = cross(b, l.n);
}

// The density of a local direction: a cosine's, behind the inverse transform ((A, 0, B), (0, A, 0), (0, 0, 1)).
FN float sheen_density(IN(Lobe) l, vec3 i) {
  const float length2 = sqr(l.alpha_x * i.x + l.alpha_y * i.z) + sqr(l.alpha_x * i.y) + sqr(i.z);
  return INV_PI * max(i.z, 0.0f) * sqr(l.alpha_x / max(length2, 1e-20f));
}

FN vec3 sheen_eval(IN(Lobe) l, vec3 wi, OUT(float) pdf) {
  vec3 t;
  vec3 b;
  sheen_frame(l, t, b);
  pdf = sheen_density(l, vec3(dot(wi, t), dot(wi, b), dot(wi, l.n)));
  return l.weight * pdf;
}

FN void sheen_sample(IN(Lobe) l, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  vec3 t;
  vec3 b;
  sheen_frame(l, t, b);
  const vec3 c = cosine_hemisphere_from_square(u);
  float len;
  const vec3 i = safe_normalize(vec3(c.x - c.z * l.alpha_y, c.y, c.z * l.alpha_x), len);
  s.wi = to_world(i, t, b, l.n);
  s.pdf = sheen_density(l, i);
  s.weight = l.weight;
}

// ---- Velvet: D of an inverted Gaussian, G of V-cavities

FN void velvet_prepare(vec3 weight, vec3 color, float sigma, vec3 n, OUT(Lobe) l) {
  lobe_clear(LOBE_VELVET, weight * max(color, vec3(0.0f)), n, l);
  l.alpha_x = 1.0f / sqr(max(clamp(sigma, 0.0f, 1.0f), 0.01f));
}

FN vec3 velvet_eval(IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  pdf = 0.0f;
  const float no = dot(l.n, wo);
  const float ni = dot(l.n, wi);
  if (!(no > 1e-5f) || !(ni > 0.0f)) return vec3(0.0f);
  pdf = 0.5f * INV_PI;
  const vec3 h = wo + wi;
  const float h2 = max(dot(h, h), 1e-20f);
  const vec3 along = cross(l.n, h);
  const float sin2 = min(dot(along, along) / h2, 1.0f);
  const float oh = 0.5f * sqrt(h2);
  // No facet stands upright, and none is seen edge-on.
  if (!(sin2 > 2e-5f) || !(oh > 1e-5f)) return vec3(0.0f);
  const float nh = max(dot(l.n, h), 0.0f) / sqrt(h2);
  const float d = exp(-nh * nh / sin2 * l.alpha_x) * l.alpha_x * INV_PI / (sin2 * sin2);
  const float g = min(1.0f, 2.0f * max(nh / oh, 1e-5f) * min(no, ni));
  return l.weight * (0.25f * d * g / no);
}

FN void velvet_sample(IN(Lobe) l, vec3 wo, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  vec3 t;
  vec3 b;
  orthonormal_basis(l.n, t, b);
  s.wi = to_world(cone_from_square(u, 1.0f), t, b, l.n);
  const vec3 f = velvet_eval(l, wo, s.wi, s.pdf);
  if (s.pdf > 0.0f) s.weight = f * (1.0f / s.pdf);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

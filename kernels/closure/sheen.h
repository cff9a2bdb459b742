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

// The layer's albedo and its transformed cosine's A and B, for cosine x toward the viewer and roughness y: polynomials
// of degree 7 in u = 2 sqrt(x) - 1 and v = 2 sqrt(y) - 1. They are least squares over a grid of 31 by 29 points of what
// facets under six suns showed in Cycles, whose table comes from the paper's simulation: 1 % of f apart (root of the
// mean square), at most 3 % of the albedo for roughnesses above 0.25.
FN float sheen_log_albedo(float u, float v) {
  const float c0 =
      -2.3135f +
      v * (6.4766f + v * (-13.896f + v * (22.805f + v * (-31.664f + v * (36.578f + v * (-26.798f + v * 8.342f))))));
  const float c1 =
      -5.1873f + v * (16.686f + v * (-27.392f + v * (27.429f + v * (-21.899f + v * (16.625f + v * -6.727f)))));
  const float c2 = -3.8625f + v * (5.8663f + v * (9.5789f + v * (-33.577f + v * (32.3f + v * -10.632f))));
  const float c3 = 1.4116f + v * (-14.234f + v * (37.545f + v * (-40.163f + v * 15.604f)));
  const float c4 = 2.6408f + v * (-9.1014f + v * (11.562f + v * -4.8945f));
  const float c5 = -0.085546f + v * (0.69883f + v * -0.79237f);
  const float c6 = -0.57479f + v * 0.46772f;
  const float c7 = 0.10259f;
  return c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * (c5 + u * (c6 + u * c7))))));
}

FN float sheen_a(float u, float v) {
  const float c0 =
      0.19825f +
      v * (0.50556f +
           v * (-0.074415f + v * (-0.39302f + v * (2.0956f + v * (-1.4146f + v * (-0.68113f + v * 0.60107f))))));
  const float c1 =
      0.10121f + v * (0.33415f + v * (0.30468f + v * (-1.8995f + v * (2.3237f + v * (-1.7187f + v * 0.65825f)))));
  const float c2 = -0.053694f + v * (-0.55169f + v * (1.3418f + v * (-0.73241f + v * (-0.54691f + v * 0.43052f))));
  const float c3 = 0.081267f + v * (-0.45851f + v * (-0.107f + v * (1.4815f + v * -1.0008f)));
  const float c4 = 0.042874f + v * (0.42621f + v * (-0.99993f + v * 0.65786f));
  const float c5 = -0.0044725f + v * (0.18334f + v * -0.1901f);
  const float c6 = 0.059732f + v * -0.10093f;
  const float c7 = -0.035236f;
  return c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * (c5 + u * (c6 + u * c7))))));
}

FN float sheen_b(float u, float v) {
  const float c0 =
      -0.00868f +
      v * (-0.051355f +
           v * (-0.49043f + v * (-0.27486f + v * (1.8781f + v * (-1.2275f + v * (0.29794f + v * -0.13067f))))));
  const float c1 =
      -0.0032138f + v * (0.44824f + v * (0.50412f + v * (-2.65f + v * (2.5818f + v * (-2.1491f + v * 1.3354f)))));
  const float c2 = -0.1628f + v * (-0.59652f + v * (2.4243f + v * (0.020564f + v * (-4.0406f + v * 2.3484f))));
  const float c3 = 0.24721f + v * (-0.5481f + v * (-2.0089f + v * (5.9756f + v * -3.8372f)));
  const float c4 = -0.11249f + v * (1.1329f + v * (-2.6152f + v * 1.6877f));
  const float c5 = -0.23225f + v * (0.14062f + v * 0.1356f);
  const float c6 = 0.20066f + v * -0.27054f;
  const float c7 = 0.072358f;
  return c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * (c5 + u * (c6 + u * c7))))));
}

// Below this roughness, which the fit does not reach, cloth is black but for its rim.
const float SHEEN_SMOOTHEST = 0.0625f;

FN void sheen_prepare(vec3 weight, vec3 color, float roughness, vec3 n, vec3 wo, OUT(Lobe) l) {
  lobe_clear(LOBE_SHEEN, weight * max(color, vec3(0.0f)), n, l);
  const float u = 2.0f * sqrt(clamp(dot(n, wo), 0.0f, 1.0f)) - 1.0f;
  const float v = 2.0f * sqrt(clamp(roughness, SHEEN_SMOOTHEST, 1.0f)) - 1.0f;
  const float albedo = exp(sheen_log_albedo(u, v));
  l.alpha_x = max(sheen_a(u, v), 0.01f);
  l.alpha_y = sheen_b(u, v);
  l.t = wo;
  l.weight *= albedo;
  if (!(albedo >= 1e-5f)) l.kind = LOBE_NONE;
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

// SPDX-License-Identifier: GPL-3.0-or-later
// Sheen of cloth: a layer of microfibers (Zeltner, Burley & Chiang 2022, "Practical Multiple-Scattering Sheen Using
// Linearly Transformed Cosines"), and Ashikhmin's velvet (Ashikhmin, Premoze & Shirley 2000).
#ifndef COTORRA_SHEEN_H
#define COTORRA_SHEEN_H

#include "lobe_tables.h"
#include "lobe_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// ---- Microfibers

// Cycles takes no cloth for smoother.
const float SHEEN_SMOOTHEST = 1e-3f;

// One of the tables of TABLE_SHEEN at a place in it.
FN float sheen_number(FloatBuffer table, uint which, uint cell, float tx, float ty) {
  const uint i = TABLE_SHEEN + which * (SHEEN_NODES * SHEEN_NODES) + cell;
  return mix(albedo_row(table, i, tx), albedo_row(table, i + SHEEN_NODES, tx), ty);
}

FN void sheen_prepare(FloatBuffer table, vec3 weight, vec3 color, float roughness, vec3 n, vec3 wo, OUT(Lobe) l) {
  lobe_clear(LOBE_SHEEN, weight * max(color, vec3(0.0f)), n, l);
  float tx;
  float ty;
  const uint x = albedo_cell(dot(n, wo), SHEEN_NODES, tx);
  const uint y = albedo_cell(max(roughness, SHEEN_SMOOTHEST), SHEEN_NODES, ty);
  const uint cell = y * SHEEN_NODES + x;
  const float albedo = sheen_number(table, 0u, cell, tx, ty);
  l.alpha_x = sheen_number(table, 1u, cell, tx, ty);
  l.alpha_y = sheen_number(table, 2u, cell, tx, ty);
  l.t = wo;
  l.weight *= albedo;
  if (!(albedo >= 1e-5f) || !(abs(l.alpha_x) >= 1e-5f)) l.kind = LOBE_NONE;
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

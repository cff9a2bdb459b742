// SPDX-License-Identifier: GPL-3.0-or-later
// The terms of microfacet reflection: distributions D, masking-shadowing V, Fresnel F, and sampling of visible normals.
// Each function is one equation under its usual name; how they are put together to a material is told in bsdf.h.
#ifndef COTORRA_MICROFACET_H
#define COTORRA_MICROFACET_H

#include "math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Notation: n normal, o toward the viewer, i toward the light, h half vector; no = dot(n, o) and so on.
// alpha = roughness squared, alpha2 = alpha squared; both above 0.

// A surface with alpha2 up to this counts as a mirror, as in Cycles.
const float MIRROR_ALPHA2 = 2e-10f;

// ---- Distribution of normals

// Walter et al. 2007, eq. 33, for a half vector of any length: h2 is its squared length, xy2 that of its part along the
// surface. Written with 1 - nh^2 instead, it would be all rounding near the mirror direction.
FN float D_GGX(float xy2, float h2, float alpha2) {
  const float q = h2 / (alpha2 * h2 + (1.0f - alpha2) * xy2);
  return alpha2 * INV_PI * q * q;
}

// ---- Masking and shadowing

// nx (1 + 2 Lambda(x)) of Smith's Lambda for GGX (Heitz 2014, eq. 72); finite at grazing angles, unlike Lambda itself.
FN float S_SmithGGX(float nx, float alpha2) { return sqrt(alpha2 + nx * nx * (1.0f - alpha2)); }

// G2 / (4 no ni), height-correlated (Heitz 2014, eq. 99); s_o, s_i as S_SmithGGX gives them.
FN float V_SmithGGXCorrelated(float no, float s_o, float ni, float s_i) { return 0.5f / (no * s_i + ni * s_o); }

// G1(o) / (4 no): times D it is the density of i when visible normals are sampled (Heitz 2018, eq. 17).
FN float V_SmithGGXVisible(float no, float s_o) { return 0.5f / (no + s_o); }

// ---- Fresnel

// Reflectance at normal incidence against vacuum, and its inverse up to 0.99.
FN float F0_from_ior(float ior) { return sqr((ior - 1.0f) / (ior + 1.0f)); }
FN float ior_from_F0(float f0) {
  const float r = sqrt(clamp(f0, 0.0f, 0.99f));
  return (1.0f + r) / (1.0f - r);
}

// Fresnel's equations for unpolarised light on a dielectric; eta inside over outside, c2 = c squared, c above 0.
// g is eta times the cosine inside. Beyond the critical angle it is 0 and both fractions square to 1: total reflection.
FN float F_Dielectric(float c, float c2, float eta) {
  const float eta2 = eta * eta;
  const float g = sqrt(max(eta2 - 1.0f + c2, 0.0f));
  const float s = (c - g) / (c + g);
  const float p = (eta2 * c - g) / (eta2 * c + g);
  return 0.5f * (s * s + p * p);
}

// Mean of 2 c F_Dielectric(c) over c in 0..1 (Kulla & Conty 2017, fit).
FN float F_DielectricAverage(float eta) {
  const float outside = (eta - 1.0f) / (4.08567f + 1.00071f * eta);
  const float inside = 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f));
  return select(eta < 1.0f, inside, outside);
}

// (1 - c)^5 (Schlick 1994).
FN float F_SchlickWeight(float c) {
  const float m = clamp(1.0f - c, 0.0f, 1.0f);
  const float m2 = m * m;
  return m2 * m2 * m;
}

// Schlick from f0 to f0 + range, less edge * c (1 - c)^6, which is strongest at 82 degrees (Kutz et al. 2021,
// "F82-tint"). All three may carry a common weight.
FN vec3 F_Schlick82(vec3 f0, vec3 range, vec3 edge, float c) {
  const float w = F_SchlickWeight(c);
  return max(f0 + range * w - edge * (c * w * (1.0f - c)), vec3(0.0f));
}

// The edge coefficient that makes F_Schlick82 equal Schlick times tint at c = 1/7, where c (1 - c)^6 has its maximum.
FN vec3 F_Schlick82Edge(vec3 f0, vec3 tint) {
  const float w = F_SchlickWeight(1.0f / 7.0f);
  return (f0 + (1.0f - f0) * w) * (1.0f - tint) * (49.0f / (6.0f * w));
}

// Mean of 2 c F_Schlick82(c) over c in 0..1, unclamped: the integrals of 2c (1 - c)^5 and 2c^2 (1 - c)^6.
FN vec3 F_Schlick82Average(vec3 f0, vec3 edge) { return f0 + (1.0f - f0) * (1.0f / 21.0f) - edge * (1.0f / 126.0f); }

// ---- Sampling of visible normals

// A half vector about +z, of any length, for the viewer o_local with o_local.z > 0, by a uniform spherical cap (Dupuy &
// Benyoub 2023). `disk` is uniform in the unit disk: the equal-area map from disk to cap keeps its stratification.
FN vec3 half_vector_GGX(vec3 o_local, float alpha, float s_o, vec2 disk) {
  // 1. To the configuration in which the surface is a hemisphere; s_o is the length of the stretched viewer.
  const float scale = 1.0f / s_o;
  const vec3 v = vec3(alpha * scale * o_local.x, alpha * scale * o_local.y, scale * o_local.z);
  // 2. A point c of the cap z > -v.z: 1 - z = r^2 (1 + v.z).
  const float r2 = dot(disk, disk);
  const float height = 1.0f + v.z;
  const float spread = sqrt(max(height * (2.0f - r2 * height), 0.0f));
  // 3. The microfacet normal c + v, with z written without cancellation, back to the ellipsoid.
  return vec3(alpha * (disk.x * spread + v.x), alpha * (disk.y * spread + v.y), max(height * (1.0f - r2), 0.0f));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

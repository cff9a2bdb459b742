// SPDX-License-Identifier: GPL-3.0-or-later
// The terms of Cook-Torrance reflection beside those of microfacet.h: more D, G and F to choose from.
// Each function is one equation; how they are put together is told in model_cook_torrance.h.
#ifndef COTORRA_MODEL_MICROFACET_H
#define COTORRA_MODEL_MICROFACET_H

#include "microfacet.h"
#include "model_math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Notation as in microfacet.h. sin2 is the squared sine between the half vector and n: given beside nh, because
// 1 - nh^2 is all rounding where the highlight is.

// ---- Distribution of normals

// Beckmann & Spizzichino 1963, as in Cook & Torrance 1982, normalised. Below nh = 1e-6 the exponential is 0.
FN float D_Beckmann(float sin2, float nh, float alpha2) {
  const float nh2 = max(nh * nh, 1e-12f);
  return exp_lanes(-sin2 / (alpha2 * nh2)) * INV_PI / (alpha2 * nh2 * nh2);
}

// (p + 2) / (2 pi) nh^p (Blinn 1977, normalised) with p = 2 / alpha^2 - 2, which makes it as wide as Beckmann's
// (Walter et al. 2007).
FN float D_BlinnPhong(float sin2, float nh, float alpha2) {
  return pow_near_one(nh * nh, sin2, 1.0f / alpha2 - 1.0f) * INV_PI / alpha2;
}

// ---- Masking and shadowing. Lambda is infinite at grazing angles, nx Lambda(x) is not: all is written with that.

FN float N_LambdaGGX(float nx, float alpha2) {
  return 0.5f * alpha2 * (1.0f - nx * nx) / (S_SmithGGX(nx, alpha2) + nx);
}

// Rational fit (Walter et al. 2007, eq. 20, as Lambda): t = nx / slope, nothing from 1.6 on. The slope is alpha times
// the sine, on an anisotropic surface by axis.
FN float N_LambdaBeckmannSlope(float nx, float slope) {
  const float t = nx / slope;
  return select(t < 1.6f, slope * (1.0f + t * (-1.259f + t * 0.396f)) / (3.535f + t * 2.181f), 0.0f);
}

// Without the fit, as sampling needs it: Lambda = (exp(-t^2) / (t sqrt(pi)) - erfc(t)) / 2 (Smith 1967).
FN float N_LambdaBeckmannSlopeExact(float nx, float slope) {
  const float t = min(nx / slope, 1e3f);
  return max(0.5f * exp_lanes(-t * t) * (slope * 0.564189584f - nx * erfc_scaled(t)), 0.0f);
}

// The same of an isotropic surface.
FN float beckmann_slope(float nx, float alpha) { return max(alpha * sqrt(max(1.0f - nx * nx, 0.0f)), 1e-20f); }
FN float N_LambdaBeckmann(float nx, float alpha) { return N_LambdaBeckmannSlope(nx, beckmann_slope(nx, alpha)); }
FN float N_LambdaBeckmannExact(float nx, float alpha) {
  return N_LambdaBeckmannSlopeExact(nx, beckmann_slope(nx, alpha));
}

// The following are G / (4 no), which is what f cos needs: the cosine ni takes the place of 1 / ni.

// Height-correlated Smith: 1 / (1 + Lambda(o) + Lambda(i)).
FN float V_SmithCorrelated(float no, float nl_o, float ni, float nl_i) {
  return 0.25f * ni / max(no * ni + ni * nl_o + no * nl_i, 1e-37f);
}
// Smith, uncorrelated: G1(o) G1(i).
FN float V_Smith(float no, float nl_o, float ni, float nl_i) {
  return 0.25f * ni / max((no + nl_o) * (ni + nl_i), 1e-37f);
}
// V-cavities (Torrance & Sparrow 1967): min(1, 2 nh no / oh, 2 nh ni / oh).
FN float V_Cavity(float no, float ni, float nh, float oh) {
  return min(0.25f / no, 0.5f * nh * min(ni / no, 1.0f) / oh);
}
// Schlick 1994 with k = alpha / 2.
FN float V_SchlickGGX(float no, float ni, float alpha) {
  const float k = 0.5f * alpha;
  return 0.25f * ni / ((no * (1.0f - k) + k) * (ni * (1.0f - k) + k));
}
// V-cavities toward the viewer alone, G1(o) / (4 no): times D it is the density of half_vector_cavity as seen in i.
FN float V_CavityVisible(float no, float nh, float oh) { return min(0.25f / no, 0.5f * nh / oh); }

// ---- Fresnel

// Fresnel's equations for unpolarised light on a conductor of index n + i k (Born & Wolf, ch. 14): a and b are the real
// and imaginary part of the root of (n + i k)^2 - sin^2.
FN float F_Conductor(float c, float n, float k) {
  const float s2 = max(1.0f - c * c, 0.0f);
  const float t = (n - k) * (n + k) - s2;
  const float m = 2.0f * n * k;
  const float a2b2 = sqrt(t * t + m * m);
  // a^2 = (a2b2 + t) / 2, without the cancellation where t is below 0.
  const float a = sqrt(0.5f * select(t > 0.0f, a2b2 + t, m * m / max(a2b2 - t, 1e-20f)));
  const float perpendicular = (a2b2 + c * c - 2.0f * a * c) / max(a2b2 + c * c + 2.0f * a * c, 1e-20f);
  const float q = a2b2 * c * c + s2 * s2;
  const float parallel = (q - 2.0f * a * c * s2) / max(q + 2.0f * a * c * s2, 1e-20f);
  return clamp(0.5f * perpendicular * (1.0f + parallel), 0.0f, 1.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Rough diffuse reflection: Oren-Nayar's qualitative model, and the energy-preserving one.
// Both share their sampling with Lambert's, in model.h.
#ifndef COTORRA_MODEL_DIFFUSE_H
#define COTORRA_MODEL_DIFFUSE_H

#include "model_math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// cos(phi_i - phi_o) sin(a) tan(b), where a is the larger and b the smaller of the angles: both sines with the cosine
// are oi - no ni, and the tangent's cosine is the larger one.
FN float oren_nayar_shape(float no, float ni, float oi) { return max(oi - no * ni, 0.0f) / max(max(no, ni), 1e-10f); }

// Oren & Nayar 1994, eq. 30: pi f / albedo = A + B shape.
FN float oren_nayar_A(float sigma2) { return 1.0f - 0.5f * sigma2 / (sigma2 + 0.33f); }
FN float oren_nayar_B(float sigma2) { return 0.45f * sigma2 / (sigma2 + 0.09f); }

// EON (Portsmouth, Kutz & Hill 2024): Fujii's form A (1 + r shape), where negative shapes are kept as oi - no ni, and
// what it loses to multiple scattering. r is sigma in units of 90 degrees.
const float EON_LOSS = 0.287793409f;       // 1/2 - 2 / (3 pi): A = 1 / (1 + EON_LOSS r)
const float EON_LOSS_MEAN = 0.215305197f;  // EON_LOSS - (2/3 - 28 / (15 pi)): of the average over all directions
FN float eon_A(float r) { return 1.0f / (1.0f + EON_LOSS * r); }

// G(theta) / pi of the paper: the single-scattering albedo is A (1 + r eon_shape). With
// tan (1 - sin^3) = sin cos (1 + sin + sin^2) / (1 + sin), nothing is infinite at 90 degrees.
FN float eon_albedo_shape(float c) {
  const float s = sqrt(max(1.0f - c * c, 0.0f));
  const float single = s * (s * acos_over_sine(c) - s * c);
  return INV_PI * (single + (2.0f / 3.0f) * s * (c * (1.0f + s + s * s) / (1.0f + s) - 1.0f));
}

// pi f of EON. With 1 - E = A r (EON_LOSS - shape) no difference of two albedos is left, and r = 0 is Lambert's.
FN vec3 eon_eval(vec3 albedo, float r, float no, float ni, float oi) {
  const float a = eon_A(r);
  const float s = oi - no * ni;
  const float shape = select(s > 0.0f, s / max(max(no, ni), 1e-10f), s);
  const float missing = a * r * EON_LOSS_MEAN;  // 1 - average albedo
  const float lost = (EON_LOSS - eon_albedo_shape(no)) * (EON_LOSS - eon_albedo_shape(ni));
  const vec3 rho = min(albedo, vec3(1.0f));  // a series of bounces: beyond 1 it has no sum
  const vec3 multiple = rho * rho * (1.0f - missing) / (vec3(1.0f) - rho * missing);
  return albedo * (a * (1.0f + r * shape)) + multiple * (a * r * lost / EON_LOSS_MEAN);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

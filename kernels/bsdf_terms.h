// SPDX-License-Identifier: GPL-3.0-or-later
// The factors of a highlight one by one, for people who want to see them: D, G and F of the half vector of two
// directions. Light transport does not need this.
#ifndef COTORRA_BSDF_TERMS_H
#define COTORRA_BSDF_TERMS_H

#include "bsdf.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Phong and Blinn-Phong have no such terms: d is their power, g is 1, and f is what the power is multiplied by.
FN void model_terms(IN(ModelBsdf) m, IN(HalfAngle) a, OUT(float) d, OUT(float) g, OUT(vec3) f) {
  d = 0.0f;
  g = 1.0f;
  f = vec3(0.0f);
  if (m.model == MODEL_PHONG) {
    d = a.rv > 0.0f ? pow_near_one(a.rv, a.off_mirror, m.exponent) : 0.0f;
    f = m.specular;
  } else if (m.model == MODEL_BLINN_PHONG) {
    d = pow_near_one(a.nh * a.nh, a.sin2, 0.5f * m.exponent);
    f = m.specular;
  } else if (m.model == MODEL_COOK_TORRANCE) {
    f = model_fresnel(m, a.oh);
    if (model_is_mirror(m)) return;
    d = model_distribution(m, a);
    g = model_masking(m, a) * 4.0f * m.no;
  }
}

// D, G and F of the highlight. Principled: D of GGX, Smith's height-correlated G, and as F the sum of metal and
// coating, with their weights. Without a highlight D and F are 0; below the surface all are. D of a mirror is 0, too.
FN void bsdf_terms(IN(Bsdf) bsdf, vec3 wo, vec3 wi, OUT(float) d, OUT(float) g, OUT(vec3) f) {
  d = 0.0f;
  g = 0.0f;
  f = vec3(0.0f);
  const float ni = glossy_cosine(bsdf, dot(bsdf.n, wi), wi, false);
  if (!(ni > 0.0f) || !(bsdf.no > 0.0f)) return;
  HalfAngle a;
  half_angle(bsdf.n_glossy, wo, wi, ni, a);
  if (FEATURE(FEATURE_MODELS) && bsdf.model.model != MODEL_PRINCIPLED) {
    model_terms(bsdf.model, a, d, g, f);
    return;
  }
  g = 1.0f;
  if (!(bsdf.p_glossy > 0.0f)) return;
  f = bsdf_fresnel(bsdf, a.oh, a.oh * a.oh);
  if ((bsdf.lobes & BSDF_SINGULAR) != 0u) return;
  d = D_GGX(a.sin2, 1.0f, bsdf.alpha2);
  g = V_SmithGGXCorrelated(bsdf.no, bsdf.s_o, ni, S_SmithGGX(ni, bsdf.alpha2)) * 4.0f * bsdf.no * ni;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Cycles' means against fireflies, for files that ask for them: clamping, Filter Glossy, and paths without caustics.
// All are biased, and do nothing where they are off. Which light and which vertex they meet is integrator.h's.
#ifndef COTORRA_FIREFLIES_H
#define COTORRA_FIREFLIES_H

#include "scattering.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Light whose channels sum up to `limit` at most.
FN vec3 clamped_light(vec3 light, float limit) {
  const float sum = abs(light.x) + abs(light.y) + abs(light.z);
  return light * select(sum > limit, limit / sum, 1.0f);
}

// Filter Glossy: the alpha that glossy lobes have at least, on a path whose widest bounce had density min_pdf. A
// density of filter_glossy or more blurs nothing.
FN float glossy_blur(float filter_glossy, float min_pdf) {
  return min_pdf < filter_glossy ? 0.5f * sqrt(1.0f - min_pdf / filter_glossy) : 0.0f;
}

// How rough what scattered along a sample is, as alpha: 0 of a mirror, 1 of what is diffuse.
FN float sampled_alpha(IN(Bsdf) bsdf, IN(Lobe) lobe, IN(BsdfSample) b) {
  if ((b.lobe & BSDF_SINGULAR) != 0u) return 0.0f;
  if (!has_lobe(lobe)) return (b.lobe & BSDF_GLOSSY) != 0u ? sqrt(bsdf.alpha2) : 1.0f;
  if (lobe.kind < LOBE_REFLECTION || lobe.kind > LOBE_ASHIKHMIN_SHIRLEY) return 1.0f;
  return sqrt(lobe.alpha_x * lobe.alpha_y);
}

// Widens the glossy lobes. Their energy stays what it was for their own roughness, as in Cycles.
FN void bsdf_blur(float alpha, INOUT(Bsdf) bsdf) {
  if (FEATURE(FEATURE_MODELS) && bsdf.model.model != MODEL_PRINCIPLED) return;
  if (!FEATURE(FEATURE_SPECULAR) || !(bsdf.p_glossy > 0.0f) || alpha * alpha <= bsdf.alpha2) return;
  bsdf.alpha2 = alpha * alpha;
  bsdf.s_o = S_SmithGGX(max(bsdf.no, 0.0f), bsdf.alpha2);
  bsdf.lobes = (bsdf.lobes & ~BSDF_SINGULAR) | BSDF_GLOSSY;
}

FN void lobe_blur(float alpha, INOUT(Lobe) l) {
  if (l.kind < LOBE_REFLECTION || l.kind > LOBE_ASHIKHMIN_SHIRLEY) return;
  l.alpha_x = max(l.alpha_x, alpha);
  l.alpha_y = max(l.alpha_y, alpha);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

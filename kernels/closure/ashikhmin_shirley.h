// SPDX-License-Identifier: GPL-3.0-or-later
// The glossy lobe of Ashikhmin & Shirley 2000, "An Anisotropic Phong BRDF Model", without its Fresnel term.
// Prepared by glossy.h; its exponents are 2 / alpha^2 - 2.
#ifndef COTORRA_ASHIKHMIN_SHIRLEY_H
#define COTORRA_ASHIKHMIN_SHIRLEY_H

#include "microfacet_lobe.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const float ASHIKHMIN_SHIRLEY_ALPHA = 1e-4f;  // at least; where both are, it is a mirror

FN void ashikhmin_shirley_limit(INOUT(Lobe) l) {
  l.alpha_x = max(l.alpha_x, ASHIKHMIN_SHIRLEY_ALPHA);
  l.alpha_y = max(l.alpha_y, ASHIKHMIN_SHIRLEY_ALPHA);
}

FN bool ashikhmin_shirley_is_mirror(IN(Lobe) l) { return max(l.alpha_x, l.alpha_y) <= ASHIKHMIN_SHIRLEY_ALPHA; }

FN float phong_exponent(float alpha) { return 2.0f / (alpha * alpha) - 2.0f; }

// Eq. 4's power of the half vector over 8 pi: density (eq. 8) times oh. `h` in the frame, any length.
FN float ashikhmin_shirley_power(IN(Lobe) l, vec3 h) {
  const float e_x = phong_exponent(l.alpha_x);
  const float e_y = phong_exponent(l.alpha_y);
  const float h2 = max(dot(h, h), 1e-30f);
  const float xy2 = h.x * h.x + h.y * h.y;
  const float e = xy2 > 1e-20f * h2 ? (e_x * h.x * h.x + e_y * h.y * h.y) / xy2 : 0.0f;
  const float power = exp(0.5f * e * log_near_one(h.z * h.z / h2, min(xy2 / h2, 1.0f)));
  return sqrt((e_x + 1.0f) * (e_y + 1.0f)) * (0.125f * INV_PI) * power;
}

FN vec3 ashikhmin_shirley_eval(IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  pdf = 0.0f;
  const float no = dot(l.n, wo);
  const float ni = dot(l.n, wi);
  if (!(no > 0.0f) || !(ni > 0.0f) || ashikhmin_shirley_is_mirror(l)) return vec3(0.0f);
  vec3 t;
  vec3 b;
  microfacet_frame(l, t, b);
  const vec3 h = wo + wi;
  const float oh = max(0.5f * sqrt(dot(h, h)), 1e-6f);
  pdf = ashikhmin_shirley_power(l, vec3(dot(h, t), dot(h, b), dot(h, l.n))) / oh;
  return l.weight * (pdf * ni / max(no, ni));
}

FN void ashikhmin_shirley_sample(IN(Lobe) l, vec3 wo, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  vec3 t;
  vec3 b;
  microfacet_frame(l, t, b);
  // 1. The azimuth, by quadrants (eq. 9): tan phi = sqrt((e_x + 1) / (e_y + 1)) tan of a uniform angle.
  const float e_x = phong_exponent(l.alpha_x);
  const float e_y = phong_exponent(l.alpha_y);
  const float angle = 2.0f * PI * u.x;
  float len;
  const vec3 flat_h = safe_normalize(vec3(cos(angle) * sqrt(e_y + 1.0f), sin(angle) * sqrt(e_x + 1.0f), 0.0f), len);
  // 2. The height (eq. 10), as 1 - cos.
  const float e = e_x * flat_h.x * flat_h.x + e_y * flat_h.y * flat_h.y;
  const float drop = one_minus_exp(min(-log_one_minus(u.y) / (e + 1.0f), 80.0f));
  const float spread = sqrt(max(drop * (2.0f - drop), 0.0f));
  vec3 h = vec3(flat_h.x * spread, flat_h.y * spread, max(1.0f - drop, 0.0f));
  if (ashikhmin_shirley_is_mirror(l)) h = vec3(0.0f, 0.0f, 1.0f);
  const vec3 facet = to_world(h, t, b, l.n);
  s.wi = facet * (2.0f * dot(facet, wo)) - wo;
  s.lobe = BSDF_GLOSSY;
  if (ashikhmin_shirley_is_mirror(l)) {
    s.lobe |= BSDF_SINGULAR;
    s.pdf = dot(l.n, wo) > 0.0f ? 1.0f : 0.0f;
    s.weight = l.weight;
    return;
  }
  const float oh = max(abs(dot(facet, wo)), 1e-6f);
  const float no = dot(l.n, wo);
  const float ni = dot(l.n, s.wi);
  if (!(no > 0.0f) || !(ni > 0.0f)) return;
  s.pdf = ashikhmin_shirley_power(l, h) / oh;
  s.weight = l.weight * (ni / max(no, ni));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

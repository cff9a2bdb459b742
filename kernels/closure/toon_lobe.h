// SPDX-License-Identifier: GPL-3.0-or-later
// Toon BSDF, diffuse and glossy: light in a cone about the normal or the mirror direction counts fully, and fades out
// over a rim. The integrator of that name is kernels/toon.h.
#ifndef COTORRA_TOON_LOBE_H
#define COTORRA_TOON_LOBE_H

#include "lobe_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN void toon_prepare(bool glossy, vec3 weight, vec3 color, float size, float smooth_rim, vec3 n, OUT(Lobe) l) {
  lobe_clear(glossy ? LOBE_TOON_GLOSSY : LOBE_TOON_DIFFUSE, weight * max(color, vec3(0.0f)), n, l);
  l.alpha_x = clamp(size, 1e-5f, 1.0f) * (0.5f * PI);
  l.alpha_y = clamp(smooth_rim, 0.0f, 1.0f) * (0.5f * PI);
}

// The cone's angle with its rim, and 1 - cos of it.
FN float toon_angle(IN(Lobe) l) { return min(l.alpha_x + l.alpha_y, 0.5f * PI); }
FN float toon_cap(IN(Lobe) l) { return 2.0f * sqr(sin(0.5f * toon_angle(l))); }

// What counts at an angle to the cone's axis.
FN float toon_intensity(IN(Lobe) l, float angle) {
  if (angle < l.alpha_x) return 1.0f;
  return l.alpha_y > 0.0f ? max(1.0f - (angle - l.alpha_x) / l.alpha_y, 0.0f) : 0.0f;
}

FN vec3 toon_axis(IN(Lobe) l, vec3 wo) { return l.kind == LOBE_TOON_GLOSSY ? l.n * (2.0f * dot(l.n, wo)) - wo : l.n; }

// f cos; the density is that of the whole cone, of which what lies below the surface is no sample.
FN vec3 toon_eval(IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  pdf = 0.0f;
  if (!(dot(l.n, wi) > 0.0f) || (l.kind == LOBE_TOON_GLOSSY && !(dot(l.n, wo) > 0.0f))) return vec3(0.0f);
  const vec3 axis = toon_axis(l, wo);
  const float angle = atan(length(cross(axis, wi)), dot(axis, wi));
  if (!(angle < toon_angle(l))) return vec3(0.0f);
  pdf = 0.5f * INV_PI / max(toon_cap(l), 1e-20f);
  return l.weight * (pdf * toon_intensity(l, angle));
}

FN void toon_sample(IN(Lobe) l, vec3 wo, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  const vec3 axis = toon_axis(l, wo);
  vec3 t;
  vec3 b;
  orthonormal_basis(axis, t, b);
  s.wi = to_world(cone_from_square(u, toon_cap(l)), t, b, axis);
  s.lobe = l.kind == LOBE_TOON_GLOSSY ? BSDF_GLOSSY : BSDF_DIFFUSE;
  const vec3 f = toon_eval(l, wo, s.wi, s.pdf);
  if (s.pdf > 0.0f) s.weight = f * (1.0f / s.pdf);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

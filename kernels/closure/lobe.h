// SPDX-License-Identifier: GPL-3.0-or-later
// Lobes by kind: what light one sends to the viewer, where it sends rays, and how much it reflects and lets through.
// Which lobes a surface has is its material's; here is one at a time.
#ifndef COTORRA_LOBE_H
#define COTORRA_LOBE_H

#include "rough_diffuse.h"
#include "sheen.h"
#include "thin_wall.h"
#include "toon_lobe.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// f |cos| times the lobe's weight, for light from wi on either side of the surface; pdf is that of lobe_sample. Both
// are 0 of mirrors and of clear glass.
FN vec3 lobe_eval(FloatBuffer table, IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  pdf = 0.0f;
  if (l.kind == LOBE_DIFFUSE || l.kind == LOBE_TRANSLUCENT) return diffuse_eval(l, wo, wi, pdf);
  if (l.kind == LOBE_ASHIKHMIN_SHIRLEY) return ashikhmin_shirley_eval(l, wo, wi, pdf);
  if (l.kind == LOBE_SHEEN) return sheen_eval(l, wi, pdf);
  if (l.kind == LOBE_VELVET) return velvet_eval(l, wo, wi, pdf);
  if (l.kind == LOBE_TOON_DIFFUSE || l.kind == LOBE_TOON_GLOSSY) return toon_eval(l, wo, wi, pdf);
  if (l.kind == LOBE_NONE) return vec3(0.0f);
  return microfacet_eval(table, l, wo, wi, pdf);
}

// A direction. pdf 0 is no sample. A sample with BSDF_SINGULAR has the probability of its choice for a pdf.
FN void lobe_sample(FloatBuffer table, IN(Lobe) l, vec3 wo, float u_lobe, vec2 u, OUT(BsdfSample) s) {
  if (l.kind == LOBE_DIFFUSE || l.kind == LOBE_TRANSLUCENT) {
    diffuse_sample(l, wo, u, s);
  } else if (l.kind == LOBE_ASHIKHMIN_SHIRLEY) {
    ashikhmin_shirley_sample(l, wo, u, s);
  } else if (l.kind == LOBE_SHEEN) {
    sheen_sample(l, u, s);
  } else if (l.kind == LOBE_VELVET) {
    velvet_sample(l, wo, u, s);
  } else if (l.kind == LOBE_TOON_DIFFUSE || l.kind == LOBE_TOON_GLOSSY) {
    toon_sample(l, wo, u, s);
  } else if (l.kind == LOBE_NONE) {
    sample_clear(s);
  } else {
    microfacet_sample(table, l, wo, u_lobe, u, s);
  }
}

// What it does with uniform light, about: for choices among lobes, and for what lies below a layer.
FN vec3 lobe_albedo(FloatBuffer table, IN(Lobe) l, vec3 wo) {
  if (l.kind == LOBE_NONE) return vec3(0.0f);
  const bool facets = l.kind >= LOBE_REFLECTION && l.kind <= LOBE_THIN_TRANSMISSION;
  return facets ? microfacet_albedo(table, l, wo) : l.weight;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// D, G and F of a surface as a picture shows them: summed over the lamps above it, each toward the lamp's centre.
// Shadows, falloffs and strengths are left out: these are terms of the surface, not light.
#ifndef COTORRA_LAMP_TERMS_H
#define COTORRA_LAMP_TERMS_H

#include "bsdf_terms.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN void lamp_terms(IN(SceneData) scene, vec3 p, IN(Bsdf) bsdf, vec3 wo, OUT(float) d, OUT(float) g, OUT(vec3) f) {
  d = 0.0f;
  g = 0.0f;
  f = vec3(0.0f);
  for (uint i = 0u; i < scene.light_count; ++i) {
    const Light light = LOAD(scene.lights, i);
    float distance;
    const vec3 to_light = light.type == LIGHT_SUN ? -light.axis : light.position - p;
    const vec3 wi = safe_normalize(to_light, distance);
    if (!(dot(bsdf.n, wi) > 0.0f)) continue;
    float lamp_d;
    float lamp_g;
    vec3 lamp_f;
    bsdf_terms(bsdf, wo, wi, lamp_d, lamp_g, lamp_f);
    d += lamp_d;
    g += lamp_g;
    f += lamp_f;
  }
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

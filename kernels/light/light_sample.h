// SPDX-License-Identifier: GPL-3.0-or-later
// What one sample of a light is, whatever its kind. How it is drawn is in light.h and area_light.h.
#ifndef COTORRA_LIGHT_SAMPLE_H
#define COTORRA_LIGHT_SAMPLE_H

#include "../sampling.h"
#include "../scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

struct LightSample {
  vec3 wi;         // unit, from the surface to the light
  float distance;  // to the light, INFINITE_DISTANCE for a sun
  vec3 weight;     // radiance / pdf; for a delta light its irradiance on a surface that faces it
  float pdf;       // solid angle; 0 for a delta light, which no ray can meet
};

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// The inputs of the Principled BSDF at a point, as its node has them. Normals are on the viewer's side.
// What becomes of them is told in principled.h.
#ifndef COTORRA_PRINCIPLED_INPUTS_H
#define COTORRA_PRINCIPLED_INPUTS_H

#include "../language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

struct PrincipledInputs {
  vec3 base_color;
  float metallic;
  vec3 specular_tint;
  float roughness;
  vec3 tangent;
  float ior;
  vec3 n;
  float specular_level;
  vec3 coat_n;
  float coat;
  vec3 coat_tint;
  float coat_roughness;
  vec3 sheen_tint;
  float coat_ior;
  vec3 emission;  // colour times strength
  float sheen;
  float sheen_roughness;
  float diffuse_roughness;
  float subsurface;  // of it, only that of a thin wall is built: else it is diffuse
  float subsurface_anisotropy;
  float anisotropic;
  float rotation;
  float transmission;
  float film;  // thickness, nm
  float film_ior;
  uint thin_wall;     // 1: the surface has no inside
  uint multiscatter;  // 1: the energy of microfacets is preserved
  uint inside;        // 1: the viewer looks at the back
  uint no_caustics;   // CAUSTICS_*: what is left out toward this viewer
};

#ifdef __cplusplus
static_assert(sizeof(PrincipledInputs) == 180);
}  // namespace cotorra
#endif

#endif

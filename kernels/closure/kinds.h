// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of closures that the shaders of surfaces, lamps and worlds are sums of, by number.
// What each does with light is in the files beside this one; who fills their arguments is in kernels/program/.
#ifndef COTORRA_CLOSURE_KINDS_H
#define COTORRA_CLOSURE_KINDS_H

#include "../language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint CLOSURE_EMISSION = 0u;
const uint CLOSURE_TRANSPARENT = 1u;
const uint CLOSURE_HOLDOUT = 2u;
const uint CLOSURE_DIFFUSE = 3u;
const uint CLOSURE_TRANSLUCENT = 4u;
const uint CLOSURE_GLOSSY = 5u;
const uint CLOSURE_METALLIC = 6u;
const uint CLOSURE_GLASS = 7u;
const uint CLOSURE_REFRACTION = 8u;
const uint CLOSURE_SHEEN = 9u;
const uint CLOSURE_TOON = 10u;
const uint CLOSURE_PRINCIPLED = 11u;
const uint CLOSURE_KINDS = 12u;

const uint METALLIC_CONDUCTOR = 256u;  // bit of the mode of CLOSURE_METALLIC: index of refraction and extinction
const uint PRINCIPLED_MULTI_GGX = 1u;  // mode of CLOSURE_PRINCIPLED
// Bit of the mode of any closure: its normal is the surface's own, which a displacement has bent.
const uint CLOSURE_OWN_NORMAL = 1u << 16;
// Its normal is another, bent from the surface's own, which a displacement has bent and the word before the arguments
// tells.
const uint CLOSURE_BENT_NORMAL = 1u << 17;

// Arguments of CLOSURE_PRINCIPLED, by their place.
const uint PRINCIPLED_BASE = 0u;
const uint PRINCIPLED_METALLIC = 1u;
const uint PRINCIPLED_ROUGHNESS = 2u;
const uint PRINCIPLED_IOR = 3u;
const uint PRINCIPLED_NORMAL = 4u;
const uint PRINCIPLED_DIFFUSE_ROUGHNESS = 5u;
const uint PRINCIPLED_SUBSURFACE = 6u;
const uint PRINCIPLED_SUBSURFACE_RADIUS = 7u;
const uint PRINCIPLED_SUBSURFACE_SCALE = 8u;
const uint PRINCIPLED_SUBSURFACE_IOR = 9u;
const uint PRINCIPLED_SUBSURFACE_ANISOTROPY = 10u;
const uint PRINCIPLED_SPECULAR_LEVEL = 11u;
const uint PRINCIPLED_SPECULAR_TINT = 12u;
const uint PRINCIPLED_ANISOTROPIC = 13u;
const uint PRINCIPLED_ROTATION = 14u;
const uint PRINCIPLED_TANGENT = 15u;
const uint PRINCIPLED_TRANSMISSION = 16u;
const uint PRINCIPLED_COAT = 17u;
const uint PRINCIPLED_COAT_ROUGHNESS = 18u;
const uint PRINCIPLED_COAT_IOR = 19u;
const uint PRINCIPLED_COAT_TINT = 20u;
const uint PRINCIPLED_COAT_NORMAL = 21u;
const uint PRINCIPLED_SHEEN = 22u;
const uint PRINCIPLED_SHEEN_ROUGHNESS = 23u;
const uint PRINCIPLED_SHEEN_TINT = 24u;
const uint PRINCIPLED_EMISSION = 25u;
const uint PRINCIPLED_FILM_THICKNESS = 26u;
const uint PRINCIPLED_FILM_IOR = 27u;
const uint PRINCIPLED_THIN_WALL = 28u;
const uint PRINCIPLED_ALPHA = 29u;
const uint PRINCIPLED_ARGUMENTS = 30u;

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// The record of one lobe at a shading point, toward one viewer: what every kind of lobe in this folder fills in.
// What the kinds do is told in their own files; lobe.h calls them by kind.
#ifndef COTORRA_LOBE_TYPES_H
#define COTORRA_LOBE_TYPES_H

#include "../bsdf.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint LOBE_NONE = 0u;
const uint LOBE_DIFFUSE = 1u;
const uint LOBE_TRANSLUCENT = 2u;
const uint LOBE_REFLECTION = 3u;         // microfacets that reflect
const uint LOBE_GLASS = 4u;              // microfacets that reflect and refract
const uint LOBE_REFRACTION = 5u;         // microfacets that refract
const uint LOBE_THIN_TRANSMISSION = 6u;  // what a thin wall lets through: a reflection, mirrored to the other side
const uint LOBE_ASHIKHMIN_SHIRLEY = 7u;
const uint LOBE_SHEEN = 8u;
const uint LOBE_VELVET = 9u;
const uint LOBE_TOON_DIFFUSE = 10u;
const uint LOBE_TOON_GLOSSY = 11u;

// Lobe.mode: Fresnel term, and distribution of normals.
const uint LOBE_FRESNEL = 3u;             // mask of the following
const uint LOBE_FRESNEL_NONE = 0u;        // all is reflected, or all that can be is refracted
const uint LOBE_FRESNEL_F82 = 1u;
const uint LOBE_FRESNEL_CONDUCTOR = 2u;
const uint LOBE_FRESNEL_DIELECTRIC = 3u;  // the curve of eta, drawn between f0 and 1
const uint LOBE_BECKMANN = 4u;            // else GGX

// Distributions, as closures name them.
const uint CLOSURE_GGX = 0u;
const uint CLOSURE_MULTI_GGX = 1u;  // GGX whose energy is preserved
const uint CLOSURE_BECKMANN = 2u;
const uint CLOSURE_ASHIKHMIN_SHIRLEY = 3u;

struct Lobe {
  vec3 weight;     // factor of f; of microfacets with multiple scattering
  uint kind;       // LOBE_*
  vec3 n;          // normal, on the viewer's side
  uint mode;       // LOBE_FRESNEL_*, LOBE_BECKMANN
  vec3 t;          // microfacets: tangent along which alpha_x is, any length; sheen: toward the viewer
  float alpha_x;   // microfacets; Oren-Nayar: A; sheen: A of the LTC; velvet: 1 / sigma^2; toon: size, radians
  vec3 f0;         // F toward the normal; conductor: n; Oren-Nayar: multiple scattering toward the viewer
  float alpha_y;   // microfacets; Oren-Nayar: B; sheen: B of the LTC; toon: smooth, radians
  vec3 f1;         // F82: edge coefficient; conductor: k; dielectric: factor of what is reflected
  float eta;       // index of refraction behind the surface over that on the viewer's side
  vec3 tint;       // factor of what is transmitted
  float single;    // albedo for F = 1 without multiple scattering
  float film;      // thickness of a thin film, nm; 0: none
  float film_eta;  // its index of refraction, over that on the viewer's side
};

// A lobe that does nothing.
FN void lobe_clear(uint kind, vec3 weight, vec3 n, OUT(Lobe) l) {
  l.weight = max(weight, vec3(0.0f));
  l.kind = kind;
  l.n = n;
  l.mode = LOBE_FRESNEL_NONE;
  l.t = vec3(0.0f);
  l.alpha_x = 1.0f;
  l.f0 = vec3(0.0f);
  l.alpha_y = 1.0f;
  l.f1 = vec3(1.0f);
  l.eta = 1.0f;
  l.tint = vec3(0.0f);
  l.single = 1.0f;
  l.film = 0.0f;
  l.film_eta = 1.0f;
}

// A sample that is none.
FN void sample_clear(OUT(BsdfSample) s) {
  s.wi = vec3(0.0f, 0.0f, 1.0f);
  s.pdf = 0.0f;
  s.weight = vec3(0.0f);
  s.lobe = BSDF_DIFFUSE;
}

FN float mean_component(vec3 a) { return (a.x + a.y + a.z) * (1.0f / 3.0f); }

// Does the lobe send light through the surface?
FN bool lobe_transmits(IN(Lobe) l) {
  return l.kind == LOBE_TRANSLUCENT || l.kind == LOBE_GLASS || l.kind == LOBE_REFRACTION ||
         l.kind == LOBE_THIN_TRANSMISSION;
}

#ifdef __cplusplus
static_assert(sizeof(Lobe) == 104);
}  // namespace cotorra
#endif

#endif

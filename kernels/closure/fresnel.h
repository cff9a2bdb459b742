// SPDX-License-Identifier: GPL-3.0-or-later
// What a facet of a lobe reflects and lets through: Fresnel's terms, bare or under a thin film.
// One interface and the film's interference are physics; what artists' parameters make of them is Cycles'.
#ifndef COTORRA_CLOSURE_FRESNEL_H
#define COTORRA_CLOSURE_FRESNEL_H

#include "../model_microfacet.h"
#include "lobe_tables.h"
#include "lobe_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Films thinner than this, in nm, are none (Cycles).
const float FILM_CUTOFF = 0.1f;

// ---- Complex numbers: x + i y

FN vec2 complex_multiply(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

// (a - b) / (a + b): its squared magnitude, and its phase as a unit vector.
FN float amplitude(vec2 a, vec2 b, OUT(vec2) phase) {
  const vec2 sum = a + b;
  const vec2 d = a - b;
  const vec2 r = vec2(d.x * sum.x + d.y * sum.y, d.y * sum.x - d.x * sum.y);
  const float length2 = dot(r, r);
  phase = length2 > 1e-30f ? r * (1.0f / sqrt(length2)) : vec2(1.0f, 0.0f);
  return dot(d, d) / max(dot(sum, sum), 1e-20f);
}

// One interface from index `eta` to n + i k at cosine c > 0 (Born & Wolf, sec. 14.4.1): reflectance and phase of both
// polarisations, perpendicular (s) and parallel (p) to the plane. Returns eta_t cos_t of the real part behind it.
FN float interface_reflection(float c, float eta, float n, float k, OUT(vec2) reflectance, OUT(vec2) phase_s,
                              OUT(vec2) phase_p) {
  const vec2 index2 = vec2((n - k) * (n + k), 2.0f * n * k);
  // The root u + i v of index^2 - eta^2 sin^2.
  const float re = index2.x - eta * eta * max(1.0f - c * c, 0.0f);
  const float size = sqrt(re * re + index2.y * index2.y);
  const vec2 root = vec2(sqrt(max(0.5f * (size + re), 0.0f)), sqrt(max(0.5f * (size - re), 0.0f)));
  reflectance.x = amplitude(vec2(eta * c, 0.0f), root, phase_s);
  reflectance.y = amplitude(index2 * c, root * eta, phase_p);
  return root.x;
}

// ---- A thin film (Belcour & Barla 2017): the series of beams that leave it, each a colour by the mean of its phase.

// Equations 9 and 10 for one polarisation and channel: r12 and r23 of the film's two sides, `phase` that both turn the
// light by. Beams of higher order than the third hardly show.
FN float film_series(FloatBuffer table, uint channel, float r12, float r23, float path_difference, vec2 phase) {
  const float t121 = 1.0f - r12;
  const float loop = r12 * r23;
  const float direct = t121 * t121 * r23 / max(1.0f - loop, 1e-6f);
  float sum = r12 + direct;
  float term = direct - t121;
  vec2 turned = phase;
  for (uint m = 1u; m <= 3u; ++m) {
    term *= sqrt(loop);
    const vec2 s = table_film(table, channel, float(int(m)) * path_difference);
    sum += 2.0f * term * (turned.x * s.x - turned.y * s.y);
    turned = complex_multiply(turned, phase);
  }
  return sum;
}

// F82 of given values toward the normal and at c = 1/7.
FN float F_82(float f0, float f82, float c) {
  const float w = F_SchlickWeight(1.0f / 7.0f);
  const float edge = (f0 + (1.0f - f0) * w - f82) * (49.0f / (6.0f * w));
  const float s = F_SchlickWeight(c);
  return clamp(f0 + (1.0f - f0) * s - edge * (c * s * (1.0f - c)), 0.0f, 1.0f);
}

// Reflectance of a film on n + i k in one channel. f82 >= 0: the substrate reflects as F82 says, and n and k only turn
// the phase.
FN float film_reflectance(FloatBuffer table, uint channel, float thickness, float film, float n, float k, float f82,
                          float c) {
  // Below 1 nm waves say nothing: the film fades out.
  const float eta = thickness < 1.0f ? mix(1.0f, film, smoothstep01(thickness)) : film;
  vec2 r12;
  vec2 r23;
  vec2 s12;
  vec2 p12;
  vec2 s23;
  vec2 p23;
  const float inside = interface_reflection(c, 1.0f, eta, 0.0f, r12, s12, p12);
  if (!(inside > 0.0f)) return 1.0f;
  const float c_film = min(inside / eta, 1.0f);
  interface_reflection(c_film, eta, n, k, r23, s23, p23);
  if (f82 >= 0.0f) {
    const float f0 = (sqr(n - eta) + k * k) / (sqr(n + eta) + k * k);
    r23 = vec2(F_82(f0, f82, c_film));
  }
  // A reflection back into the film turns as the one into it does, and half a turn more.
  const float path_difference = 2.0f * inside * thickness;
  const float s = film_series(table, channel, r12.x, r23.x, path_difference, s23 * -sign(s12.x));
  const float p = film_series(table, channel, r12.y, r23.y, path_difference, p23 * -sign(p12.x));
  return clamp(0.5f * (s + p), 0.0f, 1.0f);
}

// n and k of a metal with reflectance f0 toward the normal and f82 at its edge (Gulbrandsen 2014).
FN vec2 conductor_of_colors(float f0, float f82) {
  const float r = min(f0, 0.999f);
  const float root = sqrt(r);
  const float n = mix((1.0f + root) / (1.0f - root), (1.0f - r) / (1.0f + r), f82);
  return vec2(n, sqrt(max((r * sqr(n + 1.0f) - sqr(n - 1.0f)) / (1.0f - r), 0.0f)));
}

// One channel of what a facet under a film reflects.
FN float lobe_film_channel(FloatBuffer table, IN(Lobe) l, uint channel, float f0, float f1, float c) {
  const uint fresnel = l.mode & LOBE_FRESNEL;
  if (fresnel == LOBE_FRESNEL_CONDUCTOR) {
    return film_reflectance(table, channel, l.film, l.film_eta, f0, f1, -1.0f, c);
  }
  if (fresnel == LOBE_FRESNEL_F82) {
    const float edge = clamp(F_Schlick82(vec3(f0), vec3(1.0f - f0), vec3(f1), 1.0f / 7.0f).x, 0.0f, 1.0f);
    const vec2 metal = conductor_of_colors(f0, edge);
    return film_reflectance(table, channel, l.film, l.film_eta, metal.x, metal.y, edge, c);
  }
  // The user's F0 scales the film's colour as far as it is away from total reflection (Cycles; there is no physics in
  // it).
  const float f = film_reflectance(table, channel, l.film, l.film_eta, l.eta, 0.0f, -1.0f, c);
  const float own = F0_from_ior(l.eta);
  if (own <= 1e-5f) return f;
  return f * mix(1.0f, f0 / own, clamp((1.0f - f) / max(1.0f - own, 1e-6f), 0.0f, 1.0f));
}

// ---- A facet of a lobe

// What is reflected and what is let through at cosine c > 0 between the facet and the viewer.
FN void lobe_fresnel(FloatBuffer table, IN(Lobe) l, float c, OUT(vec3) reflected, OUT(vec3) transmitted) {
  const uint fresnel = l.mode & LOBE_FRESNEL;
  transmitted = vec3(0.0f);
  if (fresnel == LOBE_FRESNEL_NONE) {
    const bool refracts = l.kind == LOBE_REFRACTION;
    const float inside = l.eta * l.eta - 1.0f + c * c;  // at most 0: total reflection
    reflected = vec3(refracts ? 0.0f : 1.0f);
    if (refracts && inside > 0.0f) transmitted = vec3(1.0f);
    return;
  }
  vec3 f;
  if (l.film > FILM_CUTOFF) {
    f = vec3(lobe_film_channel(table, l, 0u, l.f0.x, l.f1.x, c), lobe_film_channel(table, l, 1u, l.f0.y, l.f1.y, c),
             lobe_film_channel(table, l, 2u, l.f0.z, l.f1.z, c));
  } else if (fresnel == LOBE_FRESNEL_CONDUCTOR) {
    f = vec3(F_Conductor(c, l.f0.x, l.f1.x), F_Conductor(c, l.f0.y, l.f1.y), F_Conductor(c, l.f0.z, l.f1.z));
  } else if (fresnel == LOBE_FRESNEL_F82) {
    f = min(F_Schlick82(l.f0, 1.0f - l.f0, l.f1, c), vec3(1.0f));
  } else {
    const float own = F0_from_ior(l.eta);
    const float s = clamp((F_Dielectric(c, c * c, l.eta) - own) / max(1.0f - own, 1e-6f), 0.0f, 1.0f);
    f = l.f0 + (1.0f - l.f0) * s;
  }
  reflected = f;
  if (fresnel != LOBE_FRESNEL_DIELECTRIC) return;
  reflected = f * l.f1;
  // A tint may make a film reflect more than all.
  if (l.kind == LOBE_GLASS) transmitted = max(1.0f - f, vec3(0.0f)) * l.tint;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Sampling of half vectors and lobes for the reflection models; that of GGX is in microfacet.h.
// Local frames: z is the normal. The densities stand beside the terms that they are made of.
#ifndef COTORRA_MODEL_HALF_VECTORS_H
#define COTORRA_MODEL_HALF_VECTORS_H

#include "model_microfacet.h"
#include "sampling.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Squared radius on the unit disk, kept clear of 0 and 1.
FN float disk_r2(vec2 disk) { return clamp(dot(disk, disk), 1e-20f, 0.99999994f); }

// A direction about +z with density (e + 1) / (2 pi) cos^e: cos^(e + 1) is uniform.
FN vec3 power_lobe(vec2 disk, float e) {
  const float r2 = disk_r2(disk);
  const float x = one_minus_exp(-log_one_minus(r2) / (e + 1.0f));  // 1 - cos
  const float spread = sqrt(x * (2.0f - x) / r2);
  return vec3(disk.x * spread, disk.y * spread, 1.0f - x);
}

// A half vector, of any length, with density D nh.
FN vec3 half_vector_distribution(uint distribution, vec2 disk, float alpha) {
  const float r2 = disk_r2(disk);
  const float log1m = -log_one_minus(r2);
  float tan2 = sqr(alpha) * log1m;  // Beckmann
  if (distribution == DISTRIBUTION_GGX) tan2 = sqr(alpha) * r2 / (1.0f - r2);
  if (distribution == DISTRIBUTION_BLINN_PHONG) {
    const float sin2 = one_minus_exp(sqr(alpha) * log1m);
    tan2 = sin2 / max(1.0f - sin2, 1e-12f);
  }
  const float spread = sqrt(tan2 / r2);
  return vec3(disk.x * spread, disk.y * spread, 1.0f);
}

// A half vector that the viewer o_local sees of V-cavities (Heitz & d'Eon 2014, sec. 4): one side of a cavity, or its
// other side, in proportion to how much of each is seen. Density D G1(o) oh / no; works for every D.
FN vec3 half_vector_cavity(uint distribution, vec3 o_local, vec2 disk, float u_side, float alpha) {
  const vec3 h = half_vector_distribution(distribution, disk, alpha);
  const float along = o_local.x * h.x + o_local.y * h.y;
  const float here = max(o_local.z + along, 0.0f);
  const float there = max(o_local.z - along, 0.0f);
  const bool turn = u_side * (here + there) >= here;
  return vec3(select(turn, -h.x, h.x), select(turn, -h.y, h.y), 1.0f);
}

// The x of the density (c - s x) exp(-x^2), x <= c / s, by its cumulated share u: Newton's steps, and where one would
// leave the bracket, halving. The slopes toward a viewer at cosine c and sine s on a Beckmann surface of alpha 1 lie so
// (Heitz & d'Eon 2014, appendix); with c = 1, s = 0 it is the inverse of the error function.
FN float visible_slope_Beckmann(float c, float s, float u) {
  float low = -5.0f;
  float high = min(c / max(s, 1e-6f), 5.0f);
  // The integral up to x is c sqrt(pi) erfc(-x) / 2 + s exp(-x^2) / 2.
  const float e_high = exp_lanes(-high * high);
  const float target = u * (0.886226925f * c * (2.0f - e_high * erfc_scaled(high)) + 0.5f * s * e_high);
  // A first guess: a logistic curve in place of the error function.
  float x = clamp(0.415f * (log_lanes(max(u, 1e-7f)) - log_one_minus(u)), low, high);
  for (uint i = 0u; i < 10u; ++i) {
    const float e = exp_lanes(-x * x);
    const float tail = e * erfc_scaled(abs(x));
    const float value = 0.886226925f * c * select(x < 0.0f, tail, 2.0f - tail) + 0.5f * s * e - target;
    low = select(value < 0.0f, x, low);
    high = select(value < 0.0f, high, x);
    const float step = x - value / max((c - s * x) * e, 1e-20f);
    x = select(step >= low && step <= high, step, 0.5f * (low + high));
  }
  return x;
}

// A half vector, of any length, that the viewer o_local sees of a Beckmann surface by Smith's model.
FN vec3 half_vector_Beckmann(vec3 o_local, float alpha, vec2 u) {
  // 1. To a surface of alpha 1.
  const vec3 v = normalize(vec3(alpha * o_local.x, alpha * o_local.y, o_local.z));
  const float s2 = v.x * v.x + v.y * v.y;
  const float s = sqrt(s2);
  // 2. A slope toward the viewer and one across, turned to the viewer's azimuth.
  const float along = visible_slope_Beckmann(v.z, s, u.x);
  const float across = visible_slope_Beckmann(1.0f, 0.0f, u.y);
  const float cos_phi = select(s2 > 0.0f, v.x / max(s, 1e-20f), 1.0f);
  const float sin_phi = select(s2 > 0.0f, v.y / max(s, 1e-20f), 0.0f);
  // 3. Back.
  return vec3(-alpha * (cos_phi * along - sin_phi * across), -alpha * (sin_phi * along + cos_phi * across), 1.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

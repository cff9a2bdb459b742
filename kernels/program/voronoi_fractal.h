// SPDX-License-Identifier: GPL-3.0-or-later
// Octaves of Worley's cells, and the ops voronoi_f and voronoi_v. An octave is a step of its own, as in
// noise_fractal.h. What an octave is, is in voronoi.h.
#ifndef COTORRA_PROGRAM_VORONOI_FRACTAL_H
#define COTORRA_PROGRAM_VORONOI_FRACTAL_H

#include "noise_fractal.h"
#include "voronoi.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint VORONOI_NORMALIZE = 2048u;  // bit of the mode

FN uint voronoi_dimensions(uint mode) { return (mode & 3u) + 1u; }
FN uint voronoi_feature(uint mode) { return (mode >> 2) & 7u; }
FN uint voronoi_metric(uint mode) { return (mode >> 5) & 3u; }
FN uint voronoi_output(uint mode) { return (mode >> 8) & 7u; }

// Arguments of the node within their bounds.
struct VoronoiInputs {
  float scale;
  float detail;
  float roughness;
  float lacunarity;
  float smoothness;
  float exponent;
  float randomness;
  float largest;  // distance that normalising divides by
};

struct VoronoiFractal {
  float distance;
  vec3 color;
  vec4 position;
  float amplitude;
  float frequency;
  float total;
};

FN float voronoi_largest(uint mode, float exponent, float randomness) {
  const uint dimensions = voronoi_dimensions(mode);
  const uint feature = voronoi_feature(mode);
  const float side = 0.5f + 0.5f * randomness;
  if (feature == VORONOI_EDGE) return side;
  const vec4 corner =
      vec4(side, dimensions > 1u ? side : 0.0f, dimensions > 2u ? side : 0.0f, dimensions > 3u ? side : 0.0f);
  const float largest = voronoi_distance(dimensions, voronoi_metric(mode), exponent, corner);
  return feature == VORONOI_F2 ? 2.0f * largest : largest;
}

FN VoronoiInputs voronoi_inputs(uint mode, float scale, float detail, float roughness, float lacunarity,
                                float smoothness, float exponent, float randomness) {
  VoronoiInputs i;
  i.scale = scale;
  i.detail = noise_detail(detail);
  i.roughness = saturate(roughness);
  i.lacunarity = lacunarity;
  i.smoothness = clamp(0.5f * smoothness, 0.0f, 0.5f);
  i.exponent = exponent;
  i.randomness = saturate(randomness);
  i.largest = voronoi_largest(mode, exponent, i.randomness);
  return i;
}

FN VoronoiFractal voronoi_begin(uint mode, IN(VoronoiInputs) i) {
  VoronoiFractal s;
  const bool edge = voronoi_feature(mode) == VORONOI_EDGE;
  s.distance = edge ? 8.0f : 0.0f;  // farther than any edge
  s.color = vec3(0.0f, 0.0f, 0.0f);
  s.position = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  s.amplitude = 1.0f;
  s.frequency = 1.0f;
  s.total = edge ? i.largest : 0.0f;
  return s;
}

// The point of an octave, at coordinates that are multiplied by its frequency already.
FN VoronoiPoint voronoi_find(uint mode, IN(VoronoiInputs) i, vec4 p) {
  const uint dimensions = voronoi_dimensions(mode);
  const uint feature = voronoi_feature(mode);
  const uint metric = voronoi_metric(mode);
  if (feature == VORONOI_SMOOTH_F1 && i.smoothness != 0.0f) {
    return voronoi_smooth(dimensions, metric, i.exponent, i.randomness, i.smoothness, p);
  }
  return voronoi_ranked(feature, dimensions, metric, i.exponent, i.randomness, p);
}

// Adds what an octave found: of VORONOI_EDGE its distance alone counts.
FN void voronoi_step(uint mode, IN(VoronoiInputs) i, int octave, IN(VoronoiPoint) found, INOUT(VoronoiFractal) s) {
  const float share = octave_share(i.detail, octave) * s.amplitude;
  if (voronoi_feature(mode) == VORONOI_EDGE) {
    s.total = lerp(s.total, safe_divide(i.largest, s.frequency), share);
    s.distance = lerp(s.distance, min(s.distance, safe_divide(found.distance, s.frequency)), share);
  } else {
    s.total += share;
    s.distance += found.distance * share;
    s.color = s.color + found.color * share;
    s.position = s.position + (found.position * safe_divide(1.0f, s.frequency) - s.position) * share;
  }
  s.frequency *= i.lacunarity;
  s.amplitude *= i.roughness;
}

FN void voronoi_octave(uint mode, IN(VoronoiInputs) i, vec4 p, int octave, INOUT(VoronoiFractal) s) {
  VoronoiPoint found;
  if (voronoi_feature(mode) == VORONOI_EDGE) {
    found = voronoi_point_zero();
    found.distance = voronoi_edge(voronoi_dimensions(mode), i.randomness, p * s.frequency);
  } else {
    found = voronoi_find(mode, i, p * s.frequency);
  }
  voronoi_step(mode, i, octave, found, s);
}

FN float voronoi_end_distance(uint mode, IN(VoronoiInputs) i, IN(VoronoiFractal) s) {
  if ((mode & VORONOI_NORMALIZE) == 0u) return s.distance;
  return safe_divide(s.distance, voronoi_feature(mode) == VORONOI_EDGE ? s.total : s.total * i.largest);
}

// x, y, z, w in the coordinates that the node was given. One dimension is w.
FN vec4 voronoi_end_position(uint mode, IN(VoronoiInputs) i, IN(VoronoiFractal) s) {
  const uint dimensions = voronoi_dimensions(mode);
  const vec4 p = s.position * safe_divide(1.0f, i.scale);
  if (dimensions == 1u) return vec4(0.0f, 0.0f, 0.0f, p.x);
  return vec4(p.x, p.y, dimensions > 2u ? p.z : 0.0f, dimensions > 3u ? p.w : 0.0f);
}

// What voronoi_f and voronoi_v give after the last octave, by the output that the mode names.
FN float voronoi_end_number(uint mode, IN(VoronoiInputs) i, IN(VoronoiFractal) s) {
  return voronoi_output(mode) == 0u ? voronoi_end_distance(mode, i, s) : voronoi_end_position(mode, i, s).w;
}
FN vec3 voronoi_end_vector(uint mode, IN(VoronoiInputs) i, IN(VoronoiFractal) s) {
  if (voronoi_output(mode) == 0u) {
    return (mode & VORONOI_NORMALIZE) == 0u ? s.color : s.color * safe_divide(1.0f, s.total);
  }
  const vec4 at = voronoi_end_position(mode, i, s);
  return vec3(at.x, at.y, at.z);
}

FN VoronoiFractal voronoi_fractal(uint mode, IN(VoronoiInputs) i, vec4 p) {
  VoronoiFractal s = voronoi_begin(mode, i);
  const int octaves = fractal_octaves(i.detail);
  for (int octave = 0; octave < octaves; ++octave) voronoi_octave(mode, i, p, octave, s);
  return s;
}

// Beyond the dimensions in use coordinates are 0. One dimension is w alone.
FN vec4 voronoi_coordinates(uint dimensions, vec3 vector, float w, float scale) {
  const vec4 p = noise_coordinates(dimensions, vector, w, scale);
  return vec4(p.x, p.y, dimensions == 3u || dimensions == 4u ? p.z : 0.0f, dimensions == 4u ? p.w : 0.0f);
}

FN float op_voronoi_f(uint mode, vec3 vector, float w, float scale, float detail, float roughness, float lacunarity,
                      float smoothness, float exponent, float randomness) {
  const uint feature = voronoi_feature(mode);
  const uint output_kind = voronoi_output(mode);
  // Each feature has outputs of its own; the others are 0.
  if ((feature == VORONOI_N_SPHERE) != (output_kind == 2u)) return 0.0f;
  if (feature == VORONOI_EDGE && output_kind != 0u) return 0.0f;
  const VoronoiInputs i = voronoi_inputs(mode, scale, detail, roughness, lacunarity, smoothness, exponent, randomness);
  const vec4 p = voronoi_coordinates(voronoi_dimensions(mode), vector, w, scale);
  if (feature == VORONOI_N_SPHERE) return voronoi_n_sphere(voronoi_dimensions(mode), i.randomness, p);
  return voronoi_end_number(mode, i, voronoi_fractal(mode, i, p));
}

FN vec3 op_voronoi_v(uint mode, vec3 vector, float w, float scale, float detail, float roughness, float lacunarity,
                     float smoothness, float exponent, float randomness) {
  if (voronoi_feature(mode) >= VORONOI_EDGE) return vec3(0.0f, 0.0f, 0.0f);
  const VoronoiInputs i = voronoi_inputs(mode, scale, detail, roughness, lacunarity, smoothness, exponent, randomness);
  const vec4 p = voronoi_coordinates(voronoi_dimensions(mode), vector, w, scale);
  return voronoi_end_vector(mode, i, voronoi_fractal(mode, i, p));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

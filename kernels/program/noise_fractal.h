// SPDX-License-Identifier: GPL-3.0-or-later
// Sums and products of octaves of noise (Musgrave, in Ebert et al., Texturing and Modeling, 2003), and the ops noise_f
// and noise_v. An octave is a step of its own, so that a loop over lanes can stand inside the loop over octaves.
#ifndef COTORRA_PROGRAM_NOISE_FRACTAL_H
#define COTORRA_PROGRAM_NOISE_FRACTAL_H

#include "noise.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint NOISE_MULTIFRACTAL = 0u;
const uint NOISE_RIDGED_MULTIFRACTAL = 1u;
const uint NOISE_HYBRID_MULTIFRACTAL = 2u;
const uint NOISE_FBM = 3u;
const uint NOISE_HETERO_TERRAIN = 4u;
const uint NOISE_NORMALIZE = 32u;  // bit of the mode; of NOISE_FBM only

const float NOISE_MAX_DETAIL = 15.0f;

FN uint noise_dimensions(uint mode) { return (mode & 3u) + 1u; }
FN uint noise_type(uint mode) { return (mode >> 2) & 7u; }

// What the octaves of one point have in common.
struct FractalInputs {
  float detail;  // octaves beyond the first, a fraction included
  float roughness;
  float lacunarity;
  float offset;
  float gain;
};

// What was summed up so far.
struct Fractal {
  vec4 p;  // coordinates of the next octave; of NOISE_FBM: of the first
  float value;
  float amplitude;
  float frequency;
  float total;    // NOISE_FBM: sum of amplitudes
  float partial;  // NOISE_FBM: what an octave adds that counts by a fraction; ridged: the last signal
  float weight;   // hybrid: of the next octave
};

// Octaves beyond the first within their bounds; 0 where they are no number.
FN float noise_detail(float detail) { return select(detail > 0.0f, min(detail, NOISE_MAX_DETAIL), 0.0f); }

FN FractalInputs fractal_inputs(float detail, float roughness, float lacunarity, float offset, float gain) {
  FractalInputs i;
  i.detail = noise_detail(detail);
  i.roughness = roughness;
  i.lacunarity = lacunarity;
  i.offset = offset;
  i.gain = gain;
  return i;
}

FN Fractal fractal_begin(vec4 p) {
  Fractal s;
  s.p = p;
  s.value = 0.0f;
  s.amplitude = 1.0f;
  s.frequency = 1.0f;
  s.total = 0.0f;
  s.partial = 0.0f;
  s.weight = 1.0f;
  return s;
}

// Number of steps that a point needs.
FN int fractal_octaves(float detail) { return int(ceil(noise_detail(detail))) + 1; }

// How much an octave counts: all, a fraction for the last one, nothing beyond.
FN float octave_share(float detail, int octave) {
  const float at = float(octave);
  return select(at <= detail, 1.0f, select(at < detail + 1.0f, detail - floor(detail), 0.0f));
}

// Adds noise n, as its share says, to the sum of the given type.
FN void fractal_add(uint type, IN(FractalInputs) i, int octave, float share, float n, INOUT(Fractal) s) {
  const float amplitude = s.amplitude;
  const float shifted = n + i.offset;
  if (PROGRAM_VARIANT(1u << (VARIANT_TYPES_SHIFT + NOISE_FBM)) && type == NOISE_FBM) {
    const float whole = select(share == 1.0f, 1.0f, 0.0f);
    s.value += whole * n * amplitude;
    s.total += whole * amplitude;
    s.partial = select(share == 1.0f, 0.0f, select(share > 0.0f, n * amplitude, s.partial));
  } else if (PROGRAM_VARIANT(1u << (VARIANT_TYPES_SHIFT + NOISE_MULTIFRACTAL)) && type == NOISE_MULTIFRACTAL) {
    s.value = select(octave == 0, 1.0f, s.value) * (share * amplitude * n + 1.0f);
  } else if (PROGRAM_VARIANT(1u << (VARIANT_TYPES_SHIFT + NOISE_HETERO_TERRAIN)) && type == NOISE_HETERO_TERRAIN) {
    s.value = select(octave == 0, shifted, s.value + share * (shifted * amplitude * s.value));
  } else if (type == NOISE_HYBRID_MULTIFRACTAL) {
    const bool counts = s.weight > 0.001f;
    const float weight = min(s.weight, 1.0f);
    const float signal = shifted * amplitude;
    s.value += select(counts, share * weight * signal, 0.0f);
    s.weight = select(counts, weight * (i.gain * signal), s.weight);
  } else {
    const float ridge = i.offset - abs(n);
    const float signal = ridge * ridge * select(octave == 0, 1.0f, saturate(s.partial * i.gain));
    s.value += select(share == 1.0f, signal * amplitude, 0.0f);
    s.partial = signal;
  }
}

// Where the next octave reads the noise.
FN vec4 fractal_position(uint type, IN(Fractal) s) { return type == NOISE_FBM ? s.p * s.frequency : s.p; }

// Adds an octave whose noise is n, and goes on to the next one.
FN void fractal_step(uint type, IN(FractalInputs) i, int octave, float n, INOUT(Fractal) s) {
  const float share = octave_share(i.detail, octave);
  fractal_add(type, i, octave, share, n, s);
  const float more = select(share == 1.0f, 1.0f, 0.0f);
  s.amplitude = select(more > 0.0f, s.amplitude * i.roughness, s.amplitude);
  if (type == NOISE_FBM) {
    s.frequency *= i.lacunarity;
  } else {
    s.p = s.p * i.lacunarity;
  }
}

// One octave of the first `dimensions` components.
FN void fractal_octave(uint type, uint dimensions, IN(FractalInputs) i, int octave, INOUT(Fractal) s) {
  fractal_step(type, i, octave, noise_signed(dimensions, fractal_position(type, s)), s);
}

// The value after the last octave.
FN float fractal_end(uint type, bool normalized, IN(FractalInputs) i, IN(Fractal) s) {
  if (type != NOISE_FBM) return s.value;
  const float share = i.detail - floor(i.detail);
  const float next = s.value + s.partial;
  if (!normalized) return lerp(s.value, next, share);
  const float a = 0.5f * safe_divide(s.value, s.total) + 0.5f;
  const float b = 0.5f * safe_divide(next, s.total + s.amplitude) + 0.5f;
  return select(share != 0.0f, lerp(a, b, share), a);
}

FN float noise_fractal(uint type, uint dimensions, bool normalized, IN(FractalInputs) i, vec4 p) {
  Fractal s = fractal_begin(p);
  const int octaves = fractal_octaves(i.detail);
  for (int octave = 0; octave < octaves; ++octave) fractal_octave(type, dimensions, i, octave, s);
  return fractal_end(type, normalized, i, s);
}

// Where the texture node evaluates noise, before distortion. One dimension is w alone.
FN vec4 noise_coordinates(uint dimensions, vec3 vector, float w, float scale) {
  if (dimensions == 1u) return vec4(w * scale, 0.0f, 0.0f, 0.0f);
  return vec4(vector.x, vector.y, vector.z, w) * scale;
}

// 100 to 200, by a number: seeds are shifts of the coordinates.
FN float noise_shift(uint dimensions, float seed, float axis) {
  return 100.0f + 100.0f * (dimensions == 1u ? hash_float(seed) : hash_float2(seed, axis));
}

FN vec4 noise_seeded(uint dimensions, vec4 p, float seed) {
  return p + vec4(noise_shift(dimensions, seed, 0.0f), noise_shift(dimensions, seed, 1.0f),
                  noise_shift(dimensions, seed, 2.0f), noise_shift(dimensions, seed, 3.0f));
}

// The coordinates moved by noise along each axis; a distortion of 0 leaves them alone.
FN vec4 noise_distort(uint dimensions, vec4 p, float distortion) {
  float moved[4];
  moved[0] = p.x;
  moved[1] = p.y;
  moved[2] = p.z;
  moved[3] = p.w;
  UNROLL
  for (uint axis = 0u; axis < dimensions; ++axis) {
    moved[axis] += noise_signed(dimensions, noise_seeded(dimensions, p, float(int(axis)))) * distortion;
  }
  return vec4(moved[0], moved[1], moved[2], moved[3]);
}

// The texture's value is channel 0; a colour has two more, of other seeds.
FN vec4 noise_channel_position(uint dimensions, vec4 p, int channel) {
  const float seed = float(int(dimensions) + channel - 1);
  return channel == 0 ? p : noise_seeded(dimensions, p, seed);
}

FN float noise_channel(uint mode, IN(FractalInputs) i, vec4 p, int channel) {
  const uint dimensions = noise_dimensions(mode);
  const vec4 q = noise_channel_position(dimensions, p, channel);
  return noise_fractal(noise_type(mode), dimensions, (mode & NOISE_NORMALIZE) != 0u, i, q);
}

FN vec4 noise_position(uint mode, vec3 vector, float w, float scale, float distortion) {
  const vec4 p = noise_coordinates(noise_dimensions(mode), vector, w, scale);
  if (distortion == 0.0f) return p;
  return noise_distort(noise_dimensions(mode), p, distortion);
}

// Of the texture: roughness has a bound.
FN FractalInputs noise_inputs(float detail, float roughness, float lacunarity, float offset, float gain) {
  return fractal_inputs(detail, max(roughness, 0.0f), lacunarity, offset, gain);
}

FN float op_noise_f(uint mode, vec3 vector, float w, float scale, float detail, float roughness, float lacunarity,
                    float offset, float gain, float distortion) {
  const FractalInputs i = noise_inputs(detail, roughness, lacunarity, offset, gain);
  return noise_channel(mode, i, noise_position(mode, vector, w, scale, distortion), 0);
}

FN vec3 op_noise_v(uint mode, vec3 vector, float w, float scale, float detail, float roughness, float lacunarity,
                   float offset, float gain, float distortion) {
  const FractalInputs i = noise_inputs(detail, roughness, lacunarity, offset, gain);
  const vec4 p = noise_position(mode, vector, w, scale, distortion);
  float channels[3];
  for (int channel = 0; channel < 3; ++channel) channels[channel] = noise_channel(mode, i, p, channel);
  return vec3(channels[0], channels[1], channels[2]);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Sums of octaves of noise as loops over lanes inside the loop over octaves, of each type and in each dimension.
// Included by cpu_textures.cpp alone; what an octave is, is kernels/program/noise_fractal.h's.
#pragma once

#include <algorithm>
#include <functional>

#include "../kernels/program/noise_fractal.h"
#include "cpu_loops.h"

namespace cotorra {
namespace {

constexpr int kBlock = 256;  // lanes that go through all octaves together: what they keep stays in the nearest cache
struct alignas(64) BlockFloats {
  float v[kBlock];
  float &operator[](std::size_t i) { return v[i]; }
  const float &operator[](std::size_t i) const { return v[i]; }
};

struct PointLanes {
  BlockFloats x, y, z, w;

  template <uint kDimensions>
  vec4 get(std::size_t i) const {
    return {x[i], kDimensions > 1u ? y[i] : 0.0f, kDimensions > 2u ? z[i] : 0.0f, kDimensions > 3u ? w[i] : 0.0f};
  }
  template <uint kDimensions>
  void set(std::size_t i, vec4 p) {
    x[i] = p.x;
    if (kDimensions > 1u) y[i] = p.y;
    if (kDimensions > 2u) z[i] = p.z;
    if (kDimensions > 3u) w[i] = p.w;
  }
};

// FractalInputs and Fractal of the lanes.
struct FractalLanes {
  BlockFloats detail, roughness, lacunarity, offset, gain;
  PointLanes p;
  BlockFloats value, amplitude, frequency, total, partial, weight;
  BlockFloats noise;  // of the octave

  FractalInputs inputs(std::size_t i) const {
    FractalInputs in;
    in.detail = detail[i];
    in.roughness = roughness[i];
    in.lacunarity = lacunarity[i];
    in.offset = offset[i];
    in.gain = gain[i];
    return in;
  }
  void set_inputs(std::size_t i, const FractalInputs &in) {
    detail[i] = in.detail;
    roughness[i] = in.roughness;
    lacunarity[i] = in.lacunarity;
    offset[i] = in.offset;
    gain[i] = in.gain;
  }
  template <uint kDimensions>
  Fractal get(std::size_t i) const {
    Fractal s;
    s.p = p.get<kDimensions>(i);
    s.value = value[i];
    s.amplitude = amplitude[i];
    s.frequency = frequency[i];
    s.total = total[i];
    s.partial = partial[i];
    s.weight = weight[i];
    return s;
  }
  template <uint kDimensions>
  void set(std::size_t i, const Fractal &s) {
    p.set<kDimensions>(i, s.p);
    value[i] = s.value;
    amplitude[i] = s.amplitude;
    frequency[i] = s.frequency;
    total[i] = s.total;
    partial[i] = s.partial;
    weight[i] = s.weight;
  }
};

template <uint kDimensions>
struct NoiseBegin {
  COTORRA_LOOP void run(int channel, const PointLanes &p, int n, FractalLanes &s) {
    if (channel == 0) {
      COTORRA_EACH s.set<kDimensions>(i, fractal_begin(p.get<kDimensions>(i)));
    } else {
      COTORRA_EACH s.set<kDimensions>(
          i, fractal_begin(noise_channel_position(kDimensions, p.get<kDimensions>(i), channel)));
    }
  }
};

// The noise where the octave reads it. Of all types but NOISE_FBM the frequency stays 1: the point itself moves.
template <uint kDimensions>
COTORRA_LOOP void noise_octave(int n, FractalLanes &s) {
  COTORRA_EACH s.noise[i] = noise_signed(kDimensions, s.p.get<kDimensions>(i) * s.frequency[i]);
}

// The type in units, the dimensions less one in fives.
template <uint kMode>
struct FractalStep {
  COTORRA_LOOP void run(int octave, int n, FractalLanes &s) {
    constexpr uint dimensions = kMode / 5u + 1u;
    COTORRA_EACH {
      Fractal one = s.get<dimensions>(i);
      fractal_step(kMode % 5u, s.inputs(i), octave, s.noise[i], one);
      s.set<dimensions>(i, one);
    }
  }
};

// Of NOISE_FBM: as it is, or normalized.
template <uint kNormalized>
struct FractalEnd {
  COTORRA_LOOP void run(int n, const FractalLanes &s, float *out) {
    COTORRA_EACH out[i] = fractal_end(NOISE_FBM, kNormalized != 0u, s.inputs(i), s.get<1>(i));
  }
};

COTORRA_LOOP int most_octaves(const BlockFloats &detail, int n) {
  int most = 0;
  COTORRA_EACH most = std::max(most, fractal_octaves(detail[i]));
  return most;
}

// A channel of the noise at p, whose inputs are set; as many octaves as the lane that wants most.
template <uint kDimensions>
void noise_lanes(uint type, bool normalized, int channel, const PointLanes &p, int n, FractalLanes &s, float *out) {
  NoiseBegin<kDimensions>::run(channel, p, n, s);
  const int octaves = most_octaves(s.detail, n);
  for (int octave = 0; octave < octaves; ++octave) {
    noise_octave<kDimensions>(n, s);
    run_mode<FractalStep, 20>(type + 5u * (kDimensions - 1u), octave, n, std::ref(s));
  }
  if (type == NOISE_FBM) {
    run_mode<FractalEnd, 2>(uint{normalized}, n, std::cref(s), out);
  } else {
    std::copy_n(s.value.v, n, out);
  }
}

// ---- The ops noise_f and noise_v

template <uint kDimensions>
COTORRA_LOOP void begin_noise(Columns a, int n, PointLanes &p, FractalLanes &s) {
  COTORRA_EACH {
    p.set<kDimensions>(i, noise_coordinates(kDimensions, column_vector(a, 0, i), a[3][i], a[4][i]));
    s.set_inputs(i, noise_inputs(a[5][i], a[6][i], a[7][i], a[8][i], a[9][i]));
  }
}

// Where the noise that moves the points along an axis is read.
template <uint kDimensions>
COTORRA_LOOP void seed_noise(int axis, const PointLanes &p, int n, FractalLanes &s) {
  COTORRA_EACH {
    s.p.set<kDimensions>(i, noise_seeded(kDimensions, p.get<kDimensions>(i), float(axis)));
    s.frequency[i] = 1.0f;
  }
}

COTORRA_LOOP void move_along(const float *distortion, int n, const FractalLanes &s, float *coordinate) {
  COTORRA_EACH {
    const float moved = coordinate[i] + s.noise[i] * distortion[i];
    coordinate[i] = select(distortion[i] != 0.0f, moved, coordinate[i]);
  }
}

template <uint kDimensions>
void distort_noise(const float *distortion, int n, PointLanes &p, FractalLanes &s) {
  PointLanes moved = p;
  BlockFloats *const coordinates[] = {&moved.x, &moved.y, &moved.z, &moved.w};
  for (uint axis = 0; axis < kDimensions; ++axis) {
    seed_noise<kDimensions>(static_cast<int>(axis), p, n, s);
    noise_octave<kDimensions>(n, s);
    move_along(distortion, n, s, coordinates[axis]->v);
  }
  p = moved;
}

// By the dimensions less one: `channels` columns of the noise for a block.
template <uint kMode>
struct Noise {
  static void run(uint mode, int channels, Columns a, int n, Results out) {
    constexpr uint dimensions = kMode + 1u;
    PointLanes p;
    FractalLanes s;
    begin_noise<dimensions>(a, n, p, s);
    if (std::any_of(a[10], a[10] + n, [](float d) { return d != 0.0f; })) distort_noise<dimensions>(a[10], n, p, s);
    for (int channel = 0; channel < channels; ++channel) {
      noise_lanes<dimensions>(noise_type(mode), (mode & NOISE_NORMALIZE) != 0u, channel, p, n, s, out[channel]);
    }
  }
};

}  // namespace
}  // namespace cotorra

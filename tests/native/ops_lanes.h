// SPDX-License-Identifier: GPL-3.0-or-later
// Lanes of arguments, and ops of shading programs over them: the list that ops_lanes.cpp runs as loops over lanes and
// ops_bench.cpp lane by lane. The mode of an op is constant in its loop.
#pragma once

#include <cstdint>

namespace cotorra {
constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu;
}
#include "program/pure.h"

constexpr int LANES = 1024;

struct Lanes {
  float x[LANES], y[LANES], z[LANES];  // coordinates
  float a[LANES], b[LANES], c[LANES];  // in 0 ... 1
  float scale[LANES], detail[LANES];
  float out[LANES];
};

// Runs the op with a number in the list over all lanes.
void run_lanes(int op, Lanes &lanes);

#define P vec3(lanes.x[i], lanes.y[i], lanes.z[i])
#define Q vec3(lanes.a[i], lanes.b[i], lanes.c[i])
#define SCALE lanes.scale[i]
#define FBM (2u | (NOISE_FBM << 2) | NOISE_NORMALIZE)
#define OPS(ROW)                                                                                                       \
  ROW(math_add, op_math(0u, lanes.a[i], lanes.b[i], 0.0f))                                                             \
  ROW(math_wrap, op_math(34u, lanes.x[i], lanes.b[i], lanes.a[i]))                                                     \
  ROW(math_power, op_math(10u, lanes.a[i], lanes.b[i], 0.0f))                                                          \
  ROW(math_sine, op_math(4u, lanes.x[i], 0.0f, 0.0f))                                                                  \
  ROW(normalize, op_vector_math_v(11u, P, P, P, 1.0f).x)                                                               \
  ROW(map_range, op_map_range_f(256u, lanes.a[i], 0.2f, 0.7f, 1.0f, 3.0f, 4.0f))                                       \
  ROW(mapping, op_mapping(0u, P, Q, Q, P).x)                                                                           \
  ROW(mix_overlay, op_mix_color(9u | MIX_CLAMP_FACTOR, lanes.a[i], Q, P).x)                                            \
  ROW(mix_hue, op_mix_color(12u, lanes.a[i], Q, P).x)                                                                  \
  ROW(hsv, op_hsv(0u, lanes.a[i], lanes.b[i], 1.0f, 1.0f, Q).x)                                                        \
  ROW(white_noise, op_white_noise_f(2u, P, 0.0f))                                                                      \
  ROW(noise_1_octave, op_noise_f(FBM, P, 0.0f, SCALE, 0.0f, 0.5f, 2.0f, 0.0f, 0.0f, 0.0f))                             \
  ROW(wave, op_wave_f(0u, P, SCALE, 0.0f, 2.0f, 1.0f, 0.5f, 0.0f))                                                     \
  ROW(magic, op_magic_v(2u, P, SCALE, 1.0f).x)                                                                         \
  ROW(gradient, op_gradient_f(6u, P))                                                                                  \
  ROW(checker, op_checker_f(0u, P, SCALE))                                                                             \
  ROW(brick, op_brick_f(514u, P, SCALE, 0.02f, 0.1f, 0.0f, 0.5f, 0.25f, 0.5f, 1.0f).x)                                 \
  ROW(voronoi_f1, op_voronoi_f(2u, P, 0.0f, SCALE, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f))                                \
  ROW(voronoi_edge, op_voronoi_f(2u | (VORONOI_EDGE << 2), P, 0.0f, SCALE, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f))        \
  ROW(voronoi_smooth, op_voronoi_f(2u | (VORONOI_SMOOTH_F1 << 2), P, 0.0f, SCALE, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f)) \
  ROW(separate_hsl, op_separate_color(2u, Q).x)                                                                        \
  ROW(voronoi_2d, op_voronoi_f(1u, P, 0.0f, SCALE, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f))                                \
  ROW(white_noise_v, op_white_noise_v(3u, P, 0.0f).y)                                                                  \
  ROW(blackbody, op_blackbody(0u, 9000.0f * lanes.a[i]).y)                                                             \
  ROW(radial_tiling, op_radial_tiling_v(0u, P, 5.0f, 0.3f).x)

// Those whose lanes are a loop inside another one, over octaves or impulses.
#define STEPPED_OPS(ROW)                                                                     \
  ROW(noise, op_noise_f(FBM, P, 0.0f, SCALE, lanes.detail[i], 0.5f, 2.0f, 0.0f, 0.0f, 0.0f)) \
  ROW(gabor, op_gabor_f(0u, P, SCALE, 2.0f, 1.0f, 0.7f, P))

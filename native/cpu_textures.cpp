// SPDX-License-Identifier: GPL-3.0-or-later
// Procedural textures as loops over lanes. The mode is constant in a loop, or decides between loops.
// Formulas are those of kernels/program/; other ops are cpu_ops.h's.
#include <algorithm>
#include <cstdint>
#include <functional>

#include "every_feature.h"

#define PROGRAM_LANES  // inner loops of a few rounds are unrolled

#include "../kernels/program/ops.h"
#include "../kernels/program/patterns.h"
#include "cpu_loops.h"
#include "cpu_voronoi.h"

namespace cotorra {
namespace {

// ---- Waves: noise of their own bends them

template <uint kMode>
struct WaveAngle {
  COTORRA_LOOP void run(Columns a, int n, float *angle) {
    COTORRA_EACH angle[i] = wave_angle(kMode, off_the_border(column_vector(a, 0, i) * a[3][i])) + a[8][i];
  }
};
template <uint kProfile>
struct WaveProfile {
  COTORRA_LOOP void run(Columns a, const float *angle, const float *noise, int n, float *out) {
    COTORRA_EACH out[i] = wave_bent(kProfile << 5, angle[i], a[4][i], noise[i]);
  }
};
COTORRA_LOOP void begin_wave(Columns a, int n, PointLanes &p, FractalLanes &s) {
  COTORRA_EACH {
    p.set<3>(i, vec4(off_the_border(column_vector(a, 0, i) * a[3][i]) * a[6][i], 0.0f));
    s.set_inputs(i, wave_inputs(a[5][i], a[7][i]));
  }
}
COTORRA_LOOP void end_wave(int n, float *noise) { COTORRA_EACH noise[i] = wave_noise(noise[i]); }

bool run_wave(uint mode, Columns a, int n, Results out) {
  BlockFloats angle;
  BlockFloats noise{};
  if (std::any_of(a[4], a[4] + n, [](float d) { return d != 0.0f; })) {
    PointLanes p;
    FractalLanes s;
    begin_wave(a, n, p, s);
    noise_lanes<3>(NOISE_FBM, true, 0, p, n, s, noise.v);
    end_wave(n, noise.v);
  }
  return run_mode<WaveAngle, 32>(mode & 31u, a, n, angle.v) &&
         run_mode<WaveProfile, 3>(mode >> 5, a, angle.v, noise.v, n, out[0]);
}

// ---- Magic: step by step, in the columns of the result

template <uint kDistorted>
struct MagicBegin {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, magic_begin(kDistorted, column_vector(a, 0, i), a[3][i], a[4][i]));
  }
};
template <uint kStep>
struct MagicStep {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, magic_step(kStep, column_vector(out, 0, i), a[4][i]));
  }
};
COTORRA_LOOP void end_magic(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i, magic_end(column_vector(out, 0, i), a[4][i]));
}

bool run_magic(uint mode, Columns a, int n, Results out) {
  const uint depth = magic_depth(mode);
  run_mode<MagicBegin, 2>(std::min(depth, 1u), a, n, out);
  for (uint step = 0; step < depth; ++step) run_mode<MagicStep, 10>(step, a, n, out);
  end_magic(a, n, out);
  return true;
}

// ---- Those of one formula

template <uint kMode>
struct WhiteNoise {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_white_noise_f(kMode, column_vector(a, 0, i), a[3][i]);
  }
};
template <uint kMode>
struct WhiteNoiseColor {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_white_noise_v(kMode, column_vector(a, 0, i), a[3][i]));
  }
};
template <uint kMode>
struct Gradient {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_gradient_f(kMode, column_vector(a, 0, i));
  }
};
COTORRA_LOOP void run_checker(Columns a, int n, Results out) {
  COTORRA_EACH out[0][i] = op_checker_f(0u, column_vector(a, 0, i), a[3][i]);
}

inline void store_brick(uint mode, Columns a, std::size_t i, Results out) {
  store(out, i,
        op_brick_f(mode, column_vector(a, 0, i), a[3][i], a[4][i], a[5][i], a[6][i], a[7][i], a[8][i], a[9][i],
                   a[10][i]));
}
// Of frequencies of 1 and 2, whose remainders are not divisions.
template <uint kMode>
struct Brick {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store_brick((1u + (kMode & 1u)) | (1u + (kMode >> 1)) << 8, a, i, out);
  }
};
COTORRA_LOOP void brick_of_mode(uint mode, Columns a, int n, Results out) { COTORRA_EACH store_brick(mode, a, i, out); }
bool run_brick(uint mode, Columns a, int n, Results out) {
  const uint offset = (mode & 255u) - 1u;
  const uint squash = (mode >> 8) - 1u;
  if (offset < 2u && squash < 2u) return run_mode<Brick, 4>(offset | squash << 1, a, n, out);
  brick_of_mode(mode, a, n, out);
  return true;
}

// ---- Ops whose lanes keep more than a result: a block after the other

constexpr int kTextureNumbers = 11;  // arguments at most

template <class Run>
bool in_blocks(Columns a, int n, Results out, int arguments, int results, Run run) {
  const float *columns[kTextureNumbers];
  float *parts[3];
  for (int begin = 0; begin < n; begin += kBlock) {
    for (int k = 0; k < arguments; ++k) columns[k] = a[k] + begin;
    for (int k = 0; k < results; ++k) parts[k] = out[k] + begin;
    if (!run(columns, std::min(n - begin, kBlock), parts)) return false;
  }
  return true;
}

bool run_noise(uint mode, int channels, Columns a, int n, Results out) {
  if (noise_type(mode) > NOISE_HETERO_TERRAIN) return false;
  return in_blocks(a, n, out, 11, channels, [&](Columns columns, int count, Results parts) {
    return run_mode<Noise, 4>(mode & 3u, mode, channels, columns, count, parts);
  });
}

bool run_voronoi(uint mode, bool vector, Columns a, int n, Results out) {
  if (!voronoi_has_loop(mode, vector)) return false;
  return in_blocks(a, n, out, 11, vector ? 3 : 1, [&](Columns columns, int count, Results parts) {
    return run_mode<VoronoiBlock, 4>(mode & 3u, mode, vector, columns, count, parts);
  });
}

}  // namespace

bool COTORRA_PROGRAM_LOOPS::run_texture(uint op, uint mode, Columns a, int n, Results out) {
  switch (op) {
    case OP_NOISE_F:
      return run_noise(mode, 1, a, n, out);
    case OP_NOISE_V:
      return run_noise(mode, 3, a, n, out);
    case OP_VORONOI_F:
      return run_voronoi(mode, false, a, n, out);
    case OP_VORONOI_V:
      return run_voronoi(mode, true, a, n, out);
    case OP_WHITE_NOISE_F:
      return run_mode<WhiteNoise, 4>(mode, a, n, out);
    case OP_WHITE_NOISE_V:
      return run_mode<WhiteNoiseColor, 4>(mode, a, n, out);
    case OP_WAVE_F:
      return in_blocks(a, n, out, 9, 1, [&](Columns columns, int count, Results parts) {
        return run_wave(mode, columns, count, parts);
      });
    case OP_MAGIC_V:
      return run_magic(mode, a, n, out);
    case OP_GRADIENT_F:
      return run_mode<Gradient, 7>(std::min(mode, 6u), a, n, out);
    case OP_CHECKER_F:
      run_checker(a, n, out);
      return true;
    case OP_BRICK_F:
      return run_brick(mode, a, n, out);
    default:
      return false;
  }
}

}  // namespace cotorra

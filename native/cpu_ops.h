// SPDX-License-Identifier: GPL-3.0-or-later
// Ops as loops over columns of arguments that the compiler vectorises, from the kernels' own functions: one loop for
// each mode, so that nothing in it asks for the mode. Included by cpu_program.cpp alone; an op without a loop here is
// called point by point.
#pragma once

#include <array>
#include <utility>

#include "../kernels/program/program.h"

#if defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COTORRA_LOOP [[gnu::flatten, gnu::noinline]] static
#else
#define COTORRA_LOOP static
#endif

namespace cotorra {
namespace {

using Columns = const float *const *;
using Results = float *const *;
using Loop = void (*)(Columns a, int n, Results out);

inline vec3 column_vector(Columns a, std::size_t first, std::size_t i) {
  return {a[first][i], a[first + 1][i], a[first + 2][i]};
}
inline void store(Results out, std::size_t i, vec3 v) {
  out[0][i] = v.x;
  out[1][i] = v.y;
  out[2][i] = v.z;
}

// ---- One loop a mode

#define COTORRA_EACH for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)

template <uint kMode>
struct Math {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_math(kMode, a[0][i], a[1][i], a[2][i]);
  }
};

template <uint kMode>
struct VectorMath {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(
        out, i,
        op_vector_math_v(kMode, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i), a[9][i]));
  }
};

template <uint kMode>
struct VectorNumber {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] =
        op_vector_math_f(kMode, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i), a[9][i]);
  }
};

// Ways to mix, with bits 8 and 9 of the op's mode in bits 5 and 6.
template <uint kMode>
struct MixColor {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    constexpr uint mode = (kMode & 31u) | (kMode >> 5) << 8;
    COTORRA_EACH store(out, i, op_mix_color(mode, a[0][i], column_vector(a, 1, i), column_vector(a, 4, i)));
  }
};

template <uint kMode>
struct MixNumber {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_mix_f(kMode, a[0][i], a[1][i], a[2][i]);
  }
};

template <uint kMode>
struct MixVector {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_mix_v(kMode, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i)));
  }
};

template <uint kMode>
struct Clamp {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_clamp_f(kMode, a[0][i], a[1][i], a[2][i]);
  }
};

// Bit 8 of the op's mode in bit 2.
template <uint kMode>
struct MapRange {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    constexpr uint mode = (kMode & 3u) | (kMode >> 2) << 8;
    COTORRA_EACH out[0][i] = op_map_range_f(mode, a[0][i], a[1][i], a[2][i], a[3][i], a[4][i], a[5][i]);
  }
};

template <uint kMode>
struct Component {
  COTORRA_LOOP void run(Columns a, int n, Results out) { COTORRA_EACH out[0][i] = a[kMode][i]; }
};

// Noise in 1 to 4 dimensions: fractal Brownian motion, as it is by default.
template <uint kMode>
struct NoiseNumber {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    constexpr uint mode = (kMode & 3u) | NOISE_FBM << 2 | (kMode >> 2) << 5;
    COTORRA_EACH out[0][i] = op_noise_f(mode, column_vector(a, 0, i), a[3][i], a[4][i], a[5][i], a[6][i], a[7][i],
                                        a[8][i], a[9][i], a[10][i]);
  }
};

template <uint kMode>
struct NoiseColor {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    constexpr uint mode = (kMode & 3u) | NOISE_FBM << 2 | (kMode >> 2) << 5;
    COTORRA_EACH store(out, i,
                       op_noise_v(mode, column_vector(a, 0, i), a[3][i], a[4][i], a[5][i], a[6][i], a[7][i], a[8][i],
                                  a[9][i], a[10][i]));
  }
};

template <template <uint> class Op, std::size_t... kModes>
constexpr std::array<Loop, sizeof...(kModes)> loops_of(std::index_sequence<kModes...>) {
  return {&Op<static_cast<uint>(kModes)>::run...};
}
template <template <uint> class Op, std::size_t kCount>
bool run_mode(uint mode, Columns a, int n, Results out) {
  static constexpr auto loops = loops_of<Op>(std::make_index_sequence<kCount>());
  if (mode >= kCount) return false;
  loops[mode](a, n, out);
  return true;
}

// ---- Ops without a mode

COTORRA_LOOP void splat_loop(Columns a, int n, Results out) { COTORRA_EACH store(out, i, vec3(a[0][i])); }
COTORRA_LOOP void combine_loop(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i, vec3(a[0][i], a[1][i], a[2][i]));
}
COTORRA_LOOP void luminance_loop(Columns a, int n, Results out) {
  COTORRA_EACH out[0][i] = op_luminance(0u, column_vector(a, 0, i));
}
COTORRA_LOOP void average_loop(Columns a, int n, Results out) {
  COTORRA_EACH out[0][i] = op_average(0u, column_vector(a, 0, i));
}
COTORRA_LOOP void affine_loop(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i,
                     op_affine(0u, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i),
                               column_vector(a, 9, i), column_vector(a, 12, i)));
}
COTORRA_LOOP void invert_loop(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i, op_invert(0u, column_vector(a, 0, i), a[3][i]));
}

#undef COTORRA_EACH

// Runs the op for n points and returns true where it has a loop.
bool run_loop(uint op, uint mode, Columns a, int n, Results out) {
  const auto run = [&](Loop loop) {
    loop(a, n, out);
    return true;
  };
  switch (op) {
    case OP_MATH:
      return run_mode<Math, 41>(mode, a, n, out);
    case OP_VECTOR_MATH_V:
      return run_mode<VectorMath, 30>(mode, a, n, out);
    case OP_VECTOR_MATH_F:
      return run_mode<VectorNumber, 10>(mode, a, n, out);
    case OP_MIX_COLOR:
      return (mode & ~0x31fu) == 0u && (mode & 31u) < 19u &&
             run_mode<MixColor, 128>((mode & 31u) | (mode >> 8) << 5, a, n, out);
    case OP_MIX_F:
      return run_mode<MixNumber, 2>(mode, a, n, out);
    case OP_MIX_V:
      return run_mode<MixVector, 2>(mode, a, n, out);
    case OP_CLAMP_F:
      return run_mode<Clamp, 2>(mode, a, n, out);
    case OP_MAP_RANGE_F:
      return (mode & ~0x103u) == 0u && run_mode<MapRange, 8>((mode & 3u) | (mode >> 8) << 2, a, n, out);
    case OP_COMPONENT:
      return run_mode<Component, 3>(mode, a, n, out);
    case OP_NOISE_F:
      return (mode >> 2 & 7u) == NOISE_FBM && run_mode<NoiseNumber, 8>((mode & 3u) | (mode >> 5) << 2, a, n, out);
    case OP_NOISE_V:
      return (mode >> 2 & 7u) == NOISE_FBM && run_mode<NoiseColor, 8>((mode & 3u) | (mode >> 5) << 2, a, n, out);
    case OP_SPLAT:
      return run(splat_loop);
    case OP_COMBINE:
      return run(combine_loop);
    case OP_LUMINANCE:
      return run(luminance_loop);
    case OP_AVERAGE:
      return run(average_loop);
    case OP_AFFINE:
      return run(affine_loop);
    case OP_INVERT:
      return run(invert_loop);
    default:
      return false;
  }
}

}  // namespace
}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Ops of numbers, vectors and colours as loops over columns of arguments that the compiler vectorises, from the
// kernels' own functions: one loop for each mode, so that nothing in it asks for the mode. Included by cpu_program.cpp
// alone.
#pragma once

#include <algorithm>

#include "../kernels/program/pure.h"
#include "cpu_loops.h"
#include "cpu_program.h"

namespace cotorra {
namespace {

// ---- One loop a mode

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

// Ways to mix; what is clamped is another loop's.
template <uint kMode>
struct MixColor {
  COTORRA_LOOP void run(const float *factor, Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_mix_color(kMode, factor[i], column_vector(a, 1, i), column_vector(a, 4, i)));
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

template <uint kMode>
struct MapRangeVector {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    constexpr uint mode = (kMode & 3u) | (kMode >> 2) << 8;
    COTORRA_EACH store(out, i,
                       op_map_range_v(mode, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i),
                                      column_vector(a, 9, i), column_vector(a, 12, i), column_vector(a, 15, i)));
  }
};

template <uint kMode>
struct Mapping {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i,
                       op_mapping(kMode, column_vector(a, 0, i), column_vector(a, 3, i), column_vector(a, 6, i),
                                  column_vector(a, 9, i)));
  }
};

template <uint kMode>
struct CombineColor {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_combine_color(kMode, a[0][i], a[1][i], a[2][i]));
  }
};

template <uint kMode>
struct SeparateColor {
  COTORRA_LOOP void run(Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_separate_color(kMode, column_vector(a, 0, i)));
  }
};

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

COTORRA_LOOP void hsv_loop(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i, op_hsv(0u, a[0][i], a[1][i], a[2][i], a[3][i], column_vector(a, 4, i)));
}
COTORRA_LOOP void bright_contrast_loop(Columns a, int n, Results out) {
  COTORRA_EACH store(out, i, op_bright_contrast(0u, column_vector(a, 0, i), a[3][i], a[4][i]));
}
COTORRA_LOOP void saturate_loop(int n, float *out) { COTORRA_EACH out[i] = saturate(out[i]); }

bool run_math(uint mode, Columns a, int n, Results out) {
  if (!run_mode<Math, 41>(mode & ~MATH_CLAMP, a, n, out)) return false;
  if ((mode & MATH_CLAMP) != 0u) saturate_loop(n, out[0]);
  return true;
}

bool run_mix_color(uint mode, Columns a, int n, Results out) {
  if ((mode & ~(31u | MIX_CLAMP_FACTOR | MIX_CLAMP_RESULT)) != 0u) return false;
  float clamped[kProgramLanes];
  const bool clamp = (mode & MIX_CLAMP_FACTOR) != 0u;
  if (clamp) {
    std::copy_n(a[0], n, clamped);
    saturate_loop(n, clamped);
  }
  if (!run_mode<MixColor, 19>(mode & 31u, clamp ? clamped : a[0], a, n, out)) return false;
  for (int c = 0; (mode & MIX_CLAMP_RESULT) != 0u && c < 3; ++c) saturate_loop(n, out[c]);
  return true;
}

// Runs the op for n points and returns true where it has a loop.
bool run_pure(uint op, uint mode, Columns a, int n, Results out) {
  const auto run = [&](Loop loop) {
    loop(a, n, out);
    return true;
  };
  switch (op) {
    case OP_MATH:
      return run_math(mode, a, n, out);
    case OP_VECTOR_MATH_V:
      return run_mode<VectorMath, 30>(mode, a, n, out);
    case OP_VECTOR_MATH_F:
      return run_mode<VectorNumber, 10>(mode, a, n, out);
    case OP_MIX_COLOR:
      return run_mix_color(mode, a, n, out);
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
    case OP_MAP_RANGE_V:
      return (mode & ~0x103u) == 0u && run_mode<MapRangeVector, 8>((mode & 3u) | (mode >> 8) << 2, a, n, out);
    case OP_MAPPING:
      return run_mode<Mapping, 4>(mode, a, n, out);
    case OP_COMBINE_COLOR:
      return run_mode<CombineColor, 3>(mode, a, n, out);
    case OP_SEPARATE_COLOR:
      return run_mode<SeparateColor, 3>(mode, a, n, out);
    case OP_HSV:
      return run(hsv_loop);
    case OP_BRIGHT_CONTRAST:
      return run(bright_contrast_loop);
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

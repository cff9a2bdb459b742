// SPDX-License-Identifier: GPL-3.0-or-later
// Calls a pure op by its number, for interpreters and for folding constants: one function a group of ops, so that a
// build may leave out groups. Loops over lanes call the ops themselves, with a mode that is constant in the loop.
#ifndef COTORRA_PROGRAM_PURE_H
#define COTORRA_PROGRAM_PURE_H

#include "color_ops.h"
#include "gabor.h"
#include "mapping.h"
#include "mix.h"
#include "ops.h"
#include "patterns.h"
#include "radial_tiling.h"
#include "spectrum.h"
#include "vector_ops.h"
#include "voronoi_fractal.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Arguments one after the other; a vector takes three.
struct ProgramArguments {
  float v[32];
};

FN vec3 argument3(IN(ProgramArguments) a, int i) { return vec3(a.v[i], a.v[i + 1], a.v[i + 2]); }

#ifdef PROGRAM_PURE_ELSEWHERE
// The CPU's kernels of an instruction set share one build of these ops, in the namespace that is named so.
namespace PROGRAM_PURE_ELSEWHERE {
vec3 pure_op(uint op, uint mode, IN(ProgramArguments) a);
}
FN vec3 program_pure(uint op, uint mode, IN(ProgramArguments) a) {
  return PROGRAM_PURE_ELSEWHERE::pure_op(op, mode, a);
}
#else

FN float pure_math(uint op, uint mode, IN(ProgramArguments) a) {
  switch (op) {
    case OP_MATH:
      return op_math(mode, a.v[0], a.v[1], a.v[2]);
    case OP_CLAMP_F:
      return op_clamp_f(mode, a.v[0], a.v[1], a.v[2]);
    case OP_MAP_RANGE_F:
      return op_map_range_f(mode, a.v[0], a.v[1], a.v[2], a.v[3], a.v[4], a.v[5]);
    case OP_MIX_F:
      return op_mix_f(mode, a.v[0], a.v[1], a.v[2]);
    case OP_LUMINANCE:
      return op_luminance(mode, argument3(a, 0));
    case OP_AVERAGE:
      return op_average(mode, argument3(a, 0));
    case OP_COMPONENT:
      return op_component(mode, argument3(a, 0));
    case OP_VECTOR_MATH_F:
      return op_vector_math_f(mode, argument3(a, 0), argument3(a, 3), argument3(a, 6), a.v[9]);
    default:
      return op_radial_tiling_f(mode, argument3(a, 0), a.v[3], a.v[4]);
  }
}

FN vec3 pure_vector(uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  const vec3 q = argument3(a, 3);
  const vec3 r = argument3(a, 6);
  switch (op) {
    case OP_SPLAT:
      return op_splat(mode, a.v[0]);
    case OP_COMBINE:
      return op_combine(mode, a.v[0], a.v[1], a.v[2]);
    case OP_VECTOR_MATH_V:
      return op_vector_math_v(mode, p, q, r, a.v[9]);
    case OP_MAP_RANGE_V:
      return op_map_range_v(mode, p, q, r, argument3(a, 9), argument3(a, 12), argument3(a, 15));
    case OP_MIX_V:
      return op_mix_v(mode, p, q, r);
    case OP_MAPPING:
      return op_mapping(mode, p, q, r, argument3(a, 9));
    case OP_VECTOR_ROTATE:
      return op_vector_rotate(mode, p, q, r, a.v[9], argument3(a, 10));
    case OP_AFFINE:
      return op_affine(mode, p, q, r, argument3(a, 9), argument3(a, 12));
    default:
      return op_radial_tiling_v(mode, p, a.v[3], a.v[4]);
  }
}

FN vec3 pure_color(uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  switch (op) {
    case OP_MIX_COLOR:
      return op_mix_color(mode, a.v[0], argument3(a, 1), argument3(a, 4));
    case OP_COMBINE_COLOR:
      return op_combine_color(mode, a.v[0], a.v[1], a.v[2]);
    case OP_SEPARATE_COLOR:
      return op_separate_color(mode, p);
    case OP_HSV:
      return op_hsv(mode, a.v[0], a.v[1], a.v[2], a.v[3], argument3(a, 4));
    case OP_GAMMA:
      return op_gamma(mode, p, a.v[3]);
    case OP_BRIGHT_CONTRAST:
      return op_bright_contrast(mode, p, a.v[3], a.v[4]);
    case OP_INVERT:
      return op_invert(mode, p, a.v[3]);
    default:
      return op_blackbody(mode, a.v[0]);
  }
}

FN vec3 pure_noise(uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  if (op == OP_NOISE_V) {
    return op_noise_v(mode, p, a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8], a.v[9], a.v[10]);
  }
  return vec3(op_noise_f(mode, p, a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8], a.v[9], a.v[10]));
}

FN vec3 pure_voronoi(uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  if (op == OP_VORONOI_V) {
    return op_voronoi_v(mode, p, a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8], a.v[9], a.v[10]);
  }
  return vec3(op_voronoi_f(mode, p, a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8], a.v[9], a.v[10]));
}

FN vec3 pure_pattern(uint op, uint mode, IN(ProgramArguments) a) {
  const vec3 p = argument3(a, 0);
  switch (op) {
    case OP_WHITE_NOISE_F:
      return vec3(op_white_noise_f(mode, p, a.v[3]));
    case OP_WHITE_NOISE_V:
      return op_white_noise_v(mode, p, a.v[3]);
    case OP_MAGIC_V:
      return op_magic_v(mode, p, a.v[3], a.v[4]);
    case OP_GRADIENT_F:
      return vec3(op_gradient_f(mode, p));
    case OP_CHECKER_F:
      return vec3(op_checker_f(mode, p, a.v[3]));
    default:
      return op_brick_f(mode, p, a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8], a.v[9], a.v[10]);
  }
}

// The result of a pure op; of a number, x holds it. 0 where the op's group is left out.
FN vec3 program_pure(uint op, uint mode, IN(ProgramArguments) a) {
  const uint group = program_group(op);
  if (PROGRAM_GROUP(GROUP_MATH) && group == GROUP_MATH) return vec3(pure_math(op, mode, a), 0.0f, 0.0f);
  if (PROGRAM_GROUP(GROUP_VECTOR) && group == GROUP_VECTOR) return pure_vector(op, mode, a);
  if (PROGRAM_GROUP(GROUP_COLOR) && group == GROUP_COLOR) return pure_color(op, mode, a);
  if (PROGRAM_GROUP(GROUP_WAVELENGTH) && group == GROUP_WAVELENGTH) return op_wavelength(mode, a.v[0]);
  if (PROGRAM_GROUP(GROUP_NOISE) && group == GROUP_NOISE) return pure_noise(op, mode, a);
  if (PROGRAM_GROUP(GROUP_VORONOI) && group == GROUP_VORONOI) return pure_voronoi(op, mode, a);
  if (PROGRAM_GROUP(GROUP_WAVE) && group == GROUP_WAVE) {
    return vec3(op_wave_f(mode, argument3(a, 0), a.v[3], a.v[4], a.v[5], a.v[6], a.v[7], a.v[8]));
  }
  if (PROGRAM_GROUP(GROUP_PATTERN) && group == GROUP_PATTERN) return pure_pattern(op, mode, a);
  if (PROGRAM_GROUP(GROUP_GABOR) && group == GROUP_GABOR) {
    return vec3(op_gabor_f(mode, argument3(a, 0), a.v[3], a.v[4], a.v[5], a.v[6], argument3(a, 7)), 0.0f, 0.0f);
  }
  return vec3(0.0f, 0.0f, 0.0f);
}

#endif

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

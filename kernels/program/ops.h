// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of the ops of shading programs, OP_MATH and the like, made from the list in ops.inc.
// What they compute stands in the files beside this one.
#ifndef COTORRA_PROGRAM_OPS_H
#define COTORRA_PROGRAM_OPS_H

#include "../language.h"

#ifdef __cplusplus
namespace cotorra {
#endif

#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) const uint CONSTANT = NUMBER;
#include "ops.inc"
#undef PROGRAM_OP

const uint OP_NUMBERS = 160u;  // all are below

// ---- What of the ops a build has. A device that compiles kernels for a scene leaves out what its shaders do without.
const uint GROUP_MATH = 1u;
const uint GROUP_VECTOR = 2u;
const uint GROUP_COLOR = 4u;
const uint GROUP_NOISE = 8u;
const uint GROUP_VORONOI = 16u;
const uint GROUP_PATTERN = 32u;
const uint GROUP_GABOR = 64u;
const uint GROUP_TABLE = 128u;
const uint GROUP_IMAGE = 256u;
const uint GROUP_COORDINATES = 512u;
const uint GROUP_NORMAL = 1024u;  // bent normals and tangents
const uint GROUP_POINT = 2048u;   // the rest of what reads the shading point
const uint GROUP_WAVE = 4096u;
const uint GROUP_LAYERS = 8192u;
const uint GROUP_WAVELENGTH = 16384u;  // its table takes drivers long to compile
const uint GROUP_RAYS = 32768u;
const uint GROUP_PROGRAM = 0x80000000u;  // there are programs at all
// Which programs a stage runs: where it runs none of a kind, that call of the interpreter is left out.
const uint GROUP_SURFACES = 0x40000000u;
const uint GROUP_EMISSIONS = 0x20000000u;  // worlds, too
const uint GROUP_TRANSPARENCIES = 0x10000000u;
// Bits of what noise is asked for: 1 to 4 dimensions, then the types of noise_fractal.h.
const uint VARIANT_TYPES_SHIFT = 4u;

// PROGRAM_GROUP(BIT), PROGRAM_VARIANT(BIT): is it compiled in? Whoever includes this may define them by specialization
// constants.
#ifndef PROGRAM_GROUP
#define PROGRAM_GROUP(BIT) ((BIT) != 0u)
#define PROGRAM_VARIANT(BIT) ((BIT) != 0u)
#endif

// The group of an op.
FN uint program_group(uint op) {
  if (op >= OP_IMAGE_V) return GROUP_IMAGE;
  if (op >= OP_RAMP_V) return GROUP_TABLE;
  if (op == OP_NOISE_F || op == OP_NOISE_V) return GROUP_NOISE;
  if (op == OP_VORONOI_F || op == OP_VORONOI_V) return GROUP_VORONOI;
  if (op == OP_GABOR_F) return GROUP_GABOR;
  if (op == OP_WAVE_F) return GROUP_WAVE;
  if (op == OP_WAVELENGTH) return GROUP_WAVELENGTH;
  if (op >= OP_WHITE_NOISE_F) return GROUP_PATTERN;
  if (op >= OP_MIX_COLOR) return GROUP_COLOR;
  if (op == OP_LAYERS) return GROUP_LAYERS;
  if (op == OP_AO || op == OP_BEVEL || op == OP_RAYCAST || op == OP_RAYCAST_NORMAL) return GROUP_RAYS;
  if (op < OP_SPLAT) {
    const bool coordinates = op == OP_POSITION || (op >= OP_PARAMETRIC && op <= OP_ATTRIBUTE_FAC);
    const bool normal = (op >= OP_TANGENT && op <= OP_NORMAL_MAP) || op == OP_BUMP;
    return coordinates ? GROUP_COORDINATES : (normal ? GROUP_NORMAL : GROUP_POINT);
  }
  const bool number = op == OP_LUMINANCE || op == OP_AVERAGE || op == OP_COMPONENT || op == OP_MATH ||
                      op == OP_VECTOR_MATH_F || op == OP_CLAMP_F || op == OP_MAP_RANGE_F || op == OP_MIX_F ||
                      op == OP_RADIAL_TILING_F;
  return number ? GROUP_MATH : GROUP_VECTOR;
}

// The variants of noise that an op asks for.
FN uint program_variants(uint op, uint mode) {
  const uint fbm = 3u;  // NOISE_FBM
  if (op == OP_WAVE_F) return 4u | 1u << (VARIANT_TYPES_SHIFT + fbm);
  if (op != OP_NOISE_F && op != OP_NOISE_V) return 0u;
  return 1u << (mode & 3u) | 1u << (VARIANT_TYPES_SHIFT + ((mode >> 2) & 7u));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

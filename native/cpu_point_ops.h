// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that read the shading point, tables or images as loops over points with the op constant in each: what a point
// looks up does not vectorise, but nothing asks for the op or copies arguments. Included by cpu_program.cpp alone.
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>

#include "../kernels/program/program.h"
#include "cpu_loops.h"
#include "cpu_program.h"

namespace cotorra {
namespace {

template <bool kVector>
void store_result(Results out, std::size_t i, vec3 value) {
  if (kVector) {
    store(out, i, value);
  } else {
    out[0][i] = value.x;
  }
}

// ---- The shading point

// Ops of one group, each with a constant op. Of the coordinates the mode matters only where it moves the point.
template <uint kOp, bool kVector, bool kMoved>
struct Coordinates {
  COTORRA_LOOP void run(const ProgramBatch &b, uint mode, Columns a, int n, Results out) {
    const bool has_argument = kOp == OP_ATTRIBUTE || kOp == OP_ATTRIBUTE_ALPHA || kOp == OP_ATTRIBUTE_FAC;
    COTORRA_EACH store_result<kVector>(
        out, i, program_coordinates(*b.scene, b.points[i], kOp, kMoved ? mode : 0u, has_argument ? a[0][i] : 0.0f));
  }
};

template <uint kOp, std::size_t kNumbers>
struct Normals {
  COTORRA_LOOP void run(const ProgramBatch &b, uint mode, Columns a, int n, Results out) {
    COTORRA_EACH {
      ProgramArguments numbers;
      for (std::size_t k = 0; k < kNumbers; ++k) numbers.v[k] = a[k][i];
      const bool nowhere = b.points[i].instance == INVALID_ID;
      store(out, i, nowhere ? b.points[i].n : program_normal(*b.scene, b.points[i], kOp, mode, numbers));
    }
  }
};

template <uint kOp, bool kVector, std::size_t kNumbers>
struct PointOp {
  COTORRA_LOOP void run(const ProgramBatch &b, uint mode, Columns a, int n, Results out) {
    COTORRA_EACH {
      ProgramArguments numbers;
      for (std::size_t k = 0; k < kNumbers; ++k) numbers.v[k] = a[k][i];
      store_result<kVector>(out, i, program_point(*b.scene, b.points[i], kOp, mode, numbers));
    }
  }
};

template <uint kOp, bool kVector>
bool run_coordinates(const ProgramBatch &b, uint mode, Columns a, Results out) {
  if (mode >> 30 == SHIFT_NONE) {
    Coordinates<kOp, kVector, false>::run(b, mode, a, b.n, out);
  } else {
    Coordinates<kOp, kVector, true>::run(b, mode, a, b.n, out);
  }
  return true;
}

template <uint kOp, std::size_t kNumbers>
bool run_normals(const ProgramBatch &b, uint mode, Columns a, Results out) {
  Normals<kOp, kNumbers>::run(b, mode, a, b.n, out);
  return true;
}

template <uint kOp, bool kVector, std::size_t kNumbers>
bool run_point_op(const ProgramBatch &b, uint mode, Columns a, Results out) {
  PointOp<kOp, kVector, kNumbers>::run(b, mode, a, b.n, out);
  return true;
}

bool run_point(const ProgramBatch &b, uint op, uint mode, Columns a, Results out) {
  switch (op) {
    case OP_POSITION:
      return run_coordinates<OP_POSITION, true>(b, mode, a, out);
    case OP_PARAMETRIC:
      return run_coordinates<OP_PARAMETRIC, true>(b, mode, a, out);
    case OP_GENERATED:
      return run_coordinates<OP_GENERATED, true>(b, mode, a, out);
    case OP_OBJECT_POSITION:
      return run_coordinates<OP_OBJECT_POSITION, true>(b, mode, a, out);
    case OP_CAMERA_POSITION:
      return run_coordinates<OP_CAMERA_POSITION, true>(b, mode, a, out);
    case OP_WINDOW:
      return run_coordinates<OP_WINDOW, true>(b, mode, a, out);
    case OP_ATTRIBUTE:
      return run_coordinates<OP_ATTRIBUTE, true>(b, mode, a, out);
    case OP_ATTRIBUTE_ALPHA:
      return run_coordinates<OP_ATTRIBUTE_ALPHA, false>(b, mode, a, out);
    case OP_ATTRIBUTE_FAC:
      return run_coordinates<OP_ATTRIBUTE_FAC, false>(b, mode, a, out);
    case OP_NORMAL_MAP:
      return run_normals<OP_NORMAL_MAP, 5>(b, mode, a, out);
    case OP_BUMP:
      return run_normals<OP_BUMP, 8>(b, mode, a, out);
    case OP_UV_TANGENT:
      return run_normals<OP_UV_TANGENT, 1>(b, mode, a, out);
    case OP_TANGENT:
      return run_normals<OP_TANGENT, 0>(b, mode, a, out);
    case OP_NORMAL:
      return run_point_op<OP_NORMAL, true, 0>(b, mode, a, out);
    case OP_TRUE_NORMAL:
      return run_point_op<OP_TRUE_NORMAL, true, 0>(b, mode, a, out);
    case OP_INCOMING:
      return run_point_op<OP_INCOMING, true, 0>(b, mode, a, out);
    case OP_BACKFACING:
      return run_point_op<OP_BACKFACING, false, 0>(b, mode, a, out);
    case OP_LIGHT_PATH:
      return run_point_op<OP_LIGHT_PATH, false, 0>(b, mode, a, out);
    case OP_FRESNEL:
      return run_point_op<OP_FRESNEL, false, 4>(b, mode, a, out);
    case OP_LAYER_WEIGHT:
      return run_point_op<OP_LAYER_WEIGHT, false, 4>(b, mode, a, out);
    default:
      return false;
  }
}

// ---- Tables

template <uint kMode>
struct Ramp {
  COTORRA_LOOP void run(const SceneData &scene, Columns a, int n, Results out) {
    COTORRA_EACH store(out, i, op_ramp_v(scene, kMode, a[0][i], a[1][i], a[2][i]));
  }
};
template <uint kMode>
struct RampAlpha {
  COTORRA_LOOP void run(const SceneData &scene, Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_ramp_alpha(scene, kMode, a[0][i], a[1][i], a[2][i]);
  }
};
template <uint kMode>
struct Curve {
  COTORRA_LOOP void run(const SceneData &scene, Columns a, int n, Results out) {
    COTORRA_EACH out[0][i] = op_curve_f(scene, kMode, a[0][i], a[1][i], a[2][i], a[3][i], a[4][i]);
  }
};
// Of colours and of vectors: both are curves of the components.
template <uint kMode>
struct Curves {
  COTORRA_LOOP void run(const SceneData &scene, Columns a, int n, Results out) {
    COTORRA_EACH store(out, i,
                       op_rgb_curve_v(scene, kMode, column_vector(a, 0, i), a[3][i], a[4][i], a[5][i], a[6][i]));
  }
};

COTORRA_LOOP void measured_light(const SceneData &scene, Columns a, int n, Results out) {
  COTORRA_EACH out[0][i] = op_ies_f(scene, column_vector(a, 0, i), a[3][i], a[4][i], a[5][i]);
}

// ---- Images

// Points whose texels are asked for before the first of them is read: what a point waits for is memory.
constexpr int kTexelBlock = 64;
struct TexelBlock {
  TexturePlace place[kTexelBlock];
  float r[kTexelBlock], g[kTexelBlock], b[kTexelBlock], a[kTexelBlock];
  uint srgb[kTexelBlock];
};

inline void prefetch_texel(const Texture &t, int x, int y, uint extension) {
  const int column = texture_wrap(x, static_cast<int>(t.width), extension);
  const int row = texture_wrap(y, static_cast<int>(t.height), extension);
  if (column < 0 || row < 0) return;
  const std::size_t number = std::size_t{static_cast<uint>(row) * t.width + static_cast<uint>(column)} * t.channels;
  [[maybe_unused]] const char *texel = reinterpret_cast<const char *>(t.texels.v) + number * texel_bytes(t.format);
#if defined(__GNUC__)
  __builtin_prefetch(texel);
#endif
}

#if defined(__GNUC__)
// texture_gather with the four numbers of a texel side by side: of RGB and RGBA of 8 bits, which most images are.
using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
using FourBytes = std::uint8_t __attribute__((vector_size(4)));

inline FourFloats byte_texel(const Texture &t, int x, int y) {
  if (x < 0 || y < 0) return FourFloats{};
  const std::size_t place = (std::size_t{static_cast<uint>(y)} * t.width + static_cast<uint>(x)) * t.channels;
  uint word;
  if (t.channels == 4u) {
    word = t.texels.v[place / 4];
  } else {
    // A texel of three bytes with that behind it; behind the last one may be none, and it comes with that before it.
    const std::size_t bytes = (std::size_t{t.width} * t.height * 3 + 3) & ~std::size_t{3};
    const std::size_t back = place + 4 > bytes ? 1 : 0;
    std::memcpy(&word, reinterpret_cast<const char *>(t.texels.v) + place - back, 4);
    word = word >> (8 * back) | 0xff000000u;
  }
  FourBytes numbers;
  std::memcpy(&numbers, &word, 4);
  return __builtin_convertvector(__builtin_convertvector(numbers, FourInts), FourFloats) * (1.0f / 255.0f);
}

// The same of RGBA in floats, as most images of the sky are; what is no number is 0.
inline FourFloats float_texel(const Texture &t, int x, int y) {
  if (x < 0 || y < 0) return FourFloats{};
  const std::size_t place = (std::size_t{static_cast<uint>(y)} * t.width + static_cast<uint>(x)) * 4;
  FourFloats c;
  std::memcpy(&c, t.texels.v + place, sizeof(c));
  return (c < INFINITE_DISTANCE) & (c > -INFINITE_DISTANCE) ? c : FourFloats{};
}

template <class Texel>
vec4 gather_four(const Texture &t, const TexturePlace &p, uint extension, Texel texel) {
  const int columns[2] = {texture_wrap(p.x, static_cast<int>(t.width), extension),
                          texture_wrap(p.x + 1, static_cast<int>(t.width), extension)};
  FourFloats sum{};
  for (int j = 0; j < 2; ++j) {
    const int row = texture_wrap(p.y + j, static_cast<int>(t.height), extension);
    FourFloats line{};
    line = line + texel(t, columns[0], row) * (1.0f - p.fx);
    line = line + texel(t, columns[1], row) * p.fx;
    sum = sum + line * (j == 0 ? 1.0f - p.fy : p.fy);
  }
  return {sum[0], sum[1], sum[2], sum[3]};
}

inline vec4 gather_linear(const Texture &t, const TexturePlace &p, uint extension) {
  if (t.format == TEXELS_UINT8 && t.channels >= 3u) return gather_four(t, p, extension, byte_texel);
  if (t.format == TEXELS_FLOAT && t.channels == 4u) return gather_four(t, p, extension, float_texel);
  return texture_gather(t, p, INTERPOLATION_LINEAR, extension);
}
#else
inline vec4 gather_linear(const Texture &t, const TexturePlace &p, uint extension) {
  return texture_gather(t, p, INTERPOLATION_LINEAR, extension);
}
#endif

// Flat, by the interpolation: image_lookup of a block of points.
template <uint kInterpolation>
struct FlatImage {
  COTORRA_LOOP void run(const SceneData &scene, uint mode, bool alpha, Columns a, int n, Results out) {
    for (int begin = 0; begin < n; begin += kTexelBlock) {
      const float *const columns[] = {a[0] + begin, a[1] + begin, a[3] + begin};  // s, t, image
      float *const parts[] = {out[0] + begin, alpha ? nullptr : out[1] + begin, alpha ? nullptr : out[2] + begin};
      block(scene, mode, alpha, columns, std::min(n - begin, kTexelBlock), parts);
    }
  }

  static void decode(const uint *srgb, int n, float *c) {
    bool bright = false;
    COTORRA_EACH bright |= c[i] > 1.0f;
    if (bright) {
      COTORRA_EACH c[i] = srgb[i] != 0u ? srgb_decode(c[i]) : c[i];
    } else {
      COTORRA_EACH c[i] = select(srgb[i] != 0u, srgb_decode_unit(c[i]), c[i]);
    }
  }

  static void block(const SceneData &scene, uint mode, bool alpha, Columns a, int n, Results out) {
    const uint extension = (mode >> 2) & 3u;
    TexelBlock t;
    // 1. Where the texels are.
    COTORRA_EACH {
      const Texture &image = scene.textures.v[image_index(scene, a[2][i])];
      t.place[i] = texture_place(image, vec2(a[0][i], a[1][i]), kInterpolation);
      t.srgb[i] = image.srgb;
      for (int j = 0; j < texture_taps(kInterpolation); ++j) {
        prefetch_texel(image, t.place[i].x, t.place[i].y + j, extension);
      }
    }
    // 2. The texels, filtered.
    COTORRA_EACH {
      const Texture &image = scene.textures.v[image_index(scene, a[2][i])];
      const vec4 c = kInterpolation == INTERPOLATION_LINEAR
                         ? gather_linear(image, t.place[i], extension)
                         : texture_gather(image, t.place[i], kInterpolation, extension);
      t.r[i] = c.x;
      t.g[i] = c.y;
      t.b[i] = c.z;
      t.a[i] = c.w;
    }
    if (alpha) {
      COTORRA_EACH out[0][i] = t.a[i];
      return;
    }
    // 3. Linear.
    const bool unassociate = (mode & IMAGE_UNASSOCIATE) != 0u;
    bool decoded = false;
    COTORRA_EACH {
      store(out, i, texture_straight(unassociate, vec4(t.r[i], t.g[i], t.b[i], t.a[i])));
      decoded |= t.srgb[i] != 0u;
    }
    for (int c = 0; decoded && c < 3; ++c) decode(t.srgb, n, out[c]);
  }
};
COTORRA_LOOP void mapped_image(const SceneData &scene, uint mode, bool alpha, Columns a, int n, Results out) {
  COTORRA_EACH {
    const vec4 c = image_lookup(scene, mode, column_vector(a, 0, i), a[3][i], a[4][i], column_vector(a, 5, i));
    out[0][i] = alpha ? c.w : c.x;
    if (alpha) continue;
    out[1][i] = c.y;
    out[2][i] = c.z;
  }
}

// From all directions, by the interpolation: op_environment_v of a block of points.
template <uint kInterpolation>
struct EnvironmentImage {
  COTORRA_LOOP void run(const SceneData &scene, uint mode, Columns a, int n, Results out) {
    for (int begin = 0; begin < n; begin += kTexelBlock) {
      float s[kTexelBlock], t[kTexelBlock];
      const float *const columns[] = {a[0] + begin, a[1] + begin, a[2] + begin};
      const int count = std::min(n - begin, kTexelBlock);
      map(image_projection(mode) == 0u, columns, count, s, t);
      const float *const places[] = {s, t, a[3] + begin};
      float *const parts[] = {out[0] + begin, out[1] + begin, out[2] + begin};
      FlatImage<kInterpolation>::block(scene, mode, false, places, count, parts);
    }
  }

  static void map(bool equirectangular, Columns a, int n, float *s, float *t) {
    if (equirectangular) {
      COTORRA_EACH {
        const vec2 place = map_equirectangular(normalize_or_zero(column_vector(a, 0, i)));
        s[i] = place.x;
        t[i] = place.y;
      }
    } else {
      COTORRA_EACH {
        const vec2 place = map_mirror_ball(normalize_or_zero(column_vector(a, 0, i)));
        s[i] = place.x;
        t[i] = place.y;
      }
    }
  }
};
bool run_image(const SceneData &scene, uint mode, bool alpha, Columns a, int n, Results out) {
  if (image_projection(mode) == PROJECTION_FLAT) {
    return run_mode<FlatImage, 4>(mode & 3u, std::cref(scene), mode, alpha, a, n, out);
  }
  mapped_image(scene, mode, alpha, a, n, out);
  return true;
}

bool run_table(const SceneData &scene, uint op, uint mode, Columns a, int n, Results out) {
  switch (op) {
    case OP_RAMP_V:
      return run_mode<Ramp, 2>(mode & TABLE_FLAG, std::cref(scene), a, n, out);
    case OP_RAMP_ALPHA:
      return run_mode<RampAlpha, 2>(mode & TABLE_FLAG, std::cref(scene), a, n, out);
    case OP_CURVE_F:
      return run_mode<Curve, 2>(mode & TABLE_FLAG, std::cref(scene), a, n, out);
    case OP_RGB_CURVE_V:
    case OP_VECTOR_CURVE_V:
      return run_mode<Curves, 2>(mode & TABLE_FLAG, std::cref(scene), a, n, out);
    case OP_IES_F:
      measured_light(scene, a, n, out);
      return true;
    case OP_IMAGE_V:
    case OP_IMAGE_F:
      return run_image(scene, mode, op == OP_IMAGE_F, a, n, out);
    case OP_ENVIRONMENT_V:
      return run_mode<EnvironmentImage, 4>(mode & 3u, std::cref(scene), mode, a, n, out);
    default:
      return false;
  }
}

}  // namespace
}  // namespace cotorra

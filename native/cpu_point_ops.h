// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that read the shading point, tables or images as loops over points with the op constant in each: what a point
// looks up does not vectorise, but nothing asks for the op or copies arguments. Included by cpu_program.cpp alone.
#pragma once

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

// Flat, by the interpolation.
template <uint kInterpolation>
struct FlatImage {
  COTORRA_LOOP void run(const SceneData &scene, uint mode, bool alpha, Columns a, int n, Results out) {
    const uint known = (mode & ~(3u | 3u << 4)) | kInterpolation | PROJECTION_FLAT << 4;
    COTORRA_EACH {
      const vec4 c = image_lookup(scene, known, column_vector(a, 0, i), a[3][i], 0.0f, vec3(0.0f));
      out[0][i] = alpha ? c.w : c.x;
      if (alpha) continue;
      out[1][i] = c.y;
      out[2][i] = c.z;
    }
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
    default:
      return false;
  }
}

}  // namespace
}  // namespace cotorra

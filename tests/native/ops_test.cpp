// SPDX-License-Identifier: GPL-3.0-or-later
// The ops of shading programs over arrays, for the tests in Python, and the list of ops.
// Nothing is tested here: see tests/test_ops.py.
#include <cstddef>
#include <cstdint>

namespace cotorra {
constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu;
}
#include "program/ies.h"
#include "program/image_map.h"
#include "program/pure.h"
#include "program/table_ops.h"

using namespace cotorra;

struct OpRow {
  const char *name;
  unsigned number;
  const char *kind;
  const char *result;
  const char *arguments;
};

#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) {#NAME, NUMBER, #KIND, #RESULT, #ARGUMENTS},
extern "C" const OpRow test_ops[] = {
#include "program/ops.inc"
    {nullptr, 0, nullptr, nullptr, nullptr},
};
#undef PROGRAM_OP

extern "C" void test_pure(unsigned op, unsigned mode, std::size_t count, const ProgramArguments *arguments,
                          vec3 *results) {
  for (std::size_t i = 0; i < count; ++i) results[i] = program_pure(op, mode, arguments[i]);
}

namespace {

vec3 table_op(const SceneData &scene, unsigned op, unsigned mode, const ProgramArguments &a) {
  const vec3 p = argument3(a, 0);
  const vec3 normal = argument3(a, 5);
  switch (op) {
    case OP_RAMP_V:
      return op_ramp_v(scene, mode, a.v[0], a.v[1], a.v[2]);
    case OP_RAMP_ALPHA:
      return vec3(op_ramp_alpha(scene, mode, a.v[0], a.v[1], a.v[2]));
    case OP_CURVE_F:
      return vec3(op_curve_f(scene, mode, a.v[0], a.v[1], a.v[2], a.v[3], a.v[4]));
    case OP_RGB_CURVE_V:
      return op_rgb_curve_v(scene, mode, p, a.v[3], a.v[4], a.v[5], a.v[6]);
    case OP_VECTOR_CURVE_V:
      return op_vector_curve_v(scene, mode, p, a.v[3], a.v[4], a.v[5], a.v[6]);
    case OP_IES_F:
      return vec3(op_ies_f(scene, p, a.v[3], a.v[4], a.v[5]));
    case OP_IMAGE_V:
      return op_image_v(scene, mode, p, a.v[3], a.v[4], normal);
    case OP_IMAGE_F:
      return vec3(op_image_f(scene, mode, p, a.v[3], a.v[4], normal));
    default:
      return op_environment_v(scene, mode, p, a.v[3]);
  }
}

}  // namespace

// One table, and one image of four floats a texel.
extern "C" void test_table(unsigned op, unsigned mode, std::size_t count, const ProgramArguments *arguments,
                           vec3 *results, const float *table, const uint *texels, unsigned width, unsigned height) {
  Texture image{};
  image.texels.v = texels;
  image.width = width;
  image.height = height;
  image.channels = 4;
  image.format = TEXELS_FLOAT;
  SceneData scene{};
  scene.tables.v = table;
  scene.textures.v = &image;
  scene.texture_count = 1;
  for (std::size_t i = 0; i < count; ++i) results[i] = table_op(scene, op, mode, arguments[i]);
}

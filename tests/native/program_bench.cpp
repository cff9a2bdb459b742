// SPDX-License-Identifier: GPL-3.0-or-later
// What ops of shading programs cost: as the CPU runs a batch of points (native/cpu_program.cpp), and point by point.
// It prints a table, with the number of points whose bits differ, and returns 1 where a point does.
#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

namespace cotorra {
constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu;
}
#include "cpu_program.h"
#include "program/program.h"

namespace cotorra {
extern const RunProgram COTORRA_PROGRAM_NAME;
}
using namespace cotorra;

namespace {

constexpr std::size_t LANES = kProgramLanes;

// ---- The scene: one triangle of one mesh with a UV map and an attribute, a ramp, a curve, an image

const vec3 corners[] = {vec3(0.0f, 0.0f, 0.1f), vec3(1.0f, 0.1f, 0.0f), vec3(0.2f, 1.3f, 0.4f)};
const uvec3 triangle = uvec3(0u, 1u, 2u);
const vec2 uvs[] = {vec2(0.1f, 0.2f), vec2(0.9f, 0.3f), vec2(0.4f, 1.7f)};
const vec4 tangents[] = {vec4(1.0f, 0.1f, 0.0f, 1.0f), vec4(0.9f, 0.0f, 0.1f, 1.0f), vec4(1.0f, 0.0f, 0.0f, 1.0f)};
const vec4 colors[] = {vec4(0.1f, 0.5f, 0.3f, 1.0f), vec4(0.7f, 0.2f, 0.9f, 0.5f), vec4(0.0f, 0.4f, 0.6f, 0.2f)};
const std::uint32_t attribute_table[] = {ATTRIBUTE_POINT | 3u << ATTRIBUTE_COMPONENTS_SHIFT, 0u};

struct TestScene {
  SceneData data{};
  Instance instance{};
  Mesh mesh{};
  MeshTextures textures{};
  ObjectSpace space{};
  Texture image{};
  std::vector<float> tables, constants;
  std::vector<std::uint32_t> texels;
  std::vector<std::uint32_t> code;
};

void fill(TestScene &s, std::mt19937 &random) {
  const auto unit = [&] { return static_cast<float>(random() >> 8) * 5.9604645e-8f; };
  s.instance.x_axis = s.instance.normal_x = vec3(1.0f, 0.0f, 0.0f);
  s.instance.y_axis = s.instance.normal_y = vec3(0.0f, 1.0f, 0.0f);
  s.instance.z_axis = s.instance.normal_z = vec3(0.0f, 0.0f, 1.0f);
  s.mesh.positions.v = corners;
  s.mesh.triangles.v = s.mesh.corners.v = &triangle;
  s.mesh.uv.v = uvs;
  s.mesh.flags = MESH_HAS_GENERATED;
  s.textures.tangents.v = tangents;
  s.textures.generated.v = corners;
  s.textures.attributes.v = colors;
  s.textures.attribute_table.v = attribute_table;
  s.textures.corner_count = 3u;
  s.textures.uv_layers = s.textures.tangent_layers = 1u;
  s.textures.attribute_words = 2u;
  s.space.x = vec4(0.0f, 2.0f, 0.0f, 0.3f);
  s.space.y = vec4(-2.0f, 0.0f, 0.1f, 0.0f);
  s.space.z = vec4(0.0f, 0.1f, 2.0f, 1.0f);
  s.image.width = s.image.height = 64u;
  s.image.channels = 4u;
  s.image.format = TEXELS_UINT8;
  s.image.srgb = 1u;
  for (int i = 0; i < 64 * 64; ++i) s.texels.push_back(static_cast<std::uint32_t>(random()));
  s.image.texels.v = s.texels.data();
  for (int i = 0; i < 3 * CURVE_ENTRIES; ++i) s.tables.push_back(unit());
  s.data.instances.v = &s.instance;
  s.data.meshes.v = &s.mesh;
  s.data.mesh_textures.v = &s.textures;
  s.data.object_spaces.v = &s.space;
  s.data.camera_space = s.space;
  s.data.camera_window = vec4(-0.5f, -0.5f, 1.0f, 1.0f);
  s.data.uv_layer_count = 1u;
  s.data.tables.v = s.tables.data();
  s.data.textures.v = &s.image;
  s.data.texture_count = 1u;
}

std::vector<ShaderPoint> make_points(std::mt19937 &random) {
  const auto unit = [&] { return static_cast<float>(random() >> 8) * 5.9604645e-8f; };
  std::vector<ShaderPoint> points(LANES);
  for (ShaderPoint &at : points) {
    at = background_point(normalize(vec3(unit(), unit() - 0.5f, 0.2f + unit())));
    at.u = 0.5f * unit();
    at.v = 0.5f * unit();
    at.p = corners[0] * (1.0f - at.u - at.v) + corners[1] * at.u + corners[2] * at.v;
    at.side = unit() < 0.5f ? -1.0f : 1.0f;
    at.instance = unit() < 0.05f ? INVALID_ID : 0u;
    at.footprint = 0.01f * unit();
  }
  return points;
}

// ---- Ops

struct Row {
  const char *name;
  uint op;
  uint mode;
  const char *arguments;         // of ops.inc
  bool vector;
  std::vector<float> constants;  // of the last arguments; the others vary
};

#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) \
  {#NAME, NUMBER, 0u, #ARGUMENTS, #RESULT[0] == 'v', {}},
const std::vector<Row> list = {
#include "program/ops.inc"
};
#undef PROGRAM_OP

Row row(uint op, uint mode, std::vector<float> constants = {}) {
  Row r = *std::find_if(list.begin(), list.end(), [&](const Row &one) { return one.op == op; });
  r.mode = mode;
  r.constants = std::move(constants);
  return r;
}

std::vector<Row> rows() {
  std::vector<Row> all;
  const auto each = [&](uint op, uint modes, std::vector<float> constants = {}) {
    for (uint mode = 0u; mode < modes; ++mode) all.push_back(row(op, mode, constants));
  };
  const uint shifted = SHIFT_DX << 30 | 0x3800u;
  for (const uint op : {OP_POSITION, OP_PARAMETRIC, OP_GENERATED, OP_OBJECT_POSITION, OP_CAMERA_POSITION, OP_WINDOW}) {
    for (const uint mode : {0u, shifted}) all.push_back(row(op, mode));
  }
  for (const uint op : {OP_ATTRIBUTE, OP_ATTRIBUTE_ALPHA, OP_ATTRIBUTE_FAC}) {
    for (const uint mode : {0u, shifted}) {
      for (const float layer : {0.0f, 1.0f}) all.push_back(row(op, mode, {layer}));
    }
  }
  for (const uint op : {OP_NORMAL, OP_TRUE_NORMAL, OP_INCOMING, OP_BACKFACING, OP_FRESNEL}) each(op, 1u);
  each(OP_LIGHT_PATH, 14u);
  each(OP_LAYER_WEIGHT, 2u);
  each(OP_NORMAL_MAP, 5u, {0.7f, 0.0f});
  each(OP_BUMP, 2u);
  each(OP_TANGENT, 3u);
  each(OP_UV_TANGENT, 1u, {0.0f});
  each(OP_MATH, 41u);
  all.push_back(row(OP_MATH, 2u | MATH_CLAMP));
  for (const uint op : {OP_MAP_RANGE_F, OP_MAP_RANGE_V}) {
    for (uint mode = 0u; mode < 8u; ++mode) all.push_back(row(op, (mode & 3u) | (mode >> 2) << 8));
  }
  each(OP_MAPPING, 4u);
  each(OP_VECTOR_MATH_V, 28u);
  each(OP_MIX_COLOR, 19u);
  each(OP_COMBINE_COLOR, 3u);
  each(OP_SEPARATE_COLOR, 3u);
  each(OP_HSV, 1u);
  each(OP_BRIGHT_CONTRAST, 1u);
  // Detail 4.3, roughness 0.5, lacunarity 2, offset 0, gain 1; distortion.
  for (const uint op : {OP_NOISE_F, OP_NOISE_V}) {
    for (uint mode = 0u; mode < 20u; ++mode) all.push_back(row(op, mode, {3.0f, 4.3f, 0.5f, 2.0f, 0.5f, 1.0f, 0.0f}));
    for (uint mode = 12u; mode < 16u; ++mode) {
      all.push_back(row(op, mode | NOISE_NORMALIZE, {3.0f, 4.0f, 0.5f, 2.0f, 0.0f, 1.0f, 0.0f}));
      all.push_back(row(op, mode | NOISE_NORMALIZE, {3.0f, 2.5f, 0.5f, 2.0f, 0.0f, 1.0f, 0.6f}));
    }
    all.push_back(row(op, 14u | NOISE_NORMALIZE));
  }
  // Scale, detail, roughness, lacunarity, smoothness, exponent, randomness.
  for (uint mode = 0u; mode < 16u; ++mode) {
    for (const float detail : {0.0f, 1.5f}) {
      for (const uint output : {0u, 1u}) {
        const uint whole = mode | output << 8 | (detail > 0.0f ? VORONOI_NORMALIZE : 0u);
        all.push_back(row(OP_VORONOI_F, whole, {3.0f, detail, 0.5f, 2.0f, 0.7f, 1.0f, 0.9f}));
        all.push_back(row(OP_VORONOI_V, whole, {3.0f, detail, 0.5f, 2.0f, 0.7f, 1.0f, 0.9f}));
      }
    }
  }
  all.push_back(row(OP_VORONOI_F, 2u | VORONOI_SMOOTH_F1 << 2, {3.0f, 0.0f, 0.5f, 2.0f, 0.0f, 1.0f, 0.9f}));
  all.push_back(row(OP_VORONOI_F, 2u | VORONOI_SMOOTH_F1 << 2, {1.0f, 0.9f}));
  each(OP_WHITE_NOISE_F, 4u);
  each(OP_WHITE_NOISE_V, 4u);
  for (uint mode = 0u; mode < 96u; ++mode) {
    if ((mode & 24u) == 0u || (mode & 7u) == 1u)
      all.push_back(row(OP_WAVE_F, mode, {2.0f, 0.0f, 2.0f, 1.0f, 0.5f, 0.3f}));
  }
  all.push_back(row(OP_WAVE_F, 0u, {2.0f, 1.5f, 2.0f, 1.0f, 0.5f, 0.3f}));
  all.push_back(row(OP_WAVE_F, 0u));
  each(OP_MAGIC_V, 11u);
  each(OP_GRADIENT_F, 7u);
  each(OP_CHECKER_F, 1u, {5.0f});
  for (const uint mode : {514u, 513u, 258u, 257u, 0u, 772u}) {
    all.push_back(row(OP_BRICK_F, mode, {3.0f, 0.02f, 0.1f, 0.0f, 0.5f, 0.25f, 0.5f, 1.5f}));
  }
  each(OP_RAMP_V, 2u, {0.0f, 32.0f});
  each(OP_RAMP_ALPHA, 2u, {0.0f, 32.0f});
  each(OP_CURVE_F, 2u, {0.0f, 0.1f, 0.8f, 0.9f});
  each(OP_RGB_CURVE_V, 2u, {0.0f, 0.1f, 0.8f, 0.9f});
  each(OP_VECTOR_CURVE_V, 2u, {0.0f, -0.5f, 0.8f, 0.9f});
  for (uint mode = 0u; mode < 64u; ++mode) {
    all.push_back(row(OP_IMAGE_V, mode, {0.0f, 0.2f, 0.2f, 0.7f, 0.4f}));
    all.push_back(row(OP_IMAGE_F, mode | IMAGE_UNASSOCIATE, {0.0f, 0.2f, 0.2f, 0.7f, 0.4f}));
  }
  return all;
}

// ---- One row

std::size_t numbers(const char *arguments) {
  std::size_t n = 0;
  for (; *arguments != '\0'; ++arguments) n += *arguments == 'v' ? 3u : 1u;
  return n;
}

template <class Run>
double nanoseconds(Run run) {
  double best = 1e30;
  for (int trial = 0; trial < 3; ++trial) {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
    best = std::min(best, took.count() / static_cast<double>(LANES));
  }
  return best;
}

// An instruction whose varying arguments are the first registers, and whose result comes behind them.
std::size_t write_code(TestScene &s, const Row &r, std::size_t count) {
  s.code.clear();
  s.constants = r.constants;
  const std::size_t varying = count - r.constants.size();
  std::uint32_t arguments = 0u;
  s.code.assign(2u, 0u);
  std::size_t place = 0;
  for (const char *c = r.arguments; *c != '\0'; ++c, ++arguments) {
    const bool vector = *c == 'v';
    const bool constant = place >= varying;
    const std::size_t at = constant ? place - varying : place;
    s.code.push_back(static_cast<std::uint32_t>(at) | (vector ? REFERENCE_VECTOR : 0u) |
                     (constant ? REFERENCE_CONSTANT : 0u));
    place += vector ? 3u : 1u;
  }
  s.code[0] = r.op | (r.vector ? PROGRAM_VECTOR : 0u) | arguments << PROGRAM_COUNT_SHIFT |
              static_cast<std::uint32_t>(count) << PROGRAM_RESULT_SHIFT;
  s.code[1] = r.mode;
  s.data.program_code.v = s.code.data();
  s.data.program_constants.v = s.constants.data();
  return varying;
}

int compare(TestScene &s, const std::vector<ShaderPoint> &points, const Row &r, std::mt19937 &random) {
  const std::size_t count = numbers(r.arguments);
  const std::size_t varying = write_code(s, r, count);
  std::vector<float> registers((count + 3) * kProgramStride);
  for (std::size_t k = 0; k < varying; ++k) {
    for (std::size_t i = 0; i < LANES; ++i) {
      registers[k * kProgramStride + i] = static_cast<float>(random() >> 8) * 1.7881394e-7f - 1.0f;  // -1 ... 2
    }
  }
  const std::vector<std::uint32_t> constants(LANES, 0u);
  // A number that is no multiple of any vector's width.
  const int n = static_cast<int>(LANES) - 5;
  const ProgramBatch batch{&s.data, points.data(), constants.data(), n, registers.data()};
  const auto end = static_cast<std::uint32_t>(s.code.size());
  const double in_lanes = nanoseconds([&] { COTORRA_PROGRAM_NAME(batch, 0u, end); });
  std::vector<vec3> alone(LANES);
  const double by_one = nanoseconds([&] {
    ProgramArguments a{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      for (std::size_t k = 0; k < count; ++k) {
        a.v[k] = k < varying ? registers[k * kProgramStride + i] : r.constants[k - varying];
      }
      alone[i] = program_op(s.data, points[i], r.op, r.mode, a);
    }
  });
  int differ = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const float *result = registers.data() + count * kProgramStride + i;
    const float expected[] = {alone[i].x, alone[i].y, alone[i].z};
    bool same = true;
    for (std::size_t c = 0; c < (r.vector ? 3u : 1u); ++c) {
      const float got = result[c * kProgramStride];
      // The sign of 0 and the bits of a NaN are nobody's business.
      same &= got == expected[c] || (got != got && expected[c] != expected[c]);
    }
    differ += !same;
  }
  std::printf("%-16s %6x %8.1f %8.1f %6.1f  %d\n", r.name, r.mode, in_lanes, by_one, by_one / in_lanes, differ);
  return differ;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  TestScene scene;
  fill(scene, random);
  const std::vector<ShaderPoint> points = make_points(random);
  std::printf("%-16s %6s %8s %8s %6s  %s\n", "op", "mode", "ns/lane", "alone", "ratio", "lanes that differ");
  int differ = 0;
  for (const Row &r : rows()) differ += compare(scene, points, r, random);
  return differ != 0;
}

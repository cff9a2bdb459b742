// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the table by which the world is sampled: brightness over cells of longitude and latitude, less what bounces
// find as well, cumulated. How directions are drawn from it is told in kernels/light/world_light.h.
#include "world_table.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <thread>

#include "every_feature.h"

#include "../kernels/integrator.h"
#include "cpu_program.h"
#include "cumulate.h"
#include "memory.h"
#include "program_steps.h"
#include "program_walk.h"

namespace cotorra {
namespace {

constexpr uint kUsualWidth = 1024;   // where no image tells: Cycles' default
constexpr uint kLeastWidth = 256;    // an image of few texels may stand beside what is finer
constexpr uint kLargestWidth = 4096;
constexpr uint kSpread = 2;          // points of a cell in each direction where no image tells how fine the world is
// Steps of the world's program for a whole table: of the usual size, where a point takes 512. What costs more has a
// coarser table, down to this width: any table is right, and a path that meets such a world costs as much again.
constexpr double kMostSteps = 1024.0 * 512.0 * (kSpread * kSpread) * 512.0;
constexpr uint kCoarsestWidth = 64;
// Worlds whose brightness above the mean is a smaller share of all of it light surfaces well enough by bounces alone.
constexpr double kLeastShare = 0.05;
// Between these is the share of samples that go to a sun.
constexpr uint kSunPoints = 256;  // on its disc, which tell how bright it is
constexpr double kLeastSun = 0.1, kMostSun = 0.9;

// The world's program over batches of directions.
class WorldProbe {
 public:
  WorldProbe(const SceneData &scene, uint registers)
      : scene_(scene), run_(choose_cpu_program()), registers_(std::size_t{std::max(registers, 1u)} * kProgramStride) {
    points_.reserve(kProgramLanes);
  }

  // Luminance, at least 0, along each direction, as rays of this one of VISIBLE_* see it.
  void luminances(std::span<const vec3> directions, uint kind, std::span<float> out) {
    const ProgramPart part = scene_.world_program;
    const std::vector<uint> constants(kProgramLanes, scene_.world_constants);
    for (std::size_t first = 0; first < directions.size(); first += kProgramLanes) {
      const std::size_t n = std::min<std::size_t>(directions.size() - first, kProgramLanes);
      points_.clear();
      for (std::size_t i = 0; i < n; ++i) points_.push_back(point(directions[first + i], kind));
      run_({&scene_, points_.data(), constants.data(), static_cast<int>(n), registers_.data()}, part.first, part.end);
      for (std::size_t i = 0; i < n; ++i) {
        LaneRegisters lane{{registers_.data() + i}};
        const vec3 light = light_numbers(program_vector(scene_, scene_.world_constants, part.result, lane));
        out[first + i] = std::max(luminance(light), 0.0f);
      }
    }
  }

 private:
  static ShaderPoint point(vec3 direction, uint kind) {
    ShaderPoint at = background_point(direction);
    at.ray_kind = kind == VISIBLE_TRANSMISSION ? kind : kind | RAY_REFLECTED;
    at.bounce = 1;
    at.diffuse_bounces = kind == VISIBLE_DIFFUSE ? 1 : 0;
    at.glossy_bounces = kind == VISIBLE_GLOSSY ? 1 : 0;
    at.transmission_bounces = kind == VISIBLE_TRANSMISSION ? 1 : 0;
    return at;
  }

  const SceneData &scene_;
  RunProgram run_;
  std::vector<float> registers_;
  std::vector<ShaderPoint> points_;
};

uint first_kind(uint kinds) {
  for (const uint kind : {VISIBLE_DIFFUSE, VISIBLE_GLOSSY, VISIBLE_TRANSMISSION}) {
    if ((kinds & kind) != 0) return kind;
  }
  return VISIBLE_CAMERA;
}

std::vector<vec3> directions_of_row(uint width, uint height, uint y) {
  std::vector<vec3> row(width);
  float across;
  for (uint x = 0; x < width; ++x) {
    const vec2 square((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                      (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
    row[x] = world_direction(square, across);
  }
  return row;
}

// Calls work(probe, row) for every row, on all cores; each row is one thread's.
template <class Work>
void each_row(const SceneData &scene, uint registers, uint rows, Work work) {
  std::atomic<uint> next{0};
  const auto take = [&] {
    WorldProbe probe(scene, registers);
    for (uint y = next++; y < rows; y = next++) work(probe, y);
  };
  const uint threads = std::clamp(std::thread::hardware_concurrency(), 1u, rows);
  std::vector<std::jthread> others;
  for (uint i = 1; i < threads; ++i) others.emplace_back(take);
  take();
}

// A texel of an image that is filtered reaches half a texel into its neighbours: each cell takes what lies there.
std::vector<float> softened(const std::vector<float> &cells, uint width, uint height) {
  const auto at = [&](uint x, uint y) { return cells[std::size_t{y} * width + x]; };
  std::vector<float> out(cells.size());
  for (uint y = 0; y < height; ++y) {
    const uint rows[3] = {y > 0 ? y - 1 : y, y, y + 1 < height ? y + 1 : y};
    for (uint x = 0; x < width; ++x) {
      const uint columns[3] = {x > 0 ? x - 1 : width - 1, x, x + 1 < width ? x + 1 : 0};
      float sum = 0.0f;
      for (const uint row : rows) {
        const float line = 0.125f * (at(columns[0], row) + at(columns[2], row)) + 0.75f * at(x, row);
        sum += (row == y ? 0.75f : 0.125f) * line;
      }
      out[std::size_t{y} * width + x] = sum;
    }
  }
  return out;
}

// Takes the mean over all directions from each cell: bounces find that much everywhere (Karlik et al. 2019). Returns
// which share of all light, as a surface that faces all of it would get it, is left.
double take_mean(std::vector<float> &cells, uint width, uint height, double &light) {
  double sum = 0.0;
  for (uint y = 0; y < height; ++y) {
    double row = 0.0;
    for (uint x = 0; x < width; ++x) row += static_cast<double>(cells[std::size_t{y} * width + x]);
    sum += row * (world_row_edge(y + 1, height) - world_row_edge(y, height));
  }
  light = sum * 2.0 * std::numbers::pi / static_cast<double>(width);
  const double mean = sum / (2.0 * static_cast<double>(width));
  double left = 0.0;
  for (uint y = 0; y < height; ++y) {
    double row = 0.0;
    for (uint x = 0; x < width; ++x) {
      float &cell = cells[std::size_t{y} * width + x];
      cell = static_cast<float>(std::max(static_cast<double>(cell) - mean, 0.0));
      row += static_cast<double>(cell);
    }
    left += row * (world_row_edge(y + 1, height) - world_row_edge(y, height));
  }
  return sum > 0.0 ? left / sum : 0.0;
}

bool shows_sun(const WorldSun &sun, vec3 direction) {
  const vec3 difference = direction - sun.direction;
  return dot(difference, difference) < 2.0f * sun.cap;
}

// The sun's light, as a surface that faces it would get it.
double light_of_sun(const SceneData &scene, uint registers, uint kind, const WorldSun &sun) {
  if (!(sun.cap > 0.0f)) return 0.0;
  vec3 t, b;
  orthonormal_basis(sun.direction, t, b);
  std::vector<vec3> directions;
  for (uint i = 0; i < kSunPoints; ++i) {
    directions.push_back(to_world(cone_from_square(sampler_pair(i, 0x5a17u), sun.cap), t, b, sun.direction));
  }
  std::vector<float> light(kSunPoints);
  WorldProbe(scene, registers).luminances(directions, kind, light);
  double sum = 0.0;
  for (const float l : light) sum += static_cast<double>(l);
  return sum / kSunPoints * 2.0 * std::numbers::pi * static_cast<double>(sun.cap);
}

}  // namespace

// As many points as the program may be run for: first fewer of each cell, then fewer cells, where the user chose none.
static WorldTableSize afforded(const SceneData &scene, WorldTableSize size, bool chosen) {
  const double steps = program_steps(scene, scene.world_program, scene.world_constants);
  const auto too_many = [&] {
    return steps * static_cast<double>(size.width * size.height) * static_cast<double>(size.spread * size.spread) >
           kMostSteps;
  };
  while (size.spread > 1 && too_many()) --size.spread;
  while (!chosen && size.width >= 2 * kCoarsestWidth && too_many()) {
    size.width /= 2;
    size.height /= 2;
  }
  return size;
}

WorldTableSize world_table_size(const SceneData &scene, uint resolution) {
  if (resolution > 0) {
    const uint width = std::clamp(resolution, 4u, kLargestWidth);
    return afforded(scene, {width, width / 2, kSpread}, true);
  }
  uint width = 0, height = 0;
  each_instruction(scene, scene.world_program, scene.world_constants, [&](const ProgramInstruction &in) {
    const std::optional<float> image = in.op == OP_ENVIRONMENT_V ? in.argument(1) : std::nullopt;
    if (!image) return;
    const Texture &texture = scene.textures.v[static_cast<uint>(*image)];
    width = std::max(width, texture.width);
    height = std::max(height, texture.height);
  });
  if (width == 0) return afforded(scene, {kUsualWidth, kUsualWidth / 2, kSpread}, false);
  width = std::max(width, kLeastWidth);
  height = std::max(height, kLeastWidth / 2);
  const uint spread = (std::max(width, 2 * height) + kLargestWidth - 1) / kLargestWidth;
  return afforded(scene, {width / spread, height / spread, spread}, false);
}

uint world_same_kinds(const SceneData &scene, uint registers, uint kinds) {
  bool asks = false;  // what kind of ray it is
  each_instruction(scene, scene.world_program, scene.world_constants,
                   [&](const ProgramInstruction &in) { asks |= in.op == OP_LIGHT_PATH; });
  if (!asks) return kinds & (VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION);
  constexpr uint kWidth = 64, kHeight = 32;
  const uint first = first_kind(kinds);
  uint same = first & kinds;
  WorldProbe probe(scene, registers);
  for (const uint kind : {VISIBLE_DIFFUSE, VISIBLE_GLOSSY, VISIBLE_TRANSMISSION}) {
    if ((kinds & kind) == 0 || kind == first) continue;
    bool equal = true;
    for (uint y = 0; equal && y < kHeight; ++y) {
      const std::vector<vec3> row = directions_of_row(kWidth, kHeight, y);
      std::vector<float> one(kWidth), other(kWidth);
      probe.luminances(row, first, one);
      probe.luminances(row, kind, other);
      equal = one == other;
    }
    if (equal) same |= kind;
  }
  return same;
}

WorldTable make_world_table(const SceneData &scene, uint registers, uint kinds, WorldTableSize size,
                            const WorldSun &sun) {
  const uint width = size.width, height = size.height;
  const std::size_t count = std::size_t{width} * height;
  WorldTable table;
  with_memory(3 * count * sizeof(float), "the brightness of the world", [&] {
    // 1. The mean of each cell.
    std::vector<float> cells(count, 0.0f);
    each_row(scene, registers, height, [&](WorldProbe &probe, uint y) {
      std::vector<float> light(std::size_t{width} * size.spread);
      for (uint part = 0; part < size.spread; ++part) {
        const std::vector<vec3> row =
            directions_of_row(width * size.spread, height * size.spread, y * size.spread + part);
        probe.luminances(row, first_kind(kinds), light);
        for (std::size_t x = 0; x < light.size(); ++x) {
          if (!shows_sun(sun, row[x])) cells[std::size_t{y} * width + x / size.spread] += light[x];
        }
      }
    });
    const float points = static_cast<float>(size.spread * size.spread);
    for (float &cell : cells) cell /= points;
    // 2. What bounces do not find as well.
    cells = softened(cells, width, height);
    const double sun_light = light_of_sun(scene, registers, first_kind(kinds), sun);
    double light = 0.0;  // that is left in the table
    const double share = take_mean(cells, width, height, light);
    if (share < kLeastShare && !(sun_light > kLeastShare * light)) return;
    if (sun_light > 0.0) {
      table.sun_share = static_cast<float>(std::clamp(sun_light / (sun_light + share * light), kLeastSun, kMostSun));
    }
    // 3. Cumulate the rows' cells, then the rows by what they fill of the sphere.
    table.cumulated.resize(count + height);
    cumulate_world(cells, width, height, table.cumulated.data());
    table.width = width;
    table.height = height;
  });
  return table;
}

}  // namespace cotorra

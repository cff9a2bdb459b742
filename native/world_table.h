// SPDX-License-Identifier: GPL-3.0-or-later
// How bright the world is by direction: the table that kernels/light/world_light.h draws from, made once for a scene.
// What the world's program computes is told in kernels/program/; it is run here, and not understood.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../kernels/scene_types.h"
#include "images.h"

namespace cotorra {

// Cumulated brightness of each row's cells, then of the rows; empty where bounces find the world as well.
struct WorldTable {
  std::vector<float> cumulated;
  uint width = 0;
  uint height = 0;
  float sun_share = 0.0f;  // of samples, for the sun
};

// A disc that the world's program shows, which is sampled by itself.
struct WorldSun {
  vec3 direction{0.0f, 0.0f, 1.0f};  // unit, to its middle
  float cap = 0.0f;                  // 1 - cos of half the angle across; 0: there is none
};

struct WorldTableSize {
  uint width, height;  // cells
  uint spread;         // points of a cell in each direction, of which it has the mean
};

// All that a table is made from; nullopt where its program asks for more of the scene.
struct WorldSource {
  std::vector<std::uint32_t> words;  // the shader as it was read, the kinds of rays that it lights, the size, the sun
  // Of each image its memory, width, height, channels, format and colour space, as long as its owner lives.
  std::vector<std::array<std::uintptr_t, 6>> images;
  bool operator==(const WorldSource &) const = default;
};
std::optional<WorldSource> world_source(const ShaderInput &shader, std::span<const ImageInput> images, uint kinds,
                                        int resolution, const WorldSun &sun);

// How the world is sampled, which the next scene takes over where its world has the same source.
struct SampledWorld {
  std::optional<WorldSource> source;
  uint kinds = 0;  // world_same_kinds
  WorldTable table;
};

// The size of a table: `resolution` cells around, where that is not 0, or as many as the largest environment image in
// the world's program has texels, within bounds. Programs that take much work are run for fewer points.
WorldTableSize world_table_size(const SceneData &scene, uint resolution);

// The kinds of rays (VISIBLE_*, of those in `kinds`) to which the world looks as it does to diffuse ones, or to the
// first of them that there is.
uint world_same_kinds(const SceneData &scene, uint registers, uint kinds);

// Runs the world's program, which keeps `registers` numbers, in all directions as rays of the first of `kinds` see it,
// on all cores.
WorldTable make_world_table(const SceneData &scene, uint registers, uint kinds, WorldTableSize size,
                            const WorldSun &sun);

}  // namespace cotorra

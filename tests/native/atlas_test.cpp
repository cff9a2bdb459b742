// SPDX-License-Identifier: GPL-3.0-or-later
// The light tree and the world's table over arrays, for the stability atlas (scripts/charting/stability_samplers.py):
// what they draw, and the probability that they claim. What is good enough, the atlas says.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "cumulate.h"
#include "light_tree.h"

namespace cotorra {
constexpr uint KERNEL_FEATURES = ~0u;
}

#include "light/light_tree.h"
#include "light/world_light.h"

using namespace cotorra;

namespace {

float number(std::mt19937 &random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

vec3 direction(std::mt19937 &random) {
  const float z = number(random, -1.0f, 1.0f), angle = number(random, 0.0f, 6.2831853f);
  const float r = std::sqrt(1.0f - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace

extern "C" {

// `lights` small ones, which shine to both sides, in a cube of this half size about the origin: a third of them points.
// From a receiver at p: the probability of each, by the way from its leaf, and how often `samples` picks found it; the
// last entry of `found` is how often none was. Returns the largest relative difference between the probability that a
// pick told and that of the light's place.
double test_light_tree(std::size_t lights, float size, const float *p, std::size_t samples, std::uint32_t seed,
                       double *chance, double *found) {
  std::mt19937 random(seed);
  std::vector<LightBounds> bounds(lights);
  for (std::size_t i = 0; i < lights; ++i) {
    LightBounds &b = bounds[i];
    const vec3 at(number(random, -size, size), number(random, -size, size), number(random, -size, size));
    const float r = i % 3 == 0 ? 0.0f : number(random, 0.0f, 0.02f) * size;
    b.axis = direction(random);
    b.energy = number(random, 0.1f, 2.0f) * size * size;
    b.box.add(at - vec3(r));
    b.box.add(at + vec3(r));
    b.cos_e = 0.0f;
    if (i % 3 == 0) {
      b.cos_o = -1.0f;
    } else {
      b.flags = LIGHT_CHILD_TWO_SIDED;
    }
  }
  const LightTree tree = build_light_tree(bounds, 0);
  SceneData scene{};
  scene.light_nodes = {tree.nodes.data()};
  scene.light_parents = {tree.parents.data()};
  scene.light_places = {tree.places.data()};
  const LightReceiver at{{p[0], p[1], p[2]}, normalize(vec3(0.3f, -0.2f, 0.9f)), 1, 0};
  for (std::size_t i = 0; i < lights; ++i) {
    chance[i] = static_cast<double>(light_tree_probability(scene, tree.places[i], at));
  }
  const LightWeights root = light_weights(scene, 0, at);
  double worst = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    float probability;
    float u = number(random, 0.0f, 0.99999994f);
    const uint light = light_tree_pick(scene, at, root, u, number(random, 0.0f, 1.0f), probability);
    const std::size_t i = light == INVALID_ID ? lights : light & LIGHT_CHILD_INDEX;
    found[i] += 1.0;
    if (i < lights) worst = std::max(worst, std::abs(static_cast<double>(probability) / chance[i] - 1.0));
  }
  return worst;
}

static SceneData scene_of_world(const float *cells, std::uint32_t width, std::uint32_t height,
                                std::vector<float> &table) {
  table.resize(std::size_t{width} * height + height);
  cumulate_world({cells, std::size_t{width} * height}, width, height, table.data());
  SceneData scene{};
  scene.world_table = {table.data()};
  scene.world_width = width;
  scene.world_height = height;
  return scene;
}

// A world of these cells' brightness: `samples` directions, (x, y, z) each, their pdf as they were drawn and as rays of
// the same directions are told; u: two numbers for each.
void test_world(const float *cells, std::uint32_t width, std::uint32_t height, const vec2 *u, std::size_t samples,
                vec3 *directions, float *drawn, float *told) {
  std::vector<float> table;
  const SceneData scene = scene_of_world(cells, width, height, table);
  for (std::size_t i = 0; i < samples; ++i) {
    directions[i] = world_sample(scene, u[i], drawn[i]);
    told[i] = world_pdf(scene, directions[i]);
  }
}

// What the table of that world gives rays, for these directions.
void test_world_pdf(const float *cells, std::uint32_t width, std::uint32_t height, const vec3 *directions,
                    std::size_t count, float *told) {
  std::vector<float> table;
  const SceneData scene = scene_of_world(cells, width, height, table);
  for (std::size_t i = 0; i < count; ++i) told[i] = world_pdf(scene, directions[i]);
}
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The light tree over random lights: what it picks is as frequent as it says, probabilities add up to one, a light that
// shines on a receiver is never left out, and a walk along a ray comes by every lamp that it meets.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "light_tree.h"

namespace cotorra {
constexpr uint KERNEL_FEATURES = ~0u;
}

#include "light/light_tree.h"

namespace {

using namespace cotorra;

std::mt19937 generator(11);
float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(generator); }
vec3 point(float size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
vec3 direction() {
  const float z = number(-1.0f, 1.0f), angle = number(0.0f, 6.2831853f), r = std::sqrt(1.0f - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

void require(bool good, const char *what, double number = 0.0) {
  if (good) return;
  std::printf("%s: %g\n", what, number);
  std::exit(1);
}

// Points, spots, squares that shine to one side, triangles, suns.
LightBounds random_light(std::size_t kind, float size) {
  LightBounds b;
  const vec3 p = point(size);
  b.axis = direction();
  b.energy = number(0.1f, 2.0f);
  b.flags = kind < 4 ? LIGHT_CHILD_LAMPS : 0u;
  const float r = kind == 0 ? 0.0f : number(0.0f, 0.3f);
  b.box.add(p - vec3(r));
  b.box.add(p + vec3(r));
  b.cos_e = 0.0f;
  if (kind == 0) b.cos_o = -1.0f;
  if (kind == 1) b.cos_e = std::cos(number(0.05f, 1.5f));
  if (kind == 3) {
    b.flags |= LIGHT_CHILD_DISTANT;
    b.cos_o = std::cos(number(0.0f, 0.1f));
    b.box = {};
    b.box.add(vec3(0.0f));
  }
  if (kind == 4) b.flags |= LIGHT_CHILD_TWO_SIDED;
  return b;
}

struct World {
  std::vector<LightBounds> lights;
  std::size_t lamps;
  LightTree tree;
  SceneData scene{};

  // Lamps come first.
  World(std::size_t lamp_count, std::size_t triangles, float size) : lamps(lamp_count) {
    for (std::size_t i = 0; i < lamp_count; ++i) lights.push_back(random_light(i % 4, size));
    for (std::size_t i = 0; i < triangles; ++i)
      lights.push_back(random_light(4 + i % 2, size));  // they shine to both sides, or to one
    tree = build_light_tree(lights, lamps);
    scene.light_nodes = {tree.nodes.data()};
    scene.light_parents = {tree.parents.data()};
    scene.light_places = {tree.places.data()};
    scene.light_count = static_cast<uint>(lamps);
  }
  std::size_t index_of(uint light) const {
    return (light & LIGHT_CHILD_INDEX) + ((light & LIGHT_CHILD_LAMPS) != 0 ? 0 : lamps);
  }
};

// May a point of the light send something to the receiver? Looked for at random.
bool shines(const LightBounds &b, const LightReceiver &at) {
  for (int i = 0; i < 64; ++i) {
    const vec3 q(number(b.box.lo.x, b.box.hi.x), number(b.box.lo.y, b.box.hi.y), number(b.box.lo.z, b.box.hi.z));
    const bool distant = (b.flags & LIGHT_CHILD_DISTANT) != 0;
    const vec3 wi = distant ? b.axis : normalize(q - at.p);
    const float facing = dot(wi, at.n);
    if ((at.both_sides != 0 ? std::abs(facing) : facing) <= 1e-3f) continue;
    if (distant || b.cos_o < 0.0f) return true;
    const float along = -dot(wi, b.axis);
    const float sent = (b.flags & LIGHT_CHILD_TWO_SIDED) != 0 ? std::abs(along) : along;
    if (sent >= b.cos_e + 1e-3f) return true;
  }
  return false;
}

// Tail of the chi-square distribution by the cube root that is nearly normal (Wilson & Hilferty 1931).
double chance_of(double statistic, double freedom) {
  const double v = 2.0 / (9.0 * freedom);
  return 0.5 * std::erfc((std::cbrt(statistic / freedom) - (1.0 - v)) / std::sqrt(2.0 * v));
}

// Is what is left of the random numbers spread evenly, whatever was picked?
void check_even(const std::vector<double> &counts) {
  double sum = 0.0, statistic = 0.0;
  for (const double n : counts) sum += n;
  if (sum < 320.0) return;
  const double expected = sum / static_cast<double>(counts.size());
  for (const double n : counts) statistic += (n - expected) * (n - expected) / expected;
  const double chance = chance_of(statistic, static_cast<double>(counts.size()) - 1.0);
  require(chance > 1e-6, "what is left of the number is not even", chance);
}

void check_receiver(const World &world, const LightReceiver &at, std::size_t samples) {
  // 1. Probabilities by the way from the leaf, and lights that must not be left out.
  std::vector<double> chance(world.lights.size(), 0.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < chance.size(); ++i) {
    chance[i] = static_cast<double>(light_tree_probability(world.scene, world.tree.places[i], at));
    sum += chance[i];
    if (chance[i] == 0.0)
      require(!shines(world.lights[i], at), "a light that shines is left out", static_cast<double>(i));
  }
  require(sum < 1.0 + 1e-4, "probabilities add up to more than one", sum);
  // 2. What is picked, evenly over the random number; where no light is found, that is what is missing of one.
  const LightWeights root = light_weights(world.scene, 0, at);
  std::vector<double> found(chance.size() + 1, 0.0), left(16, 0.0);
  for (std::size_t k = 0; k < samples; ++k) {
    float probability;
    float u = number(0.0f, 0.99999994f);
    const uint light = light_tree_pick(world.scene, at, root, u, number(0.0f, 1.0f), probability);
    if (light == INVALID_ID) {
      found.back() += 1.0;
      continue;
    }
    const std::size_t i = world.index_of(light);
    require(std::abs(static_cast<double>(probability) / chance[i] - 1.0) < 1e-4, "picked with another probability",
            static_cast<double>(probability) / chance[i]);
    found[i] += 1.0;
    require(u >= 0.0f && u < 1.0f, "what is left of the number lies outside", static_cast<double>(u));
    left[static_cast<std::size_t>(u * 16.0f)] += 1.0;
  }
  check_even(left);
  chance.push_back(std::max(1.0 - sum, 0.0));
  // 3. Chi-square; lights that are expected less than 20 times are one cell.
  double statistic = 0.0, rare_expected = 0.0, rare_found = 0.0, cells = 0.0;
  for (std::size_t i = 0; i < chance.size(); ++i) {
    const double expected = chance[i] * static_cast<double>(samples);
    if (expected < 20.0) {
      rare_expected += expected;
      rare_found += found[i];
      continue;
    }
    statistic += (found[i] - expected) * (found[i] - expected) / expected;
    cells += 1.0;
  }
  if (rare_expected >= 20.0) {
    statistic += (rare_found - rare_expected) * (rare_found - rare_expected) / rare_expected;
    cells += 1.0;
  }
  if (cells < 2.0) return;
  require(chance_of(statistic, cells - 1.0) > 1e-6, "frequencies are not the probabilities", statistic);
}

void check_walk(const World &world) {
  const vec3 origin = point(8.0f), way = direction();
  const float far = number(1.0f, 20.0f);
  std::vector<bool> seen(world.lamps, false);
  uint place = 0;
  for (uint i = light_tree_next(world.scene, origin, way, far, place); i != INVALID_ID;
       i = light_tree_next(world.scene, origin, way, far, place)) {
    require(!seen[i], "a walk comes by twice", i);
    seen[i] = true;
  }
  for (std::size_t i = 0; i < world.lamps; ++i) {
    const LightBounds &b = world.lights[i];
    if ((b.flags & LIGHT_CHILD_DISTANT) != 0) continue;
    const vec3 to = (b.box.lo + b.box.hi) * 0.5f - origin;
    const float along = dot(to, way);
    const vec3 aside = to - way * along;
    const bool meets = along > 0.0f && along < far && length(aside) < 0.5f * (b.box.hi.x - b.box.lo.x);
    require(!meets || seen[i], "a walk misses a lamp", static_cast<double>(i));
  }
}

}  // namespace

int main() {
  const std::size_t sizes[][2] = {{1, 0}, {0, 2}, {9, 0}, {5, 4}, {98, 0}, {40, 300}, {3, 3000}};
  for (const auto &size : sizes) {
    const World world(size[0], size[1], 5.0f);
    const LightTree same = build_light_tree(world.lights, world.lamps);
    const auto same_bits = [](float a, float b) { return floatBitsToUint(a) == floatBitsToUint(b); };
    require(
        std::equal(same.nodes.begin(), same.nodes.end(), world.tree.nodes.begin(), world.tree.nodes.end(), same_bits),
        "two trees over the same lights differ");
    for (uint r = 0; r < 6; ++r) check_receiver(world, {point(7.0f), direction(), r % 2, 0}, 200000);
    for (int r = 0; r < 300; ++r) check_walk(world);
  }
  // Many, of which all lie in few places: no deep tree, and little memory.
  std::vector<LightBounds> many;
  for (std::size_t i = 0; i < 200000; ++i) {
    LightBounds b = random_light(4, 100.0f);
    if (i % 3 == 0) {
      b.box = {};
      b.box.add(vec3(1.0f, 2.0f, 3.0f));
    }
    many.push_back(b);
  }
  const LightTree tree = build_light_tree(many, 0);
  for (const uint leaf : tree.places) {
    int depth = 0;
    for (uint place = leaf; place != INVALID_ID; place = tree.parents[place / LIGHT_FANOUT]) ++depth;
    require(depth < 24, "a tree is too deep", depth);
  }
  const double bytes = static_cast<double>(tree.bytes()) / static_cast<double>(many.size());
  require(bytes < 80.0, "bytes a light", bytes);
  std::printf("%.1f bytes a light\n", bytes);
  return 0;
}

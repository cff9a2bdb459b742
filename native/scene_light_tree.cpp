// SPDX-License-Identifier: GPL-3.0-or-later
// The lights that are picked by a tree: triangles that emit, and lamps where there are many; and what bounds each.
// The tree itself is built in light_tree.cpp, and read in kernels/light/light_tree.h.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "every_feature.h"

#include "../kernels/light/light_tree.h"
#include "memory.h"
#include "scene.h"

namespace cotorra {
namespace {

constexpr float kFarthest = 1e15f;  // metres; squares of it are numbers
// Light samples at a path's first vertex, which fills the picture, where lamps are among those that are picked.
constexpr uint kPicks = 4;

float brightness(vec3 radiance) { return luminance(abs(radiance)); }

// Is a spot's cone the same in its own space as in the world's?
bool keeps_angles(const Light &light) {
  const float x = dot(light.local_x, light.local_x), y = dot(light.local_y, light.local_y);
  const float z = dot(light.local_z, light.local_z);
  const float skew = std::max({std::abs(dot(light.local_x, light.local_y)), std::abs(dot(light.local_y, light.local_z)),
                               std::abs(dot(light.local_z, light.local_x))});
  const float largest = std::max({x, y, z});
  return std::max(largest - std::min({x, y, z}), skew) <= 1e-3f * largest;
}

void bound_area(const Light &light, LightBounds &b) {
  for (const float u : {-light.half_u, light.half_u}) {
    for (const float v : {-light.half_v, light.half_v}) {
      b.box.add(light.position + light.local_x * u + light.local_y * v);
    }
  }
  const bool beam = light.tan_spread <= 0.0f;
  const float open = beam ? 1.0f : light.tan_spread * light.spread_scale;  // brightest, straight ahead
  const float share = (light.flags & LIGHT_ELLIPSE) != 0 ? 0.25f * std::numbers::pi_v<float> : 1.0f;
  b.axis = light.axis;
  b.cos_e = 1.0f / std::sqrt(1.0f + std::min(light.tan_spread * light.tan_spread, 1e30f));
  b.energy = brightness(light.radiance) * open * share * 4.0f * light.half_u * light.half_v;
}

LightBounds bounds_of(const Light &light) {
  LightBounds b;
  b.flags = LIGHT_CHILD_LAMPS;
  if (light.type == LIGHT_SUN) {
    b.flags |= LIGHT_CHILD_DISTANT;
    b.box.add(vec3(0.0f));
    b.axis = light.axis * -1.0f;
    b.cos_o = 1.0f - light.radius;
    b.energy =
        brightness(light.radiance) * (light.radius > 0.0f ? 2.0f * std::numbers::pi_v<float> * light.radius : 1.0f);
    return b;
  }
  if (light.type == LIGHT_AREA) {
    bound_area(light, b);
    return b;
  }
  b.box.add(light.position - vec3(light.radius));
  b.box.add(light.position + vec3(light.radius));
  const float disk = std::numbers::pi_v<float> * light.radius * light.radius;
  b.energy = brightness(light.radiance) * (light.radius > 0.0f ? disk : 1.0f);
  b.axis = light.axis;
  if (light.type == LIGHT_POINT) {
    b.cos_o = -1.0f;
  } else {
    b.cos_e = keeps_angles(light) ? std::clamp(1.0f - light.spot_versine, 0.0f, 1.0f) : 0.0f;
  }
  return b;
}

LightBounds bounds_of(const Emitter &e, const Material &material) {
  LightBounds b;
  b.box.add(e.v0);
  b.box.add(e.v0 + e.edge1);
  b.box.add(e.v0 + e.edge2);
  const vec3 n = cross(e.edge1, e.edge2);
  const float len = length(n);
  const uint dark = e.material & ~EMITTER_MATERIAL;
  b.axis = n * ((dark == EMITTER_DARK_ALONG ? -1.0f : 1.0f) / len);
  b.cos_e = 0.0f;
  if (dark == 0) b.flags = LIGHT_CHILD_TWO_SIDED;
  b.energy = 0.5f * len * brightness(material.emission);
  return b;
}

// EMITTER_DARK_*: the sides of its triangles' edges to which a material emits nothing.
uint dark_sides(const Material &m, bool mirrored) {
  const uint front = mirrored ? EMITTER_DARK_AGAINST : EMITTER_DARK_ALONG;
  const uint back = mirrored ? EMITTER_DARK_ALONG : EMITTER_DARK_AGAINST;
  return ((m.flags & MATERIAL_FRONT_DARK) != 0 ? front : 0u) | ((m.flags & MATERIAL_BACK_DARK) != 0 ? back : 0u);
}

// Shares of all energy, so that no product with them leaves the numbers; what has none, or lies nowhere, gets 0.
void share_energy(std::span<LightBounds> lights) {
  double sum = 0.0;
  for (LightBounds &b : lights) {
    const float farthest = max_component(max(abs(b.box.lo), abs(b.box.hi)));
    if (!(b.energy > 0.0f) || !(farthest < kFarthest)) b.energy = 0.0f;
    b.energy = std::min(b.energy, std::numeric_limits<float>::max());
    sum += static_cast<double>(b.energy);
  }
  for (LightBounds &b : lights) {
    if (b.energy > 0.0f) b.energy = std::max(static_cast<float>(static_cast<double>(b.energy) / sum), 1e-20f);
  }
}

}  // namespace

bool Scene::emits(const Instance &instance) const {
  if ((instance.visibility & (VISIBLE_DIFFUSE | VISIBLE_GLOSSY)) == 0) return false;  // no bounce sees it
  for (uint s = 0; s < instance.material_count; ++s) {
    if ((materials_[material_slots_[instance.material_base + s]].flags & MATERIAL_SAMPLED) != 0) return true;
  }
  return false;
}

void Scene::prepare_emitters() {
  for (std::size_t k = 0; k < instances_.size(); ++k) {
    const Instance &instance = instances_[k];
    const Mesh &mesh = meshes_[instance.mesh];
    if (!emits(instance)) continue;
    for (uint t = 0; t < mesh.triangle_count; ++t) {
      uint slot = 0;
      if ((mesh.flags & MESH_HAS_SLOTS) != 0) slot = std::min(mesh.slots.v[t], instance.material_count - 1);
      const uint material = material_slots_[instance.material_base + slot];
      if ((materials_[material].flags & MATERIAL_SAMPLED) == 0) continue;
      const uvec3 id = mesh.triangles.v[t];
      const auto world = [&](vec3 p) {
        return instance.x_axis * p.x + instance.y_axis * p.y + instance.z_axis * p.z + instance.origin;
      };
      Emitter e{};
      e.v0 = world(mesh.positions.v[id.x]);
      e.edge1 = world(mesh.positions.v[id.y]) - e.v0;
      e.edge2 = world(mesh.positions.v[id.z]) - e.v0;
      const float len = length(cross(e.edge1, e.edge2));
      if (!(len > 0.0f) || !std::isfinite(len)) continue;
      e.instance = static_cast<uint>(k);
      e.triangle = t;
      e.material = material | dark_sides(materials_[material], (instance.flags & INSTANCE_MIRRORED) != 0);
      if (emitters_.size() == emitters_.capacity()) {
        const std::size_t room = 2 * emitters_.size() + 64;
        with_memory(room * sizeof(Emitter), "the triangles that emit", [&] { emitters_.reserve(room); });
      }
      emitters_.push_back(e);
    }
  }
  data_.emitters = {emitters_.data()};
  data_.emitter_count = static_cast<uint>(emitters_.size());
}

void Scene::prepare_light_tree() {
  const auto begin = std::chrono::steady_clock::now();
  const bool lamps = lights_.size() > LIGHTS_AT_ONCE;
  if (!lamps && emitters_.empty()) return;
  if (emitters_.size() > LIGHT_CHILD_INDEX || lights_.size() > LIGHT_CHILD_INDEX) {
    throw std::invalid_argument("too many lights: " + std::to_string(lights_.size()) + " lamps and " +
                                std::to_string(emitters_.size()) + " triangles that emit");
  }
  // 1. Bounds of each; few lamps are all sampled, and stand in no tree.
  const std::size_t lamp_count = lights_.size(), count = lamp_count + emitters_.size();
  with_memory(count * 4 * sizeof(LightBounds), "the tree of " + std::to_string(count) + " lights", [&] {
    std::vector<LightBounds> bounds(count);
    for (std::size_t i = 0; lamps && i < lamp_count; ++i) {
      bounds[i] = bounds_of(lights_[i]);
      if ((lights_[i].flags & LIGHT_PROGRAM) != 0) bounds[i].energy *= light_programs_[i].mean;
    }
    for (std::size_t i = 0; i < emitters_.size(); ++i) {
      bounds[lamp_count + i] = bounds_of(emitters_[i], materials_[emitters_[i].material & EMITTER_MATERIAL]);
    }
    share_energy(bounds);
    light_tree_ = build_light_tree(bounds, lamp_count);
    place_emitters();
  });
  if (light_tree_.nodes.empty()) return;
  data_.light_nodes = {light_tree_.nodes.data()};
  data_.light_parents = {light_tree_.parents.data()};
  data_.light_places = {light_tree_.places.data()};
  data_.tree_picks = lamps ? kPicks : 1;
  features_ |= FEATURE_LIGHT_TREE;
  stats_.light_tree_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Scene::gather_node_sets() {
  if (light_links_.empty() || light_tree_.nodes.empty()) return;
  light_node_sets_.assign(light_tree_.parents.size() * LIGHT_FANOUT, {0u, 0u});
  for (std::size_t place = light_node_sets_.size(); place-- > 0;) {  // children come after their parents
    const std::size_t node = place / LIGHT_FANOUT;
    const uint child = floatBitsToUint(
        light_tree_.nodes[node * LIGHT_NODE_FLOATS + LIGHT_ROW_CHILD * LIGHT_FANOUT + place % LIGHT_FANOUT]);
    const uint index = child & LIGHT_CHILD_INDEX;
    if ((child & LIGHT_CHILD_LEAF) != 0) {
      const std::size_t link = (child & LIGHT_CHILD_LAMPS) != 0 ? index : lights_.size() + emitters_[index].instance;
      light_node_sets_[place] = light_links_[link].sets;
    }
    const uvec2 sets = light_node_sets_[place];
    const uint parent = light_tree_.parents[node];
    if (parent == INVALID_ID) continue;
    light_node_sets_[parent].x |= sets.x;
    light_node_sets_[parent].y |= sets.y;
  }
  data_.light_node_sets = {light_node_sets_.data()};
}

// From places of lamps and emitters to places of lamps, instances and triangles.
void Scene::place_emitters() {
  if (emitters_.empty()) return;
  const std::vector<uint> places = std::move(light_tree_.places);
  const std::size_t lamps = lights_.size();
  std::vector<uint> table(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(lamps));
  table.resize(lamps + instances_.size(), INVALID_ID);
  for (std::size_t i = 0; i < emitters_.size(); ++i) {
    const Emitter &e = emitters_[i];
    uint &first = table[lamps + e.instance];
    if (first == INVALID_ID) {
      first = static_cast<uint>(table.size());
      const std::size_t size = table.size() + meshes_[instances_[e.instance].mesh].triangle_count;
      if (size >= INVALID_ID) throw std::invalid_argument("too many triangles of meshes that emit");
      table.resize(size, INVALID_ID);
    }
    table[table[lamps + e.instance] + e.triangle] = places[lamps + i];
  }
  light_tree_.places = std::move(table);
}

}  // namespace cotorra

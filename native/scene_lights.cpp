// SPDX-License-Identifier: GPL-3.0-or-later
// Derives how lamps fall off and end at the edge of their cone, where that is not Blender's way
// (kernels/light/light_shape.h), the shapes of area lights, and marks lamps that a pass shows alone. The strength of
// lamps is scene.cpp's.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "scene.h"

namespace cotorra {
namespace {

constexpr float kWidest = 1e15f;  // metres; the square is a number
constexpr float kHard = 1e30f;  // scale of a ramp without a width: a step, and still a number

void require_choice(uint value, uint count, const char *name, std::size_t index) {
  if (value < count) return;
  throw std::invalid_argument(std::string("lights.") + name + "[" + std::to_string(index) +
                              "] = " + std::to_string(value) + ", must be below " + std::to_string(count));
}

void require_not_negative(float value, const char *name, std::size_t index) {
  if (value >= 0.0f && std::isfinite(value)) return;
  throw std::invalid_argument(std::string("lights.") + name + "[" + std::to_string(index) +
                              "] = " + std::to_string(value) + ", must be 0 or more");
}

// 1 / x of a width or a range; 0 gives what is as good as infinite.
float inverse(double x) { return x > 1e-30 ? static_cast<float>(1.0 / x) : kHard; }

double versine(double angle) { return 2.0 * std::pow(std::sin(0.5 * angle), 2.0); }

}  // namespace

void set_lamp_pass(int pass, Light &light) {
  light.group = ((pass + 1) << LAMP_PASS_SHIFT) | (light.group & ((1 << LAMP_PASS_SHIFT) - 1));
}

void validate_light_shapes(const LightsInput &in) {
  const std::size_t n = in.type.size();
  if (!in.pass_index.empty() && in.pass_index.size() != n) {
    throw std::invalid_argument("lights.pass_index has " + std::to_string(in.pass_index.size()) +
                                " entries, expected " + std::to_string(n));
  }
  for (std::size_t i = 0; i < in.pass_index.size(); ++i) {
    if (in.pass_index[i] < -1 || in.pass_index[i] >= 0x7fff) {
      throw std::invalid_argument("lights.pass_index[" + std::to_string(i) + "] = " + std::to_string(in.pass_index[i]) +
                                  ", must be from -1 to 32766");
    }
  }
  if (in.falloff.empty()) return;
  if (in.falloff.size() != n || in.range.size() != n || in.polynomial.size() != n || in.spot_edge.size() != n ||
      in.inner_angle.size() != n || in.outer_angle.size() != n) {
    throw std::invalid_argument("lights.falloff and the arrays that go with it must have " + std::to_string(n) +
                                " entries each");
  }
  for (std::size_t i = 0; i < n; ++i) {
    require_choice(in.falloff[i], 3, "falloff", i);
    require_choice(in.spot_edge[i], 3, "spot_edge", i);
    require_not_negative(in.range[i], "range", i);
    require_not_negative(in.polynomial[i].x, "polynomial", i);
    require_not_negative(in.polynomial[i].y, "polynomial", i);
    require_not_negative(in.polynomial[i].z, "polynomial", i);
    require_not_negative(in.inner_angle[i], "inner_angle", i);
    require_not_negative(in.outer_angle[i], "outer_angle", i);
  }
}

void validate_area_lights(const LightsInput &in) {
  const std::size_t n = in.type.size();
  const bool any = std::find(in.type.begin(), in.type.end(), LIGHT_AREA) != in.type.end();
  if (!any && in.size_y.empty() && in.spread.empty() && in.ellipse.empty()) return;
  if (in.size_y.size() != n || in.spread.size() != n || in.ellipse.size() != n) {
    throw std::invalid_argument("lights.size_y, spread and ellipse must have " + std::to_string(n) + " entries each");
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (in.type[i] != LIGHT_AREA) continue;
    require_not_negative(in.size[i], "size", i);
    require_not_negative(in.size_y[i], "size_y", i);
    require_not_negative(in.spread[i], "spread", i);
  }
}

double shape_area_light(const LightsInput &in, std::size_t i, Light &light) {
  const float *m = in.transform.data() + 12 * i;
  const vec3 x(m[0], m[4], m[8]), y(m[1], m[5], m[9]);
  // 1. Axes in its plane. A sheared light has the widths of its axes, square to each other.
  light.local_z = -light.axis;
  light.local_x = normalize(x - light.axis * dot(light.axis, x));
  light.local_y = cross(light.local_z, light.local_x);
  if (dot(light.local_y, y) < 0.0f) light.local_y = light.local_y * -1.0f;
  light.half_u = std::min(0.5f * in.size[i] * length(x), kWidest);
  light.half_v = std::min(0.5f * in.size_y[i] * length(y), kWidest);
  light.radius = std::hypot(light.half_u, light.half_v);
  if (in.ellipse[i] != 0) light.flags |= LIGHT_ELLIPSE;
  light.flags &= ~LIGHT_SOFT_FALLOFF;
  // 2. The spread: the integral of cos(x) (1 - tan(x) / tan(h)) over angles x up to h is (tan(h) - h) / tan(h).
  const double h = 0.5 * std::min(static_cast<double>(in.spread[i]), std::numbers::pi);
  const double open = 0.5 * std::numbers::pi - h;
  if (open < 1e-6) {  // all of the half space: 1 at every angle
    light.tan_spread = 1e18f;
    light.spread_scale = 1e-18f;
  } else {
    light.tan_spread = static_cast<float>(std::tan(h));
    const double rest = h > 1e-3 ? std::tan(h) - h : h * h * h / 3.0;
    light.spread_scale = h > 0.0 ? static_cast<float>(1.0 / std::max(rest, 1e-30)) : 0.0f;
  }
  const double area = 4.0 * static_cast<double>(light.half_u) * static_cast<double>(light.half_v);
  return std::max(in.ellipse[i] != 0 ? 0.25 * std::numbers::pi * area : area, 1e-30);
}

void validate_linking(const LinkingInput &in, std::size_t lights, std::size_t instances) {
  if (in.receiver.empty() && in.blocker.empty() && in.light_sets.empty() && in.shadow_sets.empty()) return;
  if (in.receiver.size() != instances || in.blocker.size() != instances || in.light_sets.size() != lights + instances ||
      in.shadow_sets.size() != lights + instances) {
    throw std::invalid_argument("linking.receiver and blocker must have " + std::to_string(instances) +
                                " entries, light_sets and shadow_sets " + std::to_string(lights + instances));
  }
  const auto require_set = [](uint value, uint count, const char *name, std::size_t i) {
    if (value < count) return;
    throw std::invalid_argument(std::string("linking.") + name + "[" + std::to_string(i) +
                                "] = " + std::to_string(value) + ", must be below " + std::to_string(count));
  };
  for (std::size_t i = 0; i < instances; ++i) {
    require_set(in.receiver[i], 64, "receiver", i);
    require_set(in.blocker[i], 32 - SHADOW_SET_SHIFT, "blocker", i);
  }
}

void Scene::prepare_links(const LinkingInput &in, std::size_t lights) {
  if (in.light_sets.empty()) return;
  const auto link = [&](std::size_t i, uint set) {
    const bool all = in.shadow_sets[i] == ~0u;
    light_links_.push_back({in.light_sets[i], all ? VISIBLE_SHADOW : in.shadow_sets[i] << SHADOW_SET_SHIFT, set});
  };
  for (const Light &light : lights_) link(light.name_index, 0);
  for (const uint i : instance_order_) link(lights + i, in.receiver[i]);
  data_.light_links = {light_links_.data()};
  data_.light_linking = 1;
  features_ |= FEATURE_LIGHT_LINKING;
}

// How the world is sampled: as in the previous scene, where it is the same there.
std::shared_ptr<const SampledWorld> Scene::sampled_world(const SceneInput &in, uint lit, const Scene *previous) const {
  const ShaderInput &shader = in.programs.shaders[static_cast<std::size_t>(in.world_shader)];
  SampledWorld found;
  found.source = world_source(shader, in.programs.images, lit, in.world_resolution, in.world_sun);
  const std::shared_ptr<const SampledWorld> known = previous != nullptr ? previous->world_ : nullptr;
  if (known != nullptr && found.source && known->source == found.source) return known;
  const uint registers = library_of_programs_.registers;
  found.kinds = world_same_kinds(data_, registers, lit);
  if (found.kinds != 0 && in.world_resolution >= 0) {
    const WorldTableSize size = world_table_size(data_, static_cast<uint>(in.world_resolution));
    found.table = make_world_table(data_, registers, found.kinds, size, in.world_sun);
  }
  return std::make_shared<const SampledWorld>(std::move(found));
}

// The world's light, and the table by which it is sampled.
void Scene::prepare_world(const SceneInput &in, const Scene *previous) {
  bool varies = false;
  data_.world = in.world * emission_of(in.world_shader, varies);
  data_.world_visibility = in.world_visibility;
  data_.world_sampled = in.world_visibility;
  data_.world_group = in.world_group;
  data_.world_max_bounces = in.world_max_bounces;
  if (!varies) return;
  const CompiledShader &shader = compiled_[static_cast<std::size_t>(in.world_shader)];
  data_.world_program = shader.program.emission;
  data_.world_constants = shader.program.constants;
  features_ |= FEATURE_PROGRAMS;
  // Where kinds of rays see different worlds, one is sampled, and the others' rays find theirs.
  const uint lit = in.world_visibility & (VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION);
  world_ = sampled_world(in, lit, previous);
  stats_.world_taken_over = previous != nullptr && previous->world_ == world_;
  data_.world_sampled &= ~(lit & ~world_->kinds);
  if (world_->table.width == 0) return;
  data_.world_table = {world_->table.cumulated.data()};
  data_.world_width = world_->table.width;
  data_.world_height = world_->table.height;
  data_.world_sun = in.world_sun.direction;
  data_.world_sun_cap = in.world_sun.cap;
  data_.world_sun_share = world_->table.sun_share;
  features_ |= FEATURE_WORLD_LIGHT | FEATURE_BSDF_RAYS;
}

LightShape shape_light(const LightsInput &in, std::size_t i, Light &light) {
  LightShape shape{};
  if (light.type == LIGHT_SUN || light.type == LIGHT_AREA) return shape;  // no distance or no centre, and no cone
  shape.falloff = in.falloff[i];
  shape.edge = light.type == LIGHT_SPOT ? in.spot_edge[i] : SPOT_EDGE_BLENDER;
  if (shape.falloff == FALLOFF_PHYSICAL && shape.edge == SPOT_EDGE_BLENDER) return shape;
  light.flags |= LIGHT_SHAPED;
  shape.inverse_range = inverse(static_cast<double>(in.range[i]));
  shape.c0 = in.polynomial[i].x;
  shape.c1 = in.polynomial[i].y;
  shape.c2 = in.polynomial[i].z;
  if (shape.edge == SPOT_EDGE_BLENDER) return shape;
  // An inner angle beyond the outer one is the outer one; spots end at 90 degrees, as Blender's do.
  const double outer = std::min(static_cast<double>(in.outer_angle[i]), 0.5 * std::numbers::pi);
  const double inner = std::min(static_cast<double>(in.inner_angle[i]), outer);
  const bool linear = shape.edge == SPOT_EDGE_LINEAR;
  shape.edge_end = static_cast<float>(linear ? outer : versine(outer));
  shape.edge_scale = inverse(linear ? outer - inner : versine(outer) - versine(inner));
  // Blender's own cone, which this one replaces, is open everywhere.
  light.spot_versine = 3.0f;
  light.spot_scale = 1.0f;
  return shape;
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the tree of kernels/light/light_tree.h over bounds of lights. What bounds a light is scene_light_tree.cpp's.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "binary_tree.h"

namespace cotorra {

// What is known of one light, or of some: where they lie, which way they face, how far to the side of that they shine.
struct LightBounds {
  Box box;
  vec3 axis{0.0f, 0.0f, 1.0f};  // unit; of the cone of what they face; distant: toward them
  float cos_o = 1.0f;           // of its half angle
  float cos_e = 1.0f;           // of the angle from what it faces within which each shines, up to a right angle
  float energy = 0.0f;          // LIGHT_ROW_ENERGY
  uint flags = 0;               // LIGHT_CHILD_*
};

// Of both together.
LightBounds merge(const LightBounds &a, const LightBounds &b);

struct LightTree {
  std::vector<float> nodes;   // [nodes][LIGHT_ROWS][LIGHT_FANOUT]
  std::vector<uint> parents;  // place of each node: node x LIGHT_FANOUT + child, INVALID_ID for the first
  std::vector<uint> places;   // of each light

  std::size_t bytes() const { return nodes.size() * sizeof(float) + (parents.size() + places.size()) * sizeof(uint); }
};

// A tree over lights, the first `lamps` of them lamps, the others emitting triangles; those without energy are left
// out. It does not depend on the number of threads, which are as many as the machine has.
LightTree build_light_tree(std::span<const LightBounds> lights, std::size_t lamps);

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Binary bounding volume trees over boxes by the surface area heuristic: what wide_bvh.cpp makes its nodes from.
// Nothing here knows of triangles or of rays.
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "../kernels/language.h"

namespace cotorra {

struct Box {
  vec3 lo{std::numeric_limits<float>::max()}, hi{std::numeric_limits<float>::lowest()};
  void add(vec3 p) {
    lo = min(lo, p);
    hi = max(hi, p);
  }
  float half_area() const {
    const vec3 d = hi - lo;
    return d.x < 0.0f ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
  }
  bool finite() const {
    const vec3 sum = abs(lo) + abs(hi);
    return lo.x <= hi.x && sum.x + sum.y + sum.z < std::numeric_limits<float>::infinity();
  }
};

// Something in a tree: a triangle or an instance, by its index.
struct alignas(16) Item {
  vec3 lo;
  std::uint32_t index;
  vec3 hi;
  std::uint32_t unused;
  Item(const Box &box, std::uint32_t number) : lo(box.lo), index(number), hi(box.hi), unused(0) {}
};

// A node of a binary tree. The left child follows it; leaves hold items [first, first + count).
struct BinaryNode {
  Box box;
  std::uint32_t first = 0;  // right child, or first item
  std::uint32_t count = 0;  // 0: no leaf
};

constexpr std::uint32_t kLeafSize = 3;  // most items of a leaf: what a slot's byte of a wide node can count

// A tree over items, of which there is one at least, with finite boxes; they are put into its order. It does not depend
// on `threads`, the number that build it. Throws Cancelled where `cancel` is set meanwhile.
std::vector<BinaryNode> build_binary_tree(std::span<Item> items, int threads, const std::atomic<bool> &cancel);

}  // namespace cotorra

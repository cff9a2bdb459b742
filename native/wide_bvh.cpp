// SPDX-License-Identifier: GPL-3.0-or-later
// Turns binary trees into nodes of eight children in bytes.
// What a node's fields mean is told in kernels/bvh.h.
#include "wide_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "binary_tree.h"
#include "scene.h"

#include "every_feature.h"

#include "../kernels/bvh.h"

namespace cotorra {
namespace {

float axis_of(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Turns a binary tree into wide nodes at the end of `nodes`. What leaves hold is told to `emit`, which appends it and
// whose count so far `held` is.
template <class Emit>
class WideWriter {
 public:
  WideWriter(const std::vector<BinaryNode> &binary, std::span<const Item> items, std::vector<BvhNode> &nodes,
             std::uint32_t held, Emit emit)
      : binary_(binary), items_(items), nodes_(nodes), held_(held), emit_(emit) {}

  // Returns the root. `depth` becomes the number of levels.
  std::uint32_t write(int &depth) {
    const auto root = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    struct Pending {
      std::uint32_t node, binary;
      int depth;
    };
    std::vector<Pending> pending{{root, 0, 1}};
    while (!pending.empty()) {
      const Pending p = pending.back();
      pending.pop_back();
      depth = std::max(depth, p.depth);
      const std::array<std::uint32_t, 8> slots = choose_slots(p.binary);
      const auto base = static_cast<std::uint32_t>(nodes_.size());
      std::uint32_t inner = 0;
      for (const std::uint32_t child : slots) {
        if (child != INVALID_ID && binary_[child].count == 0) pending.push_back({base + inner++, child, p.depth + 1});
      }
      nodes_.resize(base + inner);
      nodes_[p.node] = encode(p.binary, slots, base);
    }
    return root;
  }

 private:
  // Up to eight descendants of a binary node, each in the slot whose octant it lies in as far as that can be.
  std::array<std::uint32_t, 8> choose_slots(std::uint32_t node) const {
    std::array<std::uint32_t, 8> children{};
    std::size_t n = 0;
    children[n++] = node;
    while (n < 8) {  // open the largest node
      std::size_t largest = n;
      for (std::size_t i = 0; i < n; ++i) {
        const BinaryNode &c = binary_[children[i]];
        const bool larger = largest == n || c.box.half_area() > binary_[children[largest]].box.half_area();
        if (c.count == 0 && larger) largest = i;
      }
      if (largest == n) break;
      const std::uint32_t opened = children[largest];
      children[largest] = opened + 1;
      children[n++] = binary_[opened].first;
    }
    // Slot s lies toward (+x if s & 1, +y if s & 2, +z if s & 4); the pair that gains most is matched first.
    const vec3 center = (binary_[node].box.lo + binary_[node].box.hi) * 0.5f;
    std::array<std::uint32_t, 8> slots;
    slots.fill(INVALID_ID);
    std::array<bool, 8> placed{};
    for (std::size_t k = 0; k < n; ++k) {
      float best = std::numeric_limits<float>::lowest();
      std::size_t best_child = 8, best_slot = 8;
      for (std::size_t c = 0; c < n; ++c) {
        if (placed[c]) continue;
        const Box &box = binary_[children[c]].box;
        const vec3 d = (box.lo + box.hi) * 0.5f - center;
        for (std::size_t s = 0; s < 8; ++s) {
          if (slots[s] != INVALID_ID) continue;
          const float gain = ((s & 1) != 0 ? d.x : -d.x) + ((s & 2) != 0 ? d.y : -d.y) + ((s & 4) != 0 ? d.z : -d.z);
          if (best_child < 8 && !(gain > best)) continue;
          best = gain;
          best_child = c;
          best_slot = s;
        }
      }
      slots[best_slot] = children[best_child];
      placed[best_child] = true;
    }
    return slots;
  }

  // Exponent of the smallest power of two of which 255 span the extent, biased as in a float.
  static std::uint32_t grid_exponent(float extent) {
    const int e = extent > 0.0f ? std::ilogb(extent / 255.0f) + 1 : -126;
    return static_cast<std::uint32_t>(std::clamp(e, -126, 127) + 127);
  }

  static void put_byte(uint *words, std::size_t slot, std::uint32_t byte) { words[slot / 4] |= byte << 8 * (slot % 4); }

  // Steps of the grid below and above a child's side; exact, so that no box is too small.
  static void put_sides(BvhNode &node, std::size_t slot, std::size_t axis, float origin, float lo, float hi,
                        std::uint32_t exponent) {
    const double step = std::ldexp(1.0, static_cast<int>(exponent) - 127);
    const double below = std::floor((static_cast<double>(lo) - static_cast<double>(origin)) / step);
    const double above = std::ceil((static_cast<double>(hi) - static_cast<double>(origin)) / step);
    put_byte(node.low + 2 * axis, slot, static_cast<std::uint32_t>(std::clamp(below, 0.0, 255.0)));
    put_byte(node.high + 2 * axis, slot, static_cast<std::uint32_t>(std::clamp(above, 0.0, 255.0)));
  }

  BvhNode encode(std::uint32_t index, const std::array<std::uint32_t, 8> &slots, std::uint32_t child_base) {
    const Box &box = binary_[index].box;
    const vec3 extent = box.hi - box.lo;
    const std::array<std::uint32_t, 3> exponents{grid_exponent(extent.x), grid_exponent(extent.y),
                                                 grid_exponent(extent.z)};
    BvhNode node{};
    node.origin = box.lo;
    node.exponents = exponents[0] | exponents[1] << 8 | exponents[2] << 16;
    node.child_base = child_base;
    node.leaf_base = held_;
    for (std::size_t s = 0; s < 8; ++s) {
      if (slots[s] == INVALID_ID) continue;
      const BinaryNode &child = binary_[slots[s]];
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        put_sides(node, s, a, axis_of(box.lo, axis), axis_of(child.box.lo, axis), axis_of(child.box.hi, axis),
                  exponents[a]);
      }
      if (child.count == 0) {
        node.exponents |= 1u << (24 + s);
        put_byte(node.meta, s, bvh_meta_node(static_cast<uint>(s)));
        continue;
      }
      put_byte(node.meta, s, bvh_meta_leaf(held_ - node.leaf_base, child.count));
      for (std::uint32_t i = 0; i < child.count; ++i, ++held_) emit_(items_[child.first + i].index);
    }
    return node;
  }

  const std::vector<BinaryNode> &binary_;
  std::span<const Item> items_;
  std::vector<BvhNode> &nodes_;
  std::uint32_t held_;
  Emit emit_;
};

class SceneBuilder {
 public:
  SceneBuilder(std::span<const Mesh> meshes, std::span<const Instance> instances, std::span<const char> flattened,
               int threads, const std::atomic<bool> &cancel)
      : meshes_(meshes), instances_(instances), flattened_(flattened), cancel_(cancel) {
    threads_ = threads > 0 ? threads : static_cast<int>(std::max(std::thread::hardware_concurrency(), 1u));
  }

  WideBvh build() {
    build_world();
    std::vector<std::uint32_t> roots(meshes_.size(), INVALID_ID);
    std::vector<Box> boxes(meshes_.size());
    for (const Instance &instance : instances_) {
      const std::size_t m = instance.mesh;
      if (flattened_[m] == 0 && roots[m] == INVALID_ID) roots[m] = build_mesh(m, boxes[m]);
    }
    build_top(roots, boxes);
    if (mesh_depth_ + top_depth_ + 2 > BVH_STACK) {  // a level may leave a node and, at an instance, what waits there
      throw std::runtime_error("the BVH is " + std::to_string(mesh_depth_ + top_depth_) + " levels deep, more than " +
                               std::to_string(BVH_STACK - 2));
    }
    return std::move(out_);
  }

 private:
  template <class Emit>
  std::uint32_t build_tree(std::vector<Item> &items, std::size_t held, int &depth, Emit emit) {
    if (items.empty()) return INVALID_ID;
    if (held + items.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
      throw std::runtime_error("more triangles than the BVH of a GPU can hold");
    }
    const std::vector<BinaryNode> binary = build_binary_tree(items, threads_, cancel_);
    WideWriter writer(binary, items, out_.nodes, static_cast<std::uint32_t>(held), emit);
    return writer.write(depth);
  }

  static void add_triangle(const Mesh &mesh, std::uint32_t triangle, std::uint32_t index, std::vector<Item> &items) {
    const uvec3 id = mesh.triangles.v[triangle];
    Box box;
    box.add(mesh.positions.v[id.x]);
    box.add(mesh.positions.v[id.y]);
    box.add(mesh.positions.v[id.z]);
    if (box.finite()) items.emplace_back(box, index);  // else no ray meets it, as in Embree
  }

  void push_triangle(const Mesh &mesh, std::uint32_t triangle, std::uint32_t instance, std::uint32_t mask) {
    const uvec3 id = mesh.triangles.v[triangle];
    out_.triangles.push_back(
        {mesh.positions.v[id.x], instance, mesh.positions.v[id.y], triangle, mesh.positions.v[id.z], mask});
  }

  std::size_t flattened_triangles() const {
    std::size_t count = 0;
    for (const Instance &instance : instances_) {
      if (flattened_[instance.mesh] != 0) count += meshes_[instance.mesh].triangle_count;
    }
    return count;
  }

  void build_world() {
    std::vector<std::uint32_t> first;  // index of each flattened instance's first triangle
    std::vector<std::uint32_t> owner;
    std::vector<Item> items;
    std::uint64_t count = 0;
    items.reserve(flattened_triangles());
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
      const Mesh &mesh = meshes_[instances_[k].mesh];
      if (flattened_[instances_[k].mesh] == 0) continue;
      first.push_back(static_cast<std::uint32_t>(count));
      owner.push_back(k);
      count += mesh.triangle_count;
      if (count > std::numeric_limits<std::uint32_t>::max() / 2) throw std::runtime_error("too many triangles");
      for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) add_triangle(mesh, t, first.back() + t, items);
    }
    out_.triangles.reserve(items.size());
    out_.world_root = build_tree(items, 0, mesh_depth_, [&](std::uint32_t index) {
      const auto k = static_cast<std::size_t>(std::upper_bound(first.begin(), first.end(), index) - first.begin()) - 1;
      const Instance &instance = instances_[owner[k]];
      push_triangle(meshes_[instance.mesh], index - first[k], owner[k], instance.visibility);
    });
  }

  std::uint32_t build_mesh(std::size_t m, Box &box) {
    const Mesh &mesh = meshes_[m];
    std::vector<Item> items;
    for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) add_triangle(mesh, t, t, items);
    for (const Item &item : items) {
      box.add(item.lo);
      box.add(item.hi);
    }
    return build_tree(items, out_.triangles.size(), mesh_depth_,
                      [&](std::uint32_t index) { push_triangle(mesh, index, INVALID_ID, ~0u); });
  }

  void build_top(const std::vector<std::uint32_t> &roots, const std::vector<Box> &boxes) {
    std::vector<Item> items;
    for (std::uint32_t k = 0; k < instances_.size(); ++k) {
      const Instance &instance = instances_[k];
      if (roots[instance.mesh] == INVALID_ID) continue;
      const Box &box = boxes[instance.mesh];
      Box item;
      for (unsigned corner = 0; corner < 8; ++corner) {
        const vec3 p((corner & 1) != 0 ? box.hi.x : box.lo.x, (corner & 2) != 0 ? box.hi.y : box.lo.y,
                     (corner & 4) != 0 ? box.hi.z : box.lo.z);
        item.add(instance_point(instance, p));
      }
      // The corners were rounded.
      const vec3 slack = (abs(item.lo) + abs(item.hi)) * 4e-7f;
      item.lo = item.lo - slack;
      item.hi = item.hi + slack;
      BvhInstance unused;
      if (item.finite() && world_to_object(instance, unused)) items.emplace_back(item, k);
    }
    out_.top_root = build_tree(items, 0, top_depth_, [&](std::uint32_t k) {
      BvhInstance entry{};
      world_to_object(instances_[k], entry);
      entry.root = roots[instances_[k].mesh];
      entry.instance = k;
      entry.mask = instances_[k].visibility;
      out_.instances.push_back(entry);
    });
  }

  // Rows of the inverse transform, in double precision. False for a singular one: its object has no inside to enter.
  static bool world_to_object(const Instance &i, BvhInstance &out) {
    const std::array<double, 3> a{i.x_axis.x, i.x_axis.y, i.x_axis.z}, b{i.y_axis.x, i.y_axis.y, i.y_axis.z},
        c{i.z_axis.x, i.z_axis.y, i.z_axis.z}, o{i.origin.x, i.origin.y, i.origin.z};
    const auto cross3 = [](const std::array<double, 3> &p, const std::array<double, 3> &q) {
      return std::array<double, 3>{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    };
    const auto dot3 = [](const std::array<double, 3> &p, const std::array<double, 3> &q) {
      return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    };
    const double det = dot3(a, cross3(b, c));
    if (!(std::abs(det) > 0.0) || !std::isfinite(1.0 / det)) return false;
    const auto row = [&](const std::array<double, 3> &n) {
      return vec4(static_cast<float>(n[0] / det), static_cast<float>(n[1] / det), static_cast<float>(n[2] / det),
                  static_cast<float>(-dot3(n, o) / det));
    };
    out.x = row(cross3(b, c));
    out.y = row(cross3(c, a));
    out.z = row(cross3(a, b));
    return true;
  }

  std::span<const Mesh> meshes_;
  std::span<const Instance> instances_;
  std::span<const char> flattened_;
  int threads_;
  const std::atomic<bool> &cancel_;
  WideBvh out_;
  int mesh_depth_ = 0, top_depth_ = 0;
};

}  // namespace

WideBvh::WideBvh() = default;
WideBvh::~WideBvh() = default;
WideBvh::WideBvh(WideBvh &&) noexcept = default;
WideBvh &WideBvh::operator=(WideBvh &&) noexcept = default;

std::uint64_t WideBvh::bytes() const {
  return nodes.size() * sizeof(BvhNode) + triangles.size() * sizeof(BvhTriangle) +
         instances.size() * sizeof(BvhInstance);
}

WideBvh build_wide_bvh(std::span<const Mesh> meshes, std::span<const Instance> instances,
                       std::span<const char> flattened, int threads, const std::atomic<bool> &cancel) {
  return SceneBuilder(meshes, instances, flattened, threads, cancel).build();
}

}  // namespace cotorra

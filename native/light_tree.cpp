// SPDX-License-Identifier: GPL-3.0-or-later
// The builder: top down by the surface area orientation heuristic (Conty Estevez & Kulla 2018, section 4), each node
// split until it has eight children; then bounds from the leaves upward.
#include "light_tree.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include "every_feature.h"

#include "../kernels/light/light_tree.h"

namespace cotorra {
namespace {

constexpr std::size_t kBins = 12;
constexpr std::size_t kTask = 1 << 14;   // lights of a subtree that is one task
constexpr std::size_t kFull = 1 << 16;  // of more lights, nodes are filled: memory counts more than where they split
constexpr int kBalancedDepth = 20;  // below, halves instead of the heuristic: that bounds the depth
constexpr double kPi = std::numbers::pi;

struct Entry {
  LightBounds b;
  uint index;
};

vec3 middle(const Box &box) { return (box.lo + box.hi) * 0.5f; }

// The measure of directions that a cone with what shines beyond it covers (equation 1).
double orientation_measure(double cos_o, double cos_e) {
  const double o = std::acos(std::clamp(cos_o, -1.0, 1.0));
  const double w = std::min(o + std::acos(std::clamp(cos_e, -1.0, 1.0)), kPi);
  return 2.0 * kPi * (1.0 - std::cos(o)) +
         0.5 * kPi * (2.0 * w * std::sin(o) - std::cos(o - 2.0 * w) - 2.0 * o * std::sin(o) + std::cos(o));
}

// What a split is judged by: a cone is estimated by how long the sum of the axes is, which costs less than cones do.
struct Sums {
  Box box;
  double energy = 0.0;
  vec3 axes{0.0f, 0.0f, 0.0f};  // weighted by energy; nothing of what shines all around
  float cos_e = 1.0f;
  std::size_t count = 0;

  void add(const LightBounds &b, vec3 along) {
    box.add(b.box.lo);
    box.add(b.box.hi);
    energy += static_cast<double>(b.energy);
    const float side = (b.flags & LIGHT_CHILD_TWO_SIDED) != 0 && dot(b.axis, along) < 0.0f ? -1.0f : 1.0f;
    axes += b.axis * (side * b.energy * 0.5f * (1.0f + b.cos_o));
    cos_e = std::min(cos_e, b.cos_e);
    ++count;
  }
  void add(const Sums &s) {
    if (s.count == 0) return;
    box.add(s.box.lo);
    box.add(s.box.hi);
    energy += s.energy;
    axes += s.axes;
    cos_e = std::min(cos_e, s.cos_e);
    count += s.count;
  }
  double cost() const {
    if (count == 0) return 0.0;
    const vec3 d = box.hi - box.lo;
    const double mean = static_cast<double>(length(axes)) / std::max(energy, 1e-300);
    return energy * static_cast<double>(dot(d, d)) * orientation_measure(2.0 * mean - 1.0, static_cast<double>(cos_e));
  }
};

struct Range {
  std::size_t first, count;
  double cost;
};

float component(vec3 v, std::size_t axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

// Builds the children of nodes; bounds come later. Subtrees of `kTask` lights are left to others where there are more.
class Builder {
 public:
  struct Pending {
    std::size_t place;
    Range range;
    int depth;
  };

  Builder(std::span<Entry> items, bool full, bool leaves_tasks)
      : items_(items), full_(full), leaves_tasks_(leaves_tasks) {}

  // Returns the node's index.
  std::size_t build(const Range &range, int depth) {
    const std::size_t node = children.size();
    children.emplace_back();
    std::array<Range, LIGHT_FANOUT> ranges{range};
    const std::size_t n = open(ranges, depth);
    for (std::size_t k = 0; k < n; ++k) {
      const Range &r = ranges[k];
      std::size_t child;
      if (r.count == 1) {
        child = kLeaf | r.first;
      } else if (leaves_tasks_ && r.count <= kTask) {
        child = 0;
        pending.push_back({node * LIGHT_FANOUT + k, r, depth + 1});
      } else {
        child = build(r, depth + 1);
      }
      children[node][k] = child;
    }
    return node;
  }

  static constexpr std::size_t kLeaf = std::size_t{1} << 63, kNone = ~std::size_t{0};
  struct Node : std::array<std::size_t, LIGHT_FANOUT> {
    Node() { fill(kNone); }
  };
  std::vector<Node> children;  // a node, an item with kLeaf, or kNone
  std::vector<Pending> pending;

 private:
  // Splits the costliest of `ranges` until there are eight. Lights that fill one node stay together.
  std::size_t open(std::array<Range, LIGHT_FANOUT> &ranges, int depth) {
    std::size_t n = 1;
    while (n < LIGHT_FANOUT) {
      std::size_t best = n;
      for (std::size_t k = 0; k < n; ++k) {
        const bool fits = ranges[k].count > LIGHT_FANOUT || n + ranges[k].count - 1 <= LIGHT_FANOUT;
        if (ranges[k].count < 2 || !fits) continue;
        if (best == n || better(ranges[k], ranges[best])) best = k;
      }
      if (best == n) break;
      const Range r = ranges[best];
      if (r.count <= LIGHT_FANOUT) {
        ranges[best] = {r.first, 1, 0.0};
        for (std::size_t i = 1; i < r.count; ++i) ranges[n++] = {r.first + i, 1, 0.0};
      } else {
        split(r, depth, ranges[best], ranges[n]);
        ++n;
      }
    }
    return n;
  }

  // Those that need a node of their own anyhow come first.
  static bool better(const Range &a, const Range &b) {
    if ((a.count > LIGHT_FANOUT) != (b.count > LIGHT_FANOUT)) return a.count > LIGHT_FANOUT;
    return a.cost > b.cost;
  }

  void split(const Range &range, int depth, Range &left, Range &right) {
    const std::span<Entry> items = items_.subspan(range.first, range.count);
    // 1. Distant lights apart from those that lie somewhere.
    const auto near = std::stable_partition(items.begin(), items.end(),
                                            [](const Entry &i) { return (i.b.flags & LIGHT_CHILD_DISTANT) == 0; });
    std::size_t cut = static_cast<std::size_t>(near - items.begin());
    if (cut == 0 || cut == items.size()) cut = depth < kBalancedDepth && cut > 0 ? best_cut(items) : items.size() / 2;
    left = measured(range.first, cut);
    right = measured(range.first + cut, range.count - cut);
  }

  Range measured(std::size_t first, std::size_t count) const {
    Sums sums;
    const vec3 along = items_[first].b.axis;
    for (const Entry &i : items_.subspan(first, count)) sums.add(i.b, along);
    return {first, count, sums.cost()};
  }

  // Orders the items by the best plane that there is, and returns how many lie before it.
  std::size_t best_cut(std::span<Entry> items) const {
    Box centers;
    for (const Entry &i : items) centers.add(middle(i.b.box));
    const vec3 extent = centers.hi - centers.lo;
    const float longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0.0f)) return items.size() / 2;
    std::array<std::array<Sums, kBins>, 3> bins;
    const auto bin_of = [&](const Entry &i, std::size_t axis) {
      const float e = component(extent, axis);
      const float at = (component(middle(i.b.box), axis) - component(centers.lo, axis)) / e * static_cast<float>(kBins);
      return std::min(static_cast<std::size_t>(std::max(at, 0.0f)), kBins - 1);
    };
    const vec3 along = items.front().b.axis;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(component(extent, axis) > 0.0f)) continue;
      for (const Entry &i : items) bins[axis][bin_of(i, axis)].add(i.b, along);
    }
    double best = 0.0;
    std::size_t best_axis = 3, best_bin = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(component(extent, axis) > 0.0f)) continue;
      std::array<double, kBins> right{};
      Sums sums;
      for (std::size_t b = kBins - 1; b > 0; --b) {
        sums.add(bins[axis][b]);
        right[b] = sums.cost();
      }
      // Slices across the shortest side are thin, and cost little whatever they hold: that is made up for.
      const double thin = static_cast<double>(longest / component(extent, axis));
      sums = {};
      for (std::size_t b = 0; b + 1 < kBins; ++b) {
        sums.add(bins[axis][b]);
        if (sums.count == 0 || sums.count == items.size()) continue;
        const double cost = thin * (sums.cost() + right[b + 1]);
        if (best_axis < 3 && cost >= best) continue;
        best = cost;
        best_axis = axis;
        best_bin = b;
      }
    }
    if (best_axis == 3) return items.size() / 2;
    const auto at =
        std::partition(items.begin(), items.end(), [&](const Entry &i) { return bin_of(i, best_axis) <= best_bin; });
    const auto cut = static_cast<std::size_t>(at - items.begin());
    if (!full_ || items.size() > LIGHT_FANOUT * LIGHT_FANOUT) return cut;
    // Whole nodes on the left.
    const std::size_t whole =
        std::clamp((cut + LIGHT_FANOUT / 2) / LIGHT_FANOUT, std::size_t{1}, (items.size() - 1) / LIGHT_FANOUT) *
        LIGHT_FANOUT;
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(whole), items.end(),
                     [best_axis](const Entry &a, const Entry &b) {
                       const float x = component(middle(a.b.box), best_axis), y = component(middle(b.b.box), best_axis);
                       return x != y ? x < y : a.index < b.index;
                     });
    return whole;
  }

  std::span<Entry> items_;
  bool full_, leaves_tasks_;
};

// Subtrees on all cores, and one list of nodes in an order that knows nothing of that: children come after parents.
std::vector<Builder::Node> build_nodes(std::span<Entry> items) {
  const bool full = items.size() > kFull;
  Builder top(items, full, true);
  top.build({0, items.size(), 0.0}, 0);
  std::vector<std::vector<Builder::Node>> parts(top.pending.size());
  std::atomic<std::size_t> next{0};
  const auto take = [&] {
    for (std::size_t i = next++; i < parts.size(); i = next++) {
      Builder builder(items, full, false);
      builder.build(top.pending[i].range, top.pending[i].depth);
      parts[i] = std::move(builder.children);
    }
  };
  {
    const auto threads =
        std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, std::max<std::size_t>(parts.size() / 4, 1));
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(take);
    take();
  }
  std::vector<Builder::Node> nodes = std::move(top.children);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t place = top.pending[i].place, offset = nodes.size();
    nodes[place / LIGHT_FANOUT][place % LIGHT_FANOUT] = offset;
    for (Builder::Node node : parts[i]) {
      for (std::size_t &child : node) {
        if ((child & Builder::kLeaf) == 0) child += offset;
      }
      nodes.push_back(node);
    }
    parts[i] = {};
  }
  return nodes;
}

void write_child(const LightBounds &b, uint child, float *row) {
  const bool distant = (b.flags & LIGHT_CHILD_DISTANT) != 0;
  const vec3 center = distant ? vec3(0.0f) : middle(b.box);
  const float radius = distant ? 0.0f : 0.5f * length(b.box.hi - b.box.lo);
  const float values[LIGHT_ROWS] = {center.x, center.y, center.z,
                                    radius,   b.axis.x, b.axis.y,
                                    b.axis.z, b.cos_o,  std::sqrt(std::max(1.0f - b.cos_o * b.cos_o, 0.0f)),
                                    b.cos_e,  b.energy, uintBitsToFloat(child)};
  for (std::size_t r = 0; r < LIGHT_ROWS; ++r) row[r * LIGHT_FANOUT] = values[r];
}

// Two cones in one (algorithm 1 of the paper).
void merge_cones(vec3 a, float cos_a, vec3 b, float cos_b, vec3 &axis, float &cos_o) {
  if (cos_b < cos_a) {
    std::swap(a, b);
    std::swap(cos_a, cos_b);
  }
  axis = a;
  cos_o = cos_a;
  const double oa = std::acos(std::clamp(static_cast<double>(cos_a), -1.0, 1.0));
  const double ob = std::acos(std::clamp(static_cast<double>(cos_b), -1.0, 1.0));
  const vec3 aside = b - a * dot(a, b);
  const float across = length(aside);
  const double between = std::atan2(static_cast<double>(across), static_cast<double>(dot(a, b)));
  if (std::min(between + ob, kPi) <= oa) return;
  const double o = 0.5 * (oa + between + ob);
  if (o >= kPi || (across < 1e-6f && dot(a, b) < 0.0f)) {
    cos_o = -1.0f;
    return;
  }
  const double turn = o - oa;
  const vec3 to = aside * (across > 0.0f ? 1.0f / across : 0.0f);
  axis = normalize(a * static_cast<float>(std::cos(turn)) + to * static_cast<float>(std::sin(turn)));
  cos_o = static_cast<float>(std::cos(std::min(o + 1e-4, kPi)));  // and what rounding takes
}

}  // namespace

LightBounds merge(const LightBounds &a, const LightBounds &b) {
  if (a.energy == 0.0f) return b;
  if (b.energy == 0.0f) return a;
  LightBounds out = a;
  const bool distant = (a.flags & b.flags & LIGHT_CHILD_DISTANT) != 0;
  out.box.add(b.box.lo);
  out.box.add(b.box.hi);
  out.energy += b.energy;
  out.cos_e = std::min(a.cos_e, b.cos_e);
  out.flags = ((a.flags | b.flags) & LIGHT_CHILD_LAMPS) | (a.flags & b.flags & LIGHT_CHILD_TWO_SIDED) |
              (distant ? LIGHT_CHILD_DISTANT : 0u);
  if (((a.flags ^ b.flags) & (LIGHT_CHILD_TWO_SIDED | LIGHT_CHILD_DISTANT)) != 0) {
    out.cos_o = -1.0f;  // both ways at once
    return out;
  }
  const bool turned = (out.flags & LIGHT_CHILD_TWO_SIDED) != 0 && dot(a.axis, b.axis) < 0.0f;
  merge_cones(a.axis, a.cos_o, turned ? b.axis * -1.0f : b.axis, b.cos_o, out.axis, out.cos_o);
  return out;
}

LightTree build_light_tree(std::span<const LightBounds> lights, std::size_t lamps) {
  LightTree tree;
  std::vector<Entry> items;
  items.reserve(lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (lights[i].energy > 0.0f) items.push_back({lights[i], static_cast<uint>(i)});
  }
  tree.places.assign(lights.size(), INVALID_ID);
  if (items.empty()) return tree;
  const std::vector<Builder::Node> nodes = build_nodes(items);
  tree.nodes.assign(nodes.size() * LIGHT_NODE_FLOATS, 0.0f);
  tree.parents.assign(nodes.size(), INVALID_ID);
  std::vector<LightBounds> bounds(nodes.size());
  for (std::size_t n = nodes.size(); n-- > 0;) {
    for (std::size_t k = 0; k < LIGHT_FANOUT; ++k) {
      const std::size_t child = nodes[n][k];
      if (child == Builder::kNone) continue;
      const auto place = static_cast<uint>(n * LIGHT_FANOUT + k);
      const bool leaf = (child & Builder::kLeaf) != 0;
      const Entry *item = leaf ? &items[child & ~Builder::kLeaf] : nullptr;
      const LightBounds &b = leaf ? item->b : bounds[child];
      uint code = b.flags;
      if (leaf) {
        code |= LIGHT_CHILD_LEAF | (item->index < lamps ? item->index : item->index - static_cast<uint>(lamps));
        tree.places[item->index] = place;
      } else {
        code |= static_cast<uint>(child);
        tree.parents[child] = place;
      }
      write_child(b, code, tree.nodes.data() + n * LIGHT_NODE_FLOATS + k);
      bounds[n] = merge(bounds[n], b);
    }
  }
  return tree;
}

}  // namespace cotorra

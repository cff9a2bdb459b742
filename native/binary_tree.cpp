// SPDX-License-Identifier: GPL-3.0-or-later
// The builder: bins along the three axes at once, top down, subtrees on threads of their own.
// What it makes of a tree is wide_bvh.cpp's.
#include "binary_tree.h"

#include <algorithm>
#include <array>
#include <future>

#include "scene.h"

#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#endif

namespace cotorra {
namespace {

constexpr std::size_t kMostBins = 16;
constexpr std::size_t kFewestBins = 4;  // of a few items: sweeping over bins would cost more than they are worth
constexpr float kNodeCost = 1.0f;      // of a node, against that of a triangle: both are about one memory access
constexpr int kBalancedDepth = 40;     // below, halves instead of the heuristic: that bounds the depth
constexpr std::uint32_t kParallelSize = 1 << 14;  // smaller subtrees are not worth a task

// Four floats; the fourth, which follows the three of a vec3 in an Item, means nothing.
#if defined(__SSE2__) || defined(_M_X64)
struct Quad {
  __m128 v;
  explicit Quad(float f) : v(_mm_set1_ps(f)) {}
  explicit Quad(const vec3 &f) : v(_mm_load_ps(&f.x)) {}
  explicit Quad(__m128 f) : v(f) {}
  float operator[](std::size_t i) const {
    alignas(16) float f[4];
    _mm_store_ps(f, v);
    return f[i];
  }
};
Quad min(const Quad &a, const Quad &b) { return Quad(_mm_min_ps(a.v, b.v)); }
Quad max(const Quad &a, const Quad &b) { return Quad(_mm_max_ps(a.v, b.v)); }
Quad operator+(const Quad &a, const Quad &b) { return Quad(_mm_add_ps(a.v, b.v)); }
#else
struct Quad {
  float v[4];
  explicit Quad(float f) : v{f, f, f, f} {}
  explicit Quad(const vec3 &f) : v{f.x, f.y, f.z, 0.0f} {}
  float operator[](std::size_t i) const { return v[i]; }
};
template <class F>
Quad each(const Quad &a, const Quad &b, F f) {
  Quad q(0.0f);
  for (std::size_t i = 0; i < 4; ++i) q.v[i] = f(a.v[i], b.v[i]);
  return q;
}
Quad min(const Quad &a, const Quad &b) {
  return each(a, b, [](float x, float y) { return x < y ? x : y; });
}
Quad max(const Quad &a, const Quad &b) {
  return each(a, b, [](float x, float y) { return x > y ? x : y; });
}
Quad operator+(const Quad &a, const Quad &b) {
  return each(a, b, [](float x, float y) { return x + y; });
}
#endif

struct QuadBox {
  Quad lo{std::numeric_limits<float>::max()}, hi{std::numeric_limits<float>::lowest()};
  void add(const Quad &low, const Quad &high) {
    lo = min(lo, low);
    hi = max(hi, high);
  }
  void add(const QuadBox &b) { add(b.lo, b.hi); }
  Box box() const {
    Box b;
    b.lo = vec3(lo[0], lo[1], lo[2]);
    b.hi = vec3(hi[0], hi[1], hi[2]);
    return b;
  }
  float half_area() const { return box().half_area(); }
};

// Twice the centre of an item, a factor that no comparison notices.
Quad center(const Item &item) { return Quad(item.lo) + Quad(item.hi); }

// Which bin a centre lies in, along each axis; an axis on which all centres are the same has scale 0.
struct Bins {
  std::array<float, 3> lo, scale;
  std::size_t count;
  Bins(const QuadBox &centers, std::uint32_t items) : count(std::min(kFewestBins + items / 16, kMostBins)) {
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = centers.lo[a];
      const float extent = centers.hi[a] - lo[a];
      const float s = extent > 0.0f ? static_cast<float>(count) / extent : 0.0f;
      scale[a] = s < std::numeric_limits<float>::max() ? s : 0.0f;
    }
  }
  std::size_t of(float c, std::size_t axis) const {
    const auto bin = static_cast<int>((c - lo[axis]) * scale[axis]);
    return static_cast<std::size_t>(std::clamp(bin, 0, static_cast<int>(count) - 1));
  }
};

struct Split {
  int axis = -1;
  std::size_t border = 0;  // the first bin of the right side
  float cost = std::numeric_limits<float>::max();
};

using BinBoxes = std::array<QuadBox, kMostBins>;
using BinCounts = std::array<std::uint32_t, kMostBins>;

void sweep(const BinBoxes &boxes, const BinCounts &counts, std::size_t bins, int axis, Split &best) {
  std::array<float, kMostBins> right_cost{};
  QuadBox right;
  std::uint32_t n = 0;
  for (std::size_t b = bins - 1; b > 0; --b) {
    right.add(boxes[b]);
    n += counts[b];
    right_cost[b] = n > 0 ? static_cast<float>(n) * right.half_area() : std::numeric_limits<float>::max();
  }
  QuadBox left;
  n = 0;
  for (std::size_t b = 0; b + 1 < bins; ++b) {
    left.add(boxes[b]);
    n += counts[b];
    if (n == 0) continue;
    const float cost = static_cast<float>(n) * left.half_area() + right_cost[b + 1];
    if (cost < best.cost) best = {axis, b + 1, cost};
  }
}

// Items [first, first + count), what they fill, and what twice their centres fill.
struct Range {
  std::uint32_t first = 0, count = 0;
  QuadBox bounds, centers;
  void add(const Item &item) {
    const Quad lo(item.lo), hi(item.hi);
    const Quad c = lo + hi;
    bounds.add(lo, hi);
    centers.add(c, c);
  }
};

class BinaryBuilder {
 public:
  BinaryBuilder(std::span<Item> items, const std::atomic<bool> &cancel)
      : items_(items), nodes_(2 * items.size() - 1), cancel_(cancel) {}

  std::vector<BinaryNode> build(int threads) {
    build(0, measured(0, static_cast<std::uint32_t>(items_.size())), 0, threads);
    return std::move(nodes_);
  }

 private:
  // A subtree over n items owns 2n - 1 nodes from `node` on, so that the layout does not depend on who builds what.
  void build(std::uint32_t node, const Range &range, int depth, int threads) {
    if (cancel_.load(std::memory_order_relaxed)) return;
    const Box box = range.bounds.box();
    const std::uint32_t count = range.count;
    nodes_[node] = {box, range.first, count};
    if (count == 1) return;
    const Bins bins(range.centers, count);
    const Split split = depth < kBalancedDepth ? best_split(range, bins, box) : Split{};
    const float leaf_cost = static_cast<float>(count) * box.half_area();
    if (count <= kLeafSize && leaf_cost <= split.cost + kNodeCost * box.half_area()) return;
    Range left, right;
    partition(range, split, bins, left, right);
    const std::uint32_t right_node = node + 2 * left.count;
    nodes_[node].first = right_node;
    nodes_[node].count = 0;
    if (threads > 1 && count > kParallelSize) {
      std::future<void> task = std::async(std::launch::async, [&] { build(node + 1, left, depth + 1, threads / 2); });
      build(right_node, right, depth + 1, threads - threads / 2);
      task.get();
    } else {
      build(node + 1, left, depth + 1, 1);
      build(right_node, right, depth + 1, 1);
    }
  }

  Range measured(std::uint32_t first, std::uint32_t count) const {
    Range range;
    range.first = first;
    range.count = count;
    for (const Item &item : items_.subspan(first, count)) range.add(item);
    return range;
  }

  Split best_split(const Range &range, const Bins &bins, const Box &box) const {
    std::array<BinBoxes, 3> boxes;
    std::array<BinCounts, 3> counts{};
    for (const Item &item : items_.subspan(range.first, range.count)) {
      const Quad lo(item.lo), hi(item.hi);
      const Quad c = lo + hi;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = bins.of(c[axis], axis);
        boxes[axis][b].add(lo, hi);
        ++counts[axis][b];
      }
    }
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (bins.scale[axis] > 0.0f) sweep(boxes[axis], counts[axis], bins.count, static_cast<int>(axis), best);
    }
    // Among coplanar or equal boxes every split may cost nothing; it is a split all the same.
    if (best.axis < 0) best.cost = static_cast<float>(range.count) * box.half_area();
    return best;
  }

  // Moves the items of the left side to the front, and measures both sides on the way.
  void partition(const Range &range, const Split &split, const Bins &bins, Range &left, Range &right) {
    if (split.axis < 0) {
      halve(range, left, right);
      return;
    }
    const auto axis = static_cast<std::size_t>(split.axis);
    std::uint32_t i = range.first, j = range.first + range.count;
    while (i < j) {
      Item &item = items_[i];
      if (bins.of(center(item)[axis], axis) < split.border) {
        left.add(item);
        ++i;
      } else {
        right.add(item);
        std::swap(item, items_[--j]);
      }
    }
    left.first = range.first;
    left.count = i - range.first;
    right.first = i;
    right.count = range.count - left.count;
  }

  // Where boxes tell no difference, or the tree got too deep: two sides with as many items.
  void halve(const Range &range, Range &left, Range &right) {
    const Box centers = range.centers.box();
    const vec3 d = centers.hi - centers.lo;
    const std::size_t axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
    const std::uint32_t half = range.count / 2;
    const auto begin = items_.begin() + range.first;
    std::nth_element(begin, begin + half, begin + range.count,
                     [axis](const Item &a, const Item &b) { return center(a)[axis] < center(b)[axis]; });
    left = measured(range.first, half);
    right = measured(range.first + half, range.count - half);
  }

  std::span<Item> items_;
  std::vector<BinaryNode> nodes_;
  const std::atomic<bool> &cancel_;
};

}  // namespace

std::vector<BinaryNode> build_binary_tree(std::span<Item> items, int threads, const std::atomic<bool> &cancel) {
  std::vector<BinaryNode> nodes = BinaryBuilder(items, cancel).build(threads);
  if (cancel) throw Cancelled();
  return nodes;
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Pairs triangles that share an edge: first those that follow each other, then what is left, by its edges.
#include "quads.h"

#include <limits>

namespace cotorra {
namespace {

// Are all vertices somewhere? Nobody meets a triangle with one that is nowhere, nor a quadrilateral.
bool is_somewhere(std::span<const vec3> positions, uvec3 t) {
  const vec3 sum = abs(positions[t.x]) + abs(positions[t.y]) + abs(positions[t.z]);
  return sum.x + sum.y + sum.z < INFINITE_DISTANCE;
}

// The quadrilateral of triangles i and j, if they share an edge that both run along as a surface has it.
bool pair(std::span<const uvec3> triangles, std::span<const vec3> positions, std::size_t i, std::size_t j, Quad &quad) {
  const uvec3 s = triangles[i], t = triangles[j];
  if (!is_somewhere(positions, s) || !is_somewhere(positions, t)) return false;
  const std::array<uint, 3> a = {s.x, s.y, s.z}, b = {t.x, t.y, t.z};
  for (uint k = 0; k < 3; ++k) {
    const uint from = a[(k + 1) % 3], to = a[(k + 2) % 3];
    for (uint l = 0; l < 3; ++l) {
      if (b[(l + 1) % 3] != to || b[(l + 2) % 3] != from) continue;
      quad = {{a[k], from, b[l], to}, {static_cast<uint>(i) << 2 | k, static_cast<uint>(j) << 2 | l}};
      return true;
    }
  }
  return false;
}

Quad alone(std::span<const uvec3> triangles, std::size_t i) {
  const uvec3 t = triangles[i];
  return {{t.x, t.y, t.z, t.z}, {static_cast<uint>(i) << 2, kNoTriangle}};
}

// How much longer than the edge that two triangles share the square of another may be.
constexpr float kLonger = 1.3f;

// Pairs triangles of `left` that share the longest edge of both, or nearly: over a shorter one they would be long
// together, and rays meet the boxes around them for nothing. Edges lie in lists, by the lesser of their vertices.
void pair_rest(std::span<const uvec3> triangles, std::span<const vec3> positions, std::span<const uint> left,
               std::vector<Quad> &quads) {
  struct Edge {
    uint low, high;  // vertices
    float length2;
  };
  const auto edges_of = [&](uint triangle) {
    const uvec3 t = triangles[triangle];
    const auto edge = [&](uint a, uint b) {
      const vec3 e = positions[a] - positions[b];
      return Edge{std::min(a, b), std::max(a, b), dot(e, e)};
    };
    return std::array{edge(t.x, t.y), edge(t.y, t.z), edge(t.z, t.x)};
  };
  const auto shorter = [](const Edge &a, const Edge &b) { return a.length2 < b.length2; };
  struct Entry {
    uint high, triangle;
  };
  // 1. Where the list of each vertex ends, then where it begins.
  std::vector<uint> first(positions.size() + 1, 0u);
  for (const uint i : left) {
    for (const Edge &e : edges_of(i)) ++first[e.low];
  }
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<Entry> entries(3 * left.size());
  for (const uint i : left) {
    for (const Edge &e : edges_of(i)) entries[--first[e.low]] = {e.high, i};
  }
  // 2. Each with the first that is free.
  std::vector<bool> taken(triangles.size(), false);
  for (const uint i : left) {
    if (taken[i]) continue;
    taken[i] = true;
    const auto own = edges_of(i);
    const Edge longest = *std::max_element(own.begin(), own.end(), shorter);
    Quad quad = alone(triangles, i);
    for (std::size_t k = first[longest.low]; k < first[std::size_t{longest.low} + 1]; ++k) {
      const uint j = entries[k].triangle;
      if (entries[k].high != longest.high || taken[j]) continue;
      const auto others = edges_of(j);
      const float most = std::max_element(others.begin(), others.end(), shorter)->length2;
      if (!(most <= kLonger * longest.length2) || !pair(triangles, positions, i, j, quad)) continue;
      taken[j] = true;
      break;
    }
    quads.push_back(quad);
  }
}

}  // namespace

bool second_was_hit(const EmbreeGeometry &geometry, const Quad &quad, vec3 ng) {
  const auto at = [&](std::size_t k) { return geometry.positions[quad.vertices[k]]; };
  const vec3 edge = at(3) - at(1);
  // The square of the sine between ng and the normal of the triangle over the edge; in doubles, where squares of what
  // is tiny or huge have room.
  const auto sine2 = [&](vec3 corner) {
    using Number = double;
    const vec3 n = cross(edge, corner - at(1));
    const auto part = [](float a, float b, float c, float d) { return Number{a} * Number{b} - Number{c} * Number{d}; };
    const Number x = part(ng.y, n.z, ng.z, n.y), y = part(ng.z, n.x, ng.x, n.z), z = part(ng.x, n.y, ng.y, n.x);
    const Number n2 = Number{n.x} * Number{n.x} + Number{n.y} * Number{n.y} + Number{n.z} * Number{n.z};
    return n2 > 0.0 ? (x * x + y * y + z * z) / n2 : std::numeric_limits<Number>::infinity();
  };
  return sine2(at(2)) < sine2(at(0));
}

std::vector<Quad> pair_triangles(std::span<const uvec3> triangles, std::span<const vec3> positions) {
  const std::size_t count = triangles.size();
  std::vector<Quad> quads;
  quads.reserve(count / 2 + 1);
  std::vector<uint> left;
  for (std::size_t i = 0; i < count; ++i) {
    Quad quad;
    if (i + 1 < count && pair(triangles, positions, i, i + 1, quad)) {
      quads.push_back(quad);
      ++i;
    } else {
      left.push_back(static_cast<uint>(i));
    }
  }
  if (!left.empty()) pair_rest(triangles, positions, left, quads);
  if (quads.capacity() > quads.size() + quads.size() / 8) quads.shrink_to_fit();
  return quads;
}

}  // namespace cotorra

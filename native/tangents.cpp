// SPDX-License-Identifier: GPL-3.0-or-later
// Sums the tangents of triangles at their corners, in double precision. Blender's own `calc_tangents` refuses n-gons
// and works on quads, where Cycles works on the triangles that are rendered.
#include "tangents.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace cotorra {
namespace {

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;
};

Vector of(vec3 v) { return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)}; }
Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator*(Vector a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Vector operator/(Vector a, double s) { return {a.x / s, a.y / s, a.z / s}; }
double inner(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
bool is_zero(Vector a) { return a.x == 0.0 && a.y == 0.0 && a.z == 0.0; }

Vector unit(Vector a) {
  const double length = std::sqrt(inner(a, a));
  return length > 0.0 ? a / length : Vector{};
}

// A unit vector in the plane of the normal; 0 where the vector stands on it.
Vector laid(Vector v, Vector normal) { return unit(v - normal * inner(v, normal)); }

// The direction in which u grows, 0 where there is none, and whether uv turns as the triangle does.
struct TriangleTangent {
  Vector direction;
  bool oriented = false;
};

TriangleTangent triangle_tangent(const TangentInput &in, std::size_t t) {
  const uvec3 v = in.vertices[t], c = in.corners[t];
  const Vector p0 = of(in.positions[v.x]);
  const Vector d1 = of(in.positions[v.y]) - p0, d2 = of(in.positions[v.z]) - p0;
  const auto edge = [&](uint corner) {
    const vec2 a = in.uv[corner], b = in.uv[c.x];
    return std::array{static_cast<double>(a.x) - static_cast<double>(b.x),
                      static_cast<double>(a.y) - static_cast<double>(b.y)};
  };
  const auto e1 = edge(c.y), e2 = edge(c.z);
  const double area = e1[0] * e2[1] - e1[1] * e2[0];
  const double sign = area > 0.0 ? 1.0 : (area < 0.0 ? -1.0 : 0.0);
  return {(d1 * e2[1] - d2 * e1[1]) * sign, area > 0.0};
}

// Numbers corners: those of one position, normal and uv have one number. They are told apart by a 64-bit hash: among 10
// million two collide with a chance of 3 in a million.
class Places {
 public:
  explicit Places(std::size_t corners) : slots_(std::bit_ceil(2 * corners + 1)) {}

  std::uint32_t number(vec3 position, vec3 normal, vec2 uv) {
    std::uint64_t hash = 0;
    for (const float f : {position.x, position.y, position.z, normal.x, normal.y, normal.z, uv.x, uv.y}) {
      // SplitMix64's finalizer (Steele, Lea & Flood 2014) over what is there and the next word; -0 is 0.
      hash = (hash ^ std::bit_cast<std::uint32_t>(f + 0.0f)) + 0x9e3779b97f4a7c15u;
      hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
      hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
      hash ^= hash >> 31;
    }
    hash += hash == 0;  // which marks what is free
    for (std::size_t i = hash & (slots_.size() - 1);; i = (i + 1) & (slots_.size() - 1)) {
      Slot &slot = slots_[i];
      if (slot.hash == 0) slot = {hash, count_++};
      if (slot.hash == hash) return slot.number;
    }
  }

  std::size_t count() const { return count_; }

 private:
  struct Slot {
    std::uint64_t hash = 0;
    std::uint32_t number = 0;
  };
  std::vector<Slot> slots_;
  std::uint32_t count_ = 0;
};

void require(std::span<const uvec3> triangles, std::size_t limit, const char *name) {
  uint largest = 0;
  for (const uvec3 &t : triangles) largest = std::max({largest, t.x, t.y, t.z});
  if (!triangles.empty() && largest >= limit) {
    throw std::invalid_argument(std::string(name) + " holds " + std::to_string(largest) + ", must be below " +
                                std::to_string(limit));
  }
}

uint member(uvec3 v, std::size_t k) { return k == 0 ? v.x : (k == 1 ? v.y : v.z); }

}  // namespace

std::vector<vec4> corner_tangents(const TangentInput &in) {
  const std::size_t triangles = in.vertices.size();
  if (in.corners.size() != triangles || in.uv.size() != in.normals.size()) {
    throw std::invalid_argument("tangents need as many corners as vertices, and as many uv as normals");
  }
  require(in.vertices, in.positions.size(), "vertices");
  require(in.corners, in.normals.size(), "corners");

  // 1. Which tangent each corner shares: two for each place, one for each orientation.
  std::vector<TriangleTangent> tangents(triangles);
  std::vector<std::uint32_t> group(3 * triangles);
  Places places(3 * triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    tangents[t] = triangle_tangent(in, t);
    for (std::size_t k = 0; k < 3; ++k) {
      const uint c = member(in.corners[t], k);
      const std::uint32_t place = places.number(in.positions[member(in.vertices[t], k)], in.normals[c], in.uv[c]);
      group[3 * t + k] = 2 * place + (tangents[t].oriented ? 1u : 0u);
    }
  }
  // 2. At each corner the triangle's tangent, laid into the plane of the normal and weighted with the corner's angle.
  std::vector<Vector> sums(2 * places.count());
  for (std::size_t t = 0; t < triangles; ++t) {
    if (is_zero(tangents[t].direction)) continue;
    std::array<Vector, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = of(in.positions[member(in.vertices[t], k)]);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector normal = of(in.normals[member(in.corners[t], k)]);
      const double cosine = inner(laid(p[(k + 1) % 3] - p[k], normal), laid(p[(k + 2) % 3] - p[k], normal));
      Vector &sum = sums[group[3 * t + k]];
      sum = sum + laid(tangents[t].direction, normal) * std::acos(std::clamp(cosine, -1.0, 1.0));
    }
  }
  for (Vector &sum : sums) sum = unit(sum);
  // 3. To the corners. Triangles without area in uv take what their neighbours have.
  std::vector<vec4> found(in.normals.size(), vec4(0.0f, 0.0f, 0.0f, 1.0f));
  for (std::size_t i = 0; i < 3 * triangles; ++i) {
    std::uint32_t at = group[i];
    if (is_zero(tangents[i / 3].direction)) at = (at & ~1u) | (is_zero(sums[at | 1u]) ? 0u : 1u);
    const Vector s = sums[at];
    found[member(in.corners[i / 3], i % 3)] =
        vec4(static_cast<float>(s.x), static_cast<float>(s.y), static_cast<float>(s.z), (at & 1u) != 0 ? 1.0f : -1.0f);
  }
  return found;
}

bool are_directions(std::span<const vec3> normals) {
  bool good = true;
  for (const vec3 &n : normals) {
    const float square = dot(n, n);
    good &= square > 0.5f && square < 2.0f;
  }
  return good;
}

}  // namespace cotorra

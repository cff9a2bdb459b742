// SPDX-License-Identifier: GPL-3.0-or-later
// Finds overlapping triangles in one plane: by a hash of their planes first, then two by two.
#include "coplanar.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../kernels/math.h"
#include "parallel.h"

namespace cotorra {
namespace {

constexpr std::size_t kMostTriangles = 4'000'000;  // as seen, instances counted: beyond, all meshes are taken for such
constexpr std::size_t kMostInCell = 64;  // triangles of one plane that are compared two by two
// Opaque scenes are not to wait for what few of them have: beyond these, nothing is looked for. All triangles of a
// small mesh are compared with each other, of others those where another object's box is.
constexpr std::size_t kMostOpaqueTriangles = 100'000;
constexpr std::size_t kMostOpaqueInstances = 1'000;
constexpr std::size_t kSmallMesh = 1'000;
constexpr std::size_t kMostBoxes = 16;  // a triangle is looked for in; of more, in the one around them
constexpr float kNormalCell = 1.0f / 256.0f;
// Rays start within 4.8e-7 of the largest coordinate from their surface (surface_shape); planes within eight times that
// are one.
constexpr float kDistanceCell = 8.0f * 4.8e-7f;
constexpr float kOverlap = 1e-4f;  // of the smaller one's width: triangles that touch along an edge do not overlap
// Two grids, half a cell apart: what a border of one divides, the other does not.
constexpr std::array<float, 2> kGrids = {0.0f, 0.5f};

struct Triangle {
  vec3 a, b, c;
};

struct Bounds {
  vec3 low{std::numeric_limits<float>::max()}, high{std::numeric_limits<float>::lowest()};

  // NaN is left out.
  void add(vec3 l, vec3 h) {
    low = min(low, l);
    high = max(high, h);
  }
};

bool meet(const Bounds &a, const Bounds &b) {
  const vec3 low = max(a.low, b.low), high = min(a.high, b.high);
  return low.x <= high.x && low.y <= high.y && low.z <= high.z;
}

Triangle world_triangle(const Mesh &mesh, const Instance &i, std::size_t t) {
  const auto world = [&](uint vertex) {
    const vec3 p = mesh.positions.v[vertex];
    return i.x_axis * p.x + i.y_axis * p.y + i.z_axis * p.z + i.origin;
  };
  const uvec3 v = mesh.triangles.v[t];
  return {world(v.x), world(v.y), world(v.z)};
}

// A unit normal whose largest component is positive, so that both sides of a plane have one; 0 for no triangle.
vec3 plane_normal(const Triangle &t) {
  const vec3 n = cross(t.b - t.a, t.c - t.a);
  const float length2 = dot(n, n);
  if (!(length2 > 0.0f) || !std::isfinite(length2)) return vec3(0.0f);
  const vec3 m = abs(n);
  const float largest = m.x >= m.y && m.x >= m.z ? n.x : (m.y >= m.z ? n.y : n.z);
  return n * (std::copysign(1.0f, largest) / std::sqrt(length2));
}

std::uint64_t mixed(std::uint64_t h) {  // SplitMix64's finalizer (Steele, Lea & Flood 2014)
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return h ^ (h >> 31);
}

// The cell of a triangle's plane; 0 for no triangle.
std::uint64_t cell(const Triangle &t, vec3 center, float distance_cell, float grid) {
  const vec3 n = plane_normal(t);
  if (dot(n, n) == 0.0f) return 0;
  std::uint64_t h = 0;
  const float d = dot(n, t.a - center) / distance_cell;
  for (const float number : {n.x / kNormalCell, n.y / kNormalCell, n.z / kNormalCell, d}) {
    h = mixed(h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(number + grid)))) +
        0x9e3779b97f4a7c15u;
  }
  return h | 1u;
}

// Seen along the largest component of the normal n.
vec2 seen_flat(vec3 p, vec3 n) {
  const vec3 m = abs(n);
  if (m.x >= m.y && m.x >= m.z) return vec2(p.y, p.z);
  return m.y >= m.z ? vec2(p.z, p.x) : vec2(p.x, p.y);
}

// Do two triangles of one plane overlap, seen along its normal? By the axes that may separate them.
bool overlap(const Triangle &s, const Triangle &t) {
  const vec3 n = plane_normal(s);
  const auto flat = [&](vec3 p) { return seen_flat(p, n); };
  const std::array<vec2, 3> a = {flat(s.a), flat(s.b), flat(s.c)}, b = {flat(t.a), flat(t.b), flat(t.c)};
  const auto separated = [&](const std::array<vec2, 3> &edges) {
    for (std::size_t k = 0; k < 3; ++k) {
      const vec2 edge = edges[(k + 1) % 3] - edges[k];
      const auto range = [&](const std::array<vec2, 3> &corners) {
        std::array<float, 2> r = {std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
        for (const vec2 &p : corners) {
          const float along = edge.x * (p.y - edges[k].y) - edge.y * (p.x - edges[k].x);
          r = {std::min(r[0], along), std::max(r[1], along)};
        }
        return r;
      };
      const auto ra = range(a), rb = range(b);
      const float shared = std::min(ra[1], rb[1]) - std::max(ra[0], rb[0]);
      if (shared <= kOverlap * std::min(ra[1] - ra[0], rb[1] - rb[0])) return true;
    }
    return false;
  };
  return !separated(a) && !separated(b);
}

struct Entry {
  std::uint64_t cell;
  std::uint32_t instance, triangle;
};

// Entries of cells that hold more than one, cell by cell.
std::vector<Entry> shared_cells(std::span<const std::uint64_t> cells, std::span<const std::size_t> firsts) {
  std::vector<std::uint8_t> count(std::bit_ceil(4 * cells.size() + 1));
  const auto slot = [&](std::uint64_t c) -> std::uint8_t & { return count[c >> 1 & (count.size() - 1)]; };
  for (const std::uint64_t c : cells) {
    if (c != 0 && slot(c) < 2) ++slot(c);
  }
  std::vector<Entry> found;
  for (std::size_t k = 0; k + 1 < firsts.size(); ++k) {
    for (std::size_t i = firsts[k]; i < firsts[k + 1]; ++i) {
      if (cells[i] == 0 || slot(cells[i]) < 2) continue;
      found.push_back({cells[i], static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(i - firsts[k])});
    }
  }
  std::sort(found.begin(), found.end(), [](const Entry &a, const Entry &b) { return a.cell < b.cell; });
  return found;
}

// Does it face along the normal that both sides of its plane have?
bool faces_along(const Triangle &t, const Instance &i) {
  const bool along = dot(cross(t.b - t.a, t.c - t.a), plane_normal(t)) > 0.0f;
  return along != ((i.flags & INSTANCE_MIRRORED) != 0);
}

vec2 lower(vec2 a, vec2 b) { return {std::min(a.x, b.x), std::min(a.y, b.y)}; }
vec2 upper(vec2 a, vec2 b) { return {std::max(a.x, b.x), std::max(a.y, b.y)}; }

struct FlatTriangle {
  Triangle triangle;
  vec2 low, high;
  bool along;
  uint mesh;
};

// The squares of a grid over one plane that each triangle's box reaches into, as square and triangle, square by square.
// Those that reach into many are left out.
std::vector<std::array<std::uint32_t, 2>> squares_of(std::span<const FlatTriangle> flats) {
  vec2 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
  for (const FlatTriangle &f : flats) {
    low = lower(low, f.low);
    high = upper(high, f.high);
  }
  const auto side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(flats.size()))));
  const auto place = [side](float x, float first, float last) {
    const float share = (x - first) / std::max(last - first, 1e-30f);
    return std::min(static_cast<std::uint32_t>(share * static_cast<float>(side)), side - 1u);
  };
  std::vector<std::array<std::uint32_t, 2>> squares;
  for (std::uint32_t k = 0; k < flats.size(); ++k) {
    const FlatTriangle &f = flats[k];
    const std::uint32_t x0 = place(f.low.x, low.x, high.x), x1 = place(f.high.x, low.x, high.x);
    const std::uint32_t y0 = place(f.low.y, low.y, high.y), y1 = place(f.high.y, low.y, high.y);
    if (std::uint64_t{x1 - x0 + 1} * (y1 - y0 + 1) > kMostInCell) continue;
    for (std::uint32_t y = y0; y <= y1; ++y) {
      for (std::uint32_t x = x0; x <= x1; ++x) squares.push_back({y * side + x, k});
    }
  }
  std::sort(squares.begin(), squares.end());
  return squares;
}

// Marks the meshes of one plane's triangles that overlap another that faces the same way: each is compared with those
// of its squares, and the large ones of few with all.
template <typename TriangleOf>
void find_coinciding(std::span<const Entry> plane, std::span<const Instance> instances, const TriangleOf &triangle_of,
                     std::vector<bool> &found) {
  std::vector<FlatTriangle> flats;
  for (const Entry &e : plane) {
    const Triangle t = triangle_of(e);
    const vec3 n = plane_normal(t);
    const vec2 a = seen_flat(t.a, n), b = seen_flat(t.b, n), c = seen_flat(t.c, n);
    const Instance &instance = instances[e.instance];
    flats.push_back({t, lower(a, lower(b, c)), upper(a, upper(b, c)), faces_along(t, instance), instance.mesh});
  }
  const auto compare = [&](const FlatTriangle &a, const FlatTriangle &b) {
    const vec2 shared = lower(a.high, b.high) - upper(a.low, b.low);
    if (a.along != b.along || !(shared.x > 0.0f) || !(shared.y > 0.0f)) return;
    if ((found[a.mesh] && found[b.mesh]) || !overlap(a.triangle, b.triangle)) return;
    found[a.mesh] = found[b.mesh] = true;
  };
  const auto squares = squares_of(flats);
  std::vector<bool> placed(flats.size(), false);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    placed[squares[i][1]] = true;
    const std::size_t end = std::min(squares.size(), i + 1 + kMostInCell);
    for (std::size_t j = i + 1; j < end && squares[j][0] == squares[i][0]; ++j) {
      compare(flats[squares[i][1]], flats[squares[j][1]]);
    }
  }
  std::size_t large = 0;
  for (std::size_t i = 0; i < flats.size() && large < kMostInCell; ++i) {
    if (placed[i]) continue;
    ++large;
    for (std::size_t j = 0; j < flats.size(); ++j) {
      if (j != i) compare(flats[i], flats[j]);
    }
  }
}

// By instance: boxes outside of which nothing of it coincides with anything else; `rounding` is what planes differ by.
std::vector<std::vector<Bounds>> places_that_may_coincide(std::span<const Mesh> meshes,
                                                          std::span<const Instance> instances,
                                                          std::span<const Bounds> boxes, float rounding) {
  std::vector<std::vector<Bounds>> places(instances.size());
  parallel_for(instances.size(), [&](std::size_t k) {
    Bounds wide = boxes[k];
    wide.add(wide.low - vec3(rounding), wide.high + vec3(rounding));
    Bounds around;
    for (std::size_t j = 0; j < instances.size(); ++j) {
      if (j == k ? meshes[instances[k].mesh].triangle_count > kSmallMesh : !meet(wide, boxes[j])) continue;
      const Bounds shared{max(wide.low, boxes[j].low - vec3(rounding)), min(wide.high, boxes[j].high + vec3(rounding))};
      around.add(shared.low, shared.high);
      places[k].push_back(shared);
    }
    if (places[k].size() > kMostBoxes) places[k] = {around};
  });
  return places;
}

// `coinciding`: of those that face one way, else of all.
std::vector<bool> meshes_in_one_plane(std::span<const Mesh> meshes, std::span<const Instance> instances,
                                      bool coinciding) {
  const std::vector<bool> unknown(meshes.size(), !coinciding);
  std::vector<bool> found(meshes.size(), false);
  std::vector<std::size_t> firsts = {0};
  for (const Instance &i : instances) firsts.push_back(firsts.back() + meshes[i.mesh].triangle_count);
  if (firsts.back() > (coinciding ? kMostOpaqueTriangles : kMostTriangles)) return unknown;
  if (coinciding && instances.size() > kMostOpaqueInstances) return unknown;

  // 1. Where the scene is, and how large: rounding grows with it. Planes' distances count from its middle.
  std::vector<Bounds> boxes(instances.size());
  parallel_for(instances.size(), [&](std::size_t k) {
    const Mesh &mesh = meshes[instances[k].mesh];
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
      const Triangle triangle = world_triangle(mesh, instances[k], t);
      for (const vec3 p : {triangle.a, triangle.b, triangle.c}) boxes[k].add(p, p);
    }
  });
  Bounds all;
  for (const Bounds &box : boxes) all.add(box.low, box.high);
  const float extent = max_component(max(abs(all.low), abs(all.high)));
  if (!(all.low.x <= all.high.x) || !std::isfinite(extent)) return unknown;
  const vec3 center = (all.low + all.high) * 0.5f;
  const float distance_cell = std::max(kDistanceCell * extent, 1e-8f);

  std::vector<std::vector<Bounds>> places;
  if (coinciding) places = places_that_may_coincide(meshes, instances, boxes, distance_cell);
  const auto asked = [&](std::size_t instance, const Triangle &t) {
    if (!coinciding) return true;
    const Bounds own{min(t.a, min(t.b, t.c)), max(t.a, max(t.b, t.c))};
    return std::any_of(places[instance].begin(), places[instance].end(), [&](const Bounds &b) { return meet(own, b); });
  };

  // 2. Cells of planes, and two by two what is in one.
  std::vector<std::uint64_t> cells(firsts.back());
  for (const float grid : kGrids) {
    parallel_for(instances.size(), [&](std::size_t k) {
      const Mesh &mesh = meshes[instances[k].mesh];
      if (coinciding && places[k].empty()) return;
      for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        const Triangle triangle = world_triangle(mesh, instances[k], t);
        cells[firsts[k] + t] = asked(k, triangle) ? cell(triangle, center, distance_cell, grid) : 0;
      }
    });
    const std::vector<Entry> entries = shared_cells(cells, firsts);
    const auto mesh_of = [&](const Entry &e) { return instances[e.instance].mesh; };
    const auto triangle_of = [&](const Entry &e) {
      return world_triangle(meshes[mesh_of(e)], instances[e.instance], e.triangle);
    };
    for (std::size_t first = 0; first < entries.size();) {
      std::size_t last = first + 1;
      while (last < entries.size() && entries[last].cell == entries[first].cell) ++last;
      const bool many = last - first > kMostInCell;
      if (coinciding) {
        find_coinciding(std::span(entries).subspan(first, last - first), instances, triangle_of, found);
        first = last;
        continue;
      }
      for (std::size_t i = first; i < last; ++i) {
        if (many) found[mesh_of(entries[i])] = true;
        for (std::size_t j = i + 1; j < last && !many; ++j) {
          const bool known = found[mesh_of(entries[i])] && found[mesh_of(entries[j])];
          if (known || !overlap(triangle_of(entries[i]), triangle_of(entries[j]))) continue;
          found[mesh_of(entries[i])] = found[mesh_of(entries[j])] = true;
        }
      }
      first = last;
    }
  }
  return found;
}

}  // namespace

std::vector<bool> coplanar_meshes(std::span<const Mesh> meshes, std::span<const Instance> instances) {
  return meshes_in_one_plane(meshes, instances, false);
}

std::vector<bool> coinciding_meshes(std::span<const Mesh> meshes, std::span<const Instance> instances) {
  return meshes_in_one_plane(meshes, instances, true);
}

}  // namespace cotorra

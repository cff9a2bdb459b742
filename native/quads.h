// SPDX-License-Identifier: GPL-3.0-or-later
// What Embree traces in place of a mesh's triangles: quadrilaterals of two that share an edge, or of one. It has half
// as many to build its BVH over and to test. Here is how they are made, and what hits of them are hits of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "../kernels/surface.h"
#include "embree.h"

namespace cotorra {

// To Embree its triangles are 0 1 3 and 2 3 1, and a triangle alone is 0 1 2 2.
struct Quad {
  std::array<uint, 4> vertices;
  // Numbers of its triangles, each above two bits: which corner of the first is vertex 0, which of the second vertex 2.
  std::array<uint, 2> triangles;
};
static_assert(sizeof(Quad) == 24);
constexpr uint kNoTriangle = 0xffffffffu;                     // in place of the second one
constexpr std::size_t kQuadTriangles = std::size_t{1} << 30;  // most of a mesh

// The triangles of a mesh, at most kQuadTriangles. Two become one where they follow each other and share an edge, as
// where Blender or an exporter divided polygons, else where the edge is the longest of both.
std::vector<Quad> pair_triangles(std::span<const uvec3> triangles, std::span<const vec3> positions);

// One geometry of the top-level BVH: a mesh in world space, or all instances of one that is seen alike.
struct EmbreeGeometry {
  uint first_instance;
  const Quad *quads;
  const vec3 *positions;  // of the vertices
};

// Numbers of a hit as Embree tells them. ng: along the normal of the triangle, in its mesh's space, of any length.
struct EmbreeHit {
  vec3 ng;
  float t, u, v;
  std::uint32_t primitive, geometry, array, place;  // place: in the array of instances, where it is one
};

FN const EmbreeGeometry &traced_geometry(const EmbreeGeometry *geometries, const EmbreeHit &h) {
  return geometries[h.array != embree::kInvalidId ? h.array : h.geometry];
}
FN uint traced_instance(const EmbreeGeometry *geometries, const EmbreeHit &h) {
  return traced_geometry(geometries, h).first_instance + (h.array != embree::kInvalidId ? h.place : 0u);
}

// u + v is 1 on the edge that the triangles share, but for rounding. There their normals tell which of them was hit:
// seen from the other side of a crease, the wrong one would send the next ray through the surface.
constexpr float kSharedEdge = 1e-6f;
bool second_was_hit(const EmbreeGeometry &geometry, const Quad &quad, vec3 ng);

// Of something that was hit. Embree counts u and v of the second triangle from its far ends.
FN Hit traced_hit(const EmbreeGeometry *geometries, const EmbreeHit &h) {
  const EmbreeGeometry &geometry = traced_geometry(geometries, h);
  const Quad &quad = geometry.quads[h.primitive];
  bool second = false;
  if (quad.triangles[1] != kNoTriangle) {
    const float past = h.u + h.v - 1.0f;
    second = std::abs(past) > kSharedEdge ? past > 0.0f : second_was_hit(geometry, quad, h.ng);
  }
  const uint triangle = quad.triangles[second ? 1 : 0];
  const uint corner = triangle & 3u;
  const float next = second ? 1.0f - h.u : h.u;
  const float last = second ? 1.0f - h.v : h.v;
  const float own = std::max(1.0f - next - last, 0.0f);
  const float u = corner == 0u ? next : (corner == 1u ? own : last);
  const float v = corner == 0u ? last : (corner == 1u ? next : own);
  return {h.t, u, v, triangle >> 2, traced_instance(geometries, h), 0u};
}

}  // namespace cotorra

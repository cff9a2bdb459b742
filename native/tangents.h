// SPDX-License-Identifier: GPL-3.0-or-later
// Tangents of triangles as MikkTSpace defines them (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", 6.2).
#pragma once

#include <span>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

struct TangentInput {
  std::span<const vec3> positions;     // by vertex
  std::span<const vec3> normals;       // by corner
  std::span<const vec2> uv;            // by corner
  std::span<const uvec3> vertices;     // of each triangle
  std::span<const uvec3> corners;      // of each triangle
};

// By corner: a unit tangent along u and the sign of its bitangent; 0, 0, 0 where uv gives no direction. Throws
// std::invalid_argument where an index has no entry.
//
// Corners of one position, normal and uv share a tangent if their triangles have one orientation in uv. MikkTSpace also
// asks that the triangles hang together around the vertex: that differs where two fans touch in a point only.
std::vector<vec4> corner_tangents(const TangentInput &in);

// Whether all are of a length between 0.7 and 1.4; NaN is not.
bool are_directions(std::span<const vec3> normals);

}  // namespace cotorra

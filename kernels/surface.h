// SPDX-License-Identifier: GPL-3.0-or-later
// From a hit to the point that is shaded: position, normals, texture coordinates, material.
// What the material does with light is in bsdf.h.
#ifndef COTORRA_SURFACE_H
#define COTORRA_SURFACE_H

#include "math.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

struct Hit {
  float t;
  float u;         // barycentric: p = (1 - u - v) p0 + u p1 + v p2
  float v;
  uint triangle;
  uint instance;   // INVALID_ID: nothing was met
};

// A shading point, world space. Both normals are on the side that the ray came from, after Blender: the smooth normal
// turns over together with the geometric one.
struct Surface {
  vec3 p;
  uint instance;
  vec3 ng;
  uint triangle;
  vec3 n;
  uint material;
  float u;
  float v;
  float epsilon;   // metres that clear the rounding of p
  uint flags;      // SURFACE_*
  float terminator;  // shadow terminator geometry offset, 0 = none
};
const uint SURFACE_SMOOTH = 1u;
const uint SURFACE_BACKFACE = 2u;

FN vec3 instance_point(IN(Instance) i, vec3 p) { return i.x_axis * p.x + i.y_axis * p.y + i.z_axis * p.z + i.origin; }
FN vec3 instance_vector(IN(Instance) i, vec3 v) { return i.x_axis * v.x + i.y_axis * v.y + i.z_axis * v.z; }
FN vec3 instance_normal(IN(Instance) i, vec3 n) { return i.normal_x * n.x + i.normal_y * n.y + i.normal_z * n.z; }

// Entries of Mesh.normals at the triangle's three corners.
FN uvec3 mesh_normal_indices(IN(Mesh) mesh, uint triangle, uvec3 vertices) {
  if ((mesh.flags & MESH_SMOOTH_CORNER) != 0u) return LOAD(mesh.corners, triangle);
  return vertices;
}

FN void surface_from_hit(IN(SceneData) scene, IN(Hit) hit, vec3 direction, OUT(Surface) s) {
  const Instance instance = LOAD(scene.instances, hit.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, hit.triangle);
  vec3 p0 = LOAD(mesh.positions, id.x);
  vec3 p1 = LOAD(mesh.positions, id.y);
  vec3 p2 = LOAD(mesh.positions, id.z);
  const float w = 1.0f - hit.u - hit.v;

  // 1. Geometric normal, from the edges in object space, where they are exact.
  vec3 ng = cross(p1 - p0, p2 - p0);
  const bool moved = (instance.flags & INSTANCE_IDENTITY) == 0u;
  vec3 p = p0 * w + p1 * hit.u + p2 * hit.v;
  vec3 extent = max(abs(p0), max(abs(p1), abs(p2)));
  if (moved) {
    ng = instance_normal(instance, ng);
    extent = abs(instance.x_axis) * extent.x + abs(instance.y_axis) * extent.y + abs(instance.z_axis) * extent.z +
             abs(instance.origin);
    p = instance_point(instance, p);
  }
  if ((mesh.flags & MESH_MIRRORED) != 0u) ng = -ng;
  float len;
  ng = safe_normalize(ng, len);
  const bool back = dot(ng, direction) > 0.0f;

  // 2. Shading normal.
  vec3 n = ng;
  s.flags = select(back, SURFACE_BACKFACE, 0u);
  if ((mesh.flags & (MESH_SMOOTH_VERTEX | MESH_SMOOTH_CORNER)) != 0u) {
    const uvec3 ni = mesh_normal_indices(mesh, hit.triangle, id);
    vec3 smooth_n = LOAD(mesh.normals, ni.x) * w + LOAD(mesh.normals, ni.y) * hit.u + LOAD(mesh.normals, ni.z) * hit.v;
    if (moved) smooth_n = instance_normal(instance, smooth_n);
    smooth_n = safe_normalize(smooth_n, len);
    n = len > 0.0f ? smooth_n : ng;
    s.flags |= SURFACE_SMOOTH;
  }
  const float side = select(back, -1.0f, 1.0f);

  // 3. The material of the triangle's slot; slots past the object's last use the last, as Blender does.
  uint slot = 0u;
  if ((mesh.flags & MESH_HAS_SLOTS) != 0u) slot = min(LOAD(mesh.slots, hit.triangle), instance.material_count - 1u);
  s.material = LOAD(scene.material_slots, instance.material_base + slot);
  s.p = p;
  s.ng = ng * side;
  s.n = n * side;
  s.u = hit.u;
  s.v = hit.v;
  s.instance = hit.instance;
  s.terminator = float(instance.flags >> INSTANCE_TERMINATOR_SHIFT) * (1.0f / 65535.0f);
  s.triangle = hit.triangle;
  // Four units in the last place of the largest coordinate that went into p.
  s.epsilon = max_component(extent) * 4.8e-7f + 1e-9f;
}

FN vec2 surface_uv(IN(SceneData) scene, IN(Surface) s) {
  Mesh mesh = LOAD(scene.meshes, LOAD(scene.instances, s.instance).mesh);
  if ((mesh.flags & MESH_HAS_UV) == 0u) return vec2(0.0f, 0.0f);
  const uvec3 c = LOAD(mesh.corners, s.triangle);
  return LOAD(mesh.uv, c.x) * (1.0f - s.u - s.v) + LOAD(mesh.uv, c.y) * s.u + LOAD(mesh.uv, c.z) * s.v;
}

// Start of a ray that leaves the surface in direction wi, clear of the triangle it starts on.
FN vec3 surface_ray_origin(IN(Surface) s, vec3 wi) {
  return s.p + s.ng * (dot(s.ng, wi) >= 0.0f ? s.epsilon : -s.epsilon);
}

// Height above p of the plane through corner a with normal n, lifted to clear the corners b and c.
FN float plane_height(vec3 a, vec3 n, vec3 b, vec3 c, vec3 p, float side) {
  const float lift = max(max(side * dot(b - a, n), side * dot(c - a, n)), 0.0f);
  return max(side * dot(a - p, n) + lift, 0.0f);
}

// How far the smooth surface that the normals describe lies above the flat triangle at the point, as a vector: a
// parabola through the corner normals, kept within the tangent planes (the idea is Cycles' "shadow terminator geometry
// offset", which this equals; Hanika 2021 describes the problem).
FN vec3 surface_smooth_lift(IN(SceneData) scene, IN(Surface) s) {
  const Instance instance = LOAD(scene.instances, s.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, s.triangle);
  const uvec3 ni = mesh_normal_indices(mesh, s.triangle, id);
  const vec3 p0 = LOAD(mesh.positions, id.x);
  const vec3 p1 = LOAD(mesh.positions, id.y);
  const vec3 p2 = LOAD(mesh.positions, id.z);
  const vec3 n0 = LOAD(mesh.normals, ni.x);
  const vec3 n1 = LOAD(mesh.normals, ni.y);
  const vec3 n2 = LOAD(mesh.normals, ni.z);
  const float w = 1.0f - s.u - s.v;
  const vec3 p = p0 * w + p1 * s.u + p2 * s.v;
  vec3 n = n0 * w + n1 * s.u + n2 * s.v;
  if ((instance.flags & INSTANCE_IDENTITY) == 0u) n = instance_vector(instance, n);

  // Height of the parabola over the triangle.
  const float e20 = dot(n2 - n0, p0 - p2);
  const float e21 = dot(n2 - n1, p1 - p2);
  const float e10 = dot(n1 - n0, p1 - p0);
  float h = e20 * w * (w - 1.0f) + (e20 + e21 + e10) * w * s.u + e21 * s.u * (s.u - 1.0f);

  // Heights of the three tangent planes over p, each lifted so far that it clears the triangle; seen from behind the
  // same with all signs turned.
  const float side = select(dot(n, s.ng) > 0.0f, 1.0f, -1.0f);
  const float h0 = plane_height(p0, n0, p1, p2, p, side);
  const float h1 = plane_height(p1, n1, p0, p2, p, side);
  const float h2 = plane_height(p2, n2, p0, p1, p, side);
  const float envelope = min(min(h0, h1), h2);
  h = select(side > 0.0f, max(envelope, h * 0.5f), min(-envelope, h * 0.5f));
  return n * h;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

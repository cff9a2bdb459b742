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
  uint crossed;    // transparent surfaces on the way
};

// In the place of a triangle that a ray left: the ray meets the instance alone.
const uint LEFT_ALL_OTHERS = 0xfffffffeu;

// Is the triangle none that the ray can meet? `left`: instance and triangle that it left.
FN bool ray_passes(uint instance, uint triangle, uvec2 left) {
  if (left.y == LEFT_ALL_OTHERS) return instance != left.x;
  return triangle == left.y && instance == left.x;
}

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
  float epsilon;     // metres that clear the rounding of p
  float terminator;  // shadow terminator geometry offset, 0 = none
  float side;        // 1: seen from the front, -1: from behind
  float t;           // length of the ray that met it
};

FN vec3 instance_point(IN(Instance) i, vec3 p) { return i.x_axis * p.x + i.y_axis * p.y + i.z_axis * p.z + i.origin; }
FN vec3 instance_vector(IN(Instance) i, vec3 v) { return i.x_axis * v.x + i.y_axis * v.y + i.z_axis * v.z; }
FN vec3 instance_normal(IN(Instance) i, vec3 n) { return i.normal_x * n.x + i.normal_y * n.y + i.normal_z * n.z; }

// Entries of Mesh.normals at the triangle's three corners.
FN uvec3 mesh_normal_indices(IN(Mesh) mesh, uint triangle, uvec3 vertices) {
  if ((mesh.flags & MESH_SMOOTH_CORNER) != 0u) return LOAD(mesh.corners, triangle);
  return vertices;
}

// The material of a triangle; slots past the object's last use the last, as Blender does.
FN uint triangle_material(IN(SceneData) scene, uint instance_id, uint triangle) {
  const Instance instance = LOAD(scene.instances, instance_id);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  uint slot = 0u;
  if ((mesh.flags & MESH_HAS_SLOTS) != 0u) slot = min(LOAD(mesh.slots, triangle), instance.material_count - 1u);
  return LOAD(scene.material_slots, instance.material_base + slot);
}

// The triangle of a hit in world space, and what belongs to it.
struct SurfaceTriangle {
  vec3 p0;
  float orientation;  // -1 where a mirroring transform turned the triangle over
  vec3 p1;
  float terminator;   // Instance's shadow terminator geometry offset, 0 where the triangle is flat
  vec3 p2;
  uint material;
  vec3 n0;            // null vectors where the triangle is flat
  vec3 n1;
  vec3 n2;
};

FN void surface_fetch(IN(SceneData) scene, uint instance_id, uint triangle, OUT(SurfaceTriangle) t) {
  const Instance instance = LOAD(scene.instances, instance_id);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, triangle);
  t.p0 = LOAD(mesh.positions, id.x);
  t.p1 = LOAD(mesh.positions, id.y);
  t.p2 = LOAD(mesh.positions, id.z);
  t.n0 = vec3(0.0f);
  t.n1 = vec3(0.0f);
  t.n2 = vec3(0.0f);
  t.terminator = 0.0f;
  if ((mesh.flags & (MESH_SMOOTH_VERTEX | MESH_SMOOTH_CORNER)) != 0u) {
    const uvec3 ni = mesh_normal_indices(mesh, triangle, id);
    t.n0 = LOAD(mesh.normals, ni.x);
    t.n1 = LOAD(mesh.normals, ni.y);
    t.n2 = LOAD(mesh.normals, ni.z);
    t.terminator = float(int(instance.flags >> INSTANCE_TERMINATOR_SHIFT)) * (1.0f / 65535.0f);
  }
  if ((instance.flags & INSTANCE_IDENTITY) == 0u) {
    t.p0 = instance_point(instance, t.p0);
    t.p1 = instance_point(instance, t.p1);
    t.p2 = instance_point(instance, t.p2);
    t.n0 = instance_normal(instance, t.n0);
    t.n1 = instance_normal(instance, t.n1);
    t.n2 = instance_normal(instance, t.n2);
  }
  t.orientation = select((instance.flags & INSTANCE_MIRRORED) != 0u, -1.0f, 1.0f);
  t.material = triangle_material(scene, instance_id, triangle);
}

// How far, in roundings of the position, one that is nearer to an edge is drawn toward the triangle's centroid.
const float SURFACE_INSET = 4.0f;

// Position and normals at barycentric u, v, seen along `direction`: both normals turn to the ray's side together, as in
// Blender. Returns the rounding of the position, in metres. Without branches, so that a loop vectorises.
// At an edge the position would round to either side of the neighbour's plane, and a ray that starts there leave a
// closed mesh: near one it is drawn inward, where the triangle is that large, so that rays start inside (down to angles
// between neighbours of atan(1 / SURFACE_INSET), for triangles that are no needles). Elsewhere it is what it is.
FN float surface_shape(IN(SurfaceTriangle) t, float u, float v, vec3 direction, OUT(vec3) p, OUT(vec3) ng, OUT(vec3) n,
                       OUT(float) side) {
  const float w = 1.0f - u - v;
  const vec3 e1 = t.p1 - t.p0;
  const vec3 e2 = t.p2 - t.p0;
  const vec3 c = cross(e1, e2) * t.orientation;
  const float c2 = dot(c, c);
  const vec3 face = c * (1.0f / sqrt(max(c2, 1e-37f)));
  side = select(dot(face, direction) > 0.0f, -1.0f, 1.0f);
  const vec3 s = t.n0 * w + t.n1 * u + t.n2 * v;
  const float s2 = dot(s, s);
  ng = face * side;
  n = select(s2 > 0.0f, s * (side / sqrt(max(s2, 1e-37f))), ng);
  // Eight times the unit roundoff of the largest coordinate that goes into p.
  const vec3 extent = max(abs(t.p0), max(abs(t.p1), abs(t.p2)));
  const float rounding = max_component(extent) * 4.8e-7f;
  const vec3 inward = e1 * (1.0f / 3.0f - u) + e2 * (1.0f / 3.0f - v);
  const float drawn = SURFACE_INSET * rounding;
  const vec3 e3 = e2 - e1;
  const float longest2 = max(dot(e1, e1), max(dot(e2, e2), dot(e3, e3)));
  // No edge is nearer than the least barycentric coordinate times the least height.
  const float least = max(min(u, min(v, w)), 0.0f);
  const bool near_edge = least * least * c2 <= drawn * drawn * longest2;
  const float inset = select(near_edge, min(drawn / sqrt(max(dot(inward, inward), 1e-37f)), 1.0f), 0.0f);
  p = t.p0 + (e1 * u + e2 * v + inward * inset);
  return rounding;
}

FN void surface_from_hit(IN(SceneData) scene, IN(Hit) hit, vec3 direction, OUT(Surface) s) {
  SurfaceTriangle t;
  surface_fetch(scene, hit.instance, hit.triangle, t);
  s.epsilon = surface_shape(t, hit.u, hit.v, direction, s.p, s.ng, s.n, s.side);
  s.material = t.material;
  s.t = hit.t;
  s.terminator = t.terminator;
  s.u = hit.u;
  s.v = hit.v;
  s.instance = hit.instance;
  s.triangle = hit.triangle;
}

FN vec2 surface_uv(IN(SceneData) scene, IN(Surface) s) {
  Mesh mesh = LOAD(scene.meshes, LOAD(scene.instances, s.instance).mesh);
  if ((mesh.flags & MESH_HAS_UV) == 0u) return vec2(0.0f, 0.0f);
  const uvec3 c = LOAD(mesh.corners, s.triangle);
  return LOAD(mesh.uv, c.x) * (1.0f - s.u - s.v) + LOAD(mesh.uv, c.y) * s.u + LOAD(mesh.uv, c.z) * s.v;
}

// Start of a ray that leaves the surface in direction wi, clear of the triangle it starts on.
FN vec3 surface_ray_origin(vec3 p, vec3 ng, float epsilon, vec3 wi) {
  return p + ng * select(dot(ng, wi) >= 0.0f, epsilon, -epsilon);
}

// Height above p of the plane through corner a with normal n, lifted to clear the corners b and c.
FN float plane_height(vec3 a, vec3 n, vec3 b, vec3 c, vec3 p, float side) {
  const float lift = max(max(side * dot(b - a, n), side * dot(c - a, n)), 0.0f);
  return max(side * dot(a - p, n) + lift, 0.0f);
}

// How far the smooth surface that the normals describe lies above the flat triangle at the point, as a vector: a
// parabola through the corner normals, kept within the tangent planes (the idea is Cycles' "shadow terminator geometry
// offset", which this equals; Hanika 2021 describes the problem).
FN vec3 surface_smooth_lift(IN(SceneData) scene, uint instance_id, uint triangle, float u, float v, vec3 ng) {
  const Instance instance = LOAD(scene.instances, instance_id);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, triangle);
  const uvec3 ni = mesh_normal_indices(mesh, triangle, id);
  const vec3 p0 = LOAD(mesh.positions, id.x);
  const vec3 p1 = LOAD(mesh.positions, id.y);
  const vec3 p2 = LOAD(mesh.positions, id.z);
  const vec3 n0 = LOAD(mesh.normals, ni.x);
  const vec3 n1 = LOAD(mesh.normals, ni.y);
  const vec3 n2 = LOAD(mesh.normals, ni.z);
  const float w = 1.0f - u - v;
  const vec3 p = p0 * w + p1 * u + p2 * v;
  vec3 n = n0 * w + n1 * u + n2 * v;
  if ((instance.flags & INSTANCE_IDENTITY) == 0u) n = instance_vector(instance, n);

  // Height of the parabola over the triangle.
  const float e20 = dot(n2 - n0, p0 - p2);
  const float e21 = dot(n2 - n1, p1 - p2);
  const float e10 = dot(n1 - n0, p1 - p0);
  float h = e20 * w * (w - 1.0f) + (e20 + e21 + e10) * w * u + e21 * u * (u - 1.0f);

  // Heights of the three tangent planes over p, each lifted so far that it clears the triangle; seen from behind the
  // same with all signs turned.
  const float side = select(dot(n, ng) > 0.0f, 1.0f, -1.0f);
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

// SPDX-License-Identifier: GPL-3.0-or-later
// Normals that are bent: normal maps in each space, bumps, and the tangents that they and anisotropy lie along.
// What a bent normal does to light is in bsdf.h.
#ifndef COTORRA_PROGRAM_NORMAL_MAP_H
#define COTORRA_PROGRAM_NORMAL_MAP_H

#include "point.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The smooth normal in object space, that of the triangle where it is flat. Cycles 5.2 normalises it before it builds
// the tangent frame, which the inventor of the tangents does not (measured: a monkey is 4.8 % off without).
FN vec3 tangent_space_normal(IN(Mesh) mesh, IN(MeshTextures) more, IN(NormalFrame) f, IN(ShaderPoint) at) {
  const vec3 flat_normal = normal_to_object(f, at.ng * at.side);
  if ((mesh.flags & (MESH_SMOOTH_VERTEX | MESH_SMOOTH_CORNER)) == 0u) return flat_normal;
  const uvec3 ni = mesh_normal_indices(mesh, at.triangle, LOAD(mesh.triangles, at.triangle));
  vec3 n0 = LOAD(mesh.normals, ni.x);
  vec3 n1 = LOAD(mesh.normals, ni.y);
  vec3 n2 = LOAD(mesh.normals, ni.z);
  if (more.moved != 0u) {
    n0 = normal_to_object(f, n0);
    n1 = normal_to_object(f, n1);
    n2 = normal_to_object(f, n2);
  }
  float unused;
  return safe_normalize(n0 * (1.0f - at.u - at.v) + n1 * at.u + n2 * at.v, unused);
}

// The tangent at a point, interpolated, object space, and its sign; null where the mesh has none.
FN vec4 mesh_tangent(IN(Mesh) mesh, IN(MeshTextures) more, uint layer, IN(ShaderPoint) at) {
  if (layer >= more.tangent_layers) return vec4(0.0f, 0.0f, 0.0f, 0.0f);
  const uvec3 c = LOAD(mesh.corners, at.triangle);
  const uint first = layer * more.corner_count;
  return LOAD(more.tangents, first + c.x) * (1.0f - at.u - at.v) + LOAD(more.tangents, first + c.y) * at.u +
         LOAD(more.tangents, first + c.z) * at.v;
}

// A unit vector along `n`, or `instead` where n is null or no number.
FN vec3 normalize_or(vec3 n, vec3 instead) {
  const float d2 = dot(n, n);
  return d2 > 1e-30f && d2 < INFINITE_DISTANCE ? n * (1.0f / sqrt(d2)) : instead;
}

// Direction `c` (-1 to 1 in each component) of a normal map in tangent space, in world space on the front side, of any
// length. The strength bends it toward the normal before it leaves tangent space, as Cycles 5 does.
FN vec3 tangent_normal(IN(SceneData) scene, uint layer, IN(ShaderPoint) at, vec3 c, float strength) {
  const Instance instance = LOAD(scene.instances, at.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);
  const vec4 t4 = mesh_tangent(mesh, more, layer, at);
  const vec3 t = vec3(t4.x, t4.y, t4.z);
  if (is_black(t)) return vec3(0.0f);
  const NormalFrame f = normal_frame(instance, more);
  const vec3 n = tangent_space_normal(mesh, more, f, at);
  const vec3 b = cross(n, t) * t4.w;
  float len;
  const vec3 bent = t * (c.x * strength) + b * (c.y * strength) + n * mix(1.0f, c.z, clamp(strength, 0.0f, 1.0f));
  return normal_to_world(f, safe_normalize(bent, len));
}

// The normal that a Normal Map node makes of a colour, on the viewer's side.
FN vec3 normal_map(IN(SceneData) scene, IN(ShaderPoint) at, uint space, vec3 color, float strength, uint layer) {
  vec3 c = color * 2.0f - vec3(1.0f);
  if (space >= NORMAL_BLENDER_OBJECT) c = vec3(c.x, -c.y, -c.z);
  if (space == NORMAL_TANGENT) {
    return normalize_or(tangent_normal(scene, layer, at, c, strength) * at.side, at.n);
  }
  const vec3 mapped =
      space == NORMAL_OBJECT || space == NORMAL_BLENDER_OBJECT ? normal_to_world(point_frame(scene, at), c) : c;
  const vec3 n = normalize_or(mapped * at.side, at.n);
  return normalize_or(mix(at.n, n, max(strength, 0.0f)), at.n);
}

// The normal that a height bends (Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU"): h at the point
// and a footprint aside in two directions.
FN vec3 bump_normal(IN(ShaderPoint) at, vec3 n, float h, float h_dx, float h_dy, float strength, float distance) {
  vec3 dx;
  vec3 dy;
  point_differentials(at, dx, dy);
  const vec3 rx = cross(dy, n);
  const vec3 ry = cross(n, dx);
  const float det = dot(dx, rx);
  const vec3 gradient = rx * (h_dx - h) + ry * (h_dy - h);
  const vec3 bent = normalize_or(n * abs(det) - gradient * (distance * sign(det)), n);
  const float share = max(strength, 0.0f);
  return normalize_or(bent * share + n * (1.0f - share), n);
}

// A tangent of world space at right angles to the normal; null where it cannot be told.
FN vec3 tangent_about(vec3 n, vec3 t) {
  float len;
  const vec3 b = cross(t, n);
  if (!(dot(b, b) > 1e-30f)) return vec3(0.0f);
  return cross(n, safe_normalize(b, len));
}

// Around an axis of the object, as Tangent's Radial has it: `position` is generated coordinates.
FN vec3 radial_tangent(IN(SceneData) scene, IN(ShaderPoint) at, uint axis, vec3 position) {
  const vec3 c = position - vec3(0.5f);
  vec3 t = vec3(-c.y, c.x, 0.0f);
  if (axis == 0u) t = vec3(0.0f, -c.z, c.y);
  if (axis == 1u) t = vec3(-c.z, 0.0f, c.x);
  return tangent_about(at.n, normal_to_world(point_frame(scene, at), t));
}

FN vec3 uv_tangent(IN(SceneData) scene, IN(ShaderPoint) at, uint layer) {
  const Instance instance = LOAD(scene.instances, at.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);
  const vec4 t = mesh_tangent(mesh, more, layer, at);
  return tangent_about(at.n, vector_to_world(normal_frame(instance, more), vec3(t.x, t.y, t.z)));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

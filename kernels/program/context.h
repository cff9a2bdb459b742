// SPDX-License-Identifier: GPL-3.0-or-later
// The ops that read the point at which a program runs: geometry, coordinates, attributes, the object, the path.
// Ops that depend on their arguments alone are in pure.h.
#ifndef COTORRA_PROGRAM_CONTEXT_H
#define COTORRA_PROGRAM_CONTEXT_H

#include "../closure/principled.h"
#include "normal_map.h"
#include "pure.h"
#include "rays.h"
#include "types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// ---- Cameras. Cycles' camera looks along +z.

FN vec3 camera_space(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (!has_object(at)) return object_space_vector(scene.camera_space, at.p);
  return object_space_point(scene.camera_space, at.p);
}

// Coordinates of the picture, 0 to 1.
FN vec3 window_coordinates(IN(SceneData) scene, IN(ShaderPoint) at) {
  const vec3 c = camera_space(scene, at);
  const float depth = select(scene.camera_orthographic != 0u, 1.0f, c.z);
  const float inverse = select(abs(depth) > 1e-30f, 1.0f / depth, 0.0f);
  return vec3((c.x * inverse - scene.camera_window.x) * scene.camera_window.z,
              (c.y * inverse - scene.camera_window.y) * scene.camera_window.w, 0.0f);
}

// Where a ray of the camera begins, metres from it: at the near clip, from which Cycles counts its length.
FN float camera_start(IN(SceneData) scene, vec3 wo) {
  if (scene.camera_orthographic != 0u) return scene.camera_near;
  const float c = -object_space_vector(scene.camera_space, wo).z;
  return c > 1e-6f ? scene.camera_near / c : 0.0f;
}

// ---- Spaces, as Vector Transform numbers them

const uint SPACE_WORLD = 0u;
const uint SPACE_OBJECT = 1u;
const uint SPACE_CAMERA = 2u;
const uint TRANSFORM_VECTOR = 0u;
const uint TRANSFORM_POINT = 1u;
const uint TRANSFORM_NORMAL = 2u;

FN vec3 to_world_space(IN(SceneData) scene, IN(ShaderPoint) at, uint kind, uint from, vec3 v) {
  if (from == SPACE_OBJECT) {
    const NormalFrame f = point_frame(scene, at);
    if (kind == TRANSFORM_NORMAL) return normal_to_world(f, v);
    const vec3 origin = point_space(scene, at).origin;
    return vector_to_world(f, v) + select(kind == TRANSFORM_POINT, origin, vec3(0.0f));
  }
  if (from != SPACE_CAMERA) return v;
  // The rows of a rotation are the columns of its inverse.
  const vec3 x = vec3(scene.camera_space.x.x, scene.camera_space.x.y, scene.camera_space.x.z);
  const vec3 y = vec3(scene.camera_space.y.x, scene.camera_space.y.y, scene.camera_space.y.z);
  const vec3 z = vec3(scene.camera_space.z.x, scene.camera_space.z.y, scene.camera_space.z.z);
  return x * v.x + y * v.y + z * v.z + select(kind == TRANSFORM_POINT, scene.camera_space.origin, vec3(0.0f));
}

FN vec3 from_world_space(IN(SceneData) scene, IN(ShaderPoint) at, uint kind, uint to, vec3 v) {
  if (to == SPACE_WORLD) return v;
  if (to == SPACE_OBJECT && kind == TRANSFORM_NORMAL) {
    const NormalFrame f = point_frame(scene, at);
    return vec3(dot(f.x, v), dot(f.y, v), dot(f.z, v));
  }
  ObjectSpace space = scene.camera_space;
  if (to == SPACE_OBJECT) space = point_space(scene, at);
  return kind == TRANSFORM_POINT ? object_space_point(space, v) : object_space_vector(space, v);
}

FN vec3 object_transform(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, vec3 v) {
  const uint kind = mode & 3u;
  const uint from = (mode >> 2) & 3u;
  const uint to = (mode >> 4) & 3u;
  const bool no_object = !has_object(at) && (from == SPACE_OBJECT || to == SPACE_OBJECT);
  if (from == to || no_object) return v;
  const vec3 r = from_world_space(scene, at, kind, to, to_world_space(scene, at, kind, from, v));
  float len;
  return kind == TRANSFORM_NORMAL ? safe_normalize(r, len) : r;
}

// ---- The path

// Outputs of the Light Path node, in its order.
FN float light_path(IN(SceneData) scene, IN(ShaderPoint) at, uint output_number) {
  const uint kind = at.ray_kind;
  uint bits = 0u;
  if (output_number == 0u) bits = kind & VISIBLE_CAMERA;
  if (output_number == 1u) bits = kind & VISIBLE_SHADOW;
  // Cycles tells of rays that went through as well whether the lobe was a diffuse one.
  const bool glossy_through = (kind & (VISIBLE_TRANSMISSION | RAY_DIFFUSE_THROUGH)) == VISIBLE_TRANSMISSION;
  if (output_number == 2u) bits = kind & (VISIBLE_DIFFUSE | RAY_DIFFUSE_THROUGH);
  if (output_number == 3u) bits = (kind & VISIBLE_GLOSSY) | select(glossy_through, VISIBLE_GLOSSY, 0u);
  if (output_number == 4u) bits = kind & RAY_SINGULAR;
  if (output_number == 5u) bits = kind & RAY_REFLECTED;
  if (output_number == 6u) bits = kind & VISIBLE_TRANSMISSION;
  if (output_number == 7u) bits = kind & VISIBLE_VOLUME;
  if (output_number < 8u) return select(bits != 0u, 1.0f, 0.0f);
  if (output_number == 8u) {
    const bool first = (kind & VISIBLE_CAMERA) != 0u && at.transparent_bounces == 0u && at.t < INFINITE_DISTANCE;
    return first ? max(at.t - camera_start(scene, at.wo), 0.0f) : at.t;
  }
  uint count = 0u;
  if (output_number == 9u) count = at.bounce;
  if (output_number == 10u) count = at.diffuse_bounces;
  if (output_number == 11u) count = at.glossy_bounces;
  if (output_number == 12u) count = at.transparent_bounces;
  if (output_number == 13u) count = at.transmission_bounces;
  return float(int(count));
}

// ---- Fresnel

FN float fresnel_of_ior(IN(ShaderPoint) at, float ior, vec3 n) {
  const float c = max(abs(dot(at.wo, n)), 1e-6f);
  return F_Dielectric(c, c * c, ior);
}

FN float layer_weight(IN(ShaderPoint) at, uint output_number, float blend, vec3 n) {
  if (output_number == 0u) {
    const float eta = max(1.0f - blend, 1e-5f);
    return fresnel_of_ior(at, at.side < 0.0f ? eta : 1.0f / eta, n);
  }
  float b = clamp(blend, 0.0f, 1.0f - 1e-5f);
  b = b < 0.5f ? 2.0f * b : 0.5f / (1.0f - b);
  return 1.0f - pow(abs(dot(at.wo, n)), b);
}

const uint NORMAL_MAP_DIRECTX = 8u;  // of the mode: green points down

// ---- Edges

// Metres that a pixel is wide, as a viewer sees its two sides lie on the surface: their mean.
FN float pixel_width(IN(ShaderPoint) at) {
  vec3 dx;
  vec3 dy;
  point_differentials(at, dx, dy);
  return 0.5f * (length(dx - at.wo * dot(dx, at.wo)) + length(dy - at.wo * dot(dy, at.wo)));
}

// 1 within `size` metres of an edge of the triangle, half of it on either side; of pixels where `mode` says so.
FN float wireframe(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, float size) {
  if (at.instance == INVALID_ID) return 0.0f;
  const Instance instance = LOAD(scene.instances, at.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, at.triangle);
  const float unit = (mode & 1u) != 0u ? pixel_width(at) : 1.0f;
  const float width = 0.5f * abs(size) * unit;
  vec3 before = triangle_corner(scene, instance, id.z);
  float found = 0.0f;
  for (uint k = 0u; k < 3u; ++k) {
    const vec3 corner = triangle_corner(scene, instance, k == 0u ? id.x : (k == 1u ? id.y : id.z));
    const vec3 edge = corner - before;
    if (length(cross(edge, corner - at.p)) < width * length(edge)) found = 1.0f;
    before = corner;
  }
  return found;
}

// ---- Lamps: strength that does not fall off with the square of the distance; nothing falls off from a sun
FN float light_falloff(IN(ShaderPoint) at, uint mode, float strength, float smooth_radius) {
  const float t2 = at.t * at.t;
  float s = strength;
  if (at.t >= INFINITE_DISTANCE) return s;
  if (smooth_radius > 0.0f) s *= t2 / (smooth_radius + t2);
  if (mode == 1u) s *= at.t;
  if (mode == 2u) s *= t2;
  return s;
}

// ---- The object

FN Material point_material(IN(SceneData) scene, IN(ShaderPoint) at) {
  return LOAD(scene.materials, triangle_material(scene, at.instance, at.triangle));
}

FN vec3 object_info(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode) {
  if (at.light != INVALID_ID && op == OP_OBJECT_INFO_V && mode == 0u) return point_space(scene, at).origin;
  if (at.instance == INVALID_ID) return vec3(0.0f);
  const Instance instance = LOAD(scene.instances, at.instance);
  if (op == OP_OBJECT_INFO_F && mode == 1u) return vec3(float(instance.pass_index));
  if (op == OP_OBJECT_INFO_F && mode == 2u) return vec3(float(point_material(scene, at).pass_index));
  const InstanceInfo info = LOAD(scene.instance_infos, at.instance);
  if (op == OP_OBJECT_INFO_V) return mode == 0u ? info.location : info.color;
  return vec3(mode == 0u ? info.alpha : info.random);
}

// ---- All of them

// The layer of UV maps and attributes that an argument names; of what is no such number, one that no mesh has.
FN uint layer_of(float a) { return uint(int(select(a >= 0.0f, min(a, 65535.0f), 65535.0f))); }

// Ops that take the point a little aside where their mode asks for it.
FN vec3 program_coordinates(IN(SceneData) scene, IN(ShaderPoint) here, uint op, uint mode, float argument) {
  ShaderPoint at = here;
  point_shift(scene, mode >> 30, mode_share(mode & 0xffffu), at);
  if (op == OP_POSITION) return at.p;
  if (op == OP_PARAMETRIC && at.light != INVALID_ID) return vec3(at.u, at.v, 0.0f);
  if (op == OP_PARAMETRIC) return vec3(1.0f - at.u - at.v, at.u, 0.0f);  // as Cycles: weights of corners 0 and 1
  if (op == OP_GENERATED) return point_generated(scene, at);
  if (op == OP_OBJECT_POSITION) return object_position(scene, at);
  if (op == OP_CAMERA_POSITION) return camera_space(scene, at);
  if (op == OP_WINDOW) return window_coordinates(scene, at);
  uint components;
  const vec4 a = point_attribute(scene, layer_of(argument), at, components);
  if (op == OP_ATTRIBUTE_ALPHA) return vec3(a.w);
  if (op == OP_ATTRIBUTE_FAC) return vec3(components == 2u ? a.x : (a.x + a.y + a.z) * (1.0f / 3.0f));
  return vec3(a.x, a.y, a.z);
}

// Ops that bend normals, and tangents.
FN vec3 program_normal(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode, IN(ProgramArguments) a) {
  if (op == OP_TANGENT) return radial_tangent(scene, at, mode, point_generated(scene, at));
  if (op == OP_GEOMETRY_TANGENT) return radial_tangent(scene, at, 2u, point_generated(scene, at));
  if (op == OP_UV_TANGENT) return uv_tangent(scene, at, layer_of(a.v[0]));
  if (op == OP_NORMAL_MAP) {
    vec3 color = argument3(a, 0);
    if ((mode & NORMAL_MAP_DIRECTX) != 0u) color.y = 1.0f - color.y;
    return normal_map(scene, at, mode & 7u, color, a.v[3], layer_of(a.v[4]));
  }
  const float distance = a.v[4] * select((mode & 1u) != 0u, -1.0f, 1.0f);
  return bump_normal(at, argument3(a, 5), a.v[0], a.v[1], a.v[2], a.v[3], distance);
}

FN vec3 program_point(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode, IN(ProgramArguments) a) {
  if (op == OP_NORMAL) return at.n;
  if (op == OP_TRUE_NORMAL) return at.ng;
  if (op == OP_INCOMING) return at.wo;
  if (op == OP_BACKFACING) return vec3(at.side < 0.0f ? 1.0f : 0.0f);
  if (op == OP_OBJECT_INFO_V || op == OP_OBJECT_INFO_F) return object_info(scene, at, op, mode);
  if (op == OP_LIGHT_PATH) return vec3(light_path(scene, at, mode));
  if (op == OP_CAMERA_Z) return vec3(camera_space(scene, at).z);
  if (op == OP_CAMERA_DISTANCE) return vec3(length(camera_space(scene, at)));
  if (op == OP_WIREFRAME) return vec3(wireframe(scene, at, mode, a.v[0]));
  if (op == OP_OBJECT_TRANSFORM) return object_transform(scene, at, mode, argument3(a, 0));
  if (op == OP_FRESNEL) {
    const float eta = max(a.v[0], 1e-5f);
    return vec3(fresnel_of_ior(at, at.side < 0.0f ? 1.0f / eta : eta, argument3(a, 1)));
  }
  if (op == OP_LAYER_WEIGHT) return vec3(layer_weight(at, mode, a.v[0], argument3(a, 1)));
  if (op == OP_LIGHT_FALLOFF) return vec3(light_falloff(at, mode, a.v[0], a.v[1]));
  return vec3(0.0f);
}

// What a Principled surface's sheen and coat let through; see OP_LAYERS.
FN vec3 layers_above(IN(SceneData) scene, IN(ShaderPoint) at, IN(ProgramArguments) a) {
  PrincipledInputs p;
  p.coat = a.v[0];
  p.coat_roughness = a.v[1];
  p.coat_ior = a.v[2];
  p.coat_tint = argument3(a, 3);
  p.coat_n = normalize_or(argument3(a, 6), at.n);
  p.sheen = a.v[9];
  p.sheen_roughness = a.v[10];
  p.sheen_tint = argument3(a, 11);
  p.n = normalize_or(argument3(a, 14), at.n);
  p.emission = vec3(1.0f);
  p.no_caustics = 0u;
  return principled_emission(scene.albedo, p, at.ng, at.wo);
}

// The value of a context op; a number stands in x.
FN vec3 program_context(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode, IN(ProgramArguments) a) {
  const uint group = program_group(op);
  if (group == GROUP_NORMAL && at.instance == INVALID_ID) return at.n;
  if (PROGRAM_GROUP(GROUP_COORDINATES) && group == GROUP_COORDINATES) {
    return program_coordinates(scene, at, op, mode, a.v[0]);
  }
  if (PROGRAM_GROUP(GROUP_NORMAL) && group == GROUP_NORMAL) return program_normal(scene, at, op, mode, a);
  if (PROGRAM_GROUP(GROUP_RAYS) && group == GROUP_RAYS) return program_rays(scene, at, op, mode, a);
  if (PROGRAM_GROUP(GROUP_LAYERS) && group == GROUP_LAYERS) return layers_above(scene, at, a);
  return program_point(scene, at, op, mode, a);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

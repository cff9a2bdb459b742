// SPDX-License-Identifier: GPL-3.0-or-later
// The point that a program runs at, and what the scene's meshes say there: UV maps, attributes, generated and object
// coordinates. What programs make of it is in context.h.
#ifndef COTORRA_PROGRAM_POINT_H
#define COTORRA_PROGRAM_POINT_H

#include "../surface.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A point of a surface as a ray meets it, world space; normals on the side that the ray came from. Of the background:
// the direction that the ray goes, of no instance. Of a lamp u and v are what stands for its UV map (light_program.h).
struct ShaderPoint {
  vec3 p;
  float u;          // barycentric, as in Hit
  vec3 ng;
  float v;
  vec3 n;           // smooth
  float side;       // 1: seen from the front, -1: from behind
  vec3 wo;          // toward the ray's origin, unit
  float t;          // length of the ray
  uint instance;
  uint triangle;
  float footprint;  // metres that the ray covers here
  uint ray_kind;    // VISIBLE_* and RAY_* of the ray
  uint bounce;      // vertices before this ray
  uint diffuse_bounces;
  uint glossy_bounces;
  uint transmission_bounces;
  uint transparent_bounces;
  uint light;       // INVALID_ID, or the lamp whose point this is; `instance` is then none
  uint random;      // reversed sampler index
  uint rays;        // seed of what the ops of rays.h draw here; 0: they trace none
};

FN ShaderPoint shader_point(IN(Surface) s, vec3 wo, float t) {
  ShaderPoint at;
  at.p = s.p;
  at.u = s.u;
  at.ng = s.ng;
  at.v = s.v;
  at.n = s.n;
  at.side = s.side;
  at.wo = wo;
  at.t = t;
  at.instance = s.instance;
  at.triangle = s.triangle;
  at.footprint = 0.0f;
  at.ray_kind = VISIBLE_CAMERA;
  at.bounce = 0u;
  at.diffuse_bounces = 0u;
  at.glossy_bounces = 0u;
  at.transmission_bounces = 0u;
  at.transparent_bounces = 0u;
  at.light = INVALID_ID;
  at.random = 0u;
  at.rays = 0u;
  return at;
}

// What a ray meets of the background along `direction`.
FN ShaderPoint background_point(vec3 direction) {
  ShaderPoint at;
  at.p = direction;
  at.u = 0.0f;
  at.ng = -direction;
  at.v = 0.0f;
  at.n = -direction;
  at.side = 1.0f;
  at.wo = -direction;
  at.t = INFINITE_DISTANCE;
  at.instance = INVALID_ID;
  at.triangle = 0u;
  at.footprint = 0.0f;
  at.ray_kind = VISIBLE_CAMERA;
  at.bounce = 0u;
  at.diffuse_bounces = 0u;
  at.glossy_bounces = 0u;
  at.transmission_bounces = 0u;
  at.transparent_bounces = 0u;
  at.light = INVALID_ID;
  at.random = 0u;
  at.rays = 0u;
  return at;
}

// A point of which no more is known than its place on its mesh.
FN ShaderPoint mesh_point(IN(Hit) hit, vec3 direction) {
  ShaderPoint at = background_point(direction);
  at.u = hit.u;
  at.v = hit.v;
  at.t = hit.t;
  at.instance = hit.instance;
  at.triangle = hit.triangle;
  return at;
}

// ---- One pixel aside, for bump mapping

const uint SHIFT_NONE = 0u;
const uint SHIFT_DX = 1u;
const uint SHIFT_DY = 2u;

// The directions, a footprint long, of the two neighbours: those that Cycles takes, since of heights that are finer
// than a footprint each direction sees others. They lie square to the normal, the first to (1, 1, 1) as well.
FN void point_differentials(IN(ShaderPoint) at, OUT(vec3) dx, OUT(vec3) dy) {
  const vec3 n = at.ng;
  vec3 across = vec3(n.z - n.y, n.x - n.z, n.y - n.x);
  if (n.x == n.y && n.x == n.z) across = vec3(n.z - n.y, n.x + n.z, -n.y - n.x);
  float len;
  across = safe_normalize(across, len);
  dx = across * at.footprint;
  dy = cross(n, across) * at.footprint;
}

// How much of a footprint: what the low 16 bits of a mode hold, a half float.
FN float mode_share(uint bits) {
  return uintBitsToFloat(((bits & 0x7fffu) << 13) + select((bits & 0x7c00u) == 0u, 0u, 0x38000000u));
}

FN vec3 triangle_corner(IN(SceneData) scene, IN(Instance) instance, uint vertex) {
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const vec3 p = LOAD(mesh.positions, vertex);
  return (instance.flags & INSTANCE_IDENTITY) != 0u ? p : instance_point(instance, p);
}

// The point `share` of a footprint aside, on the plane of the triangle.
FN void point_shift(IN(SceneData) scene, uint shift, float share, INOUT(ShaderPoint) at) {
  if (shift == SHIFT_NONE || at.instance == INVALID_ID) return;
  vec3 dx;
  vec3 dy;
  point_differentials(at, dx, dy);
  const vec3 d = select(shift == SHIFT_DX, dx, dy) * share;
  const Instance instance = LOAD(scene.instances, at.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  const uvec3 id = LOAD(mesh.triangles, at.triangle);
  const vec3 p0 = triangle_corner(scene, instance, id.x);
  const vec3 e1 = triangle_corner(scene, instance, id.y) - p0;
  const vec3 e2 = triangle_corner(scene, instance, id.z) - p0;
  const vec3 n = cross(e1, e2);
  const float inverse = 1.0f / max(dot(n, n), 1e-37f);
  at.u += dot(cross(e2, n), d) * inverse;
  at.v += dot(cross(n, e1), d) * inverse;
  at.p += d;
}

// ---- Coordinates

FN vec2 mesh_uv(IN(Mesh) mesh, IN(MeshTextures) layers, uint layer, uvec3 c, float u, float v) {
  if (layer >= layers.uv_layers) return vec2(0.0f, 0.0f);
  const uint first = layer * layers.corner_count;
  return LOAD(mesh.uv, first + c.x) * (1.0f - u - v) + LOAD(mesh.uv, first + c.y) * u + LOAD(mesh.uv, first + c.z) * v;
}

FN vec3 object_space_point(IN(ObjectSpace) o, vec3 p) {
  return vec3(o.x.x * p.x + o.x.y * p.y + o.x.z * p.z + o.x.w, o.y.x * p.x + o.y.y * p.y + o.y.z * p.z + o.y.w,
              o.z.x * p.x + o.z.y * p.y + o.z.z * p.z + o.z.w);
}
FN vec3 object_space_vector(IN(ObjectSpace) o, vec3 p) {
  return vec3(o.x.x * p.x + o.x.y * p.y + o.x.z * p.z, o.y.x * p.x + o.y.y * p.y + o.y.z * p.z,
              o.z.x * p.x + o.z.y * p.y + o.z.z * p.z);
}

// Of the background there is no object.
FN bool has_object(IN(ShaderPoint) at) { return at.instance != INVALID_ID || at.light != INVALID_ID; }
FN ObjectSpace point_space(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (at.light != INVALID_ID) return LOAD(scene.light_programs, at.light).space;
  return LOAD(scene.object_spaces, at.instance);
}
FN vec3 object_position(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (!has_object(at)) return at.p;
  return object_space_point(point_space(scene, at), at.p);
}

// Lamps have no coordinates of their own but those of their object.
FN vec3 point_generated(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (at.instance == INVALID_ID) return object_position(scene, at);
  const uint mesh_id = LOAD(scene.instances, at.instance).mesh;
  Mesh mesh = LOAD(scene.meshes, mesh_id);
  if ((mesh.flags & MESH_HAS_GENERATED) == 0u) return vec3(0.0f);
  MeshTextures more = LOAD(scene.mesh_textures, mesh_id);
  const uvec3 id = LOAD(mesh.triangles, at.triangle);
  return LOAD(more.generated, id.x) * (1.0f - at.u - at.v) + LOAD(more.generated, id.y) * at.u +
         LOAD(more.generated, id.z) * at.v;
}

// Layer `layer` of UV maps and attributes, counted together; w is the attribute's alpha. `components` tells how many
// numbers are its own.
FN vec4 point_attribute(IN(SceneData) scene, uint layer, IN(ShaderPoint) at, OUT(uint) components) {
  components = 3u;
  if (at.instance == INVALID_ID) return vec4(0.0f, 0.0f, 0.0f, 0.0f);
  const uint mesh_id = LOAD(scene.instances, at.instance).mesh;
  Mesh mesh = LOAD(scene.meshes, mesh_id);
  MeshTextures more = LOAD(scene.mesh_textures, mesh_id);
  components = 2u;
  if (layer < scene.uv_layer_count) {
    if (layer >= more.uv_layers) return vec4(0.0f, 0.0f, 0.0f, 1.0f);
    const vec2 uv = mesh_uv(mesh, more, layer, LOAD(mesh.corners, at.triangle), at.u, at.v);
    return vec4(uv.x, uv.y, 0.0f, 1.0f);
  }
  const uint place = 2u * (layer - scene.uv_layer_count);
  components = 3u;
  if (place >= more.attribute_words) return vec4(0.0f, 0.0f, 0.0f, 1.0f);
  const uint kind = LOAD(more.attribute_table, place);
  const uint first = LOAD(more.attribute_table, place + 1u);
  const uint domain = kind & ATTRIBUTE_KIND_MASK;
  if (domain == ATTRIBUTE_NONE) return vec4(0.0f, 0.0f, 0.0f, 1.0f);
  if (domain == ATTRIBUTE_INSTANCE) return LOAD(scene.instance_attributes, first + at.instance);
  components = kind >> ATTRIBUTE_COMPONENTS_SHIFT;
  if (domain == ATTRIBUTE_FACE) return LOAD(more.attributes, first + at.triangle);
  uvec3 id = LOAD(mesh.triangles, at.triangle);
  if (domain == ATTRIBUTE_CORNER) id = LOAD(mesh.corners, at.triangle);
  return LOAD(more.attributes, first + id.x) * (1.0f - at.u - at.v) + LOAD(more.attributes, first + id.y) * at.u +
         LOAD(more.attributes, first + id.z) * at.v;
}

// ---- Frames of objects

// Object-to-world by columns, and the columns of its inverse transpose.
struct NormalFrame {
  vec3 x;
  vec3 y;
  vec3 z;
  vec3 normal_x;
  vec3 normal_y;
  vec3 normal_z;
};

FN NormalFrame normal_frame(IN(Instance) i, IN(MeshTextures) m) {
  NormalFrame f;
  const bool moved = m.moved != 0u;
  f.x = select(moved, m.x_axis, i.x_axis);
  f.y = select(moved, m.y_axis, i.y_axis);
  f.z = select(moved, m.z_axis, i.z_axis);
  f.normal_x = select(moved, m.normal_x, i.normal_x);
  f.normal_y = select(moved, m.normal_y, i.normal_y);
  f.normal_z = select(moved, m.normal_z, i.normal_z);
  return f;
}

FN NormalFrame point_frame(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (at.light != INVALID_ID) {
    const LightProgram light = LOAD(scene.light_programs, at.light);
    NormalFrame f;
    f.x = light.x_axis;
    f.y = light.y_axis;
    f.z = light.z_axis;
    f.normal_x = vec3(light.space.x.x, light.space.x.y, light.space.x.z);
    f.normal_y = vec3(light.space.y.x, light.space.y.y, light.space.y.z);
    f.normal_z = vec3(light.space.z.x, light.space.z.y, light.space.z.z);
    return f;
  }
  const Instance instance = LOAD(scene.instances, at.instance);
  return normal_frame(instance, LOAD(scene.mesh_textures, instance.mesh));
}

FN vec3 vector_to_world(IN(NormalFrame) f, vec3 v) { return f.x * v.x + f.y * v.y + f.z * v.z; }
FN vec3 normal_to_world(IN(NormalFrame) f, vec3 n) { return f.normal_x * n.x + f.normal_y * n.y + f.normal_z * n.z; }

// A normal of world space in object space, unit length.
FN vec3 normal_to_object(IN(NormalFrame) f, vec3 n) {
  float len;
  return safe_normalize(vec3(dot(f.x, n), dot(f.y, n), dot(f.z, n)), len);
}

#ifdef __cplusplus
static_assert(sizeof(ShaderPoint) == 112);
}  // namespace cotorra
#endif

#endif

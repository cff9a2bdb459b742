// SPDX-License-Identifier: GPL-3.0-or-later
// A material at a point: the inputs that read images resolved, and the normal map applied.
// What the images hold is read in texture.h; what the material does with light is in bsdf.h.
#ifndef COTORRA_MATERIAL_H
#define COTORRA_MATERIAL_H

#include "surface.h"
#include "texture.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Highlights below this roughness may be narrower than a usual lamp: light sampling alone becomes noisy, and BSDF
// sampling shares the work, for a ray a sample. Where exactly the two break even was not measured yet.
const float SHARP_ROUGHNESS = 0.25f;

// A point on a triangle of the scene.
struct TexturePoint {
  uint instance;
  uint triangle;
  float u;  // barycentric, as in Hit
  float v;
};

// ---- Coordinates

FN vec2 mesh_uv(IN(Mesh) mesh, IN(MeshTextures) layers, uint layer, uvec3 c, float u, float v) {
  if (layer >= layers.uv_layers) return vec2(0.0f, 0.0f);
  const uint first = layer * layers.corner_count;
  return LOAD(mesh.uv, first + c.x) * (1.0f - u - v) + LOAD(mesh.uv, first + c.y) * u + LOAD(mesh.uv, first + c.z) * v;
}

// The position in world space.
FN vec3 texture_position(IN(Instance) instance, IN(Mesh) mesh, uvec3 id, float u, float v) {
  const vec3 p =
      LOAD(mesh.positions, id.x) * (1.0f - u - v) + LOAD(mesh.positions, id.y) * u + LOAD(mesh.positions, id.z) * v;
  return (instance.flags & INSTANCE_IDENTITY) != 0u ? p : instance_point(instance, p);
}

FN vec3 object_space_point(IN(ObjectSpace) o, vec3 p) {
  return vec3(o.x.x * p.x + o.x.y * p.y + o.x.z * p.z + o.x.w, o.y.x * p.x + o.y.y * p.y + o.y.z * p.z + o.y.w,
              o.z.x * p.x + o.z.y * p.y + o.z.z * p.z + o.z.w);
}

// The coordinates that a slot starts from, at a point.
FN vec3 texture_coordinates(IN(SceneData) scene, IN(TextureSlot) slot, IN(TexturePoint) at) {
  const Instance instance = LOAD(scene.instances, at.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);
  if (slot.coordinates == COORDINATES_UV) {
    if (more.uv_layers == 0u) return vec3(0.0f);
    const vec2 uv = mesh_uv(mesh, more, slot.uv_layer, LOAD(mesh.corners, at.triangle), at.u, at.v);
    return vec3(uv.x, uv.y, 0.0f);
  }
  const uvec3 id = LOAD(mesh.triangles, at.triangle);
  if (slot.coordinates == COORDINATES_GENERATED) {
    if ((mesh.flags & MESH_HAS_GENERATED) == 0u) return vec3(0.0f);
    return LOAD(more.generated, id.x) * (1.0f - at.u - at.v) + LOAD(more.generated, id.y) * at.u +
           LOAD(more.generated, id.z) * at.v;
  }
  const vec3 p = texture_position(instance, mesh, id, at.u, at.v);
  if (slot.coordinates == COORDINATES_WORLD) return p;
  return object_space_point(LOAD(scene.object_spaces, at.instance), p);
}

// ---- Inputs

// The texel that was read last: inputs that read the same one share it.
struct LastLookup {
  vec4 texel;
  uint lookup;  // TextureSlot.lookup, INVALID_ID at first
};

FN vec3 material_input(IN(SceneData) scene, int slot_index, IN(TexturePoint) at, INOUT(LastLookup) last) {
  const TextureSlot slot = LOAD(scene.texture_slots, uint(slot_index));
  if (slot.lookup != last.lookup) {
    last.texel = texture_lookup(scene, slot, texture_coordinates(scene, slot, at));
    last.lookup = slot.lookup;
  }
  return texture_value(slot, last.texel);
}

FN vec3 material_slot(IN(SceneData) scene, int slot_index, IN(TexturePoint) at) {
  LastLookup last;
  last.texel = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  last.lookup = INVALID_ID;
  return material_input(scene, slot_index, at, last);
}

FN float unit_clamp(float a) { return clamp(a, 0.0f, 1.0f); }

// The inputs that material_resolve sets, by number.
const uint RESOLVED_INPUTS = 6u;

// Slot of input `number`, -1 where it is a constant.
FN int material_input_slot(IN(MaterialInputs) inputs, uint number) {
  int slot = inputs.base_color;
  slot = select(number == 1u, inputs.specular_tint, slot);
  slot = select(number == 2u, inputs.metallic, slot);
  slot = select(number == 3u, inputs.roughness, slot);
  slot = select(number == 4u, inputs.ior, slot);
  return select(number == 5u, inputs.specular_level, slot);
}

// Sets input `number`, clamped as the Principled BSDF's.
FN void material_set_input(uint number, vec3 value, INOUT(Material) m) {
  if (number == 0u) m.base_color = max(value, vec3(0.0f));
  if (number == 1u) m.specular_tint = max(value, vec3(0.0f));
  if (number == 2u) m.metallic = unit_clamp(value.x);
  if (number == 3u) {
    m.roughness = unit_clamp(value.x);
    // Of other models the scene's flag holds, which is set where any texel could be sharp.
    if ((m.flags & MATERIAL_MODEL) == 0u && m.roughness >= SHARP_ROUGHNESS) m.flags &= ~MATERIAL_SHARP;
  }
  if (number == 4u) m.ior = max(value.x, 1e-5f);
  if (number == 5u) m.specular_level = max(value.x, 0.0f);
}

// Sets the inputs that read images. Emission is left out: see material_emission. In a loop, since compilers for
// graphics cards copy what is called to each place that calls it, and one lookup of an image is long.
FN void material_resolve(IN(SceneData) scene, uint index, IN(TexturePoint) at, INOUT(Material) m) {
  const MaterialInputs inputs = LOAD(scene.material_inputs, index);
  LastLookup last;
  last.texel = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  last.lookup = INVALID_ID;
  for (uint number = 0u; number < RESOLVED_INPUTS; ++number) {
    const int slot = material_input_slot(inputs, number);
    if (slot < 0) continue;
    const vec3 value = material_input(scene, slot, at, last);
    material_set_input(number, value, m);
  }
}

FN TexturePoint texture_point(IN(Surface) s) {
  TexturePoint at;
  at.instance = s.instance;
  at.triangle = s.triangle;
  at.u = s.u;
  at.v = s.v;
  return at;
}

// The material of a surface as it is there; emission is material_emission's.
FN void material_fetch(IN(SceneData) scene, IN(Surface) s, OUT(Material) m) {
  m = LOAD(scene.materials, s.material);
  if (FEATURE(FEATURE_TEXTURES) && (m.flags & MATERIAL_TEXTURED) != 0u) {
    const TexturePoint at = texture_point(s);
    material_resolve(scene, s.material, at, m);
  }
}

// What the material emits at a point. Material.emission of a textured emission is its mean, which only says how often
// light sampling picks the triangle.
FN vec3 material_emission(IN(SceneData) scene, uint index, IN(Material) material, IN(TexturePoint) at) {
  if (FEATURE(FEATURE_TEXTURES) && (material.flags & MATERIAL_TEXTURED) != 0u) {
    const int slot = LOAD(scene.material_inputs, index).emission;
    if (slot >= 0) return material_slot(scene, slot, at);
  }
  return material.emission;
}

// Share of the light that the material keeps at a point: the rest passes through.
FN float material_alpha(IN(SceneData) scene, uint index, IN(TexturePoint) at) {
  const Material material = LOAD(scene.materials, index);
  if ((material.flags & MATERIAL_TRANSPARENT) == 0u) return 1.0f;
  if (FEATURE(FEATURE_TEXTURES) && (material.flags & MATERIAL_TEXTURED) != 0u) {
    const int slot = LOAD(scene.material_inputs, index).alpha;
    if (slot >= 0) return unit_clamp(material_slot(scene, slot, at).x);
  }
  return unit_clamp(material.alpha);
}

// ---- Normal maps

// Object-to-world by columns, and the columns of its inverse transpose: where a tangent lies.
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

FN vec3 normal_to_world(IN(NormalFrame) f, vec3 n) { return f.normal_x * n.x + f.normal_y * n.y + f.normal_z * n.z; }

// A normal of world space in object space, unit length.
FN vec3 normal_to_object(IN(NormalFrame) f, vec3 n) {
  float len;
  return safe_normalize(vec3(dot(f.x, n), dot(f.y, n), dot(f.z, n)), len);
}

// The smooth normal in object space, that of the triangle where it is flat. Cycles 5.2 normalises it before it builds
// the tangent frame, which the inventor of the tangents does not (measured: a monkey is 4.8 % off without).
FN vec3 tangent_space_normal(IN(Mesh) mesh, IN(MeshTextures) more, IN(NormalFrame) f, IN(Surface) s) {
  const vec3 flat_normal = normal_to_object(f, s.ng * s.side);
  if ((mesh.flags & (MESH_SMOOTH_VERTEX | MESH_SMOOTH_CORNER)) == 0u) return flat_normal;
  const uvec3 ni = mesh_normal_indices(mesh, s.triangle, LOAD(mesh.triangles, s.triangle));
  vec3 n0 = LOAD(mesh.normals, ni.x);
  vec3 n1 = LOAD(mesh.normals, ni.y);
  vec3 n2 = LOAD(mesh.normals, ni.z);
  if (more.moved != 0u) {
    n0 = normal_to_object(f, n0);
    n1 = normal_to_object(f, n1);
    n2 = normal_to_object(f, n2);
  }
  float unused;
  return safe_normalize(n0 * (1.0f - s.u - s.v) + n1 * s.u + n2 * s.v, unused);
}

// The tangent at a point, interpolated, and its sign; null where the mesh has none.
FN vec4 mesh_tangent(IN(Mesh) mesh, IN(MeshTextures) more, uint layer, IN(Surface) s) {
  if (layer >= more.tangent_layers) return vec4(0.0f, 0.0f, 0.0f, 0.0f);
  const uvec3 c = LOAD(mesh.corners, s.triangle);
  const uint first = layer * more.corner_count;
  return LOAD(more.tangents, first + c.x) * (1.0f - s.u - s.v) + LOAD(more.tangents, first + c.y) * s.u +
         LOAD(more.tangents, first + c.z) * s.v;
}

// Direction `c` (-1 to 1 in each component) of a normal map in tangent space, in world space on the front side, of any
// length. The strength bends it toward the normal before it leaves tangent space, as Cycles 5 does.
FN vec3 tangent_normal(IN(Mesh) mesh, IN(MeshTextures) more, IN(NormalFrame) f, IN(MaterialInputs) inputs,
                       IN(Surface) s, vec3 c) {
  const vec4 t4 = mesh_tangent(mesh, more, inputs.tangent_layer, s);
  const vec3 t = vec3(t4.x, t4.y, t4.z);
  if (is_black(t)) return vec3(0.0f);
  const vec3 n = tangent_space_normal(mesh, more, f, s);
  const vec3 b = cross(n, t) * t4.w;
  const float strength = inputs.normal_strength;
  float len;
  const vec3 bent = t * (c.x * strength) + b * (c.y * strength) + n * mix(1.0f, c.z, unit_clamp(strength));
  return normal_to_world(f, safe_normalize(bent, len));
}

// A unit vector along `n`, or `instead` where n is null or no number.
FN vec3 normalize_or(vec3 n, vec3 instead) {
  const float d2 = dot(n, n);
  return d2 > 1e-30f && d2 < INFINITE_DISTANCE ? n * (1.0f / sqrt(d2)) : instead;
}

// The shading normal of a surface after the material's normal map, on the side of the viewer as s.n is. It may lean
// below the triangle, or away from the viewer: the glossy lobes lift it (normal_for_reflection), the diffuse lobe takes
// it as it is.
FN vec3 material_normal(IN(SceneData) scene, IN(Surface) s) {
  if ((LOAD(scene.materials, s.material).flags & MATERIAL_TEXTURED) == 0u) return s.n;
  const MaterialInputs inputs = LOAD(scene.material_inputs, s.material);
  if (inputs.normal < 0) return s.n;
  const Instance instance = LOAD(scene.instances, s.instance);
  Mesh mesh = LOAD(scene.meshes, instance.mesh);
  MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);
  const TexturePoint at = texture_point(s);
  const vec3 c = material_slot(scene, inputs.normal, at) * 2.0f - vec3(1.0f);
  const NormalFrame f = normal_frame(instance, more);
  if (inputs.normal_space == NORMAL_TANGENT) {
    return normalize_or(tangent_normal(mesh, more, f, inputs, s, c) * s.side, s.n);
  }
  const vec3 mapped = inputs.normal_space == NORMAL_OBJECT ? normal_to_world(f, c) : c;
  const vec3 n = normalize_or(mapped * s.side, s.n);
  return normalize_or(mix(s.n, n, max(inputs.normal_strength, 0.0f)), s.n);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

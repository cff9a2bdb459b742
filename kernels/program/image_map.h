// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that read images: flat, from the sides of a box, wrapped on a sphere or tube, and from all directions.
// Texels and filters are texture.h's.
#ifndef COTORRA_PROGRAM_IMAGE_MAP_H
#define COTORRA_PROGRAM_IMAGE_MAP_H

#include "../texture.h"
#include "math_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Of the mode: INTERPOLATION_* in bits 0 and 1, EXTENSION_* in 2 and 3, the projection in 4 and 5.
const uint PROJECTION_FLAT = 0u;
const uint PROJECTION_BOX = 1u;
const uint PROJECTION_SPHERE = 2u;
const uint PROJECTION_TUBE = 3u;
const uint IMAGE_UNASSOCIATE = 64u;  // bit of the mode

FN uint image_projection(uint mode) { return (mode >> 4) & 3u; }

// Around the z axis and from pole to pole; coordinates run from 0 to 1 across the sphere.
FN vec2 map_to_sphere(vec3 p) {
  const vec3 a = (p + -0.5f) * 2.0f;
  const float d2 = dot(a, a);
  const float u = a.x == 0.0f && a.y == 0.0f ? 0.0f : 0.5f - angle_of(a.x, a.y) / TWO_PI;
  const float v = 1.0f - acos(clamp(a.z / sqrt(select(d2 > 0.0f, d2, 1.0f)), -1.0f, 1.0f)) * INV_PI;
  return vec2(u, select(d2 > 0.0f, v, 0.0f));
}

FN vec2 map_to_tube(vec3 p) {
  const vec3 a = (p + -0.5f) * 2.0f;
  const bool on_axis = a.x == 0.0f && a.y == 0.0f;
  const float u = (1.0f - angle_of(a.x, a.y) * INV_PI) * 0.5f;
  return vec2(select(on_axis, 0.0f, u), select(on_axis, 0.0f, (a.z + 1.0f) * 0.5f));
}

// Longitude and latitude of a unit vector; -y is in the middle of a quarter, +x at u = 0.5.
FN vec2 map_equirectangular(vec3 d) {
  const bool none = dot(d, d) == 0.0f;
  const float u = 0.5f - angle_lanes(d.y, d.x) / TWO_PI;
  const float v = 1.0f - angle_lanes(sqrt(d.x * d.x + d.y * d.y), d.z) * INV_PI;
  return vec2(select(none, 0.0f, u), select(none, 0.0f, v));
}

// The place on a mirror ball, seen along +y, that reflects a unit vector.
FN vec2 map_mirror_ball(vec3 d) {
  const float scale = 2.0f * safe_sqrt(0.5f * (1.0f - d.y));
  const float inverse = 1.0f / select(scale > 0.0f, scale, 1.0f);
  return vec2(0.5f * (d.x * inverse + 1.0f), 0.5f * (d.z * inverse + 1.0f));
}

// Share of b against a, both at least 0, where they blend over a width of `blend`.
FN float box_share(float a, float b, float blend) {
  return saturate((safe_divide(a, a + b) - 0.5f * (1.0f - blend)) / max(blend, 1e-10f));
}

// Weights of the images seen along x, y and z. The components of the normal, whose sum is made 1, are coordinates in a
// triangle: one image near its corners, two blend along its edges, three in its middle.
FN vec3 box_weights(vec3 normal, float blend) {
  const vec3 a = abs(normal);
  const float sum = a.x + a.y + a.z;
  const vec3 n = a / select(sum > 0.0f, sum, 1.0f);
  const float limit = 0.5f * (1.0f + blend);
  if (n.x > limit * (n.x + n.y) && n.x > limit * (n.x + n.z)) return vec3(1.0f, 0.0f, 0.0f);
  if (n.y > limit * (n.x + n.y) && n.y > limit * (n.y + n.z)) return vec3(0.0f, 1.0f, 0.0f);
  if (n.z > limit * (n.x + n.z) && n.z > limit * (n.y + n.z)) return vec3(0.0f, 0.0f, 1.0f);
  if (blend <= 0.0f) return vec3(1.0f, 0.0f, 0.0f);
  if (n.z < (1.0f - limit) * (n.y + n.x)) {
    const float x = box_share(n.x, n.y, blend);
    return vec3(x, 1.0f - x, 0.0f);
  }
  if (n.x < (1.0f - limit) * (n.y + n.z)) {
    const float y = box_share(n.y, n.z, blend);
    return vec3(0.0f, y, 1.0f - y);
  }
  if (n.y < (1.0f - limit) * (n.x + n.z)) {
    const float x = box_share(n.x, n.z, blend);
    return vec3(x, 0.0f, 1.0f - x);
  }
  return (n * (2.0f - limit) + (limit - 1.0f)) / (2.0f * limit - 1.0f);
}

// Where the box's image along an axis is read, turned so that it is nowhere mirrored.
FN vec2 box_coordinates(int axis, vec3 p, vec3 normal) {
  const float across = axis == 1 ? p.x : p.y;
  const float side = axis == 0 ? -normal.x : (axis == 1 ? normal.y : normal.z);
  return vec2(side > 0.0f ? 1.0f - across : across, axis == 2 ? p.x : p.z);
}

// `image` may be computed (which tile of several): its number is held within those that there are.
FN uint image_index(IN(SceneData) scene, float image) {
  const float last = float(int(scene.texture_count)) - 1.0f;
  return uint(int(select(image >= 0.0f, min(image, last), 0.0f)));
}

FN vec4 image_read(IN(SceneData) scene, uint mode, float image, vec2 st) {
  Texture t = LOAD(scene.textures, image_index(scene, image));
  const vec4 texel = texture_filtered(t, st, mode & 3u, (mode >> 2) & 3u);
  return texture_linear(t, (mode & IMAGE_UNASSOCIATE) != 0u, texel);
}

FN vec2 image_coordinates(uint projection, vec3 p) {
  if (projection == PROJECTION_SPHERE) return map_to_sphere(p);
  if (projection == PROJECTION_TUBE) return map_to_tube(p);
  return vec2(p.x, p.y);
}

// Colour and alpha. A box reads up to three places: one loop, that the lookup is compiled once.
FN vec4 image_lookup(IN(SceneData) scene, uint mode, vec3 p, float image, float blend, vec3 normal) {
  const bool box = image_projection(mode) == PROJECTION_BOX;
  const vec3 weights = box ? box_weights(normal, blend) : vec3(1.0f, 0.0f, 0.0f);
  vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  for (int axis = 0; axis < (box ? 3 : 1); ++axis) {
    const float weight = axis == 0 ? weights.x : (axis == 1 ? weights.y : weights.z);
    if (weight > 0.0f) {
      const vec2 st = box ? box_coordinates(axis, p, normal) : image_coordinates(image_projection(mode), p);
      sum = sum + image_read(scene, mode, image, st) * weight;
    }
  }
  return sum;
}

FN vec3 op_image_v(IN(SceneData) scene, uint mode, vec3 p, float image, float blend, vec3 normal) {
  const vec4 c = image_lookup(scene, mode, p, image, blend, normal);
  return vec3(c.x, c.y, c.z);
}

FN float op_image_f(IN(SceneData) scene, uint mode, vec3 p, float image, float blend, vec3 normal) {
  return image_lookup(scene, mode, p, image, blend, normal).w;
}

// Projections: 0 equirectangular, 1 mirror ball.
FN vec3 op_environment_v(IN(SceneData) scene, uint mode, vec3 direction, float image) {
  const vec3 d = normalize_or_zero(direction);
  const vec4 c =
      image_read(scene, mode, image, image_projection(mode) == 0u ? map_equirectangular(d) : map_mirror_ball(d));
  return vec3(c.x, c.y, c.z);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

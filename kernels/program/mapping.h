// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that move vectors: the Mapping and Vector Rotate nodes, and a matrix.
// Between the spaces of objects and the camera, context ops move them.
#ifndef COTORRA_PROGRAM_MAPPING_H
#define COTORRA_PROGRAM_MAPPING_H

#include "elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Rows of the rotation about x, then y, then z.
struct Rotation {
  vec3 x;
  vec3 y;
  vec3 z;
};

FN Rotation rotation_euler(vec3 angles) {
  const float cx = cos_lanes(angles.x);
  const float sx = sin_lanes(angles.x);
  const float cy = cos_lanes(angles.y);
  const float sy = sin_lanes(angles.y);
  const float cz = cos_lanes(angles.z);
  const float sz = sin_lanes(angles.z);
  Rotation r;
  r.x = vec3(cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz);
  r.y = vec3(cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz);
  r.z = vec3(-sy, sx * cy, cx * cy);
  return r;
}

FN vec3 rotate(IN(Rotation) r, vec3 a) { return vec3(dot(r.x, a), dot(r.y, a), dot(r.z, a)); }
FN vec3 rotate_back(IN(Rotation) r, vec3 a) { return r.x * a.x + r.y * a.y + r.z * a.z; }

// Types: 0 point, 1 texture (the point's inverse), 2 vector, 3 normal. Division by a scale of 0 gives 0.
FN vec3 op_mapping(uint mode, vec3 vector, vec3 location, vec3 rotation, vec3 scale) {
  const Rotation r = rotation_euler(rotation);
  if (mode == 1u) return safe_divide(rotate_back(r, vector - location), scale);
  if (mode == 3u) return normalize_or_zero(rotate(r, safe_divide(vector, scale)));
  const vec3 turned = rotate(r, vector * scale);
  return mode == 0u ? turned + location : turned;
}

// About a unit axis (Rodrigues).
FN vec3 turn_about(vec3 a, vec3 axis, float angle) {
  const float c = cos_lanes(angle);
  return a * c + cross(axis, a) * sin_lanes(angle) + axis * (dot(axis, a) * (1.0f - c));
}

const uint ROTATE_INVERT = 256u;

// Types: 0 axis and angle, 1 to 3 about x, y or z, 4 Euler. Without an axis nothing is rotated.
FN vec3 op_vector_rotate(uint mode, vec3 vector, vec3 center, vec3 axis, float angle, vec3 rotation) {
  const uint type = mode & 7u;
  const bool inverted = (mode & ROTATE_INVERT) != 0u;
  const vec3 a = vector - center;
  if (type == 4u) {
    const Rotation r = rotation_euler(rotation);
    return (inverted ? rotate_back(r, a) : rotate(r, a)) + center;
  }
  const vec3 along = vec3(type == 1u ? 1.0f : 0.0f, type == 2u ? 1.0f : 0.0f, type == 3u ? 1.0f : 0.0f);
  const vec3 unit = type == 0u ? normalize_or_zero(axis) : along;
  const bool none = dot(unit, unit) == 0.0f;
  return select(none, vector, turn_about(a, unit, inverted ? -angle : angle) + center);
}

FN vec3 op_affine(uint, vec3 vector, vec3 row0, vec3 row1, vec3 row2, vec3 translation) {
  return vec3(dot(row0, vector), dot(row1, vector), dot(row2, vector)) + translation;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Outlines: Sobel's operator on what the rays around a camera ray meet, so that a line is as wide as the distance
// between these rays at every resolution. It decides for one ray; tracing and colour are not here.
#ifndef COTORRA_OUTLINE_H
#define COTORRA_OUTLINE_H

#include "camera.h"
#include "surface.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint OUTLINE_NORMAL = 1u;
const uint OUTLINE_DEPTH = 2u;
const uint OUTLINE_OBJECT = 4u;
const uint OUTLINE_RAYS = 9u;  // three rows of three
const uint OUTLINE_MIDDLE = 4u;

// Sobel's weights sum to 4 on either side: a step of this size between two columns gives four times it.
const float OUTLINE_CREASE = 0.5176f;  // between normals 30 degrees apart: 2 sin(15 degrees)
const float OUTLINE_STEP = 0.02f;      // in depth, of what the picture is high at that distance

// What the camera ray in the middle met; instance is INVALID_ID where it met nothing.
struct OutlinePoint {
  vec3 p;
  uint instance;
  vec3 n;        // shading normal
  float height;  // metres that the picture is high at p
  vec3 ng;
  float unused;
};

struct OutlineSums {
  vec3 normal_x;
  float depth_x;
  vec3 normal_y;
  float depth_y;
  float object_x;
  float object_y;
};

// Where ray 0 to 8 lies from the middle one, in half widths of a line.
FN vec2 outline_move(uint ray) { return vec2(float(ray % 3u) - 1.0f, float(ray / 3u) - 1.0f); }

// The ray that is traced after this one. The middle comes first, since it has no weight itself and the others are
// compared with it; after the last it is its turn again.
FN uint outline_next(uint ray) {
  if (ray == OUTLINE_MIDDLE) return 0u;
  if (ray == OUTLINE_RAYS - 1u) return OUTLINE_MIDDLE;
  return select(ray + 1u == OUTLINE_MIDDLE, ray + 2u, ray + 1u);
}

// Sobel: [-1 0 1; -2 0 2; -1 0 1] and its transpose, for ray 0 to 8 row by row.
FN float sobel_x(uint ray) {
  const int column = int(ray % 3u) - 1;
  const int row = int(ray / 3u) - 1;
  return float(column * (2 - row * row));
}
FN float sobel_y(uint ray) {
  const int column = int(ray % 3u) - 1;
  const int row = int(ray / 3u) - 1;
  return float(row * (2 - column * column));
}

// Metres that the whole picture is high where p is.
FN float outline_height(IN(CameraData) camera, float rows, vec3 p) {
  const float depth = select(camera.kind == CAMERA_PERSPECTIVE, camera_depth(camera, p), 1.0f);
  return max(abs(camera.pixel_height * rows * depth), 1e-20f);
}

FN void outline_point(IN(SceneData) scene, IN(CameraData) camera, float rows, IN(Hit) hit, vec3 direction,
                      OUT(OutlinePoint) point) {
  point.instance = hit.instance;
  point.p = vec3(0.0f);
  point.n = vec3(0.0f);
  point.ng = vec3(0.0f);
  point.height = 0.0f;
  point.unused = 0.0f;
  if (hit.instance == INVALID_ID) return;
  Surface s;
  surface_from_hit(scene, hit, direction, s);
  point.p = s.p;
  point.n = s.n;
  point.ng = s.ng;
  point.height = outline_height(camera, rows, s.p);
}

FN void outline_begin(OUT(OutlineSums) sums) {
  sums.normal_x = vec3(0.0f);
  sums.normal_y = vec3(0.0f);
  sums.depth_x = 0.0f;
  sums.depth_y = 0.0f;
  sums.object_x = 0.0f;
  sums.object_y = 0.0f;
}

// Depth as a height over the plane through the middle point, in heights of the picture: 0 on a plane however it is
// tilted, and the same at every scale. Where one of the two met nothing, the step is as large as it gets.
FN float outline_depth(IN(OutlinePoint) middle, uint instance, vec3 p) {
  const bool there = instance != INVALID_ID;
  if ((middle.instance != INVALID_ID) != there) return 1.0f;
  if (!there) return 0.0f;
  return clamp(dot(middle.ng, p - middle.p) / middle.height, -1.0f, 1.0f);
}

// Adds what ray 0 to 8 met: instance, place and shading normal.
FN void outline_add(IN(OutlinePoint) middle, uint ray, uint instance, vec3 p, vec3 n, INOUT(OutlineSums) sums) {
  const float x = sobel_x(ray);
  const float y = sobel_y(ray);
  const float depth = outline_depth(middle, instance, p);
  const bool both = instance != INVALID_ID && middle.instance != INVALID_ID;
  const vec3 turn = select(both, n - middle.n, vec3(0.0f));
  const float other = select(instance != middle.instance, 1.0f, 0.0f);
  sums.normal_x += turn * x;
  sums.normal_y += turn * y;
  sums.depth_x += depth * x;
  sums.depth_y += depth * y;
  sums.object_x += other * x;
  sums.object_y += other * y;
}

// Is the ray in the middle on a line? `kinds` are OUTLINE_* that draw one; `reach` is how far apart the rays are, in
// heights of the picture: what only slopes, up to 2 : 1, is no step.
FN bool outline_found(IN(OutlineSums) sums, uint kinds, float reach) {
  const float crease = dot(sums.normal_x, sums.normal_x) + dot(sums.normal_y, sums.normal_y);
  const float depth = sqr(sums.depth_x) + sqr(sums.depth_y);
  const float object = sqr(sums.object_x) + sqr(sums.object_y);
  return ((kinds & OUTLINE_NORMAL) != 0u && crease > sqr(4.0f * OUTLINE_CREASE)) ||
         ((kinds & OUTLINE_DEPTH) != 0u && depth > sqr(4.0f * (OUTLINE_STEP + 2.0f * reach))) ||
         ((kinds & OUTLINE_OBJECT) != 0u && object > 0.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

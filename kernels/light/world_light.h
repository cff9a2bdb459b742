// SPDX-License-Identifier: GPL-3.0-or-later
// The world as a light: directions drawn from a table of how bright it is, or within the sun's disc, and the density
// with which they are.
// What the world shows and what comes of it at a surface is the integrator's; the table is native/world_table.cpp's.
#ifndef COTORRA_WORLD_LIGHT_H
#define COTORRA_WORLD_LIGHT_H

#include "../program/math_ops.h"
#include "../sampling.h"
#include "../scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A direction as longitude and latitude, both from 0 to 1, as environment images have them: +x in the middle, the nadir
// below. Latitude by atan, which keeps its digits near the poles, where acos loses them.
FN vec2 world_square(vec3 d) {
  const float across = sqrt(d.x * d.x + d.y * d.y);
  const float u = select(across > 0.0f, 0.5f - angle_lanes(d.y, d.x) / TWO_PI, 0.5f);
  return vec2(clamp(u, 0.0f, 1.0f), clamp(angle_lanes(d.z, across) * INV_PI + 0.5f, 0.0f, 1.0f));
}

FN vec3 world_direction(vec2 square, OUT(float) across) {
  const float longitude = (0.5f - square.x) * TWO_PI;
  const float latitude = (square.y - 0.5f) * PI;
  across = max(cos_lanes(latitude), 0.0f);
  return vec3(across * cos_lanes(longitude), across * sin_lanes(longitude), sin_lanes(latitude));
}

// The first of `count` cumulated numbers above u: the last is 1, so that there is one. u becomes the way into its step,
// 0 to 1, and `share` the step's height. What is searched halves without a branch that a processor would have to guess.
FN uint world_search(FloatBuffer table, uint first, uint count, INOUT(float) u, OUT(float) share) {
  uint low = 0u;
  for (uint left = count - 1u; left > 0u;) {
    const uint part = (left + 1u) / 2u;
    low = select(u < LOAD(table, first + low + part - 1u), low, low + part);
    left -= part;
  }
  const float before = low > 0u ? LOAD(table, first + low - 1u) : 0.0f;
  share = LOAD(table, first + low) - before;
  u = clamp((u - before) / max(share, 1e-30f), 0.0f, 0.99999994f);
  return low;
}

// Height of step i of cumulated numbers.
FN float world_share(FloatBuffer table, uint first, uint i) {
  const float before = i > 0u ? LOAD(table, first + i - 1u) : 0.0f;
  return LOAD(table, first + i) - before;
}

// Density in solid angle where the cell's share of the square is `share` and the circle of latitude has radius
// `across`.
FN float world_density(IN(SceneData) scene, float share, float across) {
  const float cells = float(int(scene.world_width)) * float(int(scene.world_height));
  return share * cells / (2.0f * PI * PI * max(across, 1e-9f));
}

FN float world_table_pdf(IN(SceneData) scene, vec3 direction) {
  const uint width = scene.world_width;
  const uint height = scene.world_height;
  const vec2 square = world_square(direction);
  const uint x = min(uint(int(square.x * float(int(width)))), width - 1u);
  const uint y = min(uint(int(square.y * float(int(height)))), height - 1u);
  const float row = world_share(scene.world_table, width * height, y);
  if (!(row > 0.0f)) return 0.0f;
  const float across = sqrt(direction.x * direction.x + direction.y * direction.y);
  return world_density(scene, row * world_share(scene.world_table, y * width, x), across);
}

// A direction by the table: a row, then a cell of it, each evenly drawn from.
FN vec3 world_table_sample(IN(SceneData) scene, vec2 u, OUT(float) pdf) {
  const uint width = scene.world_width;
  const uint height = scene.world_height;
  float row;
  float cell;
  const uint y = world_search(scene.world_table, width * height, height, u.y, row);
  const uint x = world_search(scene.world_table, y * width, width, u.x, cell);
  const vec2 square = vec2((float(int(x)) + u.x) / float(int(width)), (float(int(y)) + u.y) / float(int(height)));
  float across;
  const vec3 direction = world_direction(square, across);
  pdf = world_density(scene, row * cell, across);
  return direction;
}

// The same of the sun's disc.
FN float world_sun_pdf(IN(SceneData) scene, vec3 direction) {
  // |difference|^2 = 2 (1 - cos), without the cancellation of 1 - dot.
  const vec3 difference = direction - scene.world_sun;
  const float cap = scene.world_sun_cap;
  return select(dot(difference, difference) <= 2.0f * cap, 1.0f / max(2.0f * PI * cap, 1e-30f), 0.0f);
}

// The density with which world_sample draws a direction; 0 where it never does.
FN float world_pdf(IN(SceneData) scene, vec3 direction) {
  if (!FEATURE(FEATURE_WORLD_LIGHT) || scene.world_width == 0u) return 0.0f;
  const float share = scene.world_sun_share;
  const float table = world_table_pdf(scene, direction);
  return share > 0.0f ? mix(table, world_sun_pdf(scene, direction), share) : table;
}

// A direction to the sun or by the table.
FN vec3 world_sample(IN(SceneData) scene, vec2 u, OUT(float) pdf) {
  const float share = scene.world_sun_share;
  if (!(share > 0.0f)) return world_table_sample(scene, u, pdf);
  if (u.x >= share) {
    u.x = min((u.x - share) / (1.0f - share), 0.99999994f);
    const vec3 direction = world_table_sample(scene, u, pdf);
    pdf = mix(pdf, world_sun_pdf(scene, direction), share);
    return direction;
  }
  u.x = u.x / share;
  vec3 t;
  vec3 b;
  orthonormal_basis(scene.world_sun, t, b);
  const vec3 direction = to_world(cone_from_square(u, scene.world_sun_cap), t, b, scene.world_sun);
  pdf = mix(world_table_pdf(scene, direction), 1.0f / max(2.0f * PI * scene.world_sun_cap, 1e-30f), share);
  return direction;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

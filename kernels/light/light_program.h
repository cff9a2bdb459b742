// SPDX-License-Identifier: GPL-3.0-or-later
// Lights whose shader varies: the point of a light that the program runs at, with its coordinates as Cycles has them.
// What the light is without its program is light.h's.
#ifndef COTORRA_LIGHT_PROGRAM_H
#define COTORRA_LIGHT_PROGRAM_H

#include "light.h"
#include "../program/program.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The two numbers that stand for a light's UV map: of a spot the picture that fills its cone, of a sun its disk, of an
// area light its square, of a point light the sphere about it.
FN vec2 light_uv(IN(Light) light, IN(LightProgram) program, vec3 p, vec3 wi, vec3 n) {
  if (light.type == LIGHT_AREA) {
    const vec3 d = p - light.position;
    const float u = 0.5f * dot(light.local_x, d) / light.half_u;
    const float v = 0.5f * dot(light.local_y, d) / light.half_v;
    return vec2(clamp(u, -0.5f, 0.5f) + 0.5f, clamp(v, -0.5f, 0.5f) + 0.5f);
  }
  // Of coordinates from 0 to 1, as an image has it.
  if (light.type == LIGHT_POINT) return map_to_sphere(object_space_vector(program.space, n) * 0.5f + 0.5f);
  if (light.type == LIGHT_SUN) {
    const vec3 l = object_space_vector(program.space, wi);
    float len;
    safe_normalize(wi - light.axis, len);
    const float scale = program.uv_scale / max(len, 1e-6f);
    return vec2(l.x * scale + 0.5f, l.y * scale + 0.5f);
  }
  const vec3 l = vec3(dot(light.local_x, wi), dot(light.local_y, wi), dot(light.local_z, wi));
  const float scale = safe_divide(program.uv_scale, l.z);
  return vec2(0.5f - l.x * scale, 0.5f - l.y * scale);
}

// The point of light `index` that lies `distance` along wi from p.
FN ShaderPoint light_point(uint index, IN(Light) light, IN(LightProgram) program, vec3 p, vec3 wi, float distance) {
  const bool sun = light.type == LIGHT_SUN;
  ShaderPoint at = background_point(wi);
  at.light = index;
  at.t = distance;
  at.p = select(sun, -wi, p + wi * distance);
  at.n = -wi;
  if (light.type == LIGHT_AREA) at.n = light.axis;
  const bool ball = light.type <= LIGHT_SPOT && !sun && (light.flags & LIGHT_SOFT_FALLOFF) == 0u && light.radius > 0.0f;
  if (ball) {
    float len;
    at.n = safe_normalize(at.p - light.position, len);
  }
  const vec2 uv = light_uv(light, program, at.p, wi, at.n);
  at.u = uv.x;
  at.v = uv.y;
  // Seen from within a ball.
  at.side = select(dot(at.n, wi) > 0.0f, -1.0f, 1.0f);
  at.n = at.n * at.side;
  at.ng = at.n;
  return at;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

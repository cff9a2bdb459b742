// SPDX-License-Identifier: GPL-3.0-or-later
// Lights: point, sun and spot lights are sampled by the solid angle they show and met by rays; area_light.h is asked
// for the others. Shadow and BSDF are the integrator's.
#ifndef COTORRA_LIGHT_H
#define COTORRA_LIGHT_H

#include "area_light.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The pass of its own that a lamp's light goes to, -1 where it has none, and its light group: see LAMP_PASS_SHIFT.
FN int light_pass(int group) { return (group >> int(LAMP_PASS_SHIFT)) - 1; }
FN int light_group(int group) { return (group << int(LAMP_PASS_SHIFT)) >> int(LAMP_PASS_SHIFT); }

// 1 - cos of the angle between a spot's axis and direction wi (surface to light), in the lamp's own space: from the
// difference of two unit vectors, so that no digits cancel however narrow the cone is.
FN float spot_direction_versine(IN(Light) light, vec3 wi) {
  const vec3 l = vec3(dot(light.local_x, wi), dot(light.local_y, wi), dot(light.local_z, wi));
  const vec3 difference = l * (1.0f / sqrt(max(dot(l, l), 1e-30f))) - vec3(0.0f, 0.0f, 1.0f);
  return 0.5f * dot(difference, difference);
}

// Attenuation of a spot in direction wi (surface to light): Blender's smoothed cone.
FN float spot_attenuation(IN(Light) light, vec3 wi) {
  return smoothstep01((light.spot_versine - spot_direction_versine(light, wi)) * light.spot_scale);
}

// 1 - cos of the half angle under which a point light of size shows from squared distance d2.
FN float point_light_cap(IN(Light) light, float d2) {
  const float r2 = light.radius * light.radius;
  // A disk that faces the point fills sin^2 = r2 / (d2 + r2) of the cone; a sphere r2 / d2.
  const bool disk = (light.flags & LIGHT_SOFT_FALLOFF) != 0u;
  return one_minus_cos_from_sin2(r2 / (d2 + select(disk, r2, 0.0f)));
}

// Distance along wi to a point light of size, whose centre lies at distance d and cosine c from wi.
FN float point_light_distance(IN(Light) light, float d, float c) {
  const float r2 = light.radius * light.radius;
  const float root = sqrt(max(r2 - d * d * max(1.0f - c * c, 0.0f), 0.0f));
  const bool disk = (light.flags & LIGHT_SOFT_FALLOFF) != 0u;
  return select(disk, d / max(c, 1e-6f), select(d * d > r2, d * c - root, d * c + root));
}

// Point and spot lights. `n` serves only where the point lies inside a spherical light: light comes from all around
// there, and the cosine about the normal is all that is left to sample. Selects instead of branches: a loop over many
// points vectorises.
FN void point_light_sample(IN(Light) light, vec3 p, vec3 n, vec2 u, OUT(LightSample) s) {
  const vec3 to_light = light.position - p;
  const float d2 = max(dot(to_light, to_light), 1e-20f);
  const float d = sqrt(d2);
  const vec3 axis = to_light * (1.0f / d);
  s.wi = axis;
  s.distance = d;
  s.pdf = 0.0f;
  float scale = 1.0f / d2;
  bool inside = false;
  if (FEATURE(FEATURE_SOFT_LIGHTS) && light.radius > 0.0f) {
    inside = (light.flags & LIGHT_SOFT_FALLOFF) == 0u && d <= light.radius;
    const float h = point_light_cap(light, d2);
    const vec2 disk = disk_from_square(u);
    const float r2 = dot(disk, disk);
    const float cosine = sqrt(max(1.0f - r2, 0.0f));
    const float spread = select(inside, 1.0f, sqrt(h * max(2.0f - h * r2, 0.0f)));
    const vec3 frame = select(inside, n, axis);
    vec3 t;
    vec3 b;
    orthonormal_basis(frame, t, b);
    s.wi = to_world(vec3(disk.x * spread, disk.y * spread, select(inside, cosine, 1.0f - h * r2)), t, b, frame);
    s.distance = point_light_distance(light, d, dot(s.wi, axis));
    s.pdf = select(inside, max(cosine, 1e-6f) * INV_PI, 1.0f / max(2.0f * PI * h, 1e-30f));
    scale = 1.0f / s.pdf;
  }
  if (light.type == LIGHT_SPOT) scale *= max(spot_attenuation(light, s.wi), select(inside, 1.0f, 0.0f));
  s.weight = light.radiance * scale;
}

FN void sun_light_sample(IN(Light) light, vec2 u, OUT(LightSample) s) {
  const vec3 axis = -light.axis;
  s.wi = axis;
  s.distance = INFINITE_DISTANCE;
  s.pdf = 0.0f;
  s.weight = light.radiance;
  if (FEATURE(FEATURE_SOFT_LIGHTS)) {
    // For a sun `radius` holds 1 - cos(angle / 2). Selects, as for point lights: what is 0 here ends on the axis.
    vec3 t;
    vec3 b;
    orthonormal_basis(axis, t, b);
    s.wi = to_world(cone_from_square(u, light.radius), t, b, axis);
    const float solid = 2.0f * PI * light.radius;
    s.pdf = select(light.radius > 0.0f, 1.0f / max(solid, 1e-37f), 0.0f);
    s.weight = light.radiance * select(light.radius > 0.0f, solid, 1.0f);
  }
}

// A direction toward the light from surface point p with normal n, and what arrives along it.
FN void light_sample(IN(Light) light, vec3 p, vec3 n, vec2 u, OUT(LightSample) s) {
  if (light.type == LIGHT_SUN) {
    sun_light_sample(light, u, s);
  } else if (FEATURE(FEATURE_AREA_LIGHTS) && light.type == LIGHT_AREA) {
    area_light_sample(light, p, u, s);
  } else {
    point_light_sample(light, p, n, u, s);
  }
}

// Beams, and lights whose program runs for each sample: no loop over lanes takes them.
FN bool light_asks_lanes(IN(Light) light) {
  return (light.flags & LIGHT_PROGRAM) != 0u || (light.type == LIGHT_AREA && light.tan_spread <= 0.0f);
}

// Metres along a ray that meets the light.
FN float light_distance(IN(Light) light, vec3 origin, vec3 direction) {
  if (light.type == LIGHT_SUN) return INFINITE_DISTANCE;
  if (light.type == LIGHT_AREA) {
    return safe_divide(dot(light.axis, light.position - origin), dot(light.axis, direction));
  }
  float d;
  const vec3 axis = safe_normalize(light.position - origin, d);
  return point_light_distance(light, d, dot(axis, direction));
}

// Does all of the lamp lie below the plane through p with the normal n? Of an area light, the circle about it.
FN bool light_is_below(IN(Light) light, vec3 p, vec3 n) {
  if (light.type == LIGHT_SUN) return dot(n, light.axis) > sqrt(max(1.0f - sqr(light.cos_sun), 0.0f));
  return dot(n, light.position - p) < -light.radius;
}

// Does the ray meet the light nearer than t_max? If so: radiance seen, and the pdf with which light_sample would have
// drawn the direction from `origin`, whose normal was `n`.
FN bool light_intersect(IN(Light) light, vec3 origin, vec3 direction, float t_max, vec3 n, OUT(vec3) radiance,
                        OUT(float) pdf) {
  radiance = light.radiance;
  pdf = 0.0f;
  if (light.radius <= 0.0f) return false;
  if (FEATURE(FEATURE_AREA_LIGHTS) && light.type == LIGHT_AREA) {
    return area_light_intersect(light, origin, direction, t_max, radiance, pdf);
  }
  if (light.type == LIGHT_SUN) {
    pdf = 1.0f / (2.0f * PI * light.radius);
    // |difference|^2 = 2 (1 - cos), without the cancellation of 1 - dot.
    const vec3 difference = direction + light.axis;
    return t_max >= INFINITE_DISTANCE && dot(difference, difference) <= 2.0f * light.radius;
  }
  float d;
  const vec3 axis = safe_normalize(light.position - origin, d);
  const float c = dot(axis, direction);
  const bool disk = (light.flags & LIGHT_SOFT_FALLOFF) != 0u;
  const bool inside = !disk && d <= light.radius;
  const vec3 difference = direction - axis;
  const float h = point_light_cap(light, d * d);
  if (!inside && dot(difference, difference) > 2.0f * h) return false;
  const float t = point_light_distance(light, d, c);
  if (t >= t_max || t <= 0.0f) return false;
  pdf = inside ? max(dot(n, direction), 1e-6f) * INV_PI : 1.0f / max(2.0f * PI * h, 1e-30f);
  if (light.type == LIGHT_SPOT) {
    // Blender's spots are seen from the front only.
    if (dot(direction, light.axis) >= 0.0f && !inside) return false;
    if (!inside) radiance = radiance * spot_attenuation(light, direction);
  }
  return true;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

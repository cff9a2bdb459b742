// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights: rectangles and ellipses that shine to one side, sampled by the solid angle that they show, with a
// spread. Which lamp a light is, and all that lamps of other kinds need, is light.h's.
#ifndef COTORRA_AREA_LIGHT_H
#define COTORRA_AREA_LIGHT_H

#include "light_sample.h"
#include "../program/elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The part of a light that may light a point, as a rectangle in the light's plane. Its coordinates run along local_x
// and local_y from the foot of the point, from which the plane is `height` metres away.
struct AreaView {
  float a0;
  float a1;
  float b0;
  float b1;
  float height;  // 0 or less: the point lies behind
  float x;  // of the foot, from the light's centre
  float y;
  float nearest2;  // squared distance from the point to the rectangle
  uint whole;  // 1: the spread cuts nothing off
};

// Angle of (x, y) to the x axis for y >= 0, in 0 to pi: a fitted polynomial, 2e-8; the same bits on each device.
FN float angle_of_point(float x, float y) {
  const float ax = abs(x);
  const float low = min(ax, y);
  const float high = max(ax, y);
  const float r = low / max(high, 1e-37f);
  const float z = r * r;
  const float tail =
      0.106409347f + z * (-0.0750429554f + z * (0.0426915272f + z * (-0.0160686319f + z * 0.00284988993f)));
  const float octant = r * (0.999999985f + z * (-0.333330733f + z * (0.199926194f + z * (-0.142036447f + z * tail))));
  const float quadrant = select(y > ax, HALF_PI - octant, octant);
  return select(x < 0.0f, PI - quadrant, quadrant);
}

FN void area_light_view(IN(Light) light, vec3 p, OUT(AreaView) v) {
  const vec3 from_centre = p - light.position;
  v.x = dot(light.local_x, from_centre);
  v.y = dot(light.local_y, from_centre);
  v.height = dot(light.axis, from_centre);
  // Light leaves within half the spread of the axis: what lies farther from the foot does not reach the point.
  const float reach = max(v.height, 0.0f) * light.tan_spread;
  v.a0 = max(-light.half_u - v.x, -reach);
  v.a1 = min(light.half_u - v.x, reach);
  v.b0 = max(-light.half_v - v.y, -reach);
  v.b1 = min(light.half_v - v.y, reach);
  const float a = clamp(0.0f, min(v.a0, v.a1), max(v.a0, v.a1));
  const float b = clamp(0.0f, min(v.b0, v.b1), max(v.b0, v.b1));
  v.nearest2 = a * a + b * b + v.height * v.height;
  v.whole = select(reach >= max(light.half_u + abs(v.x), light.half_v + abs(v.y)), 1u, 0u);
}

FN bool area_view_empty(IN(AreaView) v) { return !(v.height > 0.0f && v.a1 > v.a0 && v.b1 > v.b0); }

// Solid angle of the rectangle, as the two triangles that a diagonal makes of it (Van Oosterom & Strackee 1983): no
// digits cancel, however far away or near it is.
FN float area_view_solid_angle(IN(AreaView) v) {
  const float h2 = v.height * v.height;
  const float r00 = sqrt(v.a0 * v.a0 + v.b0 * v.b0 + h2);
  const float r10 = sqrt(v.a1 * v.a1 + v.b0 * v.b0 + h2);
  const float r11 = sqrt(v.a1 * v.a1 + v.b1 * v.b1 + h2);
  const float r01 = sqrt(v.a0 * v.a0 + v.b1 * v.b1 + h2);
  const float aa = v.a0 * v.a1;
  const float bb = v.b0 * v.b1;
  const float d00_11 = aa + bb + h2;  // dot products of corners
  const float d00_10 = aa + v.b0 * v.b0 + h2;
  const float d10_11 = v.a1 * v.a1 + bb + h2;
  const float d00_01 = v.a0 * v.a0 + bb + h2;
  const float d01_11 = aa + v.b1 * v.b1 + h2;
  // tan(angle / 2) = volume / d of each triangle; divided by distances, so that no product overflows.
  const float volume = (v.a1 - v.a0) * (v.b1 - v.b0) * v.height;
  const float lower = r00 + d00_10 / r10 + d00_11 / r11 + d10_11 * (r00 / (r10 * r11));
  const float upper = r00 + d00_01 / r01 + d00_11 / r11 + d01_11 * (r00 / (r01 * r11));
  const float s = volume / (r10 * r11);
  const float t = volume / (r01 * r11);
  // The angles add up as those of complex numbers (lower, s) and (upper, t) do.
  return 2.0f * angle_of_point(lower * upper - s * t, s * upper + t * lower);
}

const uint AREA_SPHERICAL = 0u;  // uniform in solid angle over the rectangle
const uint AREA_PLANAR = 1u;     // uniform over the rectangle
const uint AREA_DISK = 2u;       // uniform over the ellipse

// Where the light is far away, directions hardly differ from points: these cost less, and of an ellipse none is lost.
FN uint area_view_technique(IN(Light) light, IN(AreaView) v) {
  const float diagonal2 = sqr(v.a1 - v.a0) + sqr(v.b1 - v.b0);
  const bool disk = (light.flags & LIGHT_ELLIPSE) != 0u && v.whole != 0u && diagonal2 < v.nearest2;
  const uint flat_or_not = select(16.0f * diagonal2 < v.nearest2, AREA_PLANAR, AREA_SPHERICAL);
  return select(disk, AREA_DISK, flat_or_not);
}

// Density in solid angle with which area_light_sample draws a point at distance d.
FN float area_view_pdf(IN(Light) light, IN(AreaView) v, float d) {
  const uint technique = area_view_technique(light, v);
  const float rectangle = (v.a1 - v.a0) * (v.b1 - v.b0);
  const float area = select(technique == AREA_DISK, PI * light.half_u * light.half_v, rectangle);
  const float flat_pdf = d * d * d / max(v.height * area, 1e-37f);
  return select(technique == AREA_SPHERICAL, 1.0f / max(area_view_solid_angle(v), 1e-37f), flat_pdf);
}

// A point of the rectangle, uniform in solid angle (Urena, Fajardo & King 2013, "An area-preserving parametrization for
// spherical rectangles"). Angles are added by sines and cosines, which needs no arc functions.
FN vec2 area_view_spherical(IN(AreaView) v, float solid_angle, vec2 u) {
  // 1. z of the normals of the four planes through the point and an edge; the paper has the rectangle at z0 < 0.
  const float h2 = v.height * v.height;
  const float n0 = -v.b0 / sqrt(h2 + v.b0 * v.b0);
  const float n2 = v.b1 / sqrt(h2 + v.b1 * v.b1);
  const float n3 = -v.a0 / sqrt(h2 + v.a0 * v.a0);
  // 2. The angle k = 2 pi - g2 - g3, from which the angle of the cut runs on.
  const float c2 = -n2 * n3;
  const float c3 = -n3 * n0;
  // 1 - n^2 of each normal keeps the digits that 1 - c^2 would lose.
  const float m0 = h2 / (h2 + v.b0 * v.b0);
  const float m2 = h2 / (h2 + v.b1 * v.b1);
  const float m3 = h2 / (h2 + v.a0 * v.a0);
  const float s2 = sqrt(m2 + n2 * n2 * m3);
  const float s3 = sqrt(m0 + n0 * n0 * m3);
  const float ck = c2 * c3 - s2 * s3;
  const float sk = -(s2 * c3 + c2 * s3);
  const float cu = cos_lanes(u.x * solid_angle);
  const float su = sin_lanes(u.x * solid_angle);
  const float ca = ck * cu - sk * su;
  const float sa = sk * cu + ck * su;
  // 3. Where the cut that leaves u.x of the solid angle to its left meets the plane.
  // ca n0 - n2, where both are nearly 1, from what they lack of it.
  const float s = select(ca < 0.0f, -1.0f, 1.0f);
  const float p0 = s * n0;
  const float lack = select(n2 < 0.0f, -1.0f, 1.0f) * (m2 / (1.0f + abs(n2)) - m0 / (1.0f + abs(n0)));
  const float apart = select(p0 * n2 > 0.0f, lack, p0 - n2) - p0 * (sa * sa / (1.0f + abs(ca)));
  const float f = apart / select(abs(sa) > 1e-12f, sa, 1e-12f);
  const float g = f * f - m0;  // the paper's 1 / cu^2 - 1
  const float a = clamp(select(f > 0.0f, v.height, -v.height) / sqrt(max(g, 1e-20f)), v.a0, v.a1);
  // 4. Along the cut, whose plane the light crosses at distance sqrt(d2).
  const float d2 = a * a + h2;
  const float t0 = v.b0 / sqrt(d2 + v.b0 * v.b0);
  const float t1 = v.b1 / sqrt(d2 + v.b1 * v.b1);
  const float t = t0 + u.y * (t1 - t0);
  const float b = t * sqrt(d2 / max(1.0f - t * t, 1e-12f));
  return vec2(a, clamp(b, v.b0, v.b1));
}

// Does a point of the rectangle belong to the light?
FN bool area_light_rounds(IN(Light) light, float x, float y) {
  return select((light.flags & LIGHT_ELLIPSE) != 0u, sqr(x / light.half_u) + sqr(y / light.half_v), 0.0f) <= 1.0f;
}
FN bool area_light_covers(IN(Light) light, float x, float y) {
  return abs(x) <= light.half_u && abs(y) <= light.half_v && area_light_rounds(light, x, y);
}

// Factor on the radiance toward a direction whose angle to the axis has this tangent: the grid of a soft box hides more
// and more of the light behind it, up to half the spread. The light keeps its power.
FN float area_light_spread(IN(Light) light, float tangent) {
  return max((light.tan_spread - tangent) * light.spread_scale, 0.0f);
}

// A light without spread sends a parallel beam: where it falls, its irradiance is radiance x pi.
FN void area_light_beam(IN(Light) light, vec3 p, OUT(LightSample) s) {
  AreaView v;
  area_light_view(light, p, v);
  s.wi = -light.axis;
  s.distance = max(v.height, 0.0f);
  s.pdf = 0.0f;
  const bool lit = v.height > 0.0f && area_light_covers(light, v.x, v.y);
  s.weight = select(lit, light.radiance * PI, vec3(0.0f));
}

// A direction toward a light with a spread from p, and what arrives along it. Selects instead of branches: a loop over
// many points vectorises.
FN void area_light_sample_spread(IN(Light) light, vec3 p, vec2 u, OUT(LightSample) s) {
  AreaView v;
  area_light_view(light, p, v);
  // 1. A point, from the foot.
  const uint technique = area_view_technique(light, v);
  const float solid_angle = area_view_solid_angle(v);
  const vec2 disk = disk_from_square(u);
  const vec2 round_point = vec2(light.half_u * disk.x - v.x, light.half_v * disk.y - v.y);
  const vec2 flat_point = vec2(v.a0 + u.x * (v.a1 - v.a0), v.b0 + u.y * (v.b1 - v.b0));
  const vec2 spherical = area_view_spherical(v, solid_angle, u);
  const bool curved = technique == AREA_SPHERICAL;
  const bool disk_drawn = technique == AREA_DISK;
  const vec2 q = vec2(select(curved, spherical.x, select(disk_drawn, round_point.x, flat_point.x)),
                      select(curved, spherical.y, select(disk_drawn, round_point.y, flat_point.y)));
  // 2. The direction, and its density.
  const float lateral2 = dot(q, q);
  s.distance = sqrt(max(lateral2 + v.height * v.height, 1e-30f));
  s.wi = (light.local_x * q.x + light.local_y * q.y - light.axis * v.height) * (1.0f / s.distance);
  const float rectangle = (v.a1 - v.a0) * (v.b1 - v.b0);
  const float area = select(disk_drawn, PI * light.half_u * light.half_v, rectangle);
  const float flat_weight = v.height * area / (s.distance * s.distance * s.distance);
  const float inverse_pdf = select(curved, solid_angle, flat_weight);
  // 3. What arrives. The corners of the rectangle about an ellipse, and what the spread cuts round, are dark.
  const float open = min(v.height, min(v.a1 - v.a0, v.b1 - v.b0));  // 0 or less: area_view_empty
  const bool lit = select(area_light_rounds(light, q.x + v.x, q.y + v.y), open, 0.0f) > 0.0f;
  const float spread = area_light_spread(light, sqrt(lateral2) / max(v.height, 1e-30f));
  s.pdf = select(lit, 1.0f / max(inverse_pdf, 1e-30f), 0.0f);
  s.weight = light.radiance * select(lit, spread * inverse_pdf, 0.0f);
}

FN void area_light_sample(IN(Light) light, vec3 p, vec2 u, OUT(LightSample) s) {
  if (light.tan_spread > 0.0f) {
    area_light_sample_spread(light, p, u, s);
  } else {
    area_light_beam(light, p, s);
  }
}

// As light_intersect.
FN bool area_light_intersect(IN(Light) light, vec3 origin, vec3 direction, float t_max, OUT(vec3) radiance,
                             OUT(float) pdf) {
  radiance = vec3(0.0f);
  pdf = 0.0f;
  const float cosine = -dot(direction, light.axis);
  if (!(cosine > 0.0f) || light.tan_spread <= 0.0f) return false;
  AreaView v;
  area_light_view(light, origin, v);
  if (area_view_empty(v)) return false;
  const float t = v.height / cosine;
  if (!(t < t_max)) return false;
  const float a = dot(direction, light.local_x) * t;
  const float b = dot(direction, light.local_y) * t;
  if (!area_light_covers(light, a + v.x, b + v.y)) return false;
  radiance = light.radiance * area_light_spread(light, sqrt(a * a + b * b) / v.height);
  pdf = area_view_pdf(light, v, t);
  return max_component(abs(radiance)) > 0.0f;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a triangle that shines: uniform over its area from afar, uniform over the solid angle that it shows from
// near, where distance and cosine differ much from point to point (Arvo 1995, "Stratified Sampling of Spherical
// Triangles").
#ifndef COTORRA_SPHERICAL_TRIANGLE_H
#define COTORRA_SPHERICAL_TRIANGLE_H

#include "area_light.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Near is a triangle whose middle is not this many times its longest edge away, squares compared; and it shows at least
// so many steradians then, since single precision tells too little of slivers.
const float TRIANGLE_NEAR = 2.0f;
// Of a point in its very plane directions tell nothing: the corners' volume is at least this. The density holds to 0.5
// % down to 5e-6 of an edge from the plane, to 5 % at a tenth of that, where points uniform by area would miss all
// light.
const float TRIANGLE_VOLUME = 1e-7f;
const float TRIANGLE_SHOWN = 1e-3f;

// A triangle as it shows from a point.
struct TriangleView {
  vec3 a;  // directions to its corners
  vec3 b;
  vec3 c;
  float volume;  // of the three
  float solid_angle;  // 0: it is far
};

// `to`: from the point to the first corner.
FN void triangle_view(vec3 to, vec3 edge1, vec3 edge2, OUT(TriangleView) view) {
  const vec3 middle = to + (edge1 + edge2) * (1.0f / 3.0f);
  view.solid_angle = 0.0f;
  view.volume = 0.0f;
  view.a = view.b = view.c = middle;
  const vec3 edge3 = edge2 - edge1;
  const float longest = max(dot(edge1, edge1), max(dot(edge2, edge2), dot(edge3, edge3)));
  if (!(dot(middle, middle) < TRIANGLE_NEAR * longest)) return;
  float distance;
  float far_b;
  float far_c;
  view.a = safe_normalize(to, distance);
  view.b = safe_normalize(to + edge1, far_b);
  view.c = safe_normalize(to + edge2, far_c);
  view.volume = abs(dot(to, cross(edge1, edge2))) / max(distance * far_b * far_c, 1e-37f);
  // Van Oosterom & Strackee 1983.
  const float below = 1.0f + dot(view.a, view.b) + dot(view.b, view.c) + dot(view.c, view.a);
  const float shown = 2.0f * angle_of_point(below, view.volume);
  if (shown >= TRIANGLE_SHOWN && view.volume >= TRIANGLE_VOLUME) view.solid_angle = shown;
}

// The direction of a uniform point of it.
FN vec3 spherical_triangle_sample(IN(TriangleView) view, vec2 u) {
  // 1. Corners a and b and a point on the edge from a to c make a triangle of area E with the whole one's angle at a,
  // where tan(side / 2) = sin(E / 2) / (tan(ab / 2) sin(angle - E / 2)). No angle is needed but by sine and cosine.
  const float along = -dot(cross(view.a, view.b), cross(view.c, view.a));
  const float over = 1.0f / max(sqrt(view.volume * view.volume + along * along), 1e-30f);
  const float sin_half = sin_lanes(0.5f * u.x * view.solid_angle);
  const float cos_half = cos_lanes(0.5f * u.x * view.solid_angle);
  const float rest = max((view.volume * cos_half - along * sin_half) * over, 1e-20f);
  const float tan_side = sin_half * length(view.a + view.b) / max(length(view.a - view.b) * rest, 1e-20f);
  float unused;
  const vec3 aside = safe_normalize(view.c - view.a * dot(view.c, view.a), unused);
  const float scale = 1.0f / (1.0f + tan_side * tan_side);
  const vec3 cut = view.a * ((1.0f - tan_side * tan_side) * scale) + aside * (2.0f * tan_side * scale);
  // 2. A point between b and there, by the height above b.
  const vec3 from_b = cut - view.b;
  const float below = 0.5f * u.y * dot(from_b, from_b);
  const vec3 away = safe_normalize(cut - view.b * dot(cut, view.b), unused);
  return view.b * (1.0f - below) + away * sqrt(max(below * (2.0f - below), 0.0f));
}

// A point of the triangle as barycentric coordinates of its second and third corner.
FN vec2 triangle_light_sample(IN(TriangleView) view, vec3 to, vec3 edge1, vec3 edge2, vec2 u) {
  if (!(view.solid_angle > 0.0f)) return triangle_from_square(u);
  const vec3 way = spherical_triangle_sample(view, u);
  const vec3 normal = cross(edge1, edge2);
  const vec3 on = way * (dot(normal, to) / dot(normal, way)) - to;
  const float over = 1.0f / dot(normal, normal);
  const float x = clamp(dot(cross(on, edge2), normal) * over, 0.0f, 1.0f);
  return vec2(x, clamp(dot(cross(edge1, on), normal) * over, 0.0f, 1.0f - x));
}

// The density of that, per steradian, of a point `distance` metres away that faces with the cosine `facing`.
FN float triangle_light_pdf(IN(TriangleView) view, float twice_area, float distance, float facing) {
  if (view.solid_angle > 0.0f) return 1.0f / view.solid_angle;
  return distance * distance / (0.5f * twice_area * facing);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

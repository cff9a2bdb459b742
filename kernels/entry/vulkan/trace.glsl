// SPDX-License-Identifier: GPL-3.0-or-later
// The one way in which stages trace rays: the BVH of bvh.h, or (RAY_QUERY) the acceleration structure of the hardware.
// What becomes of a ray at a surface, such as one that lets it through, is the stages' own business.

#ifdef RAY_QUERY

// The hardware may count hits at both ends of the interval; ours excludes them, so that a ray can go on behind the
// surface that it has met. Below 1e-30 there may be no normal float between 0 and the result.
float float_after(float t) { return max(uintBitsToFloat(floatBitsToUint(t) + 1u), 1e-30f); }

// The triangle of a query's hit, COMMITTED or asked about, as instance and triangle. A macro: which of the two must be
// a constant.
#define QUERY_TRIANGLE(TRIANGLE, COMMITTED)                                                                        \
  {                                                                                                                \
    const uint place = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, COMMITTED)) +                     \
                       uint(rayQueryGetIntersectionGeometryIndexEXT(query, COMMITTED));                            \
    const TracedGeometry geometry = LOAD(WAVE.acceleration.geometries, place);                                     \
    const uint first = geometry.first_triangle;                                                                    \
    TRIANGLE = uvec2(geometry.instance, first + uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, COMMITTED))); \
  }

#endif

// The nearest surface beyond t_min and before t_max that a ray of this visibility meets; or, with `any`, some surface.
// Not the triangle that it left; see ray_passes.
bool trace(vec3 origin, vec3 direction, float t_min, float t_max, uint visibility, bool any, uvec2 left, out Hit hit) {
  hit.t = t_max;
  hit.u = 0.0f;
  hit.v = 0.0f;
  hit.triangle = 0u;
  hit.instance = INVALID_ID;
  hit.crossed = 0u;
#ifdef RAY_QUERY
  const float begin = t_min < 0.0f ? 0.0f : float_after(t_min);
  if (!(begin < t_max)) return false;  // a query needs an interval
  const bool asks = left.x != INVALID_ID;  // each triangle whether it is the one that was left
  // Masks of the hardware have eight bits: sets of objects that shadow are asked for.
  const bool of_sets = FEATURE(FEATURE_LIGHT_LINKING) && visibility >> SHADOW_SET_SHIFT != 0u;
  const uint flags = (asks || of_sets ? gl_RayFlagsNoOpaqueEXT : gl_RayFlagsOpaqueEXT) |
                     (any ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
  // Hits at the very start count for a ray that left a triangle, which the hardware may not know: it begins earlier, by
  // 32 times the rounding of its place, since triangles reach farther than that.
  const float before = asks && left.y != LEFT_ALL_OTHERS ? max_component(abs(origin)) * 3.8e-6f + 1e-12f : 0.0f;
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(WAVE.acceleration.top), flags,
                        of_sets ? VISIBLE_SHADOW : visibility, origin - direction * before, begin, direction, t_max);
  uvec2 triangle;
  while (rayQueryProceedEXT(query)) {
    QUERY_TRIANGLE(triangle, false)
    const bool shadows = !of_sets || (LOAD(SCENE.instances, triangle.x).visibility & visibility) != 0u;
    if (!ray_passes(triangle.x, triangle.y, left) && shadows) rayQueryConfirmIntersectionEXT(query);
  }
  if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionTriangleEXT) return false;
  QUERY_TRIANGLE(triangle, true)
  const vec2 barycentric = rayQueryGetIntersectionBarycentricsEXT(query, true);
  hit.t = rayQueryGetIntersectionTEXT(query, true);
  hit.u = barycentric.x;
  hit.v = barycentric.y;
  hit.triangle = triangle.y;
  hit.instance = triangle.x;
  return true;
#else
  return bvh_trace(WAVE.bvh, origin, direction, t_min, visibility, any, left, hit);
#endif
}

// The triangle that the lane's surface lies on, where rays from there cannot meet it; see surface_left.
uvec2 left_at(uint lane, vec3 origin, vec3 direction) {
  if (!FEATURE(FEATURE_LOBES | FEATURE_TRANSPARENCY) || SCENE.starts_at_point == 0u)
    return uvec2(INVALID_ID, INVALID_ID);
  Surface s;
  surface_from_hit(SCENE, LOAD(WAVE.hits, lane), direction, s);
  return surface_left(SCENE, s, origin, direction);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Light that a path finds by itself: lamps on its way, the background, surfaces that emit; each weighed against light
// sampling, which would have drawn the same direction. That is told in sampled.h.
#ifndef COTORRA_FOUND_H
#define COTORRA_FOUND_H

#include "../path.h"
#include "light_program.h"
#include "light_shape.h"
#include "light_tree.h"
#include "spherical_triangle.h"
#include "world_light.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint VISIBLE_SCATTERED = VISIBLE_DIFFUSE | VISIBLE_GLOSSY;
const uint VISIBLE_LIT = VISIBLE_SCATTERED | VISIBLE_TRANSMISSION;

// Throughput for light that a ray found by itself, and the density with which it was found, 0 where light sampling
// cannot. `visibility` tells which rays see the light.
FN vec3 found_throughput(IN(SceneData) scene, IN(PathState) path, uint visibility, OUT(float) pdf) {
  const bool own = scene.light_kinds != 0u && (visibility & VISIBLE_SCATTERED) != VISIBLE_SCATTERED;
  pdf = select(own, path.kind_pdf, path.pdf);
  return path.throughput * select(own, path.kind_weight, vec3(1.0f));
}

// Weight of such light, where light sampling draws the same direction with `light_pdf`.
FN float found_weight(float pdf, float light_pdf) { return pdf > 0.0f ? power_heuristic(pdf, light_pdf) : 1.0f; }

// Factor on what lamp `index` sends along -wi from `distance` metres away: 1, or what its program says. As in Cycles, a
// lamp knows the number of bounces and not the kind of ray.
FN vec3 path_light_program(IN(SceneData) scene, uint index, IN(Light) light, IN(PathState) path, vec3 p, vec3 wi,
                           float distance) {
  if (!FEATURE(FEATURE_PROGRAMS) || !PROGRAM_GROUP(GROUP_EMISSIONS) || (light.flags & LIGHT_PROGRAM) == 0u) {
    return vec3(1.0f);
  }
  const LightProgram program = LOAD(scene.light_programs, index);
  ShaderPoint at = light_point(index, light, program, p, wi, distance);
  path_counts(path, at);
  at.ray_kind = 0u;
  at.bounce += 1u;
  return light_numbers(program_value(scene, at, program.emission, program.constants));
}

// The set of objects that the path's vertex before its ray is one of.
FN uint path_set(IN(PathState) path) { return (path.ray_kind >> RAY_SET_SHIFT) & 63u; }

// Is this light hidden from the ray, as the vertex before it is not lit by it? The camera sees it.
FN bool path_unlinked(IN(SceneData) scene, IN(PathState) path, uint link) {
  return has_links(scene) && path.bounce > 0u && !light_lights(scene, link, path_set(path));
}

// How many light samples the tree draws at the vertex before a ray's.
FN float found_picks(IN(SceneData) scene, IN(PathState) path) {
  return path.bounce == 1u ? float(int(scene.tree_picks)) : 1.0f;
}

// The number of light samples that take the light at `place` of the tree, on average, at the vertex that the path left
// for p, `distance` metres along `direction`.
FN float found_probability(IN(SceneData) scene, IN(PathState) path, uint place, vec3 p, vec3 direction,
                           float distance) {
  LightReceiver at;
  at.p = p - direction * distance;
  at.n = path.normal;
  at.both_sides = path.ray_kind & RAY_BOTH_SIDES;
  at.set = path_set(path);
  return light_tree_probability(scene, place, at) * found_picks(scene, path);
}

// Lamp `index` as the ray meets it on its way of length t_max; lamps are transparent to rays, as in Cycles.
FN vec3 path_meet_light(IN(SceneData) scene, uint index, IN(PathState) path, vec3 origin, vec3 direction, float t_max,
                        OUT(int) group) {
  const Light light = LOAD(scene.lights, index);
  vec3 radiance;
  float pdf;
  group = light.group;
  // A light lights what a ray leaves: the vertex before this one. The camera always sees it.
  const uint met = select(path.bounce == 0u, LIGHT_SEEN, LIGHT_VISIBLE);
  const bool seen = (light.visibility & path.ray_kind) != 0u && (light.flags & met) != 0u &&
                    (path.bounce == 0u || path.bounce - 1u <= light.max_bounces);
  if (path_unlinked(scene, path, index)) return vec3(0.0f);
  if (!seen || !light_intersect(light, origin, direction, t_max, path.normal, radiance, pdf)) return vec3(0.0f);
  // Where light sampling brings all of it, a bounce must not bring it again.
  const bool shared_work = FEATURE(FEATURE_BSDF_RAYS) && (path.ray_kind & RAY_MEETS_LAMPS) != 0u;
  if (path.bounce > 0u && !shared_work) return vec3(0.0f);
  if (FEATURE(FEATURE_LIGHT_SHAPES)) radiance *= scene_light_shape(scene, index, light, origin, direction);
  if ((light.flags & LIGHT_PROGRAM) != 0u) {
    const bool first = path.bounce == 0u && path.transparent_bounces == 0u;
    const float begin = first ? camera_start(scene, -direction) : -path.passed;
    const float t = max(light_distance(light, origin, direction) - begin, 0.0f);
    radiance *= path_light_program(scene, index, light, path, origin + direction * begin, direction, t);
  }
  // As in Cycles: the light tree there leaves out what lies below the smooth surface, so that rays bring all of it.
  if ((path.ray_kind & RAY_HIDDEN) != 0u && light_is_below(light, origin - direction * path.passed, path.normal)) {
    pdf = 0.0f;
  }
  float found_pdf;
  const vec3 throughput = found_throughput(scene, path, light.visibility, found_pdf);
  if (FEATURE(FEATURE_LIGHT_TREE) && scene.light_count > LIGHTS_AT_ONCE && found_pdf > 0.0f) {
    const uint place = light_place_of_lamp(scene, index);
    pdf *= found_probability(scene, path, place, origin, direction, path.passed);
  }
  return throughput * radiance * found_weight(found_pdf, pdf);
}

// What the background shows at one of its points.
FN vec3 world_radiance(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (!FEATURE(FEATURE_PROGRAMS) || !PROGRAM_GROUP(GROUP_EMISSIONS) || scene.world_program.end == 0u) {
    return scene.world;
  }
  return light_numbers(program_value(scene, at, scene.world_program, scene.world_constants));
}

// The background's point along a ray that met no surface.
FN ShaderPoint path_background(IN(PathState) path, vec3 direction) {
  ShaderPoint at = background_point(direction);
  path_counts(path, at);
  at.bounce += 1u;  // it is one bounce on, says Cycles, as where light is sampled
  return at;
}

// Does such a ray see the background? It lights what the ray leaves: the vertex before this one. The camera always
// sees it.
FN bool path_sees_world(IN(SceneData) scene, IN(PathState) path) {
  const bool lights = path.bounce == 0u || path.bounce - 1u <= scene.world_max_bounces;
  return (scene.world_visibility & path.ray_kind) != 0u && lights;
}

// What a ray that sees the background brings, where that shows it `sky`.
FN vec3 path_escape(IN(SceneData) scene, IN(PathState) path, vec3 direction, vec3 sky) {
  float pdf;
  const vec3 throughput = found_throughput(scene, path, scene.world_sampled, pdf);
  float weight = 1.0f;
  if (FEATURE(FEATURE_WORLD_LIGHT) && pdf > 0.0f && (scene.world_sampled & path.ray_kind & VISIBLE_LIT) != 0u) {
    weight = found_weight(pdf, world_pdf(scene, direction));
  }
  return throughput * sky * weight;
}

// Light that the surface itself emits toward the ray's origin; `material` is the scene's record.
FN vec3 path_emission(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, IN(Material) material, vec3 wo, float t) {
  if (material_is_dark(material, s.side)) return vec3(0.0f);
  if (path_unlinked(scene, path, scene.light_count + s.instance)) return vec3(0.0f);
  uint visibility = VISIBLE_ALL;
  if (scene.light_kinds != 0u) visibility = LOAD(scene.instances, s.instance).visibility;
  float pdf;
  const vec3 throughput = found_throughput(scene, path, visibility, pdf);
  float weight = 1.0f;
  if (FEATURE(FEATURE_LIGHT_TREE) && (material.flags & MATERIAL_SAMPLED) != 0u && pdf > 0.0f) {
    const uint place = light_place_of_triangle(scene, s.instance, s.triangle);
    const float distance = path.passed + t;
    if (place != INVALID_ID) {
      // Light sampling picks a triangle by the tree, then a point of it.
      const float chosen = found_probability(scene, path, place, s.p, -wo, distance);
      SurfaceTriangle t;
      surface_fetch(scene, s.instance, s.triangle, t);
      const vec3 edge1 = t.p1 - t.p0;
      const vec3 edge2 = t.p2 - t.p0;
      const vec3 normal = cross(edge1, edge2);
      const float twice_area = sqrt(dot(normal, normal));
      TriangleView view;
      triangle_view(t.p0 - (s.p + wo * distance), edge1, edge2, view);
      const float facing = max(abs(dot(s.ng, wo)), 1e-8f);
      weight = found_weight(pdf, chosen * triangle_light_pdf(view, twice_area, distance, facing));
    }
  }
  const ShaderPoint at = path_point(scene, path, s, wo, t);
  return throughput * material_emission(scene, s.material, material, at) * weight;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// A path on its way: what it keeps between its vertices, its random numbers, its limits, and the points of surfaces as
// its shaders see them. How it goes on is integrator.h's, what lights it is told in light/.
#ifndef COTORRA_PATH_H
#define COTORRA_PATH_H

#include "fireflies.h"
#include "sampling.h"
#include "surface_shading.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Random pairs of a path: a few for the camera, then a block for each vertex.
const uint PAIR_FILTER = 0u;
const uint PAIRS_BEFORE_VERTICES = 4u;
const uint PAIRS_PER_VERTEX = 256u;
const uint PAIR_BSDF = 0u;      // direction
const uint PAIR_CHOICE = 1u;    // lobe; Russian roulette
const uint PAIR_EMITTER = 2u;   // which emitting triangle, and a point on it
const uint PAIR_PICK = 3u;      // digits for picks out of very many lights
const uint PAIR_LIGHTS = 4u;    // one for each lamp, or each pick and what it picks
const uint PAIR_WORLD = 253u;   // direction to the world
const uint PAIR_CLOSURE = 254u; // which closure of the surface
const uint PAIR_RAYS = 252u;    // rays of its program
const uint PAIR_SHADOW = 251u;  // which weak shadow rays are traced
const uint LAST_SHARED_PAIR = 248u;  // lamps beyond share them
FN uint vertex_pair(uint bounce, uint pair) { return PAIRS_BEFORE_VERTICES + bounce * PAIRS_PER_VERTEX + pair; }

struct IntegratorData {
  uint max_bounces;      // after the first hit; 0 = direct light
  uint diffuse_bounces;
  uint glossy_bounces;
  uint roulette_start;   // the bounce from which a path may end at random
  uint transparent_bounces;  // surfaces that let rays through, all along a path, shadow rays included
  uint transmission_bounces;
  float clamp_direct;    // of one contribution, the sum of its channels; INFINITE_DISTANCE: no limit
  float clamp_indirect;
  float shadow_roulette;  // 1 / the light below which a shadow ray is traced at random, 0: each is
  float filter_glossy;   // density from which on a bounce blurs what it meets, 0: none does
};

// Limits of transparent surfaces from here on are none.
const uint TRANSPARENT_UNLIMITED = 256u;

struct PathState {
  vec3 throughput;
  float pdf;             // with which the ray's direction was sampled; 0: camera ray or mirror
  vec3 normal;           // at the vertex that the ray left
  uint bounce;           // vertices before this ray
  uint diffuse_bounces;
  uint glossy_bounces;
  uint ray_kind;         // VISIBLE_* bit of the ray
  uint random;           // reversed sampler index
  uint transparent_bounces;  // surfaces that let the path through so far
  uint transmission_bounces;
  float kind_pdf;        // as pdf, and
  vec3 kind_weight;      // a factor on throughput: for light that rays of this kind alone see, see path_note_kind
  float passed;  // metres from the last vertex to the ray's origin, which lies on a surface that let it through
  float footprint;  // metres that the ray is wide at its origin
  uint vertex;  // surfaces that were shaded before this ray: counts the random numbers
  float min_pdf;  // of all bounces that were no mirror's
  float spread;   // by how much bounces widened the ray a metre on, with Filter Glossy: see path_widen
};

// Light that will arrive if nothing stands between the surface and the light.
struct ShadowRay {
  vec3 origin;
  float t_max;
  vec3 direction;
  int group;
  vec3 contribution;
  uint visibility;  // VISIBLE_SHADOW, 0 where the light casts no shadow, or the sets of a linked one
};

FN void path_begin(uint random, OUT(PathState) path) {
  path.throughput = vec3(1.0f);
  path.pdf = 0.0f;
  path.normal = vec3(0.0f, 0.0f, 1.0f);
  path.bounce = 0u;
  path.diffuse_bounces = 0u;
  path.glossy_bounces = 0u;
  path.ray_kind = VISIBLE_CAMERA | RAY_SHOWN;
  path.random = random;
  path.transparent_bounces = 0u;
  path.transmission_bounces = 0u;
  path.kind_pdf = 0.0f;
  path.kind_weight = vec3(1.0f);
  path.passed = 0.0f;
  path.footprint = 0.0f;
  path.vertex = 0u;
  path.min_pdf = INFINITE_DISTANCE;
  path.spread = 0.0f;
}

// Most light that a contribution to a vertex may bring; `bounce`: of that vertex, as PathState counts.
FN float light_limit(IN(IntegratorData) integrator, uint bounce) {
  return select(bounce > 0u, integrator.clamp_indirect, integrator.clamp_direct);
}

// What a path found by itself lights the vertex before: seen by the camera and after one bounce it is direct (Cycles).
FN float found_limit(IN(IntegratorData) integrator, IN(PathState) path) {
  return select(path.bounce > 1u, integrator.clamp_indirect, integrator.clamp_direct);
}

// Filter Glossy, at a vertex whose lobes are prepared.
FN void path_filter_glossy(IN(IntegratorData) integrator, IN(PathState) path, INOUT(Bsdf) bsdf, INOUT(Lobe) lobe) {
  const float alpha = glossy_blur(integrator.filter_glossy, path.min_pdf);
  if (!(alpha > 0.0f)) return;
  bsdf_blur(alpha, bsdf);
  if (has_lobe(lobe)) lobe_blur(alpha, lobe);
}

// Cycles' Filter Glossy widens rays as well, by which bump maps behind a bounce look flatter: by alpha a metre on
// (measured with 5.2.3, to 2 %), as many times as it is strong, at most once; the widest bounce counts.
FN void path_widen(IN(IntegratorData) integrator, float alpha, INOUT(PathState) path) {
  path.spread = max(path.spread, min(integrator.filter_glossy, 1.0f) * min(alpha, 1.0f));
}

// What shaders may ask of the path itself.
FN void path_counts(IN(PathState) path, INOUT(ShaderPoint) at) {
  at.ray_kind = path.ray_kind;
  at.bounce = path.bounce;
  at.diffuse_bounces = path.diffuse_bounces;
  at.glossy_bounces = path.glossy_bounces;
  at.transparent_bounces = path.transparent_bounces;
  at.transmission_bounces = path.transmission_bounces;
}

// By how much the path's ray widens a metre on. Rays of the camera are narrower where they lean from its axis: fine
// heights under a bump map show a thousandth of it. After a bounce nothing does, and the middle of the picture counts.
FN float path_spread(IN(SceneData) scene, IN(PathState) path, vec3 wo) {
  const float width = scene.camera_spread;
  if (path.bounce != 0u || scene.camera_orthographic != 0u) return width;
  const ObjectSpace space = scene.camera_space;
  const vec3 d = -vec3(dot(vec3(space.x.x, space.x.y, space.x.z), wo), dot(vec3(space.y.x, space.y.y, space.y.z), wo),
                       dot(vec3(space.z.x, space.z.y, space.z.z), wo));
  if (!(d.z > 1e-3f)) return width;
  const vec3 middle = d * (1.0f / d.z);
  float len;
  const vec3 n = safe_normalize(middle, len);
  const vec3 x = safe_normalize(middle + vec3(width, 0.0f, 0.0f), len) - n;
  const vec3 y = safe_normalize(middle + vec3(0.0f, width, 0.0f), len) - n;
  return 0.5f * (sqrt(dot(x, x)) + sqrt(dot(y, y)));
}

// The point of a surface that a path's ray met after t metres, as shaders see it.
FN ShaderPoint path_point(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, vec3 wo, float t) {
  ShaderPoint at = shader_point(s, wo, t);
  const float spread = path_spread(scene, path, wo);
  const bool orthographic = scene.camera_orthographic != 0u;
  at.footprint = path.footprint + select(orthographic, spread, 0.0f);
  at.footprint += max(select(orthographic, 0.0f, spread), path.spread) * t;
  path_counts(path, at);
  // Blocks of pixels share these numbers: they lie further apart than anyone sees.
  at.random = path.random;
  at.rays = sampler_pair_seed(scene.seed, vertex_pair(path.vertex, PAIR_RAYS)) | 1u;
  return at;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

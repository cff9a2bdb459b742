// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of a path: begin, escape, surface, light, bounce. A device runs them one after the other over many paths
// and traces rays in between; Direct is the path of length one. No tracing, no queues and no film here.
#ifndef COTORRA_INTEGRATOR_H
#define COTORRA_INTEGRATOR_H

#include "fireflies.h"
#include "light_program.h"
#include "light_shape.h"
#include "sampling.h"
#include "surface_shading.h"
#include "world_light.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Random pairs of a path: a few for the camera, then a block for each vertex.
const uint PAIR_FILTER = 0u;
const uint PAIRS_BEFORE_VERTICES = 4u;
const uint PAIRS_PER_VERTEX = 256u;
const uint PAIR_BSDF = 0u;      // direction
const uint PAIR_CHOICE = 1u;    // lobe; Russian roulette
const uint PAIR_EMITTER = 2u;   // point on an emitting triangle
const uint PAIR_PICK = 3u;      // which emitter; which lamp, where not all are sampled
const uint PAIR_LIGHTS = 4u;    // one for each lamp
const uint PAIR_WORLD = 253u;   // direction to the world
const uint PAIR_CLOSURE = 254u; // which closure of the surface
const uint PAIR_RAYS = 252u;    // rays of its program
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
};

// Light that will arrive if nothing stands between the surface and the light.
struct ShadowRay {
  vec3 origin;
  float t_max;
  vec3 direction;
  int group;
  vec3 contribution;
  uint visibility;  // VISIBLE_SHADOW, or 0 where the light casts no shadow
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
  const float spread = path_spread(scene, path, wo) * select(scene.camera_orthographic != 0u, 1.0f, t);
  at.footprint = path.footprint + spread;
  path_counts(path, at);
  // Blocks of pixels share these numbers: they lie further apart than anyone sees.
  at.random = path.random;
  at.rays = sampler_pair_seed(scene.seed, vertex_pair(path.vertex, PAIR_RAYS)) | 1u;
  return at;
}

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
  if (!seen || !light_intersect(light, origin, direction, t_max, path.normal, radiance, pdf)) return vec3(0.0f);
  // Where light sampling brings all of it, a bounce must not bring it again.
  const bool shared_work = FEATURE(FEATURE_BSDF_RAYS) && (path.ray_kind & RAY_MEETS_LAMPS) != 0u;
  if (path.bounce > 0u && !shared_work) return vec3(0.0f);
  if (FEATURE(FEATURE_LIGHT_SHAPES)) radiance *= scene_light_shape(scene, index, light, origin, direction);
  if ((light.flags & LIGHT_PROGRAM) != 0u) {
    const float t = path.passed + light_distance(light, origin, direction);
    radiance *= path_light_program(scene, index, light, path, origin - direction * path.passed, direction, t);
  }
  float found_pdf;
  const vec3 throughput = found_throughput(scene, path, light.visibility, found_pdf);
  return throughput * radiance * found_weight(found_pdf, pdf);
}

// What the background shows at one of its points.
FN vec3 world_radiance(IN(SceneData) scene, IN(ShaderPoint) at) {
  if (!FEATURE(FEATURE_PROGRAMS) || !PROGRAM_GROUP(GROUP_EMISSIONS) || scene.world_program.end == 0u) {
    return scene.world;
  }
  return light_numbers(program_value(scene, at, scene.world_program, scene.world_constants));
}

// The background, for a ray that met no surface.
FN vec3 path_escape(IN(SceneData) scene, IN(PathState) path, vec3 direction) {
  // It lights what the ray leaves: the vertex before this one. The camera always sees it.
  const bool lights = path.bounce == 0u || path.bounce - 1u <= scene.world_max_bounces;
  if ((scene.world_visibility & path.ray_kind) == 0u || !lights) return vec3(0.0f);
  float pdf;
  const vec3 throughput = found_throughput(scene, path, scene.world_sampled, pdf);
  float weight = 1.0f;
  if (FEATURE(FEATURE_WORLD_LIGHT) && pdf > 0.0f && (scene.world_sampled & path.ray_kind & VISIBLE_LIT) != 0u) {
    weight = found_weight(pdf, world_pdf(scene, direction));
  }
  ShaderPoint at = background_point(direction);
  path_counts(path, at);
  return throughput * world_radiance(scene, at) * weight;
}

// Light that the surface itself emits toward the ray's origin; `material` is the scene's record.
FN vec3 path_emission(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, IN(Material) material, vec3 wo, float t) {
  uint visibility = VISIBLE_ALL;
  if (scene.light_kinds != 0u) visibility = LOAD(scene.instances, s.instance).visibility;
  float pdf;
  const vec3 throughput = found_throughput(scene, path, visibility, pdf);
  float weight = 1.0f;
  if ((material.flags & MATERIAL_SAMPLED) != 0u) {
    // Light sampling picks a triangle in proportion to area x luminance, then a point uniformly.
    const float area_pdf = luminance(material.emission) * scene.emitter_norm;
    const float distance = path.passed + t;
    weight = found_weight(pdf, area_pdf * distance * distance / max(abs(dot(s.ng, wo)), 1e-8f));
  }
  const ShaderPoint at = path_point(scene, path, s, wo, t);
  return throughput * material_emission(scene, s.material, material, at) * weight;
}

// Amount by which a shadow ray's start is lifted onto the smooth surface, 0 to 1: full where the light is about to set
// behind the flat triangle, nothing where it stands high (Cycles' "geometry offset", cutoff 0.1 by default). 0 for a
// cutoff of 0.
FN float terminator_amount(float cutoff, float n_wi, float ng_wi) {
  const float a = abs(n_wi);
  const float g = select(n_wi < 0.0f, -ng_wi, ng_wi);
  const float inverse = 1.0f / max(cutoff, 1e-6f);
  const float amount = select(a < cutoff, 2.0f - (g + a) * inverse, 1.0f - g * inverse);
  return select(cutoff > 0.0f, clamp(amount, 0.0f, 1.0f), 0.0f);
}

FN vec3 shadow_ray_origin(IN(SceneData) scene, IN(Surface) s, vec3 wi) {
  const float amount = terminator_amount(s.terminator, dot(s.n, wi), dot(s.ng, wi));
  vec3 origin = surface_start(scene, s, wi);
  // Light from behind starts behind, where nothing lifts it.
  if (amount > 0.0f && dot(s.n, wi) > 0.0f)
    origin += surface_smooth_lift(scene, s.instance, s.triangle, s.u, s.v, s.ng) * amount;
  return origin;
}

// Takes note of what the ray would carry if it were of a scene without the other kind of lobe: light that rays of its
// kind alone see must not be weighed with lobes that it is hidden from. The lobe's own sample is throughput x
// kind_weight, its density kind_pdf.
FN void path_note_kind(IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo, vec3 wi, INOUT(PathState) path) {
  if (!(path.pdf > 0.0f) || has_lobe(lobe)) return;  // a mirror's ray is its own, and so is that of one lobe
  float all_pdf;
  const vec3 all = visible_bsdf(bsdf, wo, wi, VISIBLE_SCATTERED, all_pdf);
  const vec3 own = visible_bsdf(bsdf, wo, wi, path.ray_kind, path.kind_pdf);
  const float scale = select(path.kind_pdf > 0.0f, all_pdf / max(path.kind_pdf, 1e-30f), 0.0f);
  path.kind_weight = own * scale / max(all, vec3(1e-30f));
}

// What one sample of a lamp brings to the surface if nothing stands between. Without branches on the point, so that a
// loop over many points vectorises. `scale` is 1 / probability of having chosen the lamp.
FN vec3 light_contribution(IN(Light) light, IN(LightSample) l, IN(Bsdf) bsdf, vec3 wo, vec3 throughput, float scale) {
  float bsdf_pdf;
  const vec3 f = visible_bsdf(bsdf, wo, l.wi, light.visibility, bsdf_pdf);
  float weight = scale;
  if (FEATURE(FEATURE_BSDF_RAYS) && (light.flags & LIGHT_VISIBLE) != 0u) {
    // Only sharp highlights share the work with bounces; elsewhere light sampling does all of it.
    weight *= select((bsdf.lobes & BSDF_SHARP) != 0u, power_heuristic(l.pdf, bsdf_pdf), 1.0f);
  }
  return throughput * f * l.weight * weight;
}

// The same of a Lobe.
FN vec3 lobe_light_contribution(IN(SceneData) scene, IN(Light) light, IN(LightSample) l, IN(Bsdf) bsdf, IN(Lobe) lobe,
                                vec3 wo, vec3 throughput, float scale) {
  float pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, l.wi, light.visibility, pdf);
  const bool shared_work = (light.flags & LIGHT_VISIBLE) != 0u && !lobe_is_diffuse(lobe);
  const float weight = FEATURE(FEATURE_BSDF_RAYS) && shared_work ? scale * power_heuristic(l.pdf, pdf) : scale;
  return throughput * f * l.weight * weight;
}

// The shadow ray of a lamp's sample. Returns false where there is nothing to bring.
FN bool light_shadow_ray(IN(SceneData) scene, IN(Light) light, IN(Surface) s, uint bounce, vec3 wi, float distance,
                         vec3 contribution, OUT(ShadowRay) ray) {
  ray.contribution = contribution;
  ray.direction = wi;
  ray.t_max = distance;
  ray.group = light.group;
  ray.visibility = select((light.flags & LIGHT_CAST_SHADOW) != 0u, VISIBLE_SHADOW, 0u);
  ray.origin = s.p;
  if (bounce > light.max_bounces || !(max_component(contribution) > 0.0f)) return false;
  ray.origin = shadow_ray_origin(scene, s, wi);
  return true;
}

// The surface without what a normal map did to it: where shadow rays start is a question of its shape.
FN Surface smooth_surface(IN(Surface) s, IN(Bsdf) bsdf) {
  Surface bare = s;
  if (FEATURE(FEATURE_PROGRAMS)) bare.n = bsdf.n_smooth;
  return bare;
}

// One sample of lamp `index`. Returns false where nothing can arrive.
FN bool path_sample_light(IN(SceneData) scene, uint index, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf,
                          IN(Lobe) lobe, vec3 wo, vec2 u, float scale, OUT(ShadowRay) ray) {
  const Light light = LOAD(scene.lights, index);
  LightSample l;
  light_sample(light, s.p, s.n, u, l);
  if (FEATURE(FEATURE_LIGHT_SHAPES)) l.weight *= scene_light_shape(scene, index, light, s.p, l.wi);
  l.weight *= path_light_program(scene, index, light, path, s.p, l.wi, l.distance);
  vec3 contribution;
  if (has_lobe(lobe)) {
    contribution = lobe_light_contribution(scene, light, l, bsdf, lobe, wo, path.throughput, scale);
  } else {
    contribution = light_contribution(light, l, bsdf, wo, path.throughput, scale);
  }
  const Surface start = smooth_surface(s, bsdf);
  return light_shadow_ray(scene, light, start, path.bounce, l.wi, l.distance, contribution, ray);
}

// A quick bound of what lamp `index` without its program may contribute at the surface, to choose lamps by;
// `both_sides`: light from behind counts as well.
FN float light_bound(IN(SceneData) scene, uint index, IN(Surface) s, bool both_sides) {
  Light light = LOAD(scene.lights, index);
  if (light.type == LIGHT_SUN) {
    const float size = select(light.radius > 0.0f, 2.0f * PI * light.radius, 1.0f);
    const float c = -dot(s.n, light.axis);
    return luminance(light.radiance) * size * max((both_sides ? abs(c) : c) + sqrt(2.0f * light.radius), 0.0f);
  }
  float d;
  const vec3 wi = safe_normalize(light.position - s.p, d);
  if (FEATURE(FEATURE_AREA_LIGHTS) && light.type == LIGHT_AREA) {
    const float facing = both_sides ? abs(dot(s.n, wi)) : max(dot(s.n, wi), 0.0f);
    const float widest = min(facing + light.radius / max(d, 1e-6f), 1.0f);
    return luminance(light.radiance) * area_light_importance(light, s.p) * widest;
  }
  const float r2 = light.radius * light.radius;
  const float power = luminance(light.radiance) * select(light.radius > 0.0f, PI * r2, 1.0f);
  // The widest cosine that the light's disk can show.
  const float c = dot(s.n, wi);
  const float cosine = min(max(both_sides ? abs(c) : c, 0.0f) + light.radius / max(d, 1e-6f), 1.0f);
  // Points of a lamp of size send light past the edge of the cone about its centre: cos(a - b) <= cos a + sin b.
  light.cos_spot -= light.radius / max(d, 1e-6f);
  float spot = light.type == LIGHT_SPOT && light.radius < d ? spot_attenuation(light, wi) : 1.0f;
  if (FEATURE(FEATURE_LIGHT_SHAPES) && (light.flags & LIGHT_SHAPED) != 0u) {
    const LightShape shape = LOAD(scene.light_shapes, index);
    // A lamp of size may reach past its edge to where its centre does not.
    spot *= light_falloff(shape, d) * (light.radius > 0.0f ? 1.0f : light_spot_edge(shape, light, wi));
  }
  return power * cosine * spot / (d * d + r2 + 1e-12f);
}

// With what its program sends out on average.
FN float light_importance(IN(SceneData) scene, uint index, IN(Surface) s, bool both_sides) {
  const float bound = light_bound(scene, index, s, both_sides);
  if ((LOAD(scene.lights, index).flags & LIGHT_PROGRAM) == 0u) return bound;
  return bound * LOAD(scene.light_programs, index).mean;
}

// One lamp out of many, in proportion to its importance, by reservoir sampling with one number.
// Returns its index, INVALID_ID where none can contribute; `scale` is 1 / probability.
FN uint path_pick_light(IN(SceneData) scene, IN(Surface) s, bool both_sides, float u, OUT(float) scale) {
  float sum = 0.0f;
  float chosen = 0.0f;
  uint pick = INVALID_ID;
  for (uint i = 0u; i < scene.light_count; ++i) {
    const float w = light_importance(scene, i, s, both_sides);
    sum += w;
    const float p = sum > 0.0f ? w / sum : 0.0f;
    if (u < p) {
      pick = i;
      chosen = w;
      u = u / p;
    } else {
      u = (u - p) / max(1.0f - p, 1e-8f);
    }
    u = min(u, 0.99999994f);
  }
  scale = chosen > 0.0f ? sum / chosen : 0.0f;
  return chosen > 0.0f ? pick : INVALID_ID;
}

// What an emitting triangle sends out along -wi at barycentric coordinates b, and is not let through there. As in
// Cycles, it knows the number of bounces and not the kind of ray.
FN vec3 emitter_radiance(IN(SceneData) scene, IN(PathState) path, IN(Emitter) e, vec2 b, vec3 wi, float distance) {
  if (!FEATURE(FEATURE_PROGRAMS | FEATURE_TRANSPARENCY)) return e.radiance;
  const Material material = LOAD(scene.materials, e.material);
  Hit hit;
  hit.t = distance;
  hit.u = b.x;
  hit.v = b.y;
  hit.triangle = e.triangle;
  hit.instance = e.instance;
  Surface s;
  surface_from_hit(scene, hit, wi, s);
  ShaderPoint at = shader_point(s, -wi, distance);
  path_counts(path, at);
  at.ray_kind = 0u;  // no ray came here, says Cycles, but it would be one bounce on
  at.bounce += 1u;
  const vec3 radiance = material_emission(scene, e.material, material, at);
  if ((material.flags & (MATERIAL_TRANSPARENT | MATERIAL_TINTED)) != MATERIAL_TRANSPARENT) return radiance;
  return radiance * (1.0f - material_transparency(scene, e.material, at).x);
}

// One sample of the emitting triangles.
FN bool path_sample_emitter(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf, IN(Lobe) lobe,
                            vec3 wo, float u_pick, vec2 u, OUT(ShadowRay) ray) {
  // 1. Pick a triangle by the cumulated distribution.
  uint first = 0u;
  uint last = scene.emitter_count - 1u;
  while (first < last) {
    const uint middle = (first + last) / 2u;
    if (u_pick < LOAD(scene.emitters, middle).cdf) {
      last = middle;
    } else {
      first = middle + 1u;
    }
  }
  const Emitter e = LOAD(scene.emitters, first);
  // 2. A point on it.
  const vec2 b = triangle_from_square(u);
  const vec3 q = e.v0 + e.edge1 * b.x + e.edge2 * b.y;
  float d;
  const vec3 wi = safe_normalize(q - s.p, d);
  const float cos_light = abs(dot(e.normal, wi));
  const float area_pdf = luminance(e.radiance) * scene.emitter_norm;
  const float pdf = area_pdf * d * d / max(cos_light, 1e-8f);
  float bsdf_pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, wi, e.visibility, bsdf_pdf);
  const vec3 radiance = emitter_radiance(scene, path, e, b, wi, d);
  ray.contribution = path.throughput * f * radiance * (power_heuristic(pdf, bsdf_pdf) / pdf);
  ray.direction = wi;
  ray.group = e.group;
  ray.visibility = VISIBLE_SHADOW;
  ray.t_max = 0.0f;
  ray.origin = s.p;
  const bool self = e.instance == s.instance && e.triangle == s.triangle;
  if (self || cos_light < 1e-8f || !(max_component(ray.contribution) > 0.0f)) return false;
  // 3. Aim from the lifted start at the point itself, and stop short of it.
  ray.origin = shadow_ray_origin(scene, smooth_surface(s, bsdf), wi);
  ray.direction = safe_normalize(q - ray.origin, d);
  ray.t_max = d * 0.9999f;
  return true;
}

// The background along wi, as a ray shows it that left the surface for it.
FN ShaderPoint path_world_point(IN(SceneData) scene, IN(PathState) path, IN(Lobe) lobe, vec3 wi) {
  ShaderPoint at = background_point(wi);
  path_counts(path, at);
  uint kind = select((scene.world_sampled & VISIBLE_DIFFUSE) != 0u, VISIBLE_DIFFUSE, VISIBLE_GLOSSY);
  if (has_lobe(lobe)) kind = lobe_ray_kind(lobe, wi);
  at.ray_kind = select(kind == VISIBLE_TRANSMISSION, kind, kind | RAY_REFLECTED);
  at.bounce += 1u;
  if (kind == VISIBLE_DIFFUSE) at.diffuse_bounces += 1u;
  if (kind == VISIBLE_GLOSSY) at.glossy_bounces += 1u;
  if (kind == VISIBLE_TRANSMISSION) at.transmission_bounces += 1u;
  return at;
}

// One sample of the background by its table.
FN bool path_sample_world(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo,
                          vec2 u, OUT(ShadowRay) ray) {
  float pdf;
  const vec3 wi = world_sample(scene, u, pdf);
  float bsdf_pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, wi, scene.world_sampled, bsdf_pdf);
  ray.contribution = vec3(0.0f);
  ray.direction = wi;
  ray.t_max = INFINITE_DISTANCE;
  ray.group = scene.world_group;
  ray.visibility = VISIBLE_SHADOW;
  ray.origin = s.p;
  if (path.bounce > scene.world_max_bounces || !(pdf > 0.0f) || !(max_component(f) > 0.0f)) return false;
  const vec3 radiance = world_radiance(scene, path_world_point(scene, path, lobe, wi));
  ray.contribution = path.throughput * f * radiance * (power_heuristic(pdf, bsdf_pdf) / pdf);
  if (!(max_component(ray.contribution) > 0.0f)) return false;
  ray.origin = shadow_ray_origin(scene, smooth_surface(s, bsdf), wi);
  return true;
}

// Directions of a lower density are so wide that nobody sees a bevelled edge in them (Cycles' bound).
const float BLURRED_PDF = 8.0f;

// A ray grows no narrower on its way.
FN void path_leave(IN(SceneData) scene, float spread, INOUT(PathState) path, IN(Surface) s) {
  if (scene.camera_orthographic == 0u) path.footprint += spread * s.t;
  path.vertex += 1u;
}

// Takes a path on along a sampled direction. Returns false where it ends.
FN bool path_advance(IN(SceneData) scene, IN(IntegratorData) integrator, INOUT(PathState) path, IN(Surface) s,
                     IN(BsdfSample) b, float u_roulette, OUT(vec3) origin) {
  origin = s.p;
  const bool through = FEATURE(FEATURE_LOBES) && (b.lobe & BSDF_TRANSMIT) != 0u;
  // What is reflected below the flat triangle would only meet the surface from inside, and the other way round.
  if (!(b.pdf > 0.0f) || dot(b.wi, s.ng) * select(through, -1.0f, 1.0f) <= 0.0f) return false;
  path.throughput *= b.weight;
  const bool singular = (b.lobe & BSDF_SINGULAR) != 0u;
  path.pdf = select(singular, 0.0f, b.pdf);
  if (!singular) path.min_pdf = min(path.min_pdf, b.pdf);
  const uint shown = path.ray_kind & RAY_SHOWN;
  path.kind_pdf = path.pdf;
  path.kind_weight = vec3(1.0f);
  path.normal = select(through, -s.n, s.n);
  path.bounce += 1u;
  uint blurred = path.ray_kind & RAY_BLURRED;
  if (path.pdf > 0.0f && path.pdf < BLURRED_PDF) blurred = RAY_BLURRED;
  if (through) {
    path.transmission_bounces += 1u;
    path.ray_kind = VISIBLE_TRANSMISSION;
  } else if ((b.lobe & BSDF_DIFFUSE) != 0u) {
    path.diffuse_bounces += 1u;
    path.ray_kind = VISIBLE_DIFFUSE;
  } else {
    path.glossy_bounces += 1u;
    path.ray_kind = VISIBLE_GLOSSY;
  }
  if ((b.lobe & BSDF_SHARP) != 0u) path.ray_kind |= RAY_MEETS_LAMPS;
  if (singular) path.ray_kind |= RAY_SINGULAR;
  if (!through) path.ray_kind |= RAY_REFLECTED;
  path.ray_kind |= shown | blurred;
  // Russian roulette: survive in proportion to what the path still carries, as it will look (square root).
  if (path.bounce >= integrator.roulette_start) {
    const float survival = min(sqrt(max_component(path.throughput)), 1.0f);
    if (u_roulette >= survival) return false;
    path.throughput = path.throughput / survival;
  }
  origin = surface_start(scene, s, b.wi);
  path_leave(scene, scene.camera_spread, path, s);
  path.passed = 0.0f;
  return max_component(path.throughput) > 0.0f;
}

// Takes a path straight on through a surface that lets it through: no vertex of the path, for what comes after.
FN bool path_pass(IN(SceneData) scene, INOUT(PathState) path, IN(Surface) s, vec3 wo, OUT(vec3) origin) {
  origin = surface_ray_origin(s.p, s.ng, s.epsilon, -wo);
  path.passed += s.t;
  path.transparent_bounces += 1u;
  path_leave(scene, path_spread(scene, path, wo), path, s);
  return max_component(path.throughput) > 0.0f;
}

// Transparent surfaces that a path may cross on its way to a surface: one in any case, as in Cycles.
FN uint path_crossings(IN(IntegratorData) integrator) { return max(integrator.transparent_bounces, 1u); }

// Has a path that crossed so many surfaces come too far, even to bring light home?
FN bool path_crossed_too_many(IN(IntegratorData) integrator, uint crossed) {
  return crossed > path_crossings(integrator) && integrator.transparent_bounces < TRANSPARENT_UNLIMITED;
}

// What a shadow ray leaves of its light after `crossed` surfaces, those of its path included, if they leave `kept`.
FN float shadow_kept(IN(IntegratorData) integrator, uint crossed, float kept) {
  const uint limit = integrator.transparent_bounces;
  return select(crossed > limit && limit < TRANSPARENT_UNLIMITED, 0.0f, kept);
}

// True past the last bounce, and behind as many transparent surfaces as the path may cross: the hit adds emission only.
FN bool path_is_last(IN(IntegratorData) integrator, IN(PathState) path) {
  return path.bounce > integrator.max_bounces || path.diffuse_bounces > integrator.diffuse_bounces ||
         path.glossy_bounces > integrator.glossy_bounces ||
         path.transmission_bounces > integrator.transmission_bounces ||
         path_crossed_too_many(integrator, path.transparent_bounces + 1u);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

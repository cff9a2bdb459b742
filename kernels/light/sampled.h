// SPDX-License-Identifier: GPL-3.0-or-later
// Light that is sampled at a vertex: of one lamp, of an emitting triangle, of the background; and which lamp it is
// where not all are sampled. What comes of it is a shadow ray; it is traced elsewhere.
#ifndef COTORRA_SAMPLED_H
#define COTORRA_SAMPLED_H

#include "found.h"

#ifdef __cplusplus
namespace cotorra {
#endif

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
  if (bounce > light.max_bounces || !carries_light(contribution)) return false;
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
    return luminance(abs(light.radiance)) * size * max((both_sides ? abs(c) : c) + sqrt(2.0f * light.radius), 0.0f);
  }
  float d;
  const vec3 wi = safe_normalize(light.position - s.p, d);
  if (FEATURE(FEATURE_AREA_LIGHTS) && light.type == LIGHT_AREA) {
    const float facing = both_sides ? abs(dot(s.n, wi)) : max(dot(s.n, wi), 0.0f);
    const float widest = min(facing + light.radius / max(d, 1e-6f), 1.0f);
    return luminance(abs(light.radiance)) * area_light_importance(light, s.p) * widest;
  }
  const float r2 = light.radius * light.radius;
  const float power = luminance(abs(light.radiance)) * select(light.radius > 0.0f, PI * r2, 1.0f);
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
  if (self || cos_light < 1e-8f || !carries_light(ray.contribution)) return false;
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
  if (!carries_light(ray.contribution)) return false;
  ray.origin = shadow_ray_origin(scene, smooth_surface(s, bsdf), wi);
  return true;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Light that is sampled at a vertex: of one lamp, of an emitting triangle, of the background; and which light it is
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
  const float n_wi = dot(s.n, wi);
  const float amount = terminator_amount(s.terminator, n_wi, dot(s.ng, wi));
  vec3 origin = surface_start(scene, s, wi);
  // Light from behind the smooth surface starts behind it: what shades it there is the surface itself (Cycles).
  const vec3 up = select(n_wi < 0.0f, -s.ng, s.ng);
  if (amount > 0.0f) origin += surface_smooth_lift(scene, s.instance, s.triangle, s.u, s.v, up) * amount;
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
// loop over many points vectorises. `scale` is 1 / the number of samples that take the lamp, on
// average.
FN vec3 light_contribution(IN(Light) light, IN(LightSample) l, IN(Bsdf) bsdf, vec3 wo, vec3 throughput, float scale) {
  float bsdf_pdf;
  const vec3 f = visible_bsdf(bsdf, wo, l.wi, light.visibility, bsdf_pdf);
  float weight = scale;
  if (FEATURE(FEATURE_BSDF_RAYS) && (light.flags & LIGHT_VISIBLE) != 0u) {
    // Only sharp highlights share the work with bounces; elsewhere light sampling does all of it.
    weight *= select((bsdf.lobes & BSDF_SHARP) != 0u, power_heuristic(l.pdf / scale, bsdf_pdf), 1.0f);
  }
  return throughput * f * l.weight * weight;
}

// The same of a Lobe.
FN vec3 lobe_light_contribution(IN(SceneData) scene, IN(Light) light, IN(LightSample) l, IN(Bsdf) bsdf, IN(Lobe) lobe,
                                vec3 wo, vec3 throughput, float scale) {
  float pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, l.wi, light.visibility, pdf);
  const bool shared_work = (light.flags & LIGHT_VISIBLE) != 0u && !lobe_is_diffuse(lobe);
  const float weight = FEATURE(FEATURE_BSDF_RAYS) && shared_work ? scale * power_heuristic(l.pdf / scale, pdf) : scale;
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
  if (!light_lights(scene, index, receiver_set(scene, s.instance))) contribution = vec3(0.0f);
  const Surface start = smooth_surface(s, bsdf);
  const bool sent = light_shadow_ray(scene, light, start, path.bounce, l.wi, l.distance, contribution, ray);
  if (has_links(scene) && ray.visibility != 0u) ray.visibility = light_shadows(scene, index);
  return sent;
}

// What an emitting triangle sends out along -wi to the surface at barycentric coordinates b, and is not let through
// there. As in Cycles, it knows the number of bounces and not the kind of ray; it is as wide as a ray from there, so
// that bumps and edges are those that rays find.
FN vec3 emitter_radiance(IN(SceneData) scene, IN(PathState) path, IN(Surface) from, vec3 wo, IN(Emitter) e, vec2 b,
                         vec3 wi, float distance) {
  const uint index = e.material & EMITTER_MATERIAL;
  const Material material = LOAD(scene.materials, index);
  const uint varies = MATERIAL_PROGRAM | MATERIAL_TRANSPARENT | MATERIAL_TINTED;
  if (!FEATURE(FEATURE_PROGRAMS | FEATURE_TRANSPARENCY) || (material.flags & varies) == 0u) return material.emission;
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
  at.footprint = path.footprint + scene.camera_spread;
  if (scene.camera_orthographic == 0u) {
    at.footprint = path.footprint + path_spread(scene, path, wo) * from.t + scene.camera_spread * distance;
  }
  const vec3 radiance = material_emission(scene, index, material, at);
  if ((material.flags & (MATERIAL_TRANSPARENT | MATERIAL_TINTED)) != MATERIAL_TRANSPARENT) return radiance;
  return radiance * (1.0f - material_transparency(scene, index, at).x);
}

// One sample of emitting triangle `index`; `scale` is 1 / the number of samples that take it, on average.
FN bool path_sample_emitter(IN(SceneData) scene, uint index, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf,
                            IN(Lobe) lobe, vec3 wo, vec2 u, float scale, OUT(ShadowRay) ray) {
  const Emitter e = LOAD(scene.emitters, index);
  const Instance instance = LOAD(scene.instances, e.instance);
  // 1. A point on it.
  float twice_area;
  const vec3 normal = safe_normalize(cross(e.edge1, e.edge2), twice_area);
  TriangleView view;
  triangle_view(e.v0 - s.p, e.edge1, e.edge2, view);
  const vec2 b = triangle_light_sample(view, e.v0 - s.p, e.edge1, e.edge2, u);
  const vec3 q = e.v0 + e.edge1 * b.x + e.edge2 * b.y;
  float d;
  const vec3 wi = safe_normalize(q - s.p, d);
  const float against = dot(normal, wi);
  const float cos_light = abs(against);
  ray.contribution = vec3(0.0f);
  ray.direction = wi;
  ray.group = instance.light_group;
  ray.visibility = light_shadows(scene, scene.light_count + e.instance);
  ray.t_max = 0.0f;
  ray.origin = s.p;
  const uint dark = select(against < 0.0f, EMITTER_DARK_ALONG, EMITTER_DARK_AGAINST);
  const bool self = e.instance == s.instance && e.triangle == s.triangle;
  if (self || cos_light < 1e-8f || (e.material & dark) != 0u) return false;
  if (!light_lights(scene, scene.light_count + e.instance, receiver_set(scene, s.instance))) return false;
  // 2. What it brings.
  const float pdf = triangle_light_pdf(view, twice_area, d, cos_light) / scale;
  float bsdf_pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, wi, instance.visibility, bsdf_pdf);
  if (!carries_light(f)) return false;
  const vec3 radiance = emitter_radiance(scene, path, s, wo, e, b, wi, d);
  ray.contribution = path.throughput * f * radiance * (power_heuristic(pdf, bsdf_pdf) / pdf);
  if (!carries_light(ray.contribution)) return false;
  // 3. Aim from the lifted start at the point itself, and stop short of it.
  ray.origin = shadow_ray_origin(scene, smooth_surface(s, bsdf), wi);
  ray.direction = safe_normalize(q - ray.origin, d);
  ray.t_max = d * 0.9999f;
  return true;
}

FN LightReceiver light_receiver(IN(SceneData) scene, IN(Surface) s, IN(Lobe) lobe) {
  LightReceiver at;
  at.p = s.p;
  at.n = s.n;
  at.both_sides = select(scatters_through(lobe), 1u, 0u);
  at.set = receiver_set(scene, s.instance);
  return at;
}

// Weights of the tree's first choice, which all light samples of a vertex share.
FN LightWeights path_light_weights(IN(SceneData) scene, IN(Surface) s, IN(Lobe) lobe) {
  return light_weights(scene, 0u, light_receiver(scene, s, lobe));
}

// Sample number `slot` of `slots` lights that the tree picks at a vertex; INVALID_ID where there is none. The first of
// `u` picks, stratified over the slots; what is left of both is a point of the square for the light's own sample.
FN uint path_pick_light(IN(SceneData) scene, IN(Surface) s, IN(Lobe) lobe, IN(LightWeights) root, uint slot, uint slots,
                        float fresh, INOUT(vec2) u, OUT(float) scale) {
  float probability;
  u.x = min((float(int(slot)) + u.x) / float(int(slots)), 0.99999994f);
  const uint light = light_tree_pick(scene, light_receiver(scene, s, lobe), root, u.x, fresh, probability);
  scale = 1.0f / max(probability * float(int(slots)), 1e-30f);
  return light;
}

// One sample of a light as the tree names it.
FN bool path_sample_picked(IN(SceneData) scene, uint light, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf,
                           IN(Lobe) lobe, vec3 wo, vec2 u, float scale, OUT(ShadowRay) ray) {
  const uint index = light & LIGHT_CHILD_INDEX;
  if ((light & LIGHT_CHILD_LAMPS) != 0u) {
    return path_sample_light(scene, index, path, s, bsdf, lobe, wo, u, scale, ray);
  }
  ray.origin = s.p;
  ray.t_max = 0.0f;
  ray.direction = s.n;
  ray.group = -1;
  ray.contribution = vec3(0.0f);
  ray.visibility = 0u;
  // Those of the integrators that look at lamps alone have no emitters.
  if (!FEATURE(FEATURE_EMISSIVE_MESHES) || index >= scene.emitter_count) return false;
  return path_sample_emitter(scene, index, path, s, bsdf, lobe, wo, u, scale, ray);
}

// The background along wi, as a ray shows it that left the surface for it.
FN ShaderPoint path_world_point(IN(SceneData) scene, IN(PathState) path, IN(Lobe) lobe, vec3 wi) {
  ShaderPoint at = background_point(wi);
  path_counts(path, at);
  uint kind = select((scene.world_sampled & VISIBLE_DIFFUSE) != 0u, VISIBLE_DIFFUSE, VISIBLE_GLOSSY);
  if (has_lobe(lobe)) kind = lobe_ray_kind(lobe, wi);
  const uint diffuse_through = select(lobe_is_diffuse(lobe), RAY_DIFFUSE_THROUGH, 0u);
  at.ray_kind = kind | select(kind == VISIBLE_TRANSMISSION, diffuse_through, RAY_REFLECTED);
  at.bounce += 1u;
  if (kind == VISIBLE_DIFFUSE) at.diffuse_bounces += 1u;
  if (kind == VISIBLE_GLOSSY) at.glossy_bounces += 1u;
  if (kind == VISIBLE_TRANSMISSION) at.transmission_bounces += 1u;
  return at;
}

// f cos toward a direction that the background's table drew with density `pdf`, as a sample of it counts: the BSDF's
// own rays, of density bsdf_pdf, find it as well.
FN vec3 world_share(vec3 f, float bsdf_pdf, float pdf) {
  return f * select(pdf > 0.0f, power_heuristic(pdf, bsdf_pdf) / pdf, 0.0f);
}

// The shadow ray of such a sample, from the surface without what a normal map did to it. Returns false where there is
// nothing to bring.
FN bool world_shadow_ray(IN(SceneData) scene, IN(Surface) bare, vec3 wi, vec3 contribution, OUT(ShadowRay) ray) {
  ray.contribution = contribution;
  ray.direction = wi;
  ray.t_max = INFINITE_DISTANCE;
  ray.group = scene.world_group;
  ray.visibility = VISIBLE_SHADOW;
  ray.origin = bare.p;
  if (!carries_light(contribution)) return false;
  ray.origin = shadow_ray_origin(scene, bare, wi);
  return true;
}

// One sample of the background by its table.
FN bool path_sample_world(IN(SceneData) scene, IN(PathState) path, IN(Surface) s, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo,
                          vec2 u, OUT(ShadowRay) ray) {
  float pdf;
  const vec3 wi = world_sample(scene, u, pdf);
  float bsdf_pdf;
  const vec3 f = visible_scattering(scene, bsdf, lobe, wo, wi, scene.world_sampled, bsdf_pdf);
  vec3 light = path.throughput * world_share(f, bsdf_pdf, pdf);
  if (path.bounce > scene.world_max_bounces) light = vec3(0.0f);
  if (carries_light(light)) light *= world_radiance(scene, path_world_point(scene, path, lobe, wi));
  return world_shadow_ray(scene, smooth_surface(s, bsdf), wi, light, ray);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

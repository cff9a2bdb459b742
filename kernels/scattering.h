// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface scatters at a vertex of a path: a Bsdf of bsdf.h, or, where one is set, the Lobe that was picked of
// it. Which rays see which part, and where they start, is decided here for both; light and paths are integrator.h's.
#ifndef COTORRA_SCATTERING_H
#define COTORRA_SCATTERING_H

#include "closure/principled.h"
#include "surface.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN bool has_lobe(IN(Lobe) lobe) { return FEATURE(FEATURE_LOBES) && lobe.kind != LOBE_NONE; }

// Does light from behind the surface reach the viewer?
FN bool scatters_through(IN(Lobe) lobe) { return has_lobe(lobe) && lobe_transmits(lobe); }

FN bool lobe_is_diffuse(IN(Lobe) l) {
  return l.kind == LOBE_DIFFUSE || l.kind == LOBE_TRANSLUCENT || l.kind == LOBE_SHEEN || l.kind == LOBE_VELVET ||
         l.kind == LOBE_TOON_DIFFUSE;
}

// The kind of ray that leaves the lobe toward wi.
FN uint lobe_ray_kind(IN(Lobe) l, vec3 wi) {
  if (lobe_transmits(l) && dot(l.n, wi) < 0.0f) return VISIBLE_TRANSMISSION;
  return lobe_is_diffuse(l) ? VISIBLE_DIFFUSE : VISIBLE_GLOSSY;
}

// What a bent normal leaves of light from wi (Cycles): nothing where it and the smooth one disagree whether wi lies in
// front, nor from behind where the lobe only reflects; of diffuse lobes, velvet excepted, what bump_shadowing_of
// leaves. `sampled`: of a ray that was sampled of the lobe, where highlights and what goes through pass
// (glossy_cosine).
FN float lobe_bump_shadowing(IN(Bsdf) bsdf, IN(Lobe) l, vec3 wi, bool sampled) {
  if (!FEATURE(FEATURE_PROGRAMS)) return 1.0f;
  const bool dims = lobe_is_diffuse(l) && l.kind != LOBE_VELVET;
  if (sampled && (!dims || lobe_transmits(l))) return 1.0f;
  const float height = dot(bsdf.n_smooth, wi);
  const float side = height * dot(bsdf.n_smooth, l.n) * dot(l.n, wi);
  if (side < 0.0f || (height < 0.0f && !lobe_transmits(l))) return 0.0f;
  return dims ? bump_shadowing_of(l.n, bsdf.n_smooth, wi) : 1.0f;
}

// f cos toward wi, without the lobes that the light is hidden from; pdf is that of rays that see the light.
FN vec3 visible_bsdf(IN(Bsdf) bsdf, vec3 wo, vec3 wi, uint visibility, OUT(float) pdf) {
  vec3 glossy;
  float all;
  const vec3 diffuse = bsdf_eval_lobes(bsdf, wo, wi, false, glossy, all);
  const bool to_diffuse = (visibility & VISIBLE_DIFFUSE) != 0u;
  const bool to_glossy = (visibility & VISIBLE_GLOSSY) != 0u;
  const float part = min(bsdf_diffuse_pdf(bsdf, wi), all);
  pdf = select(to_diffuse, select(to_glossy, all, part), select(to_glossy, all - part, 0.0f));
  return select(to_diffuse, diffuse, vec3(0.0f)) + select(to_glossy, glossy, vec3(0.0f));
}

// The same of a Lobe where there is one.
FN vec3 visible_scattering(IN(SceneData) scene, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo, vec3 wi, uint visibility,
                           OUT(float) pdf) {
  if (!has_lobe(lobe)) return visible_bsdf(bsdf, wo, wi, visibility, pdf);
  pdf = 0.0f;
  if ((visibility & lobe_ray_kind(lobe, wi)) == 0u) return vec3(0.0f);
  return lobe_eval(scene.albedo, lobe, wo, wi, pdf) * lobe_bump_shadowing(bsdf, lobe, wi, false);
}

// A direction. Highlights of lobes meet lamps themselves: how sharp they are is not known beforehand.
FN void scattering_sample(IN(SceneData) scene, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo, float u_lobe, vec2 u,
                          OUT(BsdfSample) s) {
  if (!has_lobe(lobe)) {
    bsdf_sample(bsdf, wo, u_lobe, u, s);
    return;
  }
  lobe_sample(scene.albedo, lobe, wo, u_lobe, u, s);
  s.weight *= lobe_bump_shadowing(bsdf, lobe, s.wi, true);
  if (!lobe_is_diffuse(lobe)) s.lobe |= BSDF_SHARP;
  if (FEATURE(FEATURE_PROGRAMS) && !lobe_transmits(lobe) && bsdf_hides(bsdf, lobe.n, s.wi)) s.lobe |= BSDF_HIDDEN;
}

// Do rays start at the very point of the surface that they leave?
FN bool starts_at_point(IN(SceneData) scene, uint instance) {
  return FEATURE(FEATURE_LOBES | FEATURE_TRANSPARENCY) && scene.starts_at_point != 0u &&
         (LOAD(scene.instances, instance).flags & INSTANCE_COPLANAR) != 0u;
}

// Where a ray in direction wi leaves the surface: lifted off it; or, where light goes through surfaces, at the point
// itself, so that it meets others in the very same plane, such as a floor that glass stands on (as in Cycles). The
// surface's own triangle is left out by who traces. Rounding may have put p behind the triangle, and where the line of
// the ray misses it a neighbour would be met from inside: there the ray is lifted all the same.
FN vec3 surface_start(IN(SceneData) scene, IN(Surface) s, vec3 wi) {
  const vec3 lifted = surface_ray_origin(s.p, s.ng, s.epsilon, wi);
  if (!starts_at_point(scene, s.instance)) return lifted;
  SurfaceTriangle t;
  surface_fetch(scene, s.instance, s.triangle, t);
  const vec3 v0 = t.p0 - s.p;
  const vec3 v1 = t.p1 - s.p;
  const vec3 v2 = t.p2 - s.p;
  // Sides of the line that the edges pass on, as bvh_meet_triangle tells them.
  const float u = dot(cross(v2 - v0, v2 + v0), wi);
  const float v = dot(cross(v0 - v1, v0 + v1), wi);
  const float w = dot(cross(v1 - v2, v1 + v2), wi);
  const bool through = min(u, min(v, w)) >= 0.0f || max(u, max(v, w)) <= 0.0f;
  return select(through, s.p, lifted);
}

// The triangle that a ray from the surface cannot meet, as instance and triangle: the one that it leaves, unless it
// starts above it and comes down; INVALID_ID: there is none.
FN uvec2 surface_left(IN(SceneData) scene, IN(Surface) s, vec3 origin, vec3 wi) {
  if (!starts_at_point(scene, s.instance) || dot(origin - s.p, wi) < 0.0f) {
    return uvec2(INVALID_ID, INVALID_ID);
  }
  return uvec2(s.instance, s.triangle);
}

// From where on a ray meets others: t_min, but where it left a triangle surfaces at its very start count.
FN float ray_begin(uvec2 left, float t_min) { return select(left.x != INVALID_ID, -1e-20f, t_min); }

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

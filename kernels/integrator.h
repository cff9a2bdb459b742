// SPDX-License-Identifier: GPL-3.0-or-later
// How a path goes on from a surface, and where it ends: bounce, straight through, Russian roulette, limits. Devices
// take many paths from stage to stage and trace rays in between; Direct is the path of length one.
#ifndef COTORRA_INTEGRATOR_H
#define COTORRA_INTEGRATOR_H

#include "light/sampled.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Directions of a lower density are so wide that nobody sees a bevelled edge in them (Cycles' bound).
const float BLURRED_PDF = 8.0f;

// A ray grows no narrower on its way.
FN void path_leave(IN(SceneData) scene, float spread, INOUT(PathState) path, IN(Surface) s) {
  path.footprint += max(select(scene.camera_orthographic != 0u, 0.0f, spread), path.spread) * s.t;
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
    path.ray_kind = VISIBLE_TRANSMISSION | select((b.lobe & BSDF_DIFFUSE) != 0u, RAY_DIFFUSE_THROUGH, 0u);
  } else if ((b.lobe & BSDF_DIFFUSE) != 0u) {
    path.diffuse_bounces += 1u;
    path.ray_kind = VISIBLE_DIFFUSE;
  } else {
    path.glossy_bounces += 1u;
    path.ray_kind = VISIBLE_GLOSSY;
  }
  if ((b.lobe & (BSDF_SHARP | BSDF_HIDDEN)) != 0u) path.ray_kind |= RAY_MEETS_LAMPS;
  if ((b.lobe & BSDF_HIDDEN) != 0u) path.ray_kind |= RAY_HIDDEN;
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

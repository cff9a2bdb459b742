// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that a shadow ray may pass, with less light: transparent ones, and glass where Whitted renders.
// LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl), and so is tracing.
#ifndef COTORRA_STAGE_THROUGH_H
#define COTORRA_STAGE_THROUGH_H

#include "../alpha.h"
#include "../whitted.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A shadow ray on its way.
struct Passage {
  vec3 light;    // what it carries, less what glass kept
  uint crossed;  // transparent surfaces
  vec3 kept;     // share that transparent surfaces leave
  uint panes;    // glass surfaces, with Whitted
};

// Whitted: takes the ray straight across glass. Returns false where the surface stops it.
FN bool cross_pane(LANE lane, IN(Hit) hit, INOUT(ShadowRay) ray, INOUT(vec3) light) {
  Surface s;
  surface_from_hit(SCENE, hit, ray.direction, s);
  ShaderPoint at = shader_point(s, -ray.direction, hit.t);
  at.ray_kind = VISIBLE_SHADOW;
  SurfaceShading shading;
  Bsdf bsdf;
  Lobe lobe;
  surface_shading(SCENE, at, 0.5f, s, shading, bsdf, lobe);
  ray.origin = surface_ray_origin(s.p, s.ng, s.epsilon, ray.direction);
  ray.t_max -= hit.t;
  return whitted_cross_pane(shading.material, LOAD(SCENE.classic, s.material), s, ray.direction, hit.t, light);
}

// Takes the ray past the surface that it met, and on from t_min. Returns false where that stops it.
FN bool shadow_passes(LANE lane, IN(PathState) path, IN(Hit) hit, bool through_glass, INOUT(ShadowRay) ray,
                      OUT(float) t_min, INOUT(Passage) passage) {
  vec3 share = vec3(0.0f);
  if (FEATURE(FEATURE_TRANSPARENCY)) share = hit_transparency(SCENE, hit, ray.direction, path, true, passage.crossed);
  if (through_glass && !(max_component(share) > 0.0f)) {
    t_min = 0.0f;
    passage.panes += 1u;
    return passage.panes <= WHITTED_PANES && cross_pane(lane, hit, ray, passage.light);
  }
  t_min = hit.t;
  passage.crossed += 1u;
  passage.kept *= share;
  return shadow_kept(JOB.integrator, path.transparent_bounces + passage.crossed, max_component(passage.kept)) > 0.0f;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5: does anything stand between the surface and the light? The one place where shadow rays are traced.
// The light itself is added by wave_bounce.comp. Compiled twice, as wave_trace.comp is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "alpha.h"
#include "trace.glsl"

// Whitted: takes the ray straight across glass, and dims its light. Returns false where the surface stops it.
bool cross_pane(Hit hit, inout ShadowRay ray, inout vec3 light) {
  Surface s;
  surface_from_hit(WAVE.scene, hit, ray.direction, s);
  ShaderPoint at = shader_point(s, -ray.direction, hit.t);
  at.ray_kind = VISIBLE_SHADOW;
  SurfaceShading shading;
  Bsdf bsdf;
  Lobe lobe;
  surface_shading(WAVE.scene, at, 0.5f, s, shading, bsdf, lobe);
  ray.origin = surface_ray_origin(s.p, s.ng, s.epsilon, ray.direction);
  ray.t_max -= hit.t;
  return whitted_cross_pane(shading.material, LOAD(WAVE.scene.classic, s.material), s, ray.direction, hit.t, light);
}

void main() {
  if (beyond(WAVE_SHADOWS)) return;
  const uint place = LOAD(WAVE.shadows_queue, gl_GlobalInvocationID.x);
  ShadowRay ray = LOAD(WAVE.shadow_rays, place);
  const bool to_light = place / WAVE.lanes != push.sky_slot;  // glass hides the sky
  const bool sees_through = FEATURE(FEATURE_WHITTED) && flag(WAVE_TRANSPARENT_SHADOWS) && to_light;
  const PathState path = LOAD(WAVE.paths, place % WAVE.lanes);
  uint crossed = 0u;
  uint panes = 0u;
  float t_min = 0.0f;
  vec3 kept = vec3(1.0f);  // share of the light that is left
  vec3 light = ray.contribution;
  while (true) {
    Hit hit;
    // Any surface will do, unless light may come through it.
    const bool any = !FEATURE(FEATURE_TRANSPARENCY) && !sees_through;
    if (!trace(ray.origin, ray.direction, t_min, ray.t_max, ray.visibility, any, hit)) break;
    vec3 share = vec3(0.0f);
    if (FEATURE(FEATURE_TRANSPARENCY)) share = hit_transparency(WAVE.scene, hit, ray.direction, path, true, crossed);
    if (sees_through && !(max_component(share) > 0.0f)) {
      panes += 1u;
      t_min = 0.0f;
      if (panes <= WHITTED_PANES && cross_pane(hit, ray, light)) continue;
    }
    crossed += 1u;
    kept = kept * share;
    if (!(shadow_kept(WAVE.integrator, path.transparent_bounces + crossed, max_component(kept)) > 0.0f)) {
      kept = vec3(0.0f);
      break;
    }
    t_min = hit.t;
  }
  // What has a colour dims the light itself; the rest is the share that arrives.
  const float arrived = max_component(kept);
  WAVE.shadow_rays.v[place].t_max = arrived;
  if (arrived > 0.0f && min(kept.x, min(kept.y, kept.z)) < arrived) light = light * (kept * (1.0f / arrived));
  // A pane is not a shadow: what it takes away is missing from the light that could arrive, too.
  if ((sees_through || FEATURE(FEATURE_PROGRAMS)) && arrived > 0.0f) WAVE.shadow_rays.v[place].contribution = light;
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5: does anything stand between the surface and the light? The one place where shadow rays are traced.
// The light itself is added by wave_bounce.comp. Compiled twice, as wave_trace.comp is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "alpha.h"
#include "trace.glsl"

float alpha_of(Hit hit) {
  TexturePoint at;
  at.instance = hit.instance;
  at.triangle = hit.triangle;
  at.u = hit.u;
  at.v = hit.v;
  return alpha_at(WAVE.scene, at);
}

// Whitted: takes the ray straight across glass, and dims its light. Returns false where the surface stops it.
bool cross_pane(Hit hit, inout ShadowRay ray, inout vec3 light) {
  Surface s;
  surface_from_hit(WAVE.scene, hit, ray.direction, s);
  Material material = LOAD(WAVE.scene.materials, s.material);
  if (FEATURE(FEATURE_TEXTURES)) material_fetch(WAVE.scene, s, material);
  ray.origin = surface_ray_origin(s.p, s.ng, s.epsilon, ray.direction);
  ray.t_max -= hit.t;
  return whitted_cross_pane(material, LOAD(WAVE.scene.classic, s.material), s, ray.direction, hit.t, light);
}

void main() {
  if (beyond(WAVE_SHADOWS)) return;
  const uint place = LOAD(WAVE.shadows_queue, gl_GlobalInvocationID.x);
  ShadowRay ray = LOAD(WAVE.shadow_rays, place);
  const bool to_light = place / WAVE.lanes != push.sky_slot;  // glass hides the sky
  const bool sees_through = FEATURE(FEATURE_WHITTED) && flag(WAVE_TRANSPARENT_SHADOWS) && to_light;
  uint crossed = WAVE.paths.v[place % WAVE.lanes].transparent_bounces;
  uint panes = 0u;
  float t_min = 0.0f;
  float kept = 1.0f;  // share of the light that is left
  vec3 light = ray.contribution;
  while (true) {
    Hit hit;
    // Any surface will do, unless light may come through it.
    const bool any = !FEATURE(FEATURE_TRANSPARENCY) && !sees_through;
    if (!trace(ray.origin, ray.direction, t_min, ray.t_max, ray.visibility, any, hit)) break;
    const float alpha = FEATURE(FEATURE_TRANSPARENCY) ? alpha_of(hit) : 1.0f;
    if (sees_through && alpha >= 1.0f) {
      panes += 1u;
      t_min = 0.0f;
      if (panes <= WHITTED_PANES && cross_pane(hit, ray, light)) continue;
    }
    crossed += 1u;
    kept = shadow_kept(WAVE.integrator, crossed, kept * (1.0f - alpha));
    if (!(kept > 0.0f)) break;
    t_min = hit.t;
  }
  WAVE.shadow_rays.v[place].t_max = kept;
  // A pane is not a shadow: what it takes away is missing from the light that could arrive, too.
  if (sees_through && kept > 0.0f) WAVE.shadow_rays.v[place].contribution = light;
}

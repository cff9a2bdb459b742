// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5: does anything stand between the surface and the light? The one place where shadow rays are traced.
// The light itself is added by wave_bounce.comp. Compiled twice, as wave_trace.comp is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"
#include "alpha.h"

float alpha_of(Hit hit) {
  TexturePoint at;
  at.instance = hit.instance;
  at.triangle = hit.triangle;
  at.u = hit.u;
  at.v = hit.v;
  return alpha_at(WAVE.scene, at);
}

void main() {
  if (beyond(WAVE_SHADOWS)) return;
  const uint place = LOAD(WAVE.shadows_queue, gl_GlobalInvocationID.x);
  const ShadowRay ray = LOAD(WAVE.shadow_rays, place);
  const uint limit = WAVE.transparent_bounces;
  uint crossed = 0u;
  float t_min = 0.0f;
  float kept = 1.0f;  // share of the light that is left
  while (true) {
    Hit hit;
    hit.t = ray.t_max;
    hit.u = 0.0f;
    hit.v = 0.0f;
    hit.triangle = 0u;
    hit.instance = INVALID_ID;
    // Any surface will do, unless light may come through it.
    const bool any = !FEATURE(FEATURE_TRANSPARENCY);
    if (!bvh_trace(WAVE.bvh, ray.origin, ray.direction, t_min, ray.visibility, any, hit)) break;
    kept = FEATURE(FEATURE_TRANSPARENCY) ? kept * (1.0f - alpha_of(hit)) : 0.0f;
    crossed += 1u;
    if (crossed > limit && limit < WAVE_UNLIMITED) kept = 0.0f;
    if (!(kept > 0.0f)) break;
    t_min = hit.t;
  }
  WAVE.shadow_rays.v[place].t_max = kept;
}

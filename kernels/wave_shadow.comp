// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5: does anything stand between the surface and the light? The one place where shadow rays are traced.
// The light itself is added by wave_bounce.comp. Compiled twice, as wave_trace.comp is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stage.glsl"

void main() {
  if (beyond(WAVE_SHADOWS)) return;
  const uint place = LOAD(WAVE.shadows_queue, gl_GlobalInvocationID.x);
  const ShadowRay ray = LOAD(WAVE.shadow_rays, place);
  Hit hit;
  hit.t = ray.t_max;
  hit.u = 0.0f;
  hit.v = 0.0f;
  hit.triangle = 0u;
  hit.instance = INVALID_ID;
  if (bvh_trace(WAVE.bvh, ray.origin, ray.direction, 0.0f, ray.visibility, true, hit)) {
    WAVE.shadow_rays.v[place].t_max = SHADOW_BLOCKED;
  }
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 5: does anything stand between the surface and the light? The one place where shadow rays are traced.
// The light itself is added by bounce.comp. Compiled twice, as trace.comp is.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/through.h"
#include "trace.glsl"

void main() {
  if (beyond(WAVE_SHADOWS)) return;
  const uint place = LOAD(WAVE.shadows_queue, gl_GlobalInvocationID.x);
  ShadowRay ray = load_shadow(place);
  const bool to_light = place / WAVE.lanes != push.sky_slot;  // glass hides the sky
  const bool through_glass = FEATURE(FEATURE_WHITTED) && FLAG(JOB_TRANSPARENT_SHADOWS) && to_light;
  // Any surface will do, unless light may come through it.
  const bool any = !FEATURE(FEATURE_TRANSPARENCY) && !through_glass;
  const uint lane = place % WAVE.lanes;
  const PathState path = load_path(lane);
  Passage passage;
  passage.light = ray.contribution;
  passage.kept = vec3(1.0f);
  passage.crossed = 0u;
  passage.panes = 0u;
  const uvec2 left = left_at(lane, ray.origin, ray.direction);
  float t_min = ray_begin(left, 0.0f);
  Hit hit;
  while (trace(ray.origin, ray.direction, t_min, ray.t_max, ray.visibility, any, left, hit)) {
    if (shadow_passes(lane, path, hit, through_glass, ray, t_min, passage)) continue;
    passage.kept = vec3(0.0f);
    break;
  }
  const vec3 kept = passage.kept;
  vec3 light = passage.light;
  // What has a colour dims the light itself; the rest is the share that arrives, of luminance, as the Shadow pass tells
  // it (light that is below 0 in part may have none).
  float arrived = max_component(kept);
  if (arrived > 0.0f && min(kept.x, min(kept.y, kept.z)) < arrived) {
    const float share = luminance(light * kept) / luminance(light);
    if (share > 0.0f && share < 1.0f) arrived = share;
    light = light * (kept * (1.0f / arrived));
  }
  STORE(WAVE.shadow_t_max, place, arrived);
  // A pane is not a shadow: what it takes away is missing from the light that could arrive, too.
  if ((through_glass || FEATURE(FEATURE_PROGRAMS)) && arrived > 0.0f) STORE(WAVE.shadow_contribution, place, light);
}

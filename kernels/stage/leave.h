// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that leave a surface: which lamp a lane's light sample is of, and how its path goes on.
// LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl); what is sampled is told in
// integrator.h.
#ifndef COTORRA_STAGE_LEAVE_H
#define COTORRA_STAGE_LEAVE_H

#include "../integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The random pair of light sample number `slot` at a vertex.
FN uint lamp_pair(uint slot) { return PAIR_LIGHTS + slot % LAST_SHARED_PAIR; }

// The lamp of light sample number `slot` out of `slots`; of many lamps some are picked, stratified over their
// importance. INVALID_ID: none can contribute. `scale` is 1 / probability.
FN uint lamp_of_slot(LANE lane, uint slot, uint slots, float u_pick, IN(Surface) s, IN(Lobe) lobe, OUT(float) scale) {
  scale = 1.0f;
  if (FLAG(JOB_ALL_LIGHTS)) return slot;
  const float u = (float(slot) + u_pick) / float(slots);
  const uint index = path_pick_light(SCENE, s, scatters_through(lobe), min(u, 0.99999994f), scale);
  scale /= float(slots);
  return index;
}

// Takes the path on from its surface: straight through, or along `b`, a sample of what the surface scatters there.
// `lobes` are BSDF_*. Returns false where it ends.
FN bool go_on(LANE lane, INOUT(PathState) path, IN(Surface) s, LANE_BSDF bsdf, IN(Lobe) lobe, uint lobes, vec3 wo,
              IN(BsdfSample) b, float u_roulette, OUT(vec3) origin, OUT(vec3) direction) {
  if (FEATURE(FEATURE_PROGRAMS) && (lobes & BSDF_THROUGH) != 0u) {
    direction = -wo;
    return path_pass(SCENE, path, s, wo, origin);
  }
  direction = b.wi;
  const bool goes_on = path_advance(SCENE, JOB.integrator, path, s, b, u_roulette, origin);
  if (FEATURE(FEATURE_HEALTH)) NOTE_SCATTER(lane, path, b);
  if (!goes_on) return false;
  if (SCENE.light_kinds != 0u) path_note_kind(bsdf, lobe, wo, b.wi, path);
  // A last ray can only bring light home: where there is none to find, it need not be traced.
  const bool finds =
      FEATURE(FEATURE_BSDF_RAYS) && (FLAG(JOB_LAST_RAYS_FIND_LIGHT) || (path.ray_kind & RAY_MEETS_LAMPS) != 0u);
  return finds || !path_is_last(JOB.integrator, path);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

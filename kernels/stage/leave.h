// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that leave a surface: which light a lane's sample is of, and how its path goes on.
// LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl); what is sampled is told in
// integrator.h.
#ifndef COTORRA_STAGE_LEAVE_H
#define COTORRA_STAGE_LEAVE_H

#include "../integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The random pair of light sample number `slot` at a vertex. Where each lamp is sampled, the tree's comes after them.
FN uint light_pair(IN(SceneData) scene, uint slot) {
  const bool of_tree = slot == scene.light_count && scene.light_count <= LIGHTS_AT_ONCE;
  return of_tree ? PAIR_EMITTER : PAIR_LIGHTS + slot % LAST_SHARED_PAIR;
}

// The light of light sample number `slot` out of `slots`, as the tree names it: each lamp in its turn, or what the tree
// picks. `scale` is 1 / the number of samples that take it, on average. INVALID_ID: there is none.
// `root`: path_light_weights; `fresh` and `u`: path_pick_light.
FN uint light_of_slot(LANE lane, uint slot, uint slots, IN(Surface) s, IN(Lobe) lobe, IN(LightWeights) root,
                      float fresh, INOUT(vec2) u, OUT(float) scale) {
  scale = 1.0f;
  if (FLAG(JOB_ALL_LIGHTS) && slot < SCENE.light_count) return LIGHT_CHILD_LEAF | LIGHT_CHILD_LAMPS | slot;
  if (!FEATURE(FEATURE_LIGHT_TREE)) return INVALID_ID;
  if (FLAG(JOB_ALL_LIGHTS)) return path_pick_light(SCENE, s, lobe, root, 0u, 1u, fresh, u, scale);
  return path_pick_light(SCENE, s, lobe, root, slot, slots, fresh, u, scale);
}

// A shadow ray that would bring less than the threshold is traced with a probability in proportion, and brings more
// then (Cycles' light threshold; what the path has lost on its way counts here, too). `u`: one number for all rays of a
// vertex, which the golden ratio spreads over them. Returns false where it is not traced.
FN bool shadow_survives(LANE lane, uint slot, float u, INOUT(ShadowRay) ray) {
  const float probability = max_component(abs(ray.contribution)) * JOB.integrator.shadow_roulette;
  if (ray.visibility == 0u || !(probability < 1.0f)) return true;
  const float own = u + float(int(slot)) * 0.618034f;
  if (own - floor(own) >= probability) return false;
  ray.contribution = ray.contribution / probability;
  return true;
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
  if (FEATURE(FEATURE_PROGRAMS) && JOB.integrator.filter_glossy > 0.0f) {
    path_widen(JOB.integrator, sampled_alpha(bsdf, lobe, b), path);
  }
  if ((path.ray_kind & RAY_HIDDEN) != 0u) path.normal = bsdf_smooth_normal(bsdf);
  if (SCENE.light_kinds != 0u) path_note_kind(bsdf, lobe, wo, b.wi, path);
  if (has_links(SCENE)) path.ray_kind |= receiver_set(SCENE, s.instance) << RAY_SET_SHIFT;
  if (FEATURE(FEATURE_LIGHT_TREE) && scatters_through(lobe)) path.ray_kind |= RAY_BOTH_SIDES;
  // A last ray can only bring light home: where there is none to find, it need not be traced.
  const bool finds =
      FEATURE(FEATURE_BSDF_RAYS) && (FLAG(JOB_LAST_RAYS_FIND_LIGHT) || (path.ray_kind & RAY_MEETS_LAMPS) != 0u);
  return finds || !path_is_last(JOB.integrator, path);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

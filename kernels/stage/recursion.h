// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion on a lane: the rays that a surface sends out wait, and media dim the rays that run inside them.
// LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl), and so is the store they wait
// in.
#ifndef COTORRA_STAGE_RECURSION_H
#define COTORRA_STAGE_RECURSION_H

#include "../whitted.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// What the medium that the ray ran inside of has left of it.
FN void absorb(LANE lane, float distance, INOUT(PathState) path) {
  const uint medium = MEDIUM(lane);
  if (medium == INVALID_ID) return;
  path.throughput *= medium_transmittance(LOAD(SCENE.classic, medium).absorption, distance);
}

FN void push_child(LANE lane, IN(PathState) path, IN(Surface) s, IN(ClassicMaterial) classic, vec3 direction,
                   vec3 weight, uint kind) {
  PendingRay ray;
  ray.path = path;
  if (!whitted_advance(ray.path, s, direction, weight, kind, JOB.whitted_threshold, ray.origin)) return;
  ray.medium = whitted_medium(classic, s, kind);
  ray.direction = direction;
  ray.slot = SLOT(lane);
  PUSH_RAY(lane, ray);
}

// The rays that go on from the surface that the lane stands at.
FN void push_children(LANE lane, IN(PathState) path, IN(Surface) s, IN(Material) material, IN(Bsdf) bsdf, vec3 wo) {
  if (path.bounce >= JOB.whitted_depth) return;
  const ClassicMaterial classic = LOAD(SCENE.classic, s.material);
  WhittedChildren children;
  whitted_children(material, classic, s, bsdf, wo, children);
  push_child(lane, path, s, classic, children.reflected, children.reflected_weight, VISIBLE_GLOSSY);
  push_child(lane, path, s, classic, children.transmitted, children.transmitted_weight, VISIBLE_TRANSMISSION);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

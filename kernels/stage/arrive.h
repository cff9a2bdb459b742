// SPDX-License-Identifier: GPL-3.0-or-later
// Light that reaches a sample: from lamps and emitters once their shadow rays are traced, from the sky, as a tone.
// LANE and the names in capitals are the device's (cpu_lane.h, entry/vulkan/lane.glsl); nothing is traced here.
#ifndef COTORRA_STAGE_ARRIVE_H
#define COTORRA_STAGE_ARRIVE_H

#include "../health.h"
#include "../occlusion.h"
#include "../outline.h"
#include "../toon.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Only one at a time works on a lane, so that sums need no atomics and come in one order.
FN void add_light(LANE lane, vec3 value, int group) {
  RADIANCE(lane) += value;
  if (FEATURE(FEATURE_TERMS)) {
    const int lamp = light_pass(group);
    if (lamp >= 0 && lamp < int(JOB.lamp_passes)) LAMP_LIGHT(lane, uint(lamp)) += value;
    group = light_group(group);
  }
  if (FEATURE(FEATURE_LIGHT_GROUPS) && group >= 0 && group < int(JOB.light_groups)) {
    GROUP_LIGHT(lane, uint(group)) += value;
  }
}

// `kept` of a light sample's contribution is left at the surface. `first`: it is the first of the path.
FN void arrive(LANE lane, bool first, vec3 contribution, vec3 kept, int group) {
  const vec3 lit = contribution * kept;
  if (FEATURE(FEATURE_HEALTH)) NOTE_LIT(lane, lit);
  if (max_component(kept) > 0.0f) {
    add_light(lane, CLAMPED(lane, lit, light_limit(JOB.integrator, PATH_BOUNCE(lane))), group);
  }
  if (FEATURE(FEATURE_DATA_PASSES) && first) NOTE_SHADOW(lane, luminance(lit), luminance(contribution));
}

// Ambient light that a surface returns, if nothing hides the sky.
FN vec3 ambient_light(LANE lane, IN(PathState) path, uint material_id, IN(Material) material) {
  return path.throughput * ambient_term(material, LOAD(SCENE.classic, material_id), JOB.ambient);
}

// What is seen of the sky, 0 to 1: as a pass, as a factor of ambient light, as the picture itself.
FN void sky_arrives(LANE lane, bool first, vec3 ambient, float sky) {
  if (FLAG(JOB_AMBIENT_OCCLUDED)) add_light(lane, ambient * sky, -1);
  if (FEATURE(FEATURE_DATA_PASSES) && FLAG(JOB_OCCLUSION_PASS) && first) NOTE_SKY(lane, sky);
  if (FLAG(JOB_OCCLUSION_PICTURE)) RADIANCE(lane) = vec3(sky);
}

// Toon: the tone of a point that `lit` lamps light fully.
FN void tone_arrives(LANE lane, uint material_id, IN(Material) material, uint lit) {
  add_light(lane, toon_color(material, LOAD(SCENE.classic, material_id), lit, SCENE.light_count), -1);
}

// A line covers what is behind it, and the transparent film.
FN void draw_line(LANE lane, IN(OutlineSums) sums) {
  if (!outline_found(sums, JOB.outlines, JOB.outline_y / JOB.rows)) return;
  RADIANCE(lane) = JOB.outline_color;
  ALPHA(lane) = 1.0f;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif

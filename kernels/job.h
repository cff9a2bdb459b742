// SPDX-License-Identifier: GPL-3.0-or-later
// What a session asks of the stages, beside the scene: camera, limits of paths, passes, and what the integrators beside
// Direct and Path are told. Which lanes there are and where they lie is each device's own business.
#ifndef COTORRA_JOB_H
#define COTORRA_JOB_H

#include "camera.h"
#include "integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint JOB_TRANSPARENT = 1u;  // the film, where a camera ray meets nothing
const uint JOB_CAMERA_MEETS_LIGHTS = 2u;
const uint JOB_LAST_RAYS_FIND_LIGHT = 4u;
const uint JOB_ALL_LIGHTS = 8u;  // every lamp is sampled at each vertex
const uint JOB_TRANSPARENT_SHADOWS = 16u;  // Whitted: shadow rays see through glass
const uint JOB_OCCLUSION_PICTURE = 32u;  // what is seen of the sky is the picture
const uint JOB_OCCLUSION_PASS = 64u;
const uint JOB_AMBIENT = 128u;  // surfaces return ambient light
const uint JOB_AMBIENT_OCCLUDED = 256u;  // as much as they see of the sky
const uint JOB_TERMS_PASS = 512u;
const uint JOB_FEATURES_PASS = 1024u;  // what denoisers are shown

struct JobData {
  CameraData camera;
  IntegratorData integrator;
  uint flags;  // JOB_*
  uint light_groups;
  uint lamp_passes;  // passes of single lamps
  uint whitted_depth;
  float whitted_threshold;
  vec3 ambient;
  float occlusion_distance;
  vec3 outline_color;
  uint outlines;  // OUTLINE_*, 0: none are drawn
  float outline_x;  // half of a line's width, pixels
  float outline_y;
  float rows;  // of the whole picture, pixels
  float white;  // radiance that is shown as white
};

#ifdef __cplusplus
static_assert(sizeof(JobData) == 188);
}  // namespace cotorra
#endif

#endif

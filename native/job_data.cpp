// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the stages' view of a job. Which settings there are is told in integrators.cpp and session.cpp.
#include "every_feature.h"

#include "job_data.h"

namespace cotorra {
namespace {

std::uint32_t flags_of(const RenderJob &job) {
  const ClassicJob &c = job.classic;
  std::uint32_t flags = 0;
  const auto set = [&flags](bool condition, std::uint32_t flag) { flags |= condition ? flag : 0u; };
  set(job.transparent, JOB_TRANSPARENT);
  set(job.camera_meets_lights, JOB_CAMERA_MEETS_LIGHTS);
  set(job.last_rays_find_light, JOB_LAST_RAYS_FIND_LIGHT);
  set(job.scene->light_count <= LIGHTS_AT_ONCE, JOB_ALL_LIGHTS);
  set(job.passes.terms, JOB_TERMS_PASS);
  set(job.passes.occlusion, JOB_OCCLUSION_PASS);
  set(job.passes.features, JOB_FEATURES_PASS);
  set(c.transparent_shadows, JOB_TRANSPARENT_SHADOWS);
  set(c.integrator == Integrator::kOcclusion, JOB_OCCLUSION_PICTURE);
  const bool ambient = max(max(c.ambient.x, c.ambient.y), c.ambient.z) > 0.0f;
  set(ambient, JOB_AMBIENT);
  set(ambient && c.occluded, JOB_AMBIENT_OCCLUDED);
  return flags;
}

}  // namespace

JobData job_data(const RenderJob &job) {
  const ClassicJob &c = job.classic;
  JobData data{};
  data.camera = job.camera;
  data.integrator = {job.limits.max_bounces,    job.limits.diffuse_bounces,     job.limits.glossy_bounces,
                     job.limits.roulette_start, job.limits.transparent_bounces, job.limits.transmission_bounces,
                     job.limits.clamp_direct,   job.limits.clamp_indirect,      job.limits.shadow_roulette,
                     job.limits.filter_glossy};
  data.flags = flags_of(job);
  data.light_groups = job.passes.light_groups;
  data.lamp_passes = job.passes.lamps;
  data.whitted_depth = c.depth;
  data.whitted_threshold = c.threshold;
  data.ambient = c.ambient;
  data.occlusion_distance = c.occlusion_distance;
  data.outline_color = c.outline_color;
  data.outlines = c.outlines;
  data.outline_x = c.outline_x;
  data.outline_y = c.outline_y;
  data.rows = c.rows;
  data.white = job.white;
  return data;
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the settings of the integrators and chooses the features that each needs of a scene's.
#include "integrators.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "../kernels/outline.h"

namespace cotorra {
namespace {

constexpr std::uint32_t kDeepest = 64;  // Whitted: each level of the recursion has memory of its own

constexpr std::pair<const char *, Integrator> kIntegrators[] = {
    {"DIRECT", Integrator::kDirect}, {"PATH", Integrator::kPath}, {"WHITTED", Integrator::kWhitted},
    {"AO", Integrator::kOcclusion},  {"TOON", Integrator::kToon},
};

Integrator integrator_of(const std::string &name) {
  for (const auto &[known, integrator] : kIntegrators) {
    if (name == known) return integrator;
  }
  throw std::invalid_argument("settings.integrator = '" + name + "', must be DIRECT, PATH, WHITTED, AO or TOON");
}

float checked(float value, const char *name) {
  if (std::isfinite(value) && value >= 0.0f) return value;
  throw std::invalid_argument(std::string("settings.") + name + " = " + std::to_string(value) +
                              ", must be a finite number of at least 0");
}

vec3 checked(const std::array<float, 3> &value, const char *name) {
  return {checked(value[0], name), checked(value[1], name), checked(value[2], name)};
}

void apply_outlines(const SettingsInput &s, const CameraInput &camera, ClassicJob &job) {
  const float half_width = 0.005f * checked(s.outline_width, "outline_width");
  job.rows = static_cast<float>(camera.resolution[1]);
  job.outline_color = checked(s.outline_color, "outline_color");
  if (!s.toon_outline || half_width == 0.0f) return;
  job.outlines = (s.outline_normal ? OUTLINE_NORMAL : 0u) | (s.outline_depth ? OUTLINE_DEPTH : 0u) |
                 (s.outline_object ? OUTLINE_OBJECT : 0u);
  job.outline_y = half_width * job.rows;
  // As wide as it is high in the picture that is shown, whatever the pixels' shape.
  const float width = std::abs(camera.window[1] - camera.window[0]) / static_cast<float>(camera.resolution[0]);
  const float height = std::abs(camera.window[3] - camera.window[2]) / job.rows;
  job.outline_x = job.outline_y * (width > 0.0f ? height / width : 1.0f);
}

// The features of the scene that the integrator has use for, and its own.
std::uint32_t features_of(Integrator integrator, const SettingsInput &s, const Scene &scene, const ClassicJob &job) {
  const std::uint32_t all = scene.features();
  const std::uint32_t seen = FEATURE_WORLD | FEATURE_PROGRAMS | FEATURE_TRANSPARENCY;
  const bool ambient = max(max(job.ambient.x, job.ambient.y), job.ambient.z) > 0.0f;
  const std::uint32_t ambient_term = ambient ? FEATURE_OCCLUSION : 0u;
  switch (integrator) {
    case Integrator::kDirect:
      return all | ambient_term;
    case Integrator::kPath:
      return all | (s.max_bounces > 0 ? FEATURE_BOUNCES : 0u);
    case Integrator::kWhitted:
      // Mirrors show lamps that have a size; how glass bends the normal belongs to the specular lobe.
      return (all & ~(FEATURE_LOBES | FEATURE_WORLD_LIGHT)) | FEATURE_WHITTED | FEATURE_SPECULAR | ambient_term |
             (scene.bounces_meet_lights() ? FEATURE_BSDF_RAYS | FEATURE_VISIBLE_LIGHTS : 0u);
    case Integrator::kOcclusion:
      return (all & seen) | FEATURE_OCCLUSION;
    case Integrator::kToon:
      return (all &
              (seen | FEATURE_EMISSIVE_MESHES | FEATURE_SOFT_LIGHTS | FEATURE_VISIBLE_LIGHTS | FEATURE_LIGHT_SHAPES)) |
             FEATURE_TOON;
  }
  return all;
}

}  // namespace

void apply_integrator(const SettingsInput &s, const CameraInput &camera, const Scene &scene, RenderJob &job,
                      SceneData &data) {
  ClassicJob &c = job.classic;
  c.integrator = integrator_of(s.integrator);
  c.depth = s.whitted_depth;
  if (c.depth > kDeepest) {
    throw std::invalid_argument("settings.whitted_depth = " + std::to_string(c.depth) + ", must be 0 to " +
                                std::to_string(kDeepest));
  }
  c.threshold = checked(s.whitted_threshold, "whitted_threshold");
  const bool whitted = c.integrator == Integrator::kWhitted;
  c.transparent_shadows = whitted && s.use_transparent_shadows;
  c.occlusion_distance = checked(s.ao_distance, "ao_distance");
  const vec3 ambient = checked(s.ambient_color, "ambient_color") * checked(s.ambient_strength, "ambient_strength");
  if (whitted || c.integrator == Integrator::kDirect) c.ambient = ambient;
  c.occluded = s.use_ambient_occlusion;
  if (c.integrator == Integrator::kToon) apply_outlines(s, camera, c);

  const bool path = c.integrator == Integrator::kPath;
  job.limits = {path ? s.max_bounces : 0u, path ? s.diffuse_bounces : 0u,     path ? s.glossy_bounces : 0u, 2u,
                s.transparent_bounces,     path ? s.transmission_bounces : 0u};
  if (whitted) job.limits = {c.depth, c.depth, c.depth, 2u, s.transparent_bounces, c.depth};
  const bool physical = path || c.integrator == Integrator::kDirect;
  // Cycles' limits are means of the three channels.
  const auto limit = [physical](float mean) { return physical && mean > 0.0f ? 3.0f * mean : INFINITE_DISTANCE; };
  job.limits.clamp_direct = limit(checked(s.clamp_direct, "clamp_direct"));
  job.limits.clamp_indirect = limit(checked(s.clamp_indirect, "clamp_indirect"));
  job.limits.filter_glossy = path ? checked(s.filter_glossy, "filter_glossy") : 0.0f;
  const float threshold = checked(s.light_threshold, "light_threshold");
  if (physical && threshold > 0.0f) job.limits.shadow_roulette = 1.0f / std::max(threshold, 1e-30f);
  if (path && !s.reflective_caustics) data.no_caustics |= CAUSTICS_REFLECTIVE;
  if (path && !s.refractive_caustics) data.no_caustics |= CAUSTICS_REFRACTIVE;
  // In the classic ones, surfaces are lit by lamps and ambient light; emitting ones are only seen.
  if (!path && c.integrator != Integrator::kDirect) {
    data.emitter_count = 0;
    data.world_width = 0;
  }
  job.features = features_of(c.integrator, s, scene, c);
  data.starts_at_point = scene.starts_at_point() && (path || c.integrator == Integrator::kDirect) ? 1u : 0u;
  data.lobes = path || c.integrator == Integrator::kDirect ? 1u : 0u;
}

}  // namespace cotorra

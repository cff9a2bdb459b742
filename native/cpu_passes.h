// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch leaves in its tile: the passes that describe the first surface, and the sums of all samples.
// Terms of the highlight and light of single lamps are cpu_terms.h's. Included by cpu_kernel.cpp alone.
#pragma once

#include "../kernels/denoising.h"
#include "cpu_camera.h"
#include "cpu_terms.h"
#include "cpu_visibility.h"

namespace cotorra {
namespace {

// Passes that describe the first surface. `slot` is the sample, whose filter offset u, v still hold.
void record_surface(const Tracer &t, uint slot, const Surface &s, const Material &material, vec3 diffuse) {
  Batch &b = t.batch;
  const RenderJob &job = t.job;
  const SceneData &scene = *job.scene;
  const std::size_t pixel = b.pixel[slot];
  if (job.passes.nearest) {
    NearestRecord &r = b.staged.nearest[pixel];
    const float distance2 = sqr(b.u[slot]) + sqr(b.v[slot]);
    if (distance2 < r.distance2) {
      r.distance2 = distance2;
      r.depth = film_number(camera_depth(job.camera, s.p));
      r.position = film_vector(s.p);
      r.object_index = static_cast<float>(scene.instances.v[s.instance].pass_index);
      r.material_index = static_cast<float>(material.pass_index);
    }
  }
  if (job.passes.surface) {
    SurfaceRecord &r = b.staged.surface[pixel];
    r.normal += film_vector(s.n);
    const vec2 uv = surface_uv(scene, s);
    r.uv = r.uv + vec2(film_number(uv.x), film_number(uv.y));
    const Mesh &mesh = scene.meshes.v[scene.instances.v[s.instance].mesh];
    r.uv_coverage += (mesh.flags & MESH_HAS_UV) != 0u ? 1.0f : 0.0f;
    r.diffuse_color += film_vector(diffuse);
  }
}

// What a denoiser is shown of the surface, or of what it mirrors.
void record_features(const Tracer &t, uint slot, PathState &path, const Bsdf &bsdf, const Lobe &lobe, vec3 wo) {
  Features features;
  if (!path_features(*t.job.scene, path, bsdf, lobe, wo, features)) return;
  FeatureRecord &r = t.batch.staged.features[t.batch.pixel[slot]];
  r.albedo += film_vector(features.albedo);
  r.normal += film_vector(features.normal);
  path.ray_kind &= ~RAY_SHOWN;
}

// Light as it counts where it is clamped, and how much that holds back.
vec3 count_clamped(vec3 light, float limit, RayCounts &counts) {
  const vec3 kept = clamped_light(light, limit);
  counts.light += static_cast<double>(film_number(luminance(light)));
  counts.held_light += static_cast<double>(film_number(luminance(light - kept)));
  return kept;
}

// Adds the samples to their pixels; the odd ones alone as well, where an error is asked for.
void stage_samples(const Tracer &t, std::span<const std::uint16_t> pixels, uint first, uint per_pixel) {
  Batch &b = t.batch;
  const RenderJob &job = t.job;
  std::size_t slot = 0;
  for (const std::uint16_t pixel : pixels) {
    FilmPixel sum{vec3(0.0f), 0.0f};
    vec3 odd(0.0f);
    for (uint s = 0; s < per_pixel; ++s, ++slot) {
      vec3 radiance = b.radiance[slot];
      const bool finite = film_add(sum, radiance, b.alpha[slot]);
      t.counts.rejected += finite ? 0u : 1u;
      if (((first + s) & 1u) != 0u) odd += radiance;
      if (FEATURE(FEATURE_LIGHT_GROUPS) && finite) {
        const std::size_t n = job.passes.light_groups;
        for (std::size_t g = 0; g < n; ++g) b.staged.groups[pixel * n + g] += film_vector(b.groups[slot * n + g]);
      }
      if (FEATURE(FEATURE_TERMS) && finite) stage_lamps(job.passes, slot, pixel, b);
    }
    FilmPixel &p = b.staged.pixels[pixel];
    p.radiance += sum.radiance;
    p.alpha += sum.alpha;
    if (job.passes.error) b.staged.odd[pixel] += odd;
  }
}

}  // namespace
}  // namespace cotorra

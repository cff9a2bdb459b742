// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch leaves in its tile: the sums of its samples, their light groups and single lamps.
// What passes are told beside light is cpu_lane.h's. Included by cpu_kernel.cpp alone.
#pragma once

#include "../kernels/denoising.h"
#include "cpu_camera.h"
#include "cpu_health.h"
#include "cpu_sharing.h"
#include "cpu_visibility.h"

namespace cotorra {
namespace {

// Light as it counts where it is clamped, and how much that holds back.
vec3 count_clamped(vec3 light, float limit, bool caustic, RayCounts &counts) {
  const vec3 kept = clamped_light(light, limit);
  const auto all = static_cast<double>(film_number(luminance(light)));
  const auto held = static_cast<double>(film_number(luminance(light - kept)));
  counts.light += all;
  counts.held_light += held;
  if (caustic) {
    counts.caustics += all;
    counts.held_caustics += held;
  }
  return kept;
}

// Adds the samples to their pixels.
void stage_samples(const Tracer &t, std::span<const std::uint16_t> pixels, std::size_t tile_width, uint per_pixel) {
  Batch &b = t.batch;
  const RenderJob &job = t.job;
  const bool shared = job.passes.shared;
  std::size_t slot = 0;
  for (const std::uint16_t pixel : pixels) {
    FilmPixel sum{vec3(0.0f), 0.0f};
    const std::size_t corner = shared ? sharing_corner(b.sharing, pixel, tile_width) : 0;
    const uint mask = shared ? sharing_mask(b.sharing, corner) : 0;
    for (uint s = 0; s < per_pixel; ++s, ++slot) {
      vec3 radiance = b.radiance[slot];
      const bool finite = film_add(sum, radiance, b.alpha[slot]);
      t.counts.rejected += finite ? 0u : 1u;
      if (shared)
        share_sample(job, b.sharing, corner, mask, vec2(b.u[slot], b.v[slot]), radiance, film_number(b.alpha[slot]));
      if (FEATURE(FEATURE_HEALTH) && !finite) note_bad(t, slot, {BAD_NOT_FINITE, HEALTH_UNKNOWN});
      if (FEATURE(FEATURE_LIGHT_GROUPS) && finite) {
        const std::size_t n = job.passes.light_groups;
        for (std::size_t g = 0; g < n; ++g) b.staged.groups[pixel * n + g] += film_vector(b.groups[slot * n + g]);
      }
      if (FEATURE(FEATURE_TERMS) && finite) {
        const std::size_t n = job.passes.lamps;
        for (std::size_t l = 0; l < n; ++l) b.staged.lamps[pixel * n + l] += film_vector(b.lamps[slot * n + l]);
      }
    }
    FilmPixel &p = b.staged.pixels[pixel];
    p.radiance += sum.radiance;
    p.alpha += sum.alpha;
  }
}

// Sorts the bright samples, where they are asked for.
void stage_bright(const Tracer &t, std::span<const std::uint16_t> pixels, uint per_pixel) {
  Batch &b = t.batch;
  const float white = t.job.white;
  std::size_t slot = 0;
  for (const std::uint16_t pixel : pixels) {
    BrightSum *const sums = b.staged.bright.data() + pixel * BRIGHT_CASCADES;
    for (uint s = 0; s < per_pixel; ++s, ++slot) {
      const vec3 light = film_vector(b.radiance[slot]);
      const float size = brightness(light);
      if (size <= white) continue;
      for (uint c = 0; c < BRIGHT_CASCADES; ++c) bright_add(sums[c], light, size, c, white);
    }
  }
}

}  // namespace
}  // namespace cotorra

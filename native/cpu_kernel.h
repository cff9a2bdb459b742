// SPDX-License-Identifier: GPL-3.0-or-later
// The border between a session and the CPU builds of the kernels: what is to be rendered, and the table of builds.
// Each build (instruction set x features) is one compilation of cpu_kernel.cpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "../kernels/camera.h"
#include "../kernels/scene_types.h"
#include "embree.h"
#include "film.h"
#include "health.h"
#include "quads.h"

namespace cotorra {

struct PathLimits {  // kernels/path.h, IntegratorData
  std::uint32_t max_bounces, diffuse_bounces, glossy_bounces, roulette_start, transparent_bounces, transmission_bounces;
  float clamp_direct = INFINITE_DISTANCE, clamp_indirect = INFINITE_DISTANCE, filter_glossy = 0.0f;
  float shadow_roulette = 0.0f;
};

enum class Integrator { kDirect, kPath, kWhitted, kOcclusion, kToon };

// What the integrators beside Path are told.
struct ClassicJob {
  Integrator integrator = Integrator::kDirect;
  std::uint32_t depth = 0;        // Whitted: mirrors and glass surfaces one after the other
  float threshold = 0.0f;         // Whitted: least throughput worth a ray
  bool transparent_shadows = false;
  vec3 ambient{0.0f, 0.0f, 0.0f};
  bool occluded = false;          // of ambient light
  float occlusion_distance = 0.0f;
  std::uint32_t outlines = 0;     // Toon: OUTLINE_*
  float outline_x = 0.0f, outline_y = 0.0f;  // half of a line's width, pixels
  float rows = 0.0f;              // of the whole picture, pixels
  vec3 outline_color{0.0f, 0.0f, 0.0f};
};

// Everything that stays the same during a session.
struct RenderJob {
  const SceneData *scene;
  CameraData camera;
  int region_x, region_y;  // of the film in the whole picture, pixels
  PathLimits limits;
  PassSelection passes;
  embree::Scene bvh;
  const embree::Api *rtc;
  std::span<const EmbreeGeometry> geometries;  // of bvh
  std::uint32_t embree_features;
  std::uint32_t features;      // FEATURE_* in use
  std::uint32_t seed;
  std::uint32_t program_registers;  // numbers that the largest program keeps
  std::uint32_t sample_bits;   // log2 of the samples a pixel, rounded up
  bool transparent;
  bool camera_meets_lights;  // a lamp is visible to camera rays
  bool last_rays_find_light;  // the world or a mesh: worth the last ray of any path, not only of those that meet lamps
  bool measure_tracing;
  float white;  // radiance that is shown as such
  float firefly_limit;  // radiance of a bounce from which on it is one, where bad samples are counted
  ClassicJob classic;
  const std::atomic<bool> *cancel;
};

struct RayCounts {
  std::uint64_t camera = 0, bounce = 0, shadow = 0, samples = 0, rejected = 0;
  // Where light is clamped or gloss filtered, on the CPU: luminance of all light, and what of it was held back; and of
  // both, the caustics.
  double light = 0.0, held_light = 0.0, caustics = 0.0, held_caustics = 0.0;
  // With RenderJob::measure_tracing: seconds of thread time for the whole work, and for Embree alone on the same rays.
  double busy_seconds = 0.0, traced_seconds = 0.0;
  BadCounts bad;
  void add(const RayCounts &other) {
    for (const auto &[sample, count] : other.bad) bad[sample] += count;
    camera += other.camera;
    bounce += other.bounce;
    shadow += other.shadow;
    samples += other.samples;
    rejected += other.rejected;
    light += other.light;
    held_light += other.held_light;
    caustics += other.caustics;
    held_caustics += other.held_caustics;
    busy_seconds += other.busy_seconds;
    traced_seconds += other.traced_seconds;
  }
};

// Memory that a thread reuses from batch to batch; its contents belong to the build that made it.
struct Workspace {
  virtual ~Workspace() = default;
};

struct CpuKernel {
  const char *isa;
  std::uint32_t isa_level;  // 2, 3, 4 for x86-64-v2, -v3, -v4
  std::uint32_t features;  // FEATURE_* compiled in
  std::size_t workspace_bytes;  // at least
  std::unique_ptr<Workspace> (*make_workspace)(const RenderJob &);
  // Takes samples [first, first + count) of each pixel in the tile's to_sample(). Returns false if cancelled; what was
  // finished by then is in the tile, unless the batch could not be kept whole.
  bool (*render)(const RenderJob &, FilmTile &, std::uint32_t first, std::uint32_t count, Workspace &, RayCounts &);
};

// The smallest build for this processor that covers the features.
const CpuKernel &choose_cpu_kernel(std::uint32_t features);
// Highest of 2, 3, 4 that this processor runs; COTORRA_ISA=2|3|4 lowers it, for tests.
std::uint32_t cpu_isa_level();
std::span<const CpuKernel *const> cpu_kernels();

}  // namespace cotorra

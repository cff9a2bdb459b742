// SPDX-License-Identifier: GPL-3.0-or-later
// The memory of one batch of paths, and Embree's entry points for the packet width of this instruction set.
// Included by cpu_kernel.cpp alone, after the kernels; the stages that use it are there.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "../kernels/occlusion.h"
#include "../kernels/outline.h"
#include "../kernels/sharing.h"
#include "../kernels/toon.h"
#include "../kernels/whitted.h"
#include "alpha_filter.h"
#include "cpu_kernel.h"
#include "cpu_lanes.h"

// Packets of 16 are slower than of 8, by 1 % (direct) to 11 % (path) of Embree's time on
// three_lights: their rays part sooner.
#if defined(__AVX2__)
#define COTORRA_PACKET 8
#else
#define COTORRA_PACKET 4
#endif

namespace cotorra {
namespace {

constexpr int kWidth = COTORRA_PACKET;  // rays of one packet

// What the alpha filters know, behind the arguments of each query; null where nothing is filtered.
using Alpha = AlphaContext<kWidth>;
Alpha *alpha_of(const embree::QueryArguments &arguments) { return reinterpret_cast<Alpha *>(arguments.context); }

void begin_alpha(const RenderJob &job, const IntegratorData &limits, uint block_seed, Alpha &alpha) {
  alpha.scene = job.scene;
  alpha.geometries = job.geometries.data();
  alpha.block_seed = block_seed;
  alpha.limits = limits;
  alpha.transparency = (job.features & FEATURE_TRANSPARENCY) != 0u;
  if (limits.transparent_bounces >= TRANSPARENT_UNLIMITED) return;
  alpha.distances.resize(std::size_t{kWidth} * (path_crossings(limits) + 1));
}

// Embree's entry points for this packet width, with the filters of scenes where light goes through surfaces.
void intersect(const embree::Api &rtc, const int *valid, embree::Scene bvh, embree::RayHit<kWidth> *packet,
               embree::QueryArguments *arguments) {
  const bool filtered = FEATURE(FEATURE_TRANSPARENCY | FEATURE_LOBES) && arguments->context != nullptr;
  if (filtered) set_filter(*alpha_of(*arguments), packet->ray, filter_path<kWidth>, *arguments);
#if COTORRA_PACKET == 8
  rtc.intersect8(valid, bvh, packet, arguments);
#else
  rtc.intersect4(valid, bvh, packet, arguments);
#endif
  if (filtered) end_passes(*alpha_of(*arguments), *packet);
}

void occluded(const embree::Api &rtc, const int *valid, embree::Scene bvh, embree::Ray<kWidth> *packet,
              embree::QueryArguments *arguments) {
  if (FEATURE(FEATURE_TRANSPARENCY | FEATURE_LOBES) && arguments->context != nullptr) {
    set_filter(*alpha_of(*arguments), *packet, filter_shadow<kWidth>, *arguments);
    alpha_of(*arguments)->kept.fill(vec3(1.0f));
  }
#if COTORRA_PACKET == 8
  rtc.occluded8(valid, bvh, packet, arguments);
#else
  rtc.occluded4(valid, bvh, packet, arguments);
#endif
}

// Share of ray k's light that an occlusion query with these arguments left, where nothing stopped it.
vec3 light_kept(const embree::QueryArguments &arguments, std::size_t k) {
  return FEATURE(FEATURE_TRANSPARENCY) && arguments.context != nullptr ? alpha_of(arguments)->kept[k] : vec3(1.0f);
}

// A packet as it was before it was traced, for RenderJob::measure_tracing.
struct RecordedPacket {
  embree::RayHit<kWidth> packet;
  int count;
  int flags;
  bool shadow;
};

// What the integrators beside Direct and Path keep; there only where one of them renders.
struct ClassicLanes {
  std::vector<std::vector<PendingRay>> pending;  // Whitted, by surfaces behind the ray: at most 2 kLanes each
  Array<uint, kLanes> medium;                    // Whitted: PendingRay's
  Array<float, kLanes> sky;                      // ambient occlusion: 1 where the ray to the sky is free
  Array<uint, kLanes> lit;                       // Toon: lamps that light the point fully
  Array<embree::RayHit<kWidth>, kLanes / kWidth> around;  // Toon: the rays around the camera rays
  Array<OutlinePoint, kLanes> middle;
  Array<OutlineSums, kLanes> sums;
};

// Where pixels share their samples: those of a tile, and two around it that windows reach and nobody samples.
struct SharingLanes {
  std::size_t stride = 0;
  std::vector<std::uint8_t> sampled;  // 1: is sampled
  std::vector<SharedSum> sums;
  std::size_t middle() const { return (SHARING_SIDE / 2) * (stride + 1); }  // the tile's first pixel
};

struct ProgramLanes;

// The paths of a batch. Lanes are compacted at each vertex: `slot` tells which sample a lane belongs to.
struct Batch final : Workspace {
  Array<embree::RayHit<kWidth>, kLanes / kWidth> packets;
  Array<Hit, kLanes> found;  // what the packets met
  Array<PathState, kLanes> path;
  Array<Surface, kLanes> surface;
  HitLanes hit;
  ShadingLanes shading;
  LightLanes light;
  BounceLanes bounce;
  Array<uint, kLanes> slot;
  Array<uint, kLanes> random;
  Array<float, kLanes> u, v, u2, v2;
  Array<float, kLanes> weak;  // which of the weak shadow rays are traced: shadow_survives
  // By sample:
  Array<std::uint16_t, kLanes> pixel;  // its place in the tile
  Array<vec3, kLanes> radiance;
  Array<float, kLanes> alpha;
  Array<std::uint8_t, FEATURE(FEATURE_HEALTH) ? kLanes : 1> unwell;  // bits by BAD_*
  std::vector<vec3> groups;
  std::vector<vec3> lamps;
  // The shadow packet that is being filled.
  embree::Ray<kWidth> shadow;
  std::array<uint, kWidth> shadow_lane;
  std::array<vec3, kWidth> shadow_contribution;
  std::array<int, kWidth> shadow_group;
  std::array<const PathState *, kWidth> shadow_paths;
  int shadow_count = 0;
  std::vector<RecordedPacket> recorded;
  bool recording = false;
  // What a call adds to the tile, kept apart so that a cancelled call leaves nothing half done.
  FilmTile staged;
  SharingLanes sharing;
  std::unique_ptr<ClassicLanes> classic;
  std::unique_ptr<ProgramLanes> programs;  // where a material varies
  Array<SurfaceShading, FEATURE(FEATURE_PROGRAMS) ? kLanes : 1> shaded;
  Alpha alpha_context;
  Array<LightWeights, FEATURE(FEATURE_LIGHT_TREE) ? kLanes : 1> light_weights;
  VectorArray<FEATURE(FEATURE_PROGRAMS) ? kLanes : 1> sky;  // what the background shows, where programs tell it
};

}  // namespace
}  // namespace cotorra

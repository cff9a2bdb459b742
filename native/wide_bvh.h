// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the BVH of kernels/bvh.h over a scene: one tree over all triangles in world space, one for each shared mesh,
// and a top level over the instances of these. Embree's BVH, for the CPU device, is scene_bvh.cpp's.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

struct BvhNode;
struct BvhTriangle;
struct BvhInstance;

struct WideBvh {
  std::vector<BvhNode> nodes;
  std::vector<BvhTriangle> triangles;
  std::vector<BvhInstance> instances;
  std::uint32_t world_root = INVALID_ID;
  std::uint32_t top_root = INVALID_ID;

  WideBvh();
  ~WideBvh();
  WideBvh(WideBvh &&) noexcept;
  WideBvh &operator=(WideBvh &&) noexcept;
  std::uint64_t bytes() const;
};

// `flattened` tells of each mesh whether it is in world space already, with one instance. Builds on `threads` threads
// (0: all); the tree does not depend on their number. Throws Cancelled where `cancel` is set meanwhile.
WideBvh build_wide_bvh(std::span<const Mesh> meshes, std::span<const Instance> instances,
                       std::span<const char> flattened, int threads, const std::atomic<bool> &cancel);

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// The hardware's acceleration structure over a scene, for devices with ray queries: which triangles go into which
// bottom level, and their building on the card. The BVH of cards without is wide_bvh.h's; rays are
// kernels/trace.glsl's.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "../kernels/scene_types.h"
#include "vulkan_api.h"

namespace cotorra {
class Scene;
struct TracedGeometry;
}  // namespace cotorra

namespace cotorra::vulkan {

// Triangles [first, first + count) of a mesh.
struct BottomPart {
  std::uint32_t mesh, first, count;
  std::uint32_t instance;  // where the mesh is in world space; else INVALID_ID
};

// A bottom level: one geometry a part.
struct BottomLevel {
  std::vector<BottomPart> parts;
  std::uint64_t triangles = 0;
};

// A bottom level, placed in the scene.
struct TopEntry {
  std::uint32_t bottom;
  std::uint32_t instance;  // whose transform it has; INVALID_ID: none
  std::uint32_t geometry;  // its first in AccelerationPlan::geometries
  std::uint32_t visibility;
};

struct AccelerationPlan {
  std::vector<BottomLevel> bottoms;
  std::vector<TopEntry> entries;
  std::vector<TracedGeometry> geometries;

  explicit AccelerationPlan(const Scene &scene);
  ~AccelerationPlan();
};

class Acceleration {
 public:
  // `meshes` are those of the scene with device addresses. Builds in slices of some milliseconds; throws DeviceError
  // where there is not enough memory or the scene is too large for the device, Cancelled.
  Acceleration(LogicalDevice &device, const Scene &scene, const AccelerationPlan &plan, std::span<const Mesh> meshes,
               const std::atomic<bool> &cancel);
  ~Acceleration();
  Acceleration(const Acceleration &) = delete;
  Acceleration &operator=(const Acceleration &) = delete;

  // Of the top level.
  std::uint64_t address() const;

 private:
  class Structure;
  struct Build;

  void check_limits(const AccelerationPlan &plan);
  Build bottom_build(const BottomLevel &bottom, std::span<const Mesh> meshes) const;
  void build_bottoms(std::span<const BottomLevel> bottoms, std::span<const Mesh> meshes);
  void build_top(const Scene &scene, const AccelerationPlan &plan);
  std::vector<std::unique_ptr<Structure>> run_builds(std::span<Build> builds, VkQueryPool sizes);
  std::vector<std::unique_ptr<Structure>> place(std::span<const std::uint64_t> sizes,
                                                VkAccelerationStructureTypeKHR type);
  std::vector<std::uint64_t> read_sizes(VkQueryPool pool, std::size_t count) const;
  void compact(std::span<const std::unique_ptr<Structure>> built, std::span<const std::uint64_t> sizes);
  void barrier(VkCommandBuffer commands) const;

  LogicalDevice &device_;
  const Scene &scene_;
  std::uint64_t scratch_alignment_ = 0;
  std::vector<std::unique_ptr<Structure>> bottoms_;
  std::unique_ptr<Structure> top_;
};

}  // namespace cotorra::vulkan

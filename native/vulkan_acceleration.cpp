// SPDX-License-Identifier: GPL-3.0-or-later
// Plans bottom levels of a bounded size, builds them a slice at a time, makes them compact, and puts the top level
// above. How a hit becomes an instance and a triangle of the scene is told by kernels/trace.glsl.
#include "vulkan_acceleration.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "scene.h"

#include "every_feature.h"

#include "../kernels/wavefront.h"

namespace cotorra::vulkan {
namespace {

// Triangles of a submission. Cards build some hundred million a second, watchdogs bark after seconds; and what is not
// compact yet takes memory.
constexpr std::uint32_t kSliceTriangles = 1 << 21;
constexpr std::size_t kSliceBottoms = 1 << 12;
constexpr std::uint64_t kStructureAlignment = 256;    // the specification's, of their places in a buffer
constexpr std::uint32_t kCustomIndices = 1 << 24;     // an instance's custom index has 24 bits
constexpr const char *kPurpose = "the acceleration structure";

std::uint64_t aligned(std::uint64_t size, std::uint64_t alignment) {
  return (size + alignment - 1) / alignment * alignment;
}

// Parts of a mesh, each small enough for a submission of its own.
template <class Take>
void split_mesh(const Mesh &mesh, std::uint32_t index, std::uint32_t instance, Take take) {
  for (std::uint32_t first = 0; first < mesh.triangle_count; first += kSliceTriangles) {
    take(BottomPart{index, first, std::min(kSliceTriangles, mesh.triangle_count - first), instance});
  }
}

// Drivers invert the transform in single precision. What has no volume cannot be entered; the BVH leaves it out, too.
bool is_invertible(const cotorra::Instance &i) { return std::isnormal(dot(i.x_axis, cross(i.y_axis, i.z_axis))); }

VkTransformMatrixKHR transform_of(const cotorra::Instance *i) {
  if (i == nullptr) return {{{1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f, 0.0f}}};
  return {{{i->x_axis.x, i->y_axis.x, i->z_axis.x, i->origin.x},
           {i->x_axis.y, i->y_axis.y, i->z_axis.y, i->origin.y},
           {i->x_axis.z, i->y_axis.z, i->z_axis.z, i->origin.z}}};
}

}  // namespace

// ---- The plan

AccelerationPlan::AccelerationPlan(const Scene &scene) {
  const std::span<const cotorra::Instance> instances = scene.instances();
  // 1. Meshes in world space share bottom levels with all that the same rays see: one traversal finds the nearest.
  std::map<std::uint32_t, std::size_t> open;  // by visibility: the bottom level that has room
  for (std::uint32_t k = 0; k < instances.size(); ++k) {
    const std::uint32_t visibility = instances[k].visibility;
    if (!scene.flattened(instances[k].mesh)) continue;
    split_mesh(scene.meshes()[instances[k].mesh], instances[k].mesh, k, [&](const BottomPart &part) {
      auto at = open.find(visibility);
      if (at == open.end() || bottoms[at->second].triangles + part.count > kSliceTriangles) {
        entries.push_back({static_cast<std::uint32_t>(bottoms.size()), INVALID_ID, 0, visibility});
        at = open.insert_or_assign(visibility, bottoms.size()).first;
        bottoms.emplace_back();
      }
      bottoms[at->second].parts.push_back(part);
      bottoms[at->second].triangles += part.count;
    });
  }
  for (TopEntry &entry : entries) {
    entry.geometry = static_cast<std::uint32_t>(geometries.size());
    for (const BottomPart &part : bottoms[entry.bottom].parts) geometries.push_back({part.instance, part.first});
  }
  // 2. Meshes that several objects show, each with bottom levels of its own.
  std::vector<std::uint32_t> first(scene.mesh_count(), INVALID_ID), end(scene.mesh_count(), 0);
  for (std::uint32_t k = 0; k < instances.size(); ++k) {
    const std::uint32_t mesh = instances[k].mesh;
    if (scene.flattened(mesh) || !is_invertible(instances[k])) continue;
    if (first[mesh] == INVALID_ID) {
      first[mesh] = static_cast<std::uint32_t>(bottoms.size());
      split_mesh(scene.meshes()[mesh], mesh, INVALID_ID,
                 [&](const BottomPart &part) { bottoms.push_back({{part}, part.count}); });
      end[mesh] = static_cast<std::uint32_t>(bottoms.size());
    }
    for (std::uint32_t bottom = first[mesh]; bottom < end[mesh]; ++bottom) {
      entries.push_back({bottom, k, static_cast<std::uint32_t>(geometries.size()), instances[k].visibility});
      geometries.push_back({k, bottoms[bottom].parts[0].first});
    }
  }
}

AccelerationPlan::~AccelerationPlan() = default;

// ---- One structure, and what it takes to build one

class Acceleration::Structure {
 public:
  // In a part of a buffer, which it keeps.
  Structure(LogicalDevice &device, std::shared_ptr<Buffer> buffer, std::uint64_t offset, std::uint64_t size,
            VkAccelerationStructureTypeKHR type)
      : device_(device), buffer_(std::move(buffer)) {
    VkAccelerationStructureCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
    info.buffer = buffer_->handle();
    info.offset = offset;
    info.size = size;
    info.type = type;
    check(device_.vkCreateAccelerationStructureKHR(device_.handle, &info, nullptr, &handle_),
          "vkCreateAccelerationStructureKHR");
    VkAccelerationStructureDeviceAddressInfoKHR address{};
    address.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
    address.accelerationStructure = handle_;
    address_ = device_.vkGetAccelerationStructureDeviceAddressKHR(device_.handle, &address);
  }
  ~Structure() { device_.vkDestroyAccelerationStructureKHR(device_.handle, handle_, nullptr); }
  Structure(const Structure &) = delete;
  Structure &operator=(const Structure &) = delete;

  VkAccelerationStructureKHR handle() const { return handle_; }
  std::uint64_t address() const { return address_; }

 private:
  LogicalDevice &device_;
  std::shared_ptr<Buffer> buffer_;
  VkAccelerationStructureKHR handle_ = VK_NULL_HANDLE;
  std::uint64_t address_ = 0;
};

struct Acceleration::Build {
  VkAccelerationStructureTypeKHR type;
  std::vector<VkAccelerationStructureGeometryKHR> geometries;
  std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
  std::uint64_t size = 0, scratch = 0;

  VkAccelerationStructureBuildGeometryInfoKHR info() const {
    VkAccelerationStructureBuildGeometryInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    if (type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR) {
      info.flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    }
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = static_cast<std::uint32_t>(geometries.size());
    info.pGeometries = geometries.data();
    return info;
  }

  void measure(const LogicalDevice &device) {
    const VkAccelerationStructureBuildGeometryInfoKHR build = info();
    std::vector<std::uint32_t> counts;
    for (const auto &range : ranges) counts.push_back(range.primitiveCount);
    VkAccelerationStructureBuildSizesInfoKHR sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    device.vkGetAccelerationStructureBuildSizesKHR(device.handle, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                                   &build, counts.data(), &sizes);
    size = sizes.accelerationStructureSize;
    scratch = sizes.buildScratchSize;
  }
};

// ---- Building

Acceleration::Acceleration(LogicalDevice &device, const Scene &scene, const AccelerationPlan &plan,
                           std::span<const Mesh> meshes, const std::atomic<bool> &cancel)
    : device_(device), scene_(scene) {
  check_limits(plan);
  const std::span<const BottomLevel> bottoms(plan.bottoms);
  for (std::size_t first = 0; first < bottoms.size();) {
    if (cancel.load(std::memory_order_relaxed)) throw Cancelled();
    std::size_t last = first;
    std::uint64_t triangles = 0;
    do {
      triangles += bottoms[last++].triangles;
    } while (last < bottoms.size() && last - first < kSliceBottoms &&
             triangles + bottoms[last].triangles <= kSliceTriangles);
    build_bottoms(bottoms.subspan(first, last - first), meshes);
    first = last;
  }
  build_top(scene, plan);
}

Acceleration::~Acceleration() = default;

std::uint64_t Acceleration::address() const { return top_->address(); }

void Acceleration::check_limits(const AccelerationPlan &plan) {
  VkPhysicalDeviceAccelerationStructurePropertiesKHR limits{};
  limits.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &limits;
  device_.instance().vkGetPhysicalDeviceProperties2(device_.physical().handle, &properties);
  scratch_alignment_ = limits.minAccelerationStructureScratchOffsetAlignment;
  const std::uint64_t most = std::min<std::uint64_t>(limits.maxInstanceCount, kCustomIndices);
  const std::uint64_t wanted = std::max(plan.entries.size(), plan.geometries.size());
  if (wanted <= most) return;
  throw DeviceError("the scene has " + std::to_string(wanted) + " instances, and ray queries of " +
                    device_.physical().info.name + " know no more than " + std::to_string(most));
}

Acceleration::Build Acceleration::bottom_build(const BottomLevel &bottom, std::span<const Mesh> meshes) const {
  Build build{VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, {}, {}};
  for (const BottomPart &part : bottom.parts) {
    const Mesh &mesh = meshes[part.mesh];
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR &triangles = geometry.geometry.triangles;
    triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = reinterpret_cast<std::uint64_t>(mesh.positions.v);
    triangles.vertexStride = sizeof(vec3);
    triangles.maxVertex = static_cast<std::uint32_t>(scene_.mesh_lengths(part.mesh).positions) - 1;
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = reinterpret_cast<std::uint64_t>(mesh.triangles.v);
    build.geometries.push_back(geometry);
    build.ranges.push_back({part.count, static_cast<std::uint32_t>(part.first * sizeof(uvec3)), 0, 0});
  }
  build.measure(device_);
  return build;
}

void Acceleration::build_bottoms(std::span<const BottomLevel> bottoms, std::span<const Mesh> meshes) {
  std::vector<Build> builds;
  for (const BottomLevel &bottom : bottoms) builds.push_back(bottom_build(bottom, meshes));
  VkQueryPoolCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
  info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
  info.queryCount = static_cast<std::uint32_t>(builds.size());
  VkQueryPool pool = VK_NULL_HANDLE;
  check(device_.vkCreateQueryPool(device_.handle, &info, nullptr, &pool), "vkCreateQueryPool");
  const auto destroy = [this](VkQueryPool *p) { device_.vkDestroyQueryPool(device_.handle, *p, nullptr); };
  const std::unique_ptr<VkQueryPool, decltype(destroy)> owner(&pool, destroy);
  const std::vector<std::unique_ptr<Structure>> built = run_builds(builds, pool);
  compact(built, read_sizes(pool, built.size()));
}

// Builds all at once, each with scratch memory of its own. Their compact sizes go into the pool, where there is one.
std::vector<std::unique_ptr<Acceleration::Structure>> Acceleration::run_builds(std::span<Build> builds,
                                                                               VkQueryPool pool) {
  std::vector<std::uint64_t> sizes;
  std::uint64_t scratch_size = scratch_alignment_;
  for (const Build &build : builds) {
    sizes.push_back(build.size);
    scratch_size += aligned(build.scratch, scratch_alignment_);
  }
  std::vector<std::unique_ptr<Structure>> built = place(sizes, builds[0].type);
  const Buffer scratch(device_, scratch_size, "building the acceleration structure");
  std::uint64_t scratch_address = aligned(scratch.address(), scratch_alignment_);
  std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
  std::vector<const VkAccelerationStructureBuildRangeInfoKHR *> ranges;
  std::vector<VkAccelerationStructureKHR> handles;
  for (std::size_t i = 0; i < builds.size(); ++i) {
    infos.push_back(builds[i].info());
    infos.back().dstAccelerationStructure = built[i]->handle();
    infos.back().scratchData.deviceAddress = scratch_address;
    scratch_address += aligned(builds[i].scratch, scratch_alignment_);
    ranges.push_back(builds[i].ranges.data());
    handles.push_back(built[i]->handle());
  }
  const auto count = static_cast<std::uint32_t>(builds.size());
  device_.run([&](VkCommandBuffer commands) {
    barrier(commands);
    device_.vkCmdBuildAccelerationStructuresKHR(commands, count, infos.data(), ranges.data());
    barrier(commands);
    if (pool == VK_NULL_HANDLE) return;
    device_.vkCmdResetQueryPool(commands, pool, 0, count);
    device_.vkCmdWriteAccelerationStructuresPropertiesKHR(
        commands, count, handles.data(), VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, pool, 0);
  });
  return built;
}

// Room for structures, side by side in one buffer.
std::vector<std::unique_ptr<Acceleration::Structure>> Acceleration::place(std::span<const std::uint64_t> sizes,
                                                                          VkAccelerationStructureTypeKHR type) {
  std::uint64_t bytes = 0;
  for (const std::uint64_t size : sizes) bytes += aligned(size, kStructureAlignment);
  const auto buffer = std::make_shared<Buffer>(device_, bytes, kPurpose);
  std::vector<std::unique_ptr<Structure>> placed;
  std::uint64_t offset = 0;
  for (const std::uint64_t size : sizes) {
    placed.push_back(std::make_unique<Structure>(device_, buffer, offset, size, type));
    offset += aligned(size, kStructureAlignment);
  }
  return placed;
}

std::vector<std::uint64_t> Acceleration::read_sizes(VkQueryPool pool, std::size_t count) const {
  std::vector<std::uint64_t> sizes(count);
  check(device_.vkGetQueryPoolResults(device_.handle, pool, 0, static_cast<std::uint32_t>(count),
                                      count * sizeof(std::uint64_t), sizes.data(), sizeof(std::uint64_t),
                                      VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  return sizes;
}

// Copies structures to where they need no more room than they have to.
void Acceleration::compact(std::span<const std::unique_ptr<Structure>> built, std::span<const std::uint64_t> sizes) {
  std::vector<std::unique_ptr<Structure>> small = place(sizes, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
  device_.run([&](VkCommandBuffer commands) {
    for (std::size_t i = 0; i < built.size(); ++i) {
      VkCopyAccelerationStructureInfoKHR copy{};
      copy.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR;
      copy.src = built[i]->handle();
      copy.dst = small[i]->handle();
      copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
      device_.vkCmdCopyAccelerationStructureKHR(commands, &copy);
    }
    barrier(commands);
  });
  std::move(small.begin(), small.end(), std::back_inserter(bottoms_));
}

void Acceleration::build_top(const Scene &scene, const AccelerationPlan &plan) {
  const std::uint64_t bytes = plan.entries.size() * sizeof(VkAccelerationStructureInstanceKHR);
  const Buffer staging(device_, bytes, kPurpose, true);
  const Buffer instances(device_, bytes, kPurpose);
  for (std::size_t i = 0; i < plan.entries.size(); ++i) {
    const TopEntry &entry = plan.entries[i];
    VkAccelerationStructureInstanceKHR instance{};
    instance.transform = transform_of(entry.instance == INVALID_ID ? nullptr : &scene.instances()[entry.instance]);
    instance.instanceCustomIndex = entry.geometry & (kCustomIndices - 1);
    instance.mask = entry.visibility & 0xff;
    instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    instance.accelerationStructureReference = bottoms_[entry.bottom]->address();
    std::memcpy(staging.data() + i * sizeof instance, &instance, sizeof instance);
  }
  if (bytes > 0) {
    device_.run([&](VkCommandBuffer commands) {
      const VkBufferCopy region{0, 0, bytes};
      device_.vkCmdCopyBuffer(commands, staging.handle(), instances.handle(), 1, &region);
    });
  }
  VkAccelerationStructureGeometryKHR geometry{};
  geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  geometry.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
  geometry.geometry.instances.data.deviceAddress = instances.address();
  Build build{VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
              {geometry},
              {{static_cast<std::uint32_t>(plan.entries.size()), 0, 0, 0}}};
  build.measure(device_);
  top_ = std::move(run_builds(std::span(&build, 1), VK_NULL_HANDLE).front());
}

// What was copied or built before may be built upon after, and traced by the stages.
void Acceleration::barrier(VkCommandBuffer commands) const {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
  memory.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                         VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
  constexpr VkPipelineStageFlags build = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
  device_.vkCmdPipelineBarrier(commands, build | VK_PIPELINE_STAGE_TRANSFER_BIT,
                               build | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

}  // namespace cotorra::vulkan

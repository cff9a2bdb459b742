// SPDX-License-Identifier: GPL-3.0-or-later
// Builds Embree's two-level BVH over a scene: meshes that one object shows lie in the top level in world space, shared
// meshes have a BVH of their own under instance arrays. Nothing is traced here.
#include <chrono>
#include <string>

#include "../kernels/program/ops.h"
#include "memory.h"
#include "scene.h"

namespace cotorra {
namespace {

// Scenes of more triangles get Embree's compact BVH: half the memory for a sixth of the traversal speed (35 instead of
// 70 bytes a triangle; 10.9 instead of 12.8 million rays a second on 472k triangles). Cycles has it by default.
constexpr std::uint64_t kCompactTriangles = 1'000'000;
constexpr std::uint64_t kCompactBytes = 35, kUsualBytes = 70;

// Embree tells before it takes memory, and when it gave some back.
bool count_memory(void *counter, ssize_t bytes, bool) {
  auto &memory = *static_cast<BvhMemory *>(counter);
  const std::int64_t now = memory.bytes.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  std::int64_t most = memory.most.load(std::memory_order_relaxed);
  while (most < now && !memory.most.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
  }
  return true;
}

bool keep_building(void *cancel, double) {
  return !static_cast<const std::atomic<bool> *>(cancel)->load(std::memory_order_relaxed);
}

}  // namespace

// At least, as far as is known.
std::uint64_t Scene::bvh_bytes_needed() const {
  const bool compact = stats_.triangles > kCompactTriangles;
  const std::uint64_t usual = stats_.triangles * (compact ? kCompactBytes : kUsualBytes);
  return std::max(usual, static_cast<std::uint64_t>(std::max<std::int64_t>(bvh_memory_.most.load(), 0)));
}

void Scene::check_embree(const std::string &doing) const {
  const int error = api().get_device_error(device_);
  if (error == embree::kNone) return;
  if (error == embree::kCancelled) throw Cancelled();
  const char *text = api().get_device_last_error_message(device_);
  const std::string what = "Embree, " + doing + ": " + (text != nullptr ? text : "unknown error");
  if (error == embree::kOutOfMemory) {
    throw OutOfMemory(bvh_bytes_needed(), "the BVH (" + what + ")");
  }
  throw std::runtime_error(what + " (error " + std::to_string(error) + ")");
}

void Scene::build_bvh(std::shared_ptr<const embree::Library> library, int threads, const std::atomic<bool> &cancel) {
  if (bvh_ != nullptr) return;
  library_ = std::move(library);
  try {
    build(threads, cancel);
  } catch (...) {
    release();
    throw;
  }
  stats_.bytes += stats_.bvh_bytes;
}

void Scene::build(int threads, const std::atomic<bool> &cancel) {
  const auto begin = std::chrono::steady_clock::now();
  const embree::Api &rtc = api();
  const std::string config = threads > 0 ? "threads=" + std::to_string(threads) : "";
  device_ = rtc.new_device(config.c_str());
  if (device_ == nullptr) {
    if (rtc.get_device_error(nullptr) == embree::kOutOfMemory) {
      throw OutOfMemory(bvh_bytes_needed(), "the BVH (Embree cannot make a device)");
    }
    throw std::runtime_error("Embree could not make a device for this processor");
  }
  const ssize_t version = rtc.get_device_property(device_, embree::kPropertyVersion);
  if (version < 40300 || version >= 50000) {
    throw std::runtime_error("Embree 4.3 or a later 4.x is needed, " + library_->path() + " is version " +
                             std::to_string(version));
  }
  rtc.set_device_memory_monitor(device_, count_memory, &bvh_memory_);
  void *cancel_pointer = const_cast<std::atomic<bool> *>(&cancel);

  // Only meshes that let rays through somewhere are asked about each hit; or all, where a ray must not meet the
  // triangle that it left, or programs trace rays.
  const bool for_programs = ((surface_needs_.groups | emission_needs_.groups) & GROUP_RAYS) != 0;
  std::vector<bool> lets_through(meshes_.size(), lets_light_through_ || for_programs);
  for (const Instance &instance : instances_) {
    for (uint s = 0; s < instance.material_count; ++s) {
      const Material &material = materials_[material_slots_[instance.material_base + s]];
      if ((material.flags & MATERIAL_TRANSPARENT) != 0) lets_through[instance.mesh] = true;
    }
  }

  // Embree hands out null where it cannot make something, and notes why.
  const auto made = [&](auto handle) {
    if (handle == nullptr) check_embree("making a scene");
    return handle;
  };
  const auto triangle_geometry = [&](std::size_t k) {
    const Mesh &mesh = meshes_[k];
    embree::Geometry geometry = made(rtc.new_geometry(device_, embree::kTriangles));
    rtc.set_shared_geometry_buffer(geometry, embree::kVertexBuffer, 0, embree::kFloat3, mesh.positions.v, 0,
                                   sizeof(vec3), storage_[k].lengths.positions);
    rtc.set_shared_geometry_buffer(geometry, embree::kIndexBuffer, 0, embree::kUint3, mesh.triangles.v, 0,
                                   sizeof(uvec3), mesh.triangle_count);
    if (lets_through[k]) rtc.set_geometry_enable_filter(geometry, true);
    return geometry;
  };
  const auto attach = [&](embree::Scene scene, embree::Geometry geometry, uint mask, uint id) {
    rtc.set_geometry_mask(geometry, mask);
    rtc.commit_geometry(geometry);
    rtc.attach_geometry_by_id(scene, geometry, id);
    rtc.release_geometry(geometry);
  };

  const bool compact = stats_.triangles > kCompactTriangles;

  // 1. One BVH for each shared mesh.
  mesh_scenes_.assign(meshes_.size(), nullptr);
  for (const Instance &instance : instances_) {
    const std::size_t k = instance.mesh;
    if (storage_[k].flattened || mesh_scenes_[k] != nullptr || meshes_[k].triangle_count == 0) continue;
    mesh_scenes_[k] = made(rtc.new_scene(device_));
    if (compact) rtc.set_scene_flags(mesh_scenes_[k], embree::kSceneCompact);
    rtc.set_scene_progress_monitor(mesh_scenes_[k], keep_building, cancel_pointer);
    attach(mesh_scenes_[k], triangle_geometry(k), VISIBLE_ANYHOW, 0);
    rtc.commit_scene(mesh_scenes_[k]);
    check_embree("building that of mesh '" + storage_[k].name + "'");
    instanced_ = true;
  }

  // 2. The top level: flattened meshes, and one instance array for each run of instances with one mesh and visibility.
  bvh_ = made(rtc.new_scene(device_));
  if (compact) rtc.set_scene_flags(bvh_, embree::kSceneCompact);
  rtc.set_scene_progress_monitor(bvh_, keep_building, cancel_pointer);
  for (std::size_t first = 0; first < instances_.size();) {
    const Instance &head = instances_[first];
    std::size_t last = first + 1;
    while (last < instances_.size() && instances_[last].mesh == head.mesh &&
           instances_[last].visibility == head.visibility) {
      ++last;
    }
    if (meshes_[head.mesh].triangle_count > 0) {
      const uint id = static_cast<uint>(first_instances_.size());
      first_instances_.push_back(static_cast<uint>(first));
      if (storage_[head.mesh].flattened) {
        attach(bvh_, triangle_geometry(head.mesh), head.visibility, id);
      } else {
        embree::Geometry array = made(rtc.new_geometry(device_, embree::kInstanceArray));
        rtc.set_geometry_instanced_scene(array, mesh_scenes_[head.mesh]);
        // An Instance begins with its four columns, each three floats and a word that Embree ignores.
        rtc.set_shared_geometry_buffer(array, embree::kTransformBuffer, 0, embree::kFloat4x4ColumnMajor, &head, 0,
                                       sizeof(Instance), last - first);
        attach(bvh_, array, head.visibility, id);
      }
      check_embree("adding geometry");
    }
    first = last;
  }
  rtc.commit_scene(bvh_);
  check_embree("building that of the scene");
  stats_.bvh_bytes = static_cast<std::uint64_t>(std::max<std::int64_t>(bvh_memory_.bytes.load(), 0));
  stats_.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Scene::release() {
  if (device_ == nullptr) return;
  if (bvh_ != nullptr) api().release_scene(bvh_);
  for (embree::Scene scene : mesh_scenes_) {
    if (scene != nullptr) api().release_scene(scene);
  }
  mesh_scenes_.clear();
  first_instances_.clear();
  api().release_device(device_);
  bvh_ = nullptr;
  device_ = nullptr;
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Builds Embree's two-level BVH over a scene: meshes that one object shows lie in the top level in world space, shared
// meshes have a BVH of their own under instance arrays. Nothing is traced here.
#include <chrono>
#include <string>

#include "../kernels/program/ops.h"
#include "memory.h"
#include "parallel.h"
#include "scene_bvh.h"

namespace cotorra {
namespace {

// Scenes of more triangles get Embree's compact BVH: less memory for a quarter of the traversal speed (32 instead of 55
// bytes a triangle of a pair, the quadrilaterals included; in one run rays took 1.38 times as long on 472k triangles).
// Cycles has it by default.
constexpr std::uint64_t kCompactTriangles = 1'000'000;
constexpr std::uint64_t kCompactBytes = 32, kUsualBytes = 55;

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
  const std::int64_t most = embree_ != nullptr ? embree_->memory.most.load() : 0;
  const std::uint64_t usual = stats_.triangles * (compact ? kCompactBytes : kUsualBytes);
  return std::max(usual, static_cast<std::uint64_t>(std::max<std::int64_t>(most, 0)));
}

void Scene::check_embree(const std::string &doing) const {
  const int error = api().get_device_error(embree_->handle);
  if (error == embree::kNone) return;
  if (error == embree::kCancelled) throw Cancelled();
  const char *text = api().get_device_last_error_message(embree_->handle);
  const std::string what = "Embree, " + doing + ": " + (text != nullptr ? text : "unknown error");
  if (error == embree::kOutOfMemory) {
    throw OutOfMemory(bvh_bytes_needed(), "the BVH (" + what + ")");
  }
  throw std::runtime_error(what + " (error " + std::to_string(error) + ")");
}

const embree::Api &Scene::api() const { return embree_->library->api(); }

void Scene::build_bvh(std::shared_ptr<const embree::Library> library, int threads, const std::atomic<bool> &cancel,
                      const Scene *previous) {
  if (bvh_ != nullptr) return;
  try {
    open_device(std::move(library), threads, previous);
    build(cancel, previous);
  } catch (...) {
    release();
    throw;
  }
  stats_.bytes += stats_.bvh_bytes;
}

// The previous scene's device, where it is such a one: BVHs cannot be taken to another.
void Scene::open_device(std::shared_ptr<const embree::Library> library, int threads, const Scene *previous) {
  const std::string config = threads > 0 ? "threads=" + std::to_string(threads) : "";
  if (editable_ && previous != nullptr && previous->bvh_ != nullptr && previous->embree_->config == config) {
    embree_ = previous->embree_;
    return;
  }
  embree_ = std::make_shared<EmbreeDevice>();
  embree_->library = std::move(library);
  embree_->config = config;
  const embree::Api &rtc = api();
  embree_->handle = rtc.new_device(config.c_str());
  if (embree_->handle == nullptr) {
    if (rtc.get_device_error(nullptr) == embree::kOutOfMemory) {
      throw OutOfMemory(bvh_bytes_needed(), "the BVH (Embree cannot make a device)");
    }
    throw std::runtime_error("Embree could not make a device for this processor");
  }
  const ssize_t version = rtc.get_device_property(embree_->handle, embree::kPropertyVersion);
  if (version < 40300 || version >= 50000) {
    throw std::runtime_error("Embree 4.3 or a later 4.x is needed, " + embree_->library->path() + " is version " +
                             std::to_string(version));
  }
  rtc.set_device_memory_monitor(embree_->handle, count_memory, &embree_->memory);
}

// The BVH of a mesh that the previous scene has as well, if it was built in the same way.
std::shared_ptr<const MeshBvh> Scene::taken_over(std::size_t mesh, bool lets_through, bool compact,
                                                 const Scene *previous) const {
  if (previous == nullptr || known_.empty() || known_[mesh] < 0 || previous->embree_ != embree_) return nullptr;
  std::shared_ptr<const MeshBvh> found = previous->mesh_bvhs_[static_cast<std::size_t>(known_[mesh])];
  const bool same = found != nullptr && found->mesh == storage_[mesh] && found->lets_through == lets_through &&
                    found->compact == compact;
  return same ? found : nullptr;
}

std::shared_ptr<const std::vector<Quad>> Scene::quads_of(std::size_t mesh) const {
  const std::span<const uvec3> triangles(meshes_[mesh].triangles.v, meshes_[mesh].triangle_count);
  const std::span<const vec3> positions(meshes_[mesh].positions.v, storage_[mesh]->lengths.positions);
  const std::string name = "mesh '" + storage_[mesh]->name + "'";
  if (triangles.size() > kQuadTriangles) {
    throw std::invalid_argument(name + " has " + std::to_string(triangles.size()) + " triangles, at most " +
                                std::to_string(kQuadTriangles) + " can be traced");
  }
  std::shared_ptr<const std::vector<Quad>> quads;
  with_memory(triangles.size() * sizeof(Quad) / 2, name,
              [&] { quads = std::make_shared<const std::vector<Quad>>(pair_triangles(triangles, positions)); });
  return quads;
}

void Scene::build(const std::atomic<bool> &cancel, const Scene *previous) {
  const auto begin = std::chrono::steady_clock::now();
  const embree::Api &rtc = api();
  void *cancel_pointer = const_cast<std::atomic<bool> *>(&cancel);

  // Only meshes that let rays through somewhere are asked about each hit; or those that rays leave at the very point,
  // whose triangle they must not meet; or all, where programs trace rays.
  const bool for_programs = ((surface_needs_.groups | emission_needs_.groups) & GROUP_RAYS) != 0;
  std::vector<bool> lets_through = coplanar_;
  lets_through.resize(meshes_.size(), false);
  if (for_programs) lets_through.assign(meshes_.size(), true);
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
  const auto mesh_geometry = [&](std::size_t k) {
    const Mesh &mesh = meshes_[k];
    embree::Geometry geometry = made(rtc.new_geometry(embree_->handle, embree::kQuads));
    rtc.set_shared_geometry_buffer(geometry, embree::kVertexBuffer, 0, embree::kFloat3, mesh.positions.v, 0,
                                   sizeof(vec3), storage_[k]->lengths.positions);
    rtc.set_shared_geometry_buffer(geometry, embree::kIndexBuffer, 0, embree::kUint4, quads_[k]->data(), 0,
                                   sizeof(Quad), quads_[k]->size());
    if (lets_through[k]) rtc.set_geometry_enable_filter(geometry, true);
    return geometry;
  };
  const auto attach = [&](embree::Scene scene, embree::Geometry geometry, uint mask, uint id) {
    rtc.set_geometry_mask(geometry, mask);
    rtc.commit_geometry(geometry);
    rtc.attach_geometry_by_id(scene, geometry, id);
    rtc.release_geometry(geometry);
  };

  // Robust: no ray slips through between two triangles that share an edge.
  const bool compact = stats_.triangles > kCompactTriangles;
  const int flags = embree::kSceneRobust | (compact ? embree::kSceneCompact : 0);

  // 1. What is traced of each mesh; a BVH that the previous scene has knows it.
  mesh_bvhs_.assign(meshes_.size(), nullptr);
  quads_.assign(meshes_.size(), nullptr);
  parallel_for(meshes_.size(), [&](std::size_t k) {
    if (!flattened_[k]) mesh_bvhs_[k] = taken_over(k, lets_through[k], compact, previous);
    quads_[k] = mesh_bvhs_[k] != nullptr ? mesh_bvhs_[k]->quads : quads_of(k);
  });

  // 2. One BVH for each mesh that is not in the top level.
  for (const Instance &instance : instances_) {
    const std::size_t k = instance.mesh;
    if (flattened_[k] || meshes_[k].triangle_count == 0) continue;
    instanced_ = true;
    if (mesh_bvhs_[k] != nullptr) continue;
    const auto bvh = std::make_shared<MeshBvh>();
    bvh->device = embree_;
    bvh->mesh = storage_[k];
    bvh->quads = quads_[k];
    bvh->lets_through = lets_through[k];
    bvh->compact = compact;
    bvh->scene = made(rtc.new_scene(embree_->handle));
    rtc.set_scene_flags(bvh->scene, flags);
    rtc.set_scene_progress_monitor(bvh->scene, keep_building, cancel_pointer);
    attach(bvh->scene, mesh_geometry(k), ~0u, 0);  // its instances have masks
    rtc.commit_scene(bvh->scene);
    check_embree("building that of mesh '" + storage_[k]->name + "'");
    mesh_bvhs_[k] = bvh;
  }

  // 3. The top level: flattened meshes, and one instance array for each run of instances with one mesh and visibility.
  bvh_ = made(rtc.new_scene(embree_->handle));
  rtc.set_scene_flags(bvh_, flags);
  rtc.set_scene_progress_monitor(bvh_, keep_building, cancel_pointer);
  for (std::size_t first = 0; first < instances_.size();) {
    const Instance &head = instances_[first];
    std::size_t last = first + 1;
    while (last < instances_.size() && instances_[last].mesh == head.mesh &&
           instances_[last].visibility == head.visibility) {
      ++last;
    }
    if (meshes_[head.mesh].triangle_count > 0) {
      const uint id = static_cast<uint>(geometries_.size());
      geometries_.push_back({static_cast<uint>(first), quads_[head.mesh]->data(), meshes_[head.mesh].positions.v});
      if (flattened_[head.mesh]) {
        attach(bvh_, mesh_geometry(head.mesh), head.visibility, id);
      } else {
        embree::Geometry array = made(rtc.new_geometry(embree_->handle, embree::kInstanceArray));
        rtc.set_geometry_instanced_scene(array, mesh_bvhs_[head.mesh]->scene);
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
  stats_.bvh_bytes = static_cast<std::uint64_t>(std::max<std::int64_t>(embree_->memory.bytes.load(), 0));
  for (const auto &quads : quads_) stats_.bvh_bytes += quads->size() * sizeof(Quad);
  stats_.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Scene::release() {
  if (bvh_ != nullptr) api().release_scene(bvh_);
  bvh_ = nullptr;
  mesh_bvhs_.clear();
  geometries_.clear();
  quads_.clear();
  embree_.reset();
}

}  // namespace cotorra

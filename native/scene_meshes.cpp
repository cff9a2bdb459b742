// SPDX-License-Identifier: GPL-3.0-or-later
// The meshes of a scene: which of them an earlier scene has, so that both share them, and which stand in world space.
// Their BVHs are built in scene_bvh.cpp.
#include <algorithm>
#include <cmath>
#include <map>

#include "memory.h"
#include "parallel.h"
#include "scene.h"

namespace cotorra {

MeshIdentity identity_of(const MeshInput &m) {
  const auto of = [](auto span) { return std::pair<const void *, std::size_t>(span.data(), span.size()); };
  return {of(m.positions), of(m.triangles), of(m.corners),
          of(m.normals),   of(m.uv),        of(m.slots),
          of(m.tangents),  of(m.generated), {nullptr, (m.corner_normals ? 2u : 0u) + (m.positions_padded ? 1u : 0u)}};
}

void Scene::recognise(const SceneInput &in, const Scene *previous) {
  known_.assign(in.meshes.size(), -1);
  if (!editable_ || previous == nullptr || !previous->editable_) return;
  std::map<MeshIdentity, int> numbers;
  for (std::size_t k = 0; k < previous->storage_.size(); ++k) {
    const MeshStorage &storage = *previous->storage_[k];
    if (storage.owner != nullptr) numbers.emplace(storage.identity, static_cast<int>(k));
  }
  for (std::size_t k = 0; k < in.meshes.size(); ++k) {
    const auto found = numbers.find(identity_of(in.meshes[k]));
    if (found != numbers.end()) known_[k] = found->second;
  }
}

// A mesh that one object shows goes into the top-level BVH in world space: no transform at each ray. In an editable
// scene it does so where no transform leads back, from which rays could be sent into its own space.
bool Scene::belongs_to_top(uint users, const Instance &instance) const {
  if (users != 1) return false;
  return !editable_ || dot(instance.x_axis, cross(instance.y_axis, instance.z_axis)) == 0.0f;
}

void Scene::prepare_meshes(SceneInput &in, const Scene *previous) {
  std::vector<uint> users(in.meshes.size(), 0);
  for (const Instance &i : instances_) ++users[i.mesh];
  storage_.resize(in.meshes.size());
  meshes_.resize(in.meshes.size());
  flattened_.assign(in.meshes.size(), false);
  std::vector<Instance *> only(in.meshes.size(), nullptr);
  for (Instance &i : instances_) only[i.mesh] = &i;

  for (std::size_t k = 0; k < in.meshes.size(); ++k) {
    flattened_[k] = only[k] != nullptr && belongs_to_top(users[k], *only[k]);
    stats_.triangles += in.meshes[k].triangles.size();
    stats_.instanced_triangles += in.meshes[k].triangles.size() * users[k];
  }
  parallel_for(in.meshes.size(), [&](std::size_t k) {
    MeshInput &source = in.meshes[k];
    prepare_mesh(k, source, only[k], previous);
    Mesh &mesh = meshes_[k];
    mesh.triangles = {source.triangles.data()};
    mesh.corners = {source.corners.data()};
    mesh.uv = {source.uv.data()};
    mesh.slots = {source.slots.data()};
    mesh.triangle_count = static_cast<uint>(source.triangles.size());
    if (!source.normals.empty()) mesh.flags |= source.corner_normals ? MESH_SMOOTH_CORNER : MESH_SMOOTH_VERTEX;
    if (!source.uv.empty()) mesh.flags |= MESH_HAS_UV;
    if (!source.slots.empty()) mesh.flags |= MESH_HAS_SLOTS;
    if (!source.generated.empty()) mesh.flags |= MESH_HAS_GENERATED;
  });
}

// Places and normals of a mesh: the exporter's, or the previous scene's, or moved to world space for its one instance.
void Scene::prepare_mesh(std::size_t k, MeshInput &source, Instance *instance, const Scene *previous) {
  const bool move = flattened_[k] && (instance->flags & INSTANCE_IDENTITY) == 0;
  Mesh &mesh = meshes_[k];
  if (!move && known_[k] >= 0) {
    const auto known = static_cast<std::size_t>(known_[k]);
    if (!previous->storage_[known]->moved) {
      storage_[k] = previous->storage_[known];
      mesh.positions = previous->meshes_[known].positions;
      mesh.normals = previous->meshes_[known].normals;
      return;
    }
  }
  storage_[k] = std::make_shared<MeshStorage>();
  MeshStorage &storage = *storage_[k];
  storage.identity = identity_of(source);
  storage.name = std::move(source.name);
  storage.owner = std::move(source.owner);
  storage.lengths = {source.positions.size(), source.triangles.size(), source.corners.size(),
                     source.normals.size(),   source.uv.size(),        source.slots.size()};
  const vec3 *positions = source.positions.data();
  const vec3 *normals = source.normals.data();
  if (move || !source.positions_padded) {
    with_memory((source.positions.size() + (move ? source.normals.size() : 0)) * sizeof(vec3),
                "mesh '" + storage.name + "'", [&] {
                  storage.positions.reserve(source.positions.size() + 1);  // Embree reads 16 bytes at the last vertex
                  if (move) storage.normals.reserve(source.normals.size());
                });
    for (const vec3 p : source.positions) {
      storage.positions.push_back(
          move ? instance->x_axis * p.x + instance->y_axis * p.y + instance->z_axis * p.z + instance->origin : p);
    }
    storage.positions.push_back(vec3(0.0f));
    positions = storage.positions.data();
  }
  if (move) {
    storage.moved = true;
    note_frame(k, *instance);
    for (const vec3 n : source.normals) {
      const vec3 moved = instance->normal_x * n.x + instance->normal_y * n.y + instance->normal_z * n.z;
      const float len2 = dot(moved, moved);
      storage.normals.push_back(len2 > 0.0f ? moved * (1.0f / std::sqrt(len2)) : vec3(0.0f));
    }
    if (!storage.normals.empty()) normals = storage.normals.data();
    instance->x_axis = instance->normal_x = {1.0f, 0.0f, 0.0f};
    instance->y_axis = instance->normal_y = {0.0f, 1.0f, 0.0f};
    instance->z_axis = instance->normal_z = {0.0f, 0.0f, 1.0f};
    instance->origin = {0.0f, 0.0f, 0.0f};
    instance->flags |= INSTANCE_IDENTITY;
  }
  mesh.positions = {positions};
  mesh.normals = {normals};
}

}  // namespace cotorra

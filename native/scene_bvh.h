// SPDX-License-Identifier: GPL-3.0-or-later
// What scenes hold of Embree and may share: the device, and the BVHs of meshes. Each ends with its last holder.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "embree.h"
#include "scene.h"

namespace cotorra {

// What Embree holds, and the most that it asked for.
struct BvhMemory {
  std::atomic<std::int64_t> bytes{0}, most{0};
};

struct EmbreeDevice {
  std::shared_ptr<const embree::Library> library;
  std::string config;
  BvhMemory memory;  // the device counts in it
  embree::Device handle = nullptr;

  EmbreeDevice() = default;
  EmbreeDevice(const EmbreeDevice &) = delete;
  EmbreeDevice &operator=(const EmbreeDevice &) = delete;
  ~EmbreeDevice() {
    if (handle != nullptr) library->api().release_device(handle);
  }
};

// The BVH of a mesh in its own space, and what it is built over.
struct MeshBvh {
  std::shared_ptr<EmbreeDevice> device;
  std::shared_ptr<const MeshStorage> mesh;
  std::shared_ptr<const std::vector<Quad>> quads;
  embree::Scene scene = nullptr;
  bool lets_through = false;  // whether each hit is asked about
  bool compact = false;

  MeshBvh() = default;
  MeshBvh(const MeshBvh &) = delete;
  MeshBvh &operator=(const MeshBvh &) = delete;
  ~MeshBvh() {
    if (scene != nullptr) device->library->api().release_scene(scene);
  }
};

}  // namespace cotorra

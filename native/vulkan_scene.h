// SPDX-License-Identifier: GPL-3.0-or-later
// A scene in the memory of a graphics card: its arrays copied, their records referring to each other by device address.
// What is not here a kernel of the card cannot read; what a scene is, is told in scene.h.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scene.h"
#include "vulkan_api.h"

namespace cotorra::vulkan {

// Copies arrays into a few large buffers, through one that the host sees.
class Uploader {
 public:
  explicit Uploader(LogicalDevice &device);
  ~Uploader();

  // The device address of a copy; 0 for an empty array.
  template <class T>
  const T *put(std::span<const T> array, const char *purpose) {
    return reinterpret_cast<const T *>(put_bytes(std::as_bytes(array), purpose));
  }
  const LogicalDevice &device() const { return device_; }
  // Copies what still waits, and gives the buffers to their owner.
  std::vector<std::unique_ptr<Buffer>> finish();

 private:
  struct Copy {
    VkBuffer target;
    VkBufferCopy region;
  };
  std::uint64_t put_bytes(std::span<const std::byte> bytes, const char *purpose);
  void flush();

  LogicalDevice &device_;
  Buffer staging_;
  std::uint64_t staged_ = 0;
  std::vector<Copy> copies_;
  std::vector<std::unique_ptr<Buffer>> blocks_;
  std::uint64_t block_used_ = 0;
};

// `data`, a session's view of the scene, gets the device addresses of copies of all that it refers to, as far as
// kernels with these features read it. Returns the meshes with the addresses of theirs.
std::vector<Mesh> upload_scene(const Scene &scene, std::uint32_t features, Uploader &uploader, SceneData &data);

}  // namespace cotorra::vulkan

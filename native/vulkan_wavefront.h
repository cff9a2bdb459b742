// SPDX-License-Identifier: GPL-3.0-or-later
// All that is on a graphics card while one session renders, and how the stages of kernels/*.comp are driven over it.
// Which card, and whether it can, is device_vulkan.cpp's.
#pragma once

#include <memory>
#include <mutex>
#include <span>

#include "device.h"
#include "vulkan_api.h"

namespace cotorra::vulkan {

// Written by the thread that renders, read by others.
struct SharedFigures {
  std::mutex mutex;
  DeviceFigures figures;
};

class Wavefront : public Workspace {
 public:
  // The job has another camera, seed or number of samples.
  virtual void look_again() = 0;
  // As Device::render.
  virtual bool render(std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count, RayCounts &counts) = 0;
};

// Copies the scene to the card and compiles the kernels, which trace by ray queries or a BVH of ours. `job` must
// outlive the result. Throws DeviceError.
std::unique_ptr<Wavefront> make_wavefront(const Scene &scene, const RenderJob &job, const DeviceChoice &choice,
                                          std::shared_ptr<Instance> instance, const Physical &physical, bool ray_query,
                                          SharedFigures &figures);

// As compile_vulkan_kernels of device.h.
std::vector<CompiledStage> compile_kernels(std::uint32_t features, const ProgramNeeds &programs,
                                           const std::string &cache, std::shared_ptr<Instance> instance,
                                           const Physical &physical, bool ray_query);

}  // namespace cotorra::vulkan

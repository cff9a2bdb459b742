// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of kernels/*.comp as compute pipelines, their features compiled in, with a cache on disk.
// In which order they run is device_vulkan.cpp's.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "program_compile.h"
#include "vulkan_api.h"

namespace cotorra::vulkan {

// The order is that of the arrays in vulkan_pipelines.cpp.
enum class Stage : std::size_t {
  kBegin,
  kPrepare,
  kTrace,
  kOutline,
  kShade,
  kLight,
  kShadow,
  kBounce,
  kFilm,
  kGather,
  kCount
};

// What is compiled into the stages.
struct KernelChoice {
  std::uint32_t features = 0;
  // What the programs of the scene need, by the parts of materials; a stage has what it runs.
  ProgramNeeds surface, emission, transparency;
};

class Pipelines {
 public:
  // Compiles on several threads, or with `report` one stage after the other. `cache` is a folder, empty for none; what
  // cannot be read or written there is done without.
  Pipelines(LogicalDevice &device, const KernelChoice &choice, std::uint32_t push_size, const std::string &cache,
            std::vector<CompiledStage> *report = nullptr);
  ~Pipelines();
  Pipelines(const Pipelines &) = delete;
  Pipelines &operator=(const Pipelines &) = delete;

  VkPipeline operator[](Stage stage) const { return pipelines_[static_cast<std::size_t>(stage)]; }
  VkPipelineLayout layout() const { return layout_; }

 private:
  void compile(std::size_t stage, const KernelChoice &choice);
  void compile_all(const KernelChoice &choice);
  CompiledStage compile_and_report(std::size_t stage, const KernelChoice &choice);
  void load_cache(const std::string &path);
  void save_cache(const std::string &path) const;
  void release();

  LogicalDevice &device_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  std::size_t loaded_bytes_ = 0;
  std::array<VkPipeline, static_cast<std::size_t>(Stage::kCount)> pipelines_{};
};

}  // namespace cotorra::vulkan

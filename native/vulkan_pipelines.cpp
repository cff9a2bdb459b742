// SPDX-License-Identifier: GPL-3.0-or-later
// Compiles the stages, whose SPIR-V the build has put into this file, for one device.
#include "vulkan_pipelines.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <span>
#include <vector>

#include "../kernels/program/ops.h"
#include "spirv_specialize.h"

namespace cotorra::vulkan {
namespace {

#include "vulkan_spirv.inc"  // wave_begin ...: arrays of words, made by CMakeLists.txt

using Stages = std::array<std::span<const std::uint32_t>, static_cast<std::size_t>(Stage::kCount)>;
constexpr Stages kSoftwareStages = {wave_begin, wave_prepare, wave_trace,  wave_outline, wave_shade,
                                    wave_light, wave_shadow,  wave_bounce, wave_film,    wave_gather};
constexpr Stages kQueryStages = {wave_begin, wave_prepare,      wave_trace_query, wave_outline, wave_shade_query,
                                 wave_light, wave_shadow_query, wave_bounce,      wave_film,    wave_gather};

const Stages &stages_of(const LogicalDevice &device) { return device.ray_query() ? kQueryStages : kSoftwareStages; }

constexpr const char *kStageNames[] = {"begin", "prepare", "trace",  "outline", "shade",
                                       "light", "shadow",  "bounce", "film",    "gather"};
static_assert(std::size(kStageNames) == kQueryStages.size());

double value_of(const VkPipelineExecutableStatisticKHR &s) {
  switch (s.format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
      return s.value.b32 != 0 ? 1.0 : 0.0;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
      return static_cast<double>(s.value.i64);
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
      return static_cast<double>(s.value.u64);
    default:
      return s.value.f64;
  }
}

// What the driver says of a pipeline that was compiled to tell it.
std::vector<std::pair<std::string, double>> statistics_of(const LogicalDevice &device, VkPipeline pipeline) {
  const auto get = reinterpret_cast<PFN_vkGetPipelineExecutableStatisticsKHR>(
      device.instance().vkGetDeviceProcAddr(device.handle, "vkGetPipelineExecutableStatisticsKHR"));
  VkPipelineExecutableInfoKHR info{};  // executable 0: a compute pipeline has no other
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR;
  info.pipeline = pipeline;
  std::uint32_t count = 0;
  check(get(device.handle, &info, &count, nullptr), "vkGetPipelineExecutableStatisticsKHR");
  std::vector<VkPipelineExecutableStatisticKHR> list(count);
  for (auto &s : list) s.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
  check(get(device.handle, &info, &count, list.data()), "vkGetPipelineExecutableStatisticsKHR");
  std::vector<std::pair<std::string, double>> statistics;
  for (const auto &s : list) statistics.emplace_back(s.name, value_of(s));
  return statistics;
}

// FNV-1a over all stages: a cache of other kernels has another name.
std::uint64_t kernels_hash(const Stages &stages, const KernelChoice &choice) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&hash](std::uint32_t word) { hash = (hash ^ word) * 0x100000001b3u; };
  for (const auto words : stages) {
    for (const std::uint32_t word : words) add(word);
  }
  add(choice.features);
  for (const ProgramNeeds *needs : {&choice.surface, &choice.emission, &choice.transparency}) {
    add(needs->groups);
    add(needs->variants);
  }
  return hash;
}

// What of the programs a stage runs.
ProgramNeeds needs_of(std::size_t stage, const KernelChoice &choice) {
  ProgramNeeds needs;
  if ((choice.features & FEATURE_PROGRAMS) == 0) return needs;
  const auto is = [stage](Stage other) { return stage == static_cast<std::size_t>(other); };
  const auto add = [&needs](const ProgramNeeds &part, std::uint32_t kind) {
    needs.add(part);
    if (part.groups != 0) needs.groups |= kind;
  };
  if (is(Stage::kShade)) add(choice.surface, GROUP_SURFACES);
  if (is(Stage::kShade) || is(Stage::kLight)) add(choice.emission, GROUP_EMISSIONS);
  if (is(Stage::kTrace) || is(Stage::kShadow) || is(Stage::kLight)) add(choice.transparency, GROUP_TRANSPARENCIES);
  // Whitted's shadow rays ask what the glass is that they cross.
  if (is(Stage::kShadow) && (choice.features & FEATURE_WHITTED) != 0) add(choice.surface, GROUP_SURFACES);
  return needs;
}

std::string cache_path(const std::string &folder, const LogicalDevice &device, const KernelChoice &choice) {
  if (folder.empty()) return "";
  std::string uuid;  // the driver's: another version has another
  const VkPhysicalDeviceProperties &properties = device.physical().properties;
  for (const std::uint8_t byte : properties.pipelineCacheUUID) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    uuid += digits;
  }
  char name[64];
  std::snprintf(name, sizeof name, "%04x-%04x-%016llx.bin", properties.vendorID, properties.deviceID,
                static_cast<unsigned long long>(kernels_hash(stages_of(device), choice)));
  return (std::filesystem::path(folder) / ("vulkan-" + uuid + "-" + name)).string();
}

}  // namespace

Pipelines::Pipelines(LogicalDevice &device, const KernelChoice &choice, std::uint32_t push_size,
                     const std::string &cache, std::vector<CompiledStage> *report)
    : device_(device) {
  const std::string path = cache_path(cache, device, choice);
  try {
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_size};
    VkPipelineLayoutCreateInfo layout{};
    layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    check(device_.vkCreatePipelineLayout(device_.handle, &layout, nullptr, &layout_), "vkCreatePipelineLayout");
    load_cache(path);
    if (report == nullptr) {
      compile_all(choice);
    } else {
      for (std::size_t s = 0; s < pipelines_.size(); ++s) report->push_back(compile_and_report(s, choice));
    }
    save_cache(path);
  } catch (...) {
    release();
    throw;
  }
}

Pipelines::~Pipelines() { release(); }

void Pipelines::release() {
  for (VkPipeline pipeline : pipelines_) device_.vkDestroyPipeline(device_.handle, pipeline, nullptr);
  device_.vkDestroyPipelineCache(device_.handle, cache_, nullptr);
  device_.vkDestroyPipelineLayout(device_.handle, layout_, nullptr);
}

void Pipelines::compile_all(const KernelChoice &choice) {
  std::vector<std::future<void>> tasks;
  for (std::size_t stage = 0; stage < pipelines_.size(); ++stage) {
    tasks.push_back(std::async(std::launch::async, [this, stage, &choice] { compile(stage, choice); }));
  }
  for (std::future<void> &task : tasks) task.wait();
  for (std::future<void> &task : tasks) task.get();
}

CompiledStage Pipelines::compile_and_report(std::size_t stage, const KernelChoice &choice) {
  const auto begin = std::chrono::steady_clock::now();
  compile(stage, choice);
  CompiledStage compiled{kStageNames[stage], 0.0, {}};
  compiled.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (device_.tells_statistics()) compiled.statistics = statistics_of(device_, pipelines_[stage]);
  return compiled;
}

void Pipelines::compile(std::size_t stage, const KernelChoice &choice) {
  // KERNEL_FEATURES, PROGRAM_GROUPS and PROGRAM_VARIANTS of stage.glsl.
  const ProgramNeeds needs = needs_of(stage, choice);
  const std::uint32_t constants[] = {choice.features, needs.groups, needs.variants};
  const std::vector<std::uint32_t> code = specialize_spirv(stages_of(device_)[stage], constants);
  VkShaderModuleCreateInfo module_info{};
  module_info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module_info.codeSize = code.size() * sizeof(std::uint32_t);
  module_info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(device_.vkCreateShaderModule(device_.handle, &module_info, nullptr, &module), "vkCreateShaderModule");
  VkComputePipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  info.layout = layout_;
  if (device_.tells_statistics()) info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  const VkResult result =
      device_.vkCreateComputePipelines(device_.handle, cache_, 1, &info, nullptr, &pipelines_[stage]);
  device_.vkDestroyShaderModule(device_.handle, module, nullptr);
  check(result, "vkCreateComputePipelines");
}

void Pipelines::load_cache(const std::string &path) {
  std::vector<char> bytes;
  if (!path.empty()) {
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  loaded_bytes_ = bytes.size();
  VkPipelineCacheCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  info.initialDataSize = bytes.size();  // the driver checks its header, and takes nothing of a stranger's
  info.pInitialData = bytes.data();
  check(device_.vkCreatePipelineCache(device_.handle, &info, nullptr, &cache_), "vkCreatePipelineCache");
}

void Pipelines::save_cache(const std::string &path) const {
  std::size_t size = 0;
  if (path.empty() || device_.vkGetPipelineCacheData(device_.handle, cache_, &size, nullptr) != VK_SUCCESS) return;
  if (size == loaded_bytes_) return;
  std::vector<char> bytes(size);
  if (device_.vkGetPipelineCacheData(device_.handle, cache_, &size, bytes.data()) != VK_SUCCESS) return;
  // Under another name first: two renders at once must not leave half a file.
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  const std::string partial = path + "." + std::to_string(reinterpret_cast<std::uintptr_t>(this));
  std::ofstream(partial, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(size));
  std::filesystem::rename(partial, path, ignored);
}

}  // namespace cotorra::vulkan

// SPDX-License-Identifier: GPL-3.0-or-later
// A graphics card as a device: which card, and whether it can render a job. The rendering is vulkan_wavefront.cpp's;
// the session keeps the film.
#include "device.h"
#include "features.h"
#include "scene.h"
#include "vulkan_film.h"
#include "vulkan_wavefront.h"

#include "../kernels/scene_types.h"

namespace cotorra {
namespace {

// What the stages have: all there is today. A feature that comes to the CPU first is refused, not left out.
constexpr std::uint32_t kFeatures =
    FEATURE_BOUNCES | FEATURE_SOFT_LIGHTS | FEATURE_VISIBLE_LIGHTS | FEATURE_EMISSIVE_MESHES | FEATURE_WORLD |
    FEATURE_SPECULAR | FEATURE_BSDF_RAYS | FEATURE_DATA_PASSES | FEATURE_LIGHT_GROUPS | FEATURE_LIGHT_SHAPES |
    FEATURE_MODELS | FEATURE_TRANSPARENCY | FEATURE_PROGRAMS | FEATURE_TERMS | FEATURE_OCCLUSION | FEATURE_LOBES |
    FEATURE_WHITTED | FEATURE_TOON | FEATURE_WORLD_LIGHT | FEATURE_AREA_LIGHTS | FEATURE_LIGHT_TREE |
    FEATURE_LIGHT_LINKING | FEATURE_REWEIGHTING | FEATURE_SHARING;

// The device that was asked for, index -1: the first that can. Throws DeviceError with the reasons of those that
// cannot.
vulkan::Physical choose(const vulkan::Instance &instance, const DeviceChoice &choice) {
  const int index = choice.index;
  const std::vector<vulkan::Physical> list = list_physical(instance);
  std::string problems;
  for (int i = 0; i < static_cast<int>(list.size()); ++i) {
    const vulkan::Physical &p = list[static_cast<std::size_t>(i)];
    if (index >= 0 && i != index) continue;
    const bool lacks_query = choice.ray_tracing == "HARDWARE" && !p.info.ray_query;
    const std::string problem = p.info.problem.empty() && lacks_query ? "it has no ray queries" : p.info.problem;
    if (problem.empty()) return p;
    problems += "; " + p.info.name + ": " + problem;
  }
  if (index < 0) throw DeviceError("no Vulkan device can be used" + problems);
  throw DeviceError("Vulkan device " + std::to_string(index) + " of " + std::to_string(list.size()) +
                    " cannot be used" + problems);
}

// A processor has no hardware to ask: with lavapipe's ray queries a picture took 3 to 8 times the processor time that
// it took with the BVH of our own.
bool uses_ray_query(const vulkan::Physical &physical, const DeviceChoice &choice) {
  if (choice.ray_tracing == "AUTO") return physical.info.ray_query && physical.info.type != "cpu";
  return choice.ray_tracing == "HARDWARE";
}

class VulkanDevice final : public Device {
 public:
  VulkanDevice(std::shared_ptr<const Scene> scene, const RenderJob &job, const DeviceChoice &choice)
      : scene_(std::move(scene)), passes_(job.passes), choice_(choice) {
    std::string missing;
    for (const std::string &name : feature_names(job.features & ~kFeatures)) {
      missing += (missing.empty() ? "" : ", ") + name;
    }
    if (!missing.empty()) throw DeviceError("graphics cards cannot render this yet: " + missing);
    instance_ = std::make_shared<vulkan::Instance>();
    physical_ = choose(*instance_, choice);
    ray_query_ = uses_ray_query(physical_, choice);
    shared_.figures.name = physical_.info.name;
    shared_.figures.isa = ray_query_ ? "ray query" : "software";
    shared_.figures.features = job.features;
  }

  int threads(int) const override { return 1; }
  std::size_t tiles_at_once() const override {
    return vulkan::film_pixels_at_once(physical_, passes_) / vulkan::kTilePixels;
  }

  std::uint64_t workspace_bytes() const override { return scene_->stats().bytes; }  // a copy, on its way to the card
  std::unique_ptr<Workspace> make_workspace(const RenderJob &job) override {
    return vulkan::make_wavefront(*scene_, job, choice_, instance_, physical_, ray_query_, shared_);
  }

  void look_again(Workspace &workspace) override { static_cast<vulkan::Wavefront &>(workspace).look_again(); }

  bool render(const RenderJob &, std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count,
              Workspace &workspace, RayCounts &counts) override {
    return static_cast<vulkan::Wavefront &>(workspace).render(tiles, first, count, counts);
  }

  DeviceFigures figures() const override {
    const std::lock_guard lock(shared_.mutex);
    DeviceFigures figures = shared_.figures;
    figures.messages = instance_->messages();
    return figures;
  }

 private:
  std::shared_ptr<const Scene> scene_;
  PassSelection passes_;
  DeviceChoice choice_;
  std::shared_ptr<vulkan::Instance> instance_;
  vulkan::Physical physical_;
  bool ray_query_ = false;
  mutable vulkan::SharedFigures shared_;
};

}  // namespace

std::unique_ptr<Device> make_vulkan_device(std::shared_ptr<const Scene> scene, const RenderJob &job,
                                           const DeviceChoice &choice) {
  return std::make_unique<VulkanDevice>(std::move(scene), job, choice);
}

std::vector<CompiledStage> compile_vulkan_kernels(std::uint32_t features, const ProgramNeeds &programs,
                                                  const DeviceChoice &choice) {
  auto instance = std::make_shared<vulkan::Instance>();
  const vulkan::Physical physical = choose(*instance, choice);
  return vulkan::compile_kernels(features, programs, choice.cache, std::move(instance), physical,
                                 uses_ray_query(physical, choice));
}

}  // namespace cotorra

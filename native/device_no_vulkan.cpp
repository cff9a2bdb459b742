// SPDX-License-Identifier: GPL-3.0-or-later
// Stands in for device_vulkan.cpp where the build found no compiler for the kernels of graphics cards. It only says so,
// and what to do.
#include "device.h"

namespace cotorra {
namespace {

constexpr const char *kReason =
    "this build of Cotorra has no Vulkan: glslang, which compiles the kernels of graphics cards, was missing when it "
    "was "
    "built; put it on the PATH and build again";

}  // namespace

std::unique_ptr<Device> make_vulkan_device(std::shared_ptr<const Scene>, const RenderJob &, const DeviceChoice &) {
  throw DeviceError(kReason);
}

std::vector<VulkanDeviceInfo> vulkan_devices() { throw DeviceError(kReason); }

std::vector<CompiledStage> compile_vulkan_kernels(std::uint32_t, const ProgramNeeds &, const DeviceChoice &) {
  throw DeviceError(kReason);
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Stands in for device_vulkan.cpp where the build found no Vulkan headers or no compiler for the kernels.
// It only says so.
#include "device.h"

namespace cotorra {

std::unique_ptr<Device> make_vulkan_device(std::shared_ptr<const Scene>, const RenderJob &, const DeviceChoice &) {
  throw DeviceError("this build of Cotorra has no Vulkan");
}

std::vector<VulkanDeviceInfo> vulkan_devices() { throw DeviceError("this build of Cotorra has no Vulkan"); }

std::vector<CompiledStage> compile_vulkan_kernels(std::uint32_t, const DeviceChoice &) {
  throw DeviceError("this build of Cotorra has no Vulkan");
}

}  // namespace cotorra

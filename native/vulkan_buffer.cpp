// SPDX-License-Identifier: GPL-3.0-or-later
// Memory of a graphics card and memory that it shares with the host, counted, so that running out of it can be told in
// figures. What lies in it is others' business.
#include <algorithm>

#include "vulkan_api.h"

namespace cotorra::vulkan {

Buffer::Buffer(LogicalDevice &device, std::uint64_t size, const char *purpose, bool host)
    : device_(device), size_(std::max<std::uint64_t>(size, 16)) {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = size_;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (!host) {
    info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                  VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    if (device_.ray_query()) {
      info.usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
                    VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    }
  }
  check(device_.vkCreateBuffer(device_.handle, &info, nullptr, &buffer_), "vkCreateBuffer");
  try {
    VkMemoryRequirements requirements{};
    device_.vkGetBufferMemoryRequirements(device_.handle, buffer_, &requirements);
    allocate(requirements, purpose, host);
    check(device_.vkBindBufferMemory(device_.handle, buffer_, memory_, 0), "vkBindBufferMemory");
    if (host) {
      check(device_.vkMapMemory(device_.handle, memory_, 0, VK_WHOLE_SIZE, 0, &data_), "vkMapMemory");
    } else {
      VkBufferDeviceAddressInfo address{};
      address.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
      address.buffer = buffer_;
      address_ = device_.vkGetBufferDeviceAddress(device_.handle, &address);
    }
  } catch (...) {
    release();
    throw;
  }
}

Buffer::~Buffer() { release(); }

void Buffer::allocate(const VkMemoryRequirements &requirements, const char *purpose, bool host) {
  const auto megabytes = [](std::uint64_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; };
  const auto too_small = [&] {
    return DeviceError("out of device memory: " + megabytes(size_) + " for " + purpose + " do not fit beside the " +
                       megabytes(device_.memory_used_) + " that are in use; " + device_.physical_.info.name + " has " +
                       megabytes(device_.memory_limit_));
  };
  if (!host && device_.memory_used_ + requirements.size > device_.memory_limit_) throw too_small();
  const VkPhysicalDeviceMemoryProperties &memory = device_.physical_.memory;
  const VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const VkMemoryPropertyFlags needed = host ? visible : local;
  // What is read back should be cached by the host; else the first type that fits is the fastest.
  const VkMemoryPropertyFlags liked = host ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT : 0;
  VkMemoryAllocateFlagsInfo flags{};
  flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  info.pNext = host ? nullptr : &flags;
  info.allocationSize = requirements.size;
  VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  for (const VkMemoryPropertyFlags wanted : {needed | liked, needed}) {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount && result != VK_SUCCESS; ++i) {
      const bool fits = (memory.memoryTypes[i].propertyFlags & wanted) == wanted;
      if (!fits || (requirements.memoryTypeBits & (1u << i)) == 0) continue;
      info.memoryTypeIndex = i;
      result = device_.vkAllocateMemory(device_.handle, &info, nullptr, &memory_);
    }
  }
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) throw too_small();
  check(result, "vkAllocateMemory");
  if (!host) allocated_ = requirements.size;
  device_.memory_used_ += allocated_;
}

void Buffer::release() {
  device_.vkDestroyBuffer(device_.handle, buffer_, nullptr);
  device_.vkFreeMemory(device_.handle, memory_, nullptr);
  device_.memory_used_ -= allocated_;
}

}  // namespace cotorra::vulkan

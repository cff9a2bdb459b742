// SPDX-License-Identifier: GPL-3.0-or-later
// A minimal Vulkan 1.2 compute device for tests: buffers that are known by their address, and one dispatch at a time.
// It is no render device: nothing is asynchronous here, and nothing is fast.
#ifndef COTORRA_TESTS_VULKAN_RUNNER_H
#define COTORRA_TESTS_VULKAN_RUNNER_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "vulkan_interface.h"

namespace cotorra::vulkan {

// What went wrong in Vulkan: the call and its result.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The functions that are used, by the object that they are asked of.
#define COTORRA_VULKAN_INSTANCE_FUNCTIONS(X) \
  X(vkCreateDebugUtilsMessengerEXT)          \
  X(vkCreateDevice)                          \
  X(vkDestroyDebugUtilsMessengerEXT)         \
  X(vkDestroyInstance)                       \
  X(vkEnumeratePhysicalDevices)              \
  X(vkGetDeviceProcAddr)                     \
  X(vkGetPhysicalDeviceFeatures2)            \
  X(vkGetPhysicalDeviceMemoryProperties)     \
  X(vkGetPhysicalDeviceProperties)           \
  X(vkGetPhysicalDeviceQueueFamilyProperties)

#define COTORRA_VULKAN_DEVICE_FUNCTIONS(X) \
  X(vkAllocateCommandBuffers)              \
  X(vkAllocateMemory)                      \
  X(vkBeginCommandBuffer)                  \
  X(vkBindBufferMemory)                    \
  X(vkCmdBindPipeline)                     \
  X(vkCmdDispatch)                         \
  X(vkCmdPipelineBarrier)                  \
  X(vkCmdPushConstants)                    \
  X(vkCreateBuffer)                        \
  X(vkCreateCommandPool)                   \
  X(vkCreateComputePipelines)              \
  X(vkCreatePipelineLayout)                \
  X(vkCreateShaderModule)                  \
  X(vkDestroyBuffer)                       \
  X(vkDestroyCommandPool)                  \
  X(vkDestroyDevice)                       \
  X(vkDestroyPipeline)                     \
  X(vkDestroyPipelineLayout)               \
  X(vkDestroyShaderModule)                 \
  X(vkEndCommandBuffer)                    \
  X(vkFreeMemory)                          \
  X(vkGetBufferDeviceAddress)              \
  X(vkGetBufferMemoryRequirements)         \
  X(vkGetDeviceQueue)                      \
  X(vkMapMemory)                           \
  X(vkQueueSubmit)                         \
  X(vkQueueWaitIdle)                       \
  X(vkResetCommandPool)

#define COTORRA_VULKAN_MEMBER(NAME) PFN_##NAME NAME = nullptr;

// The Vulkan loader, opened at run time: a program that has no Vulkan must still start.
class Library {
 public:
  explicit Library(const std::string &path);
  ~Library();
  Library(const Library &) = delete;
  Library &operator=(const Library &) = delete;

  PFN_vkGetInstanceProcAddr get_instance_proc_addr() const { return get_instance_proc_addr_; }

 private:
  void *handle_;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr_;
};

// A Vulkan 1.2 instance. With validation, the messages of Khronos' layer are kept, for the caller to judge.
class Instance {
 public:
  Instance(const Library &library, bool validate);
  ~Instance();
  Instance(const Instance &) = delete;
  Instance &operator=(const Instance &) = delete;

  bool validates() const { return messenger_ != VK_NULL_HANDLE; }
  std::vector<std::string> take_messages() { return std::exchange(messages_, {}); }

  COTORRA_VULKAN_INSTANCE_FUNCTIONS(COTORRA_VULKAN_MEMBER)
  VkInstance handle = VK_NULL_HANDLE;

 private:
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::vector<std::string> messages_;
};

// The first physical device that can run the kernels, with one compute queue.
class Device {
 public:
  explicit Device(Instance &instance);
  ~Device();
  Device(const Device &) = delete;
  Device &operator=(const Device &) = delete;

  const std::string &name() const { return name_; }
  // Memory that the host sees and that is coherent with it. Throws Error where the device has none.
  uint32_t host_memory_type(uint32_t allowed) const;

  struct Constant {
    uint32_t id;
    uint32_t value;
  };
  // Runs `groups` workgroups of entry point `main` and waits for the end.
  void run(std::span<const uint32_t> spirv, std::span<const Constant> constants, std::span<const std::byte> push,
           uint32_t groups);

  COTORRA_VULKAN_DEVICE_FUNCTIONS(COTORRA_VULKAN_MEMBER)
  VkDevice handle = VK_NULL_HANDLE;

 private:
  void select_physical(Instance &instance);

  Instance &instance_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  uint32_t family_ = 0;
  std::string name_;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

// Memory that the host has mapped and the device knows by its address.
class Buffer {
 public:
  Buffer(Device &device, size_t size);
  ~Buffer();
  Buffer(const Buffer &) = delete;
  Buffer &operator=(const Buffer &) = delete;

  void *data() const { return data_; }
  uint64_t address() const { return address_; }

 private:
  void release();

  Device &device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void *data_ = nullptr;
  uint64_t address_ = 0;
};

}  // namespace cotorra::vulkan

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// The Vulkan loader, opened at run time, an instance and a device with one compute queue: handles with owners, and
// tables of the functions that are used. Nothing here knows of rays; a machine without Vulkan gets DeviceError, and no
// more.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "device.h"
#include "vulkan_interface.h"

namespace cotorra::vulkan {

// The functions that are used, by the object that they are asked of.
#define COTORRA_VULKAN_INSTANCE_FUNCTIONS(X) \
  X(vkCreateDevice)                          \
  X(vkDestroyInstance)                       \
  X(vkEnumerateDeviceExtensionProperties)    \
  X(vkEnumeratePhysicalDevices)              \
  X(vkGetDeviceProcAddr)                     \
  X(vkGetPhysicalDeviceFeatures2)            \
  X(vkGetPhysicalDeviceMemoryProperties)     \
  X(vkGetPhysicalDeviceProperties2)          \
  X(vkGetPhysicalDeviceQueueFamilyProperties)

#define COTORRA_VULKAN_DEVICE_FUNCTIONS(X) \
  X(vkAllocateCommandBuffers)              \
  X(vkAllocateMemory)                      \
  X(vkBeginCommandBuffer)                  \
  X(vkBindBufferMemory)                    \
  X(vkCmdBindPipeline)                     \
  X(vkCmdCopyBuffer)                       \
  X(vkCmdDispatch)                         \
  X(vkCmdDispatchIndirect)                 \
  X(vkCmdFillBuffer)                       \
  X(vkCmdPipelineBarrier)                  \
  X(vkCmdPushConstants)                    \
  X(vkCmdUpdateBuffer)                     \
  X(vkCreateBuffer)                        \
  X(vkCreateCommandPool)                   \
  X(vkCreateComputePipelines)              \
  X(vkCreateFence)                         \
  X(vkCreatePipelineCache)                 \
  X(vkCreatePipelineLayout)                \
  X(vkCreateShaderModule)                  \
  X(vkDestroyBuffer)                       \
  X(vkDestroyCommandPool)                  \
  X(vkDestroyDevice)                       \
  X(vkDestroyFence)                        \
  X(vkDestroyPipeline)                     \
  X(vkDestroyPipelineCache)                \
  X(vkDestroyPipelineLayout)               \
  X(vkDestroyShaderModule)                 \
  X(vkDeviceWaitIdle)                      \
  X(vkEndCommandBuffer)                    \
  X(vkFreeMemory)                          \
  X(vkGetBufferDeviceAddress)              \
  X(vkGetBufferMemoryRequirements)         \
  X(vkGetDeviceQueue)                      \
  X(vkGetPipelineCacheData)                \
  X(vkMapMemory)                           \
  X(vkQueueSubmit)                         \
  X(vkResetCommandPool)                    \
  X(vkResetFences)                         \
  X(vkWaitForFences)

// Of a device that is made for ray queries.
#define COTORRA_VULKAN_RAY_QUERY_FUNCTIONS(X)      \
  X(vkCmdBuildAccelerationStructuresKHR)           \
  X(vkCmdCopyAccelerationStructureKHR)             \
  X(vkCmdResetQueryPool)                           \
  X(vkCmdWriteAccelerationStructuresPropertiesKHR) \
  X(vkCreateAccelerationStructureKHR)              \
  X(vkCreateQueryPool)                             \
  X(vkDestroyAccelerationStructureKHR)             \
  X(vkDestroyQueryPool)                            \
  X(vkGetAccelerationStructureBuildSizesKHR)       \
  X(vkGetAccelerationStructureDeviceAddressKHR)    \
  X(vkGetQueryPoolResults)

#define COTORRA_VULKAN_MEMBER(NAME) PFN_##NAME NAME = nullptr;

// Throws DeviceError naming the call, and its result in words.
void check(VkResult result, const char *call);

class Library {
 public:
  Library();
  ~Library();
  Library(const Library &) = delete;
  Library &operator=(const Library &) = delete;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;

 private:
  void *handle_ = nullptr;
};

class Instance {
 public:
  // COTORRA_VULKAN_VALIDATE=1 asks for Khronos' validation layer; its messages are kept.
  Instance();
  ~Instance();
  Instance(const Instance &) = delete;
  Instance &operator=(const Instance &) = delete;

  std::vector<VkPhysicalDevice> physical_devices() const;
  std::vector<std::string> messages() const;
  void add_message(std::string text);

  COTORRA_VULKAN_INSTANCE_FUNCTIONS(COTORRA_VULKAN_MEMBER)
  VkInstance handle = VK_NULL_HANDLE;

 private:
  Library library_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  PFN_vkDestroyDebugUtilsMessengerEXT destroy_messenger_ = nullptr;
  mutable std::mutex mutex_;
  std::vector<std::string> messages_;
};

// What a physical device is, and whether the kernels can run on it.
struct Physical {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::uint32_t queue_family = 0;
  VulkanDeviceInfo info;
};
// Lavapipe and its like: caches matter, and submissions cost little.
bool is_cpu(const Physical &physical);
// Best kinds first: discrete, integrated, virtual, others, CPU.
std::vector<Physical> list_physical(const Instance &instance);

// What a device is made for beside compute work.
struct DeviceUse {
  bool ray_query =
      false;   // with the extensions of hardware acceleration structures; the physical device must have them
  bool statistics = false;  // pipelines are asked what they need, where VK_KHR_pipeline_executable_properties is there
};

class LogicalDevice {
 public:
  LogicalDevice(std::shared_ptr<Instance> instance, Physical physical, DeviceUse use);
  ~LogicalDevice();
  LogicalDevice(const LogicalDevice &) = delete;
  LogicalDevice &operator=(const LogicalDevice &) = delete;

  const Physical &physical() const { return physical_; }
  const Instance &instance() const { return *instance_; }
  bool ray_query() const { return use_.ray_query; }
  // Memory that this process may use, and uses. COTORRA_VULKAN_MEMORY (bytes) makes a card smaller than it is, for
  // tests.
  std::uint64_t memory_limit() const { return memory_limit_; }
  std::uint64_t memory_used() const { return memory_used_; }

  bool tells_statistics() const { return use_.statistics; }

  // Records commands by `record(VkCommandBuffer)`, submits them and waits. Not for two threads at once.
  template <class Record>
  void run(Record record) {
    begin();
    record(commands_);
    submit();
  }

  COTORRA_VULKAN_DEVICE_FUNCTIONS(COTORRA_VULKAN_MEMBER)
  COTORRA_VULKAN_RAY_QUERY_FUNCTIONS(COTORRA_VULKAN_MEMBER)
  VkDevice handle = VK_NULL_HANDLE;

 private:
  friend class Buffer;
  void create();
  void begin();
  void submit();
  void release();

  std::shared_ptr<Instance> instance_;
  Physical physical_;
  DeviceUse use_;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::uint64_t memory_limit_ = 0;
  std::uint64_t memory_used_ = 0;
};

// Memory of the device that shaders know by its address, or (`host`) that the host has mapped and copies go through.
class Buffer {
 public:
  Buffer(LogicalDevice &device, std::uint64_t size, const char *purpose, bool host = false);
  ~Buffer();
  Buffer(const Buffer &) = delete;
  Buffer &operator=(const Buffer &) = delete;

  VkBuffer handle() const { return buffer_; }
  std::uint64_t address() const { return address_; }
  std::uint64_t size() const { return size_; }
  std::byte *data() const { return static_cast<std::byte *>(data_); }

 private:
  void allocate(const VkMemoryRequirements &requirements, const char *purpose, bool host);
  void release();

  LogicalDevice &device_;
  std::uint64_t size_;
  std::uint64_t allocated_ = 0;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  std::uint64_t address_ = 0;
  void *data_ = nullptr;
};

// A new buffer in the list, for `count` of T; returns where the card sees it.
template <class T>
T *add_buffer(LogicalDevice &device, std::vector<std::unique_ptr<Buffer>> &buffers, std::uint64_t count,
              const char *purpose) {
  buffers.push_back(std::make_unique<Buffer>(device, count * sizeof(T), purpose));
  return reinterpret_cast<T *>(buffers.back()->address());
}

// What was written before may be read after, by whatever stage.
void all_barrier(const LogicalDevice &device, VkCommandBuffer commands);

}  // namespace cotorra::vulkan

// SPDX-License-Identifier: GPL-3.0-or-later
// Opens Vulkan, lists its devices and makes one of them ready for compute work.
#include "vulkan_api.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "dynamic_library.h"

namespace cotorra::vulkan {
namespace {

#if defined(_WIN32)
constexpr const char *kLoaders[] = {"vulkan-1.dll"};
#elif defined(__APPLE__)
constexpr const char *kLoaders[] = {"libvulkan.1.dylib", "libMoltenVK.dylib"};
#else
constexpr const char *kLoaders[] = {"libvulkan.so.1"};
#endif
constexpr const char *kValidationLayer = "VK_LAYER_KHRONOS_validation";

std::string result_name(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_DEVICE_LOST:
      return "the device was lost";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialization failed";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no driver was found";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "a layer is not installed";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "an extension is missing";
    default:
      return "VkResult " + std::to_string(static_cast<int>(result));
  }
}

bool wants_validation() {
  const char *value = std::getenv("COTORRA_VULKAN_VALIDATE");
  return value != nullptr && std::string_view(value) == "1";
}

VKAPI_ATTR VkBool32 VKAPI_CALL keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT *data, void *instance) {
  static_cast<Instance *>(instance)->add_message(data->pMessage);
  return VK_FALSE;
}

int rank(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return 4;
    default:
      return 3;
  }
}

constexpr const char *kTypes[] = {"discrete", "integrated", "virtual", "other", "cpu"};

bool has_extension(const Instance &instance, VkPhysicalDevice device, const char *name) {
  std::uint32_t count = 0;
  check(instance.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr),
        "vkEnumerateDeviceExtensionProperties");
  std::vector<VkExtensionProperties> extensions(count);
  check(instance.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()),
        "vkEnumerateDeviceExtensionProperties");
  return std::any_of(extensions.begin(), extensions.end(),
                     [name](const VkExtensionProperties &e) { return std::strcmp(e.extensionName, name) == 0; });
}

// Why the kernels cannot run on a device; empty where they can.
std::string find_problem(const Instance &instance, Physical &p) {
  if (p.properties.apiVersion < VK_API_VERSION_1_2) return "it has no Vulkan 1.2";
  VkPhysicalDeviceVulkan12Features vulkan12{};
  vulkan12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &vulkan12;
  instance.vkGetPhysicalDeviceFeatures2(p.handle, &features);
  if (!vulkan12.bufferDeviceAddress) return "it lacks bufferDeviceAddress";
  if (!vulkan12.scalarBlockLayout) return "it lacks scalarBlockLayout";
  if (!features.features.shaderInt64) return "it lacks shaderInt64";
  std::uint32_t count = 0;
  instance.vkGetPhysicalDeviceQueueFamilyProperties(p.handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  instance.vkGetPhysicalDeviceQueueFamilyProperties(p.handle, &count, families.data());
  // A queue for compute alone, where there is one, leaves the screen's queue to the screen.
  int best = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) continue;
    const int score = (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) == 0 ? 2 : 1;
    if (score <= best) continue;
    best = score;
    p.queue_family = i;
  }
  return best > 0 ? "" : "it has no compute queue";
}

Physical describe(const Instance &instance, VkPhysicalDevice device) {
  Physical p;
  p.handle = device;
  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &driver;
  instance.vkGetPhysicalDeviceProperties2(device, &properties);
  instance.vkGetPhysicalDeviceMemoryProperties(device, &p.memory);
  p.properties = properties.properties;
  p.info.name = p.properties.deviceName;
  p.info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  p.info.type = kTypes[rank(p.properties.deviceType)];
  for (std::uint32_t i = 0; i < p.memory.memoryHeapCount; ++i) {
    if ((p.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) == 0) continue;
    p.info.memory = std::max<std::uint64_t>(p.info.memory, p.memory.memoryHeaps[i].size);
  }
  p.info.ray_query = has_extension(instance, device, VK_KHR_RAY_QUERY_EXTENSION_NAME);
  p.info.problem = find_problem(instance, p);
  return p;
}

}  // namespace

void check(VkResult result, const char *call) {
  if (result != VK_SUCCESS) throw DeviceError(std::string(call) + ": " + result_name(result));
}

// ---- Library and instance

Library::Library() {
  std::string tried;
  for (const char *name : kLoaders) {
    handle_ = open_library(name);
    if (handle_ != nullptr) break;
    tried += (tried.empty() ? "" : "; ") + open_error();
  }
  if (handle_ == nullptr) throw DeviceError("the Vulkan loader cannot be opened (" + tried + ")");
  get_instance_proc_addr = reinterpret_cast<PFN_vkGetInstanceProcAddr>(find_symbol(handle_, "vkGetInstanceProcAddr"));
  if (get_instance_proc_addr == nullptr) {
    close_library(handle_);
    throw DeviceError("the Vulkan loader has no vkGetInstanceProcAddr");
  }
}

Library::~Library() { close_library(handle_); }

Instance::Instance() {
  const PFN_vkGetInstanceProcAddr get = library_.get_instance_proc_addr;
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "Cotorra";
  application.apiVersion = VK_API_VERSION_1_2;
  VkDebugUtilsMessengerCreateInfoEXT messenger{};
  messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = keep_message;
  messenger.pUserData = this;
  const char *const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;
  const bool validate = wants_validation();
  if (validate) {
    info.pNext = &messenger;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"));
  check(create(&info, nullptr, &handle), "vkCreateInstance");
#define COTORRA_VULKAN_LOAD(NAME) NAME = reinterpret_cast<PFN_##NAME>(get(handle, #NAME));
  COTORRA_VULKAN_INSTANCE_FUNCTIONS(COTORRA_VULKAN_LOAD)
#undef COTORRA_VULKAN_LOAD
  if (validate) {
    const auto create_messenger =
        reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(get(handle, "vkCreateDebugUtilsMessengerEXT"));
    destroy_messenger_ =
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(get(handle, "vkDestroyDebugUtilsMessengerEXT"));
    if (create_messenger(handle, &messenger, nullptr, &messenger_) != VK_SUCCESS) messenger_ = VK_NULL_HANDLE;
  }
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE) destroy_messenger_(handle, messenger_, nullptr);
  vkDestroyInstance(handle, nullptr);
}

std::vector<VkPhysicalDevice> Instance::physical_devices() const {
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(handle, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vkEnumeratePhysicalDevices(handle, &count, devices.data()), "vkEnumeratePhysicalDevices");
  devices.resize(count);
  return devices;
}

std::vector<std::string> Instance::messages() const {
  const std::lock_guard lock(mutex_);
  return messages_;
}

void Instance::add_message(std::string text) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(std::move(text));
}

std::vector<Physical> list_physical(const Instance &instance) {
  std::vector<Physical> list;
  for (const VkPhysicalDevice device : instance.physical_devices()) list.push_back(describe(instance, device));
  std::stable_sort(list.begin(), list.end(), [](const Physical &a, const Physical &b) {
    return rank(a.properties.deviceType) < rank(b.properties.deviceType);
  });
  return list;
}

// ---- Logical device

LogicalDevice::LogicalDevice(std::shared_ptr<Instance> instance, Physical physical, bool statistics)
    : instance_(std::move(instance)), physical_(std::move(physical)), memory_limit_(physical_.info.memory) {
  if (const char *limit = std::getenv("COTORRA_VULKAN_MEMORY"); limit != nullptr && *limit != '\0') {
    memory_limit_ = std::min<std::uint64_t>(memory_limit_, std::strtoull(limit, nullptr, 10));
  }
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = physical_.queue_family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceVulkan12Features vulkan12{};
  vulkan12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  vulkan12.bufferDeviceAddress = VK_TRUE;
  vulkan12.scalarBlockLayout = VK_TRUE;
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{};
  executables.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR;
  executables.pipelineExecutableInfo = VK_TRUE;
  VkPhysicalDeviceFeatures features{};
  features.shaderInt64 = VK_TRUE;
  constexpr const char *executable_properties = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
  VkDeviceCreateInfo info{};
  if (statistics && has_extension(*instance_, physical_.handle, executable_properties)) {
    vulkan12.pNext = &executables;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &executable_properties;
    tells_statistics_ = true;
  }
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &vulkan12;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.pEnabledFeatures = &features;
  check(instance_->vkCreateDevice(physical_.handle, &info, nullptr, &handle), "vkCreateDevice");
#define COTORRA_VULKAN_LOAD(NAME) NAME = reinterpret_cast<PFN_##NAME>(instance_->vkGetDeviceProcAddr(handle, #NAME));
  COTORRA_VULKAN_DEVICE_FUNCTIONS(COTORRA_VULKAN_LOAD)
#undef COTORRA_VULKAN_LOAD
  try {
    vkGetDeviceQueue(handle, physical_.queue_family, 0, &queue_);
    VkCommandPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.queueFamilyIndex = physical_.queue_family;
    check(vkCreateCommandPool(handle, &pool, nullptr, &pool_), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool_;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(handle, &allocate, &commands_), "vkAllocateCommandBuffers");
  } catch (...) {
    release();
    throw;
  }
}

LogicalDevice::~LogicalDevice() { release(); }

void LogicalDevice::release() {
  if (fence_ != VK_NULL_HANDLE) {
    vkDeviceWaitIdle(handle);
    vkDestroyFence(handle, fence_, nullptr);
  }
  if (pool_ != VK_NULL_HANDLE) vkDestroyCommandPool(handle, pool_, nullptr);
  vkDestroyDevice(handle, nullptr);
}

void LogicalDevice::begin() {
  check(vkResetCommandPool(handle, pool_, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
}

void LogicalDevice::submit() {
  check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  if (fence_ == VK_NULL_HANDLE) {  // not before: drivers that only compile, for hardware that is not there, have none
    VkFenceCreateInfo fence{};
    fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    check(vkCreateFence(handle, &fence, nullptr, &fence_), "vkCreateFence");
  }
  check(vkResetFences(handle, 1, &fence_), "vkResetFences");
  check(vkQueueSubmit(queue_, 1, &info, fence_), "vkQueueSubmit");
  check(vkWaitForFences(handle, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
}

// ---- Buffer

Buffer::Buffer(LogicalDevice &device, std::uint64_t size, const char *purpose, bool host)
    : device_(device), size_(std::max<std::uint64_t>(size, 16)) {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = size_;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (!host) {
    info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                  VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
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

namespace cotorra {

std::vector<VulkanDeviceInfo> vulkan_devices() {
  const vulkan::Instance instance;
  std::vector<VulkanDeviceInfo> list;
  for (vulkan::Physical &p : vulkan::list_physical(instance)) list.push_back(std::move(p.info));
  return list;
}

}  // namespace cotorra

// SPDX-License-Identifier: GPL-3.0-or-later
// Opens Vulkan, lists its devices and makes one of them ready for compute work.
#include "vulkan_api.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
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

VkBool32 keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
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

constexpr const char *kRayQueryExtensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                               VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                               VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};

// Two features in a chain that begins with the second.
struct RayQueryFeatures {
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structure{};
  VkPhysicalDeviceRayQueryFeaturesKHR query{};
  RayQueryFeatures() {
    structure.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
    query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
    query.pNext = &structure;
  }
  RayQueryFeatures(const RayQueryFeatures &) = delete;
  RayQueryFeatures &operator=(const RayQueryFeatures &) = delete;
};

bool has_ray_query(const Instance &instance, VkPhysicalDevice device) {
  for (const char *name : kRayQueryExtensions) {
    if (!has_extension(instance, device, name)) return false;
  }
  RayQueryFeatures ray_query;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &ray_query.query;
  instance.vkGetPhysicalDeviceFeatures2(device, &features);
  return ray_query.structure.accelerationStructure && ray_query.query.rayQuery;
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
  p.info.problem = find_problem(instance, p);
  p.info.ray_query = p.info.problem.empty() && has_ray_query(instance, device);
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
  if (handle_ == nullptr)
    throw DeviceError(
        "the Vulkan loader cannot be opened (" + tried +
        "); it comes with the driver of the graphics card, or as the package libvulkan1 or vulkan-loader");
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

bool is_cpu(const Physical &p) { return p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU; }

std::vector<Physical> list_physical(const Instance &instance) {
  std::vector<Physical> list;
  for (const VkPhysicalDevice device : instance.physical_devices()) list.push_back(describe(instance, device));
  std::stable_sort(list.begin(), list.end(), [](const Physical &a, const Physical &b) {
    return rank(a.properties.deviceType) < rank(b.properties.deviceType);
  });
  return list;
}

// ---- Logical device

LogicalDevice::LogicalDevice(std::shared_ptr<Instance> instance, Physical physical, DeviceUse use)
    : instance_(std::move(instance)), physical_(std::move(physical)), use_(use), memory_limit_(physical_.info.memory) {
  if (const char *limit = std::getenv("COTORRA_VULKAN_MEMORY"); limit != nullptr && *limit != '\0') {
    memory_limit_ = std::min<std::uint64_t>(memory_limit_, std::strtoull(limit, nullptr, 10));
  }
  create();
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

// The handle and the functions.
void LogicalDevice::create() {
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
  VkPhysicalDeviceFeatures features{};
  features.shaderInt64 = VK_TRUE;
  VkDeviceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &vulkan12;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.pEnabledFeatures = &features;
  std::vector<const char *> extensions;
  RayQueryFeatures ray_query;
  if (use_.ray_query) {
    extensions.assign(std::begin(kRayQueryExtensions), std::end(kRayQueryExtensions));
    ray_query.structure.accelerationStructure = VK_TRUE;
    ray_query.query.rayQuery = VK_TRUE;
    vulkan12.pNext = &ray_query.query;
  }
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{};
  executables.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR;
  executables.pipelineExecutableInfo = VK_TRUE;
  use_.statistics &= has_extension(*instance_, physical_.handle, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
  if (use_.statistics) {
    extensions.push_back(VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    executables.pNext = vulkan12.pNext;
    vulkan12.pNext = &executables;
  }
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  check(instance_->vkCreateDevice(physical_.handle, &info, nullptr, &handle), "vkCreateDevice");
#define COTORRA_VULKAN_LOAD(NAME) NAME = reinterpret_cast<PFN_##NAME>(instance_->vkGetDeviceProcAddr(handle, #NAME));
  COTORRA_VULKAN_DEVICE_FUNCTIONS(COTORRA_VULKAN_LOAD)
  if (use_.ray_query) {
    COTORRA_VULKAN_RAY_QUERY_FUNCTIONS(COTORRA_VULKAN_LOAD)
  }
#undef COTORRA_VULKAN_LOAD
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

void all_barrier(const LogicalDevice &device, VkCommandBuffer commands) {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  constexpr VkPipelineStageFlags stages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  device.vkCmdPipelineBarrier(commands, stages, stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
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

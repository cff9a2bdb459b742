// SPDX-License-Identifier: GPL-3.0-or-later
// A minimal Vulkan 1.2 compute device for tests, and the C functions through which Python's ctypes drives it.
// Which kernels are run and what is compared is told in tests/test_kernels_lavapipe.py.
#include "vulkan_runner.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>

namespace cotorra::vulkan {

namespace {

constexpr const char *VALIDATION_LAYER = "VK_LAYER_KHRONOS_validation";

void check(VkResult result, const char *what) {
  if (result != VK_SUCCESS) throw Error(std::string(what) + " failed, VkResult " + std::to_string(int(result)));
}

VkBool32 keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                      const VkDebugUtilsMessengerCallbackDataEXT *data, void *messages) {
  static_cast<std::vector<std::string> *>(messages)->emplace_back(data->pMessage);
  return VK_FALSE;
}

// Frees a Vulkan object at the end of a scope.
template <class F>
class [[nodiscard]] Finally {
 public:
  explicit Finally(F f) : f_(std::move(f)) {}
  ~Finally() { f_(); }
  Finally(const Finally &) = delete;
  Finally &operator=(const Finally &) = delete;

 private:
  F f_;
};

bool has_validation_layer(PFN_vkGetInstanceProcAddr get) {
  const auto enumerate =
      reinterpret_cast<PFN_vkEnumerateInstanceLayerProperties>(get(nullptr, "vkEnumerateInstanceLayerProperties"));
  uint32_t count = 0;
  check(enumerate(&count, nullptr), "vkEnumerateInstanceLayerProperties");
  std::vector<VkLayerProperties> layers(count);
  check(enumerate(&count, layers.data()), "vkEnumerateInstanceLayerProperties");
  return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties &layer) {
    return std::strcmp(layer.layerName, VALIDATION_LAYER) == 0;
  });
}

}  // namespace

// ---- Library

Library::Library(const std::string &path) : handle_(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (handle_ == nullptr) throw Error(dlerror());
  get_instance_proc_addr_ = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(handle_, "vkGetInstanceProcAddr"));
  if (get_instance_proc_addr_ == nullptr) {
    dlclose(handle_);
    throw Error(path + " has no vkGetInstanceProcAddr");
  }
}

Library::~Library() { dlclose(handle_); }

// ---- Instance

Instance::Instance(const Library &library, bool validate) {
  const PFN_vkGetInstanceProcAddr get = library.get_instance_proc_addr();
  validate = validate && has_validation_layer(get);

  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "cotorra tests";
  application.apiVersion = VK_API_VERSION_1_2;
  const char *const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;
  if (validate) {
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &VALIDATION_LAYER;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"));
  check(create(&info, nullptr, &handle), "vkCreateInstance");

#define COTORRA_VULKAN_LOAD(NAME) NAME = reinterpret_cast<PFN_##NAME>(get(handle, #NAME));
  COTORRA_VULKAN_INSTANCE_FUNCTIONS(COTORRA_VULKAN_LOAD)
#undef COTORRA_VULKAN_LOAD

  if (validate) {
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = keep_message;
    messenger.pUserData = &messages_;
    if (vkCreateDebugUtilsMessengerEXT(handle, &messenger, nullptr, &messenger_) != VK_SUCCESS) {
      vkDestroyInstance(handle, nullptr);
      throw Error("vkCreateDebugUtilsMessengerEXT failed");
    }
  }
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE) vkDestroyDebugUtilsMessengerEXT(handle, messenger_, nullptr);
  vkDestroyInstance(handle, nullptr);
}

// ---- Device

void Device::select_physical(Instance &instance) {
  uint32_t count = 0;
  check(instance.vkEnumeratePhysicalDevices(instance.handle, &count, nullptr), "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> devices(count);
  check(instance.vkEnumeratePhysicalDevices(instance.handle, &count, devices.data()), "vkEnumeratePhysicalDevices");
  for (const VkPhysicalDevice device : devices) {
    VkPhysicalDeviceProperties properties{};
    instance.vkGetPhysicalDeviceProperties(device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2) continue;
    VkPhysicalDeviceVulkan12Features vulkan12{};
    vulkan12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    VkPhysicalDeviceFeatures2 features{};
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    features.pNext = &vulkan12;
    instance.vkGetPhysicalDeviceFeatures2(device, &features);
    if (!vulkan12.bufferDeviceAddress || !vulkan12.scalarBlockLayout || !features.features.shaderInt64) continue;

    instance.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    instance.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties &candidate) {
      return (candidate.queueFlags & VK_QUEUE_COMPUTE_BIT) != 0;
    });
    if (family == families.end()) continue;
    physical_ = device;
    family_ = uint32_t(family - families.begin());
    name_ = properties.deviceName;
    return;
  }
  throw Error("no device with Vulkan 1.2, buffer addresses, scalar layout and 64-bit integers");
}

Device::Device(Instance &instance) : instance_(instance) {
  select_physical(instance);

  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = family_;
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
  check(instance.vkCreateDevice(physical_, &info, nullptr, &handle), "vkCreateDevice");

#define COTORRA_VULKAN_LOAD(NAME) NAME = reinterpret_cast<PFN_##NAME>(instance.vkGetDeviceProcAddr(handle, #NAME));
  COTORRA_VULKAN_DEVICE_FUNCTIONS(COTORRA_VULKAN_LOAD)
#undef COTORRA_VULKAN_LOAD

  try {
    vkGetDeviceQueue(handle, family_, 0, &queue_);
    VkCommandPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.queueFamilyIndex = family_;
    check(vkCreateCommandPool(handle, &pool, nullptr, &pool_), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate.commandPool = pool_;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(handle, &allocate, &commands_), "vkAllocateCommandBuffers");
  } catch (...) {
    if (pool_ != VK_NULL_HANDLE) vkDestroyCommandPool(handle, pool_, nullptr);
    vkDestroyDevice(handle, nullptr);
    throw;
  }
}

Device::~Device() {
  vkDestroyCommandPool(handle, pool_, nullptr);
  vkDestroyDevice(handle, nullptr);
}

uint32_t Device::host_memory_type(uint32_t allowed) const {
  VkPhysicalDeviceMemoryProperties memory{};
  instance_.vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
  const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    if ((allowed & (1u << i)) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  }
  throw Error("no memory that the host sees");
}

void Device::run(std::span<const uint32_t> spirv, std::span<const Constant> constants, std::span<const std::byte> push,
                 uint32_t groups) {
  VkShaderModuleCreateInfo module_info{};
  module_info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  module_info.codeSize = spirv.size_bytes();
  module_info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(handle, &module_info, nullptr, &module), "vkCreateShaderModule");
  const Finally free_module([&] { vkDestroyShaderModule(handle, module, nullptr); });

  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, uint32_t(push.size())};
  VkPipelineLayoutCreateInfo layout_info{};
  layout_info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layout_info.pushConstantRangeCount = 1;
  layout_info.pPushConstantRanges = &range;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(handle, &layout_info, nullptr, &layout), "vkCreatePipelineLayout");
  const Finally free_layout([&] { vkDestroyPipelineLayout(handle, layout, nullptr); });

  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t i = 0; i < constants.size(); ++i) {
    entries.push_back({constants[i].id, uint32_t(i * sizeof(Constant) + offsetof(Constant, value)), sizeof(uint32_t)});
  }
  const VkSpecializationInfo specialization{uint32_t(entries.size()), entries.data(), constants.size_bytes(),
                                            constants.data()};
  VkComputePipelineCreateInfo pipeline_info{};
  pipeline_info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  pipeline_info.layout = layout;
  pipeline_info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  pipeline_info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  pipeline_info.stage.module = module;
  pipeline_info.stage.pName = "main";
  pipeline_info.stage.pSpecializationInfo = &specialization;
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(handle, VK_NULL_HANDLE, 1, &pipeline_info, nullptr, &pipeline),
        "vkCreateComputePipelines");
  const Finally free_pipeline([&] { vkDestroyPipeline(handle, pipeline, nullptr); });

  check(vkResetCommandPool(handle, pool_, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vkCmdPushConstants(commands_, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, uint32_t(push.size()), push.data());
  vkCmdDispatch(commands_, groups, 1, 1);
  VkMemoryBarrier barrier{};
  barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                       nullptr, 0, nullptr);
  check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkSubmitInfo submit{};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  check(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
  check(vkQueueWaitIdle(queue_), "vkQueueWaitIdle");
}

// ---- Buffer

Buffer::Buffer(Device &device, size_t size) : device_(device) {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = size;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  check(device_.vkCreateBuffer(device_.handle, &info, nullptr, &buffer_), "vkCreateBuffer");
  try {
    VkMemoryRequirements requirements{};
    device_.vkGetBufferMemoryRequirements(device_.handle, buffer_, &requirements);
    VkMemoryAllocateFlagsInfo flags{};
    flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.pNext = &flags;
    allocate.allocationSize = requirements.size;
    allocate.memoryTypeIndex = device_.host_memory_type(requirements.memoryTypeBits);
    check(device_.vkAllocateMemory(device_.handle, &allocate, nullptr, &memory_), "vkAllocateMemory");
    check(device_.vkBindBufferMemory(device_.handle, buffer_, memory_, 0), "vkBindBufferMemory");
    check(device_.vkMapMemory(device_.handle, memory_, 0, VK_WHOLE_SIZE, 0, &data_), "vkMapMemory");
    VkBufferDeviceAddressInfo address{};
    address.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
    address.buffer = buffer_;
    address_ = device_.vkGetBufferDeviceAddress(device_.handle, &address);
  } catch (...) {
    release();
    throw;
  }
}

Buffer::~Buffer() { release(); }

void Buffer::release() {
  device_.vkDestroyBuffer(device_.handle, buffer_, nullptr);
  device_.vkFreeMemory(device_.handle, memory_, nullptr);
}

}  // namespace cotorra::vulkan

// ---- The C functions. Each that can fail returns null or 0 then, and runner_error() says why.

namespace {

using namespace cotorra::vulkan;

struct Runner {
  Runner(const char *library_path, bool validate)
      : library(library_path), instance(library, validate), device(instance) {}
  Library library;
  Instance instance;
  Device device;
};

thread_local std::string last_error;

template <class F>
auto guarded(F f) -> decltype(f()) {
  try {
    last_error.clear();
    return f();
  } catch (const std::exception &error) {
    last_error = error.what();
    return {};
  }
}

}  // namespace

extern "C" {

const char *runner_error() { return last_error.c_str(); }

Runner *runner_open(const char *library, int validate) {
  return guarded([&] { return new Runner(library, validate != 0); });
}
void runner_close(Runner *runner) { delete runner; }
const char *runner_device_name(Runner *runner) { return runner->device.name().c_str(); }
int runner_validates(Runner *runner) { return runner->instance.validates() ? 1 : 0; }

Buffer *runner_buffer(Runner *runner, size_t size) {
  return guarded([&] { return new Buffer(runner->device, size); });
}
void runner_buffer_free(Buffer *buffer) { delete buffer; }
void *runner_buffer_data(Buffer *buffer) { return buffer->data(); }
uint64_t runner_buffer_address(Buffer *buffer) { return buffer->address(); }

// Returns 1 when the shader ran and the validation layer, where it is there, had nothing to say.
int runner_run(Runner *runner, const uint32_t *spirv, size_t words, const Device::Constant *constants,
               size_t constant_count, const std::byte *push, size_t push_size, uint32_t groups) {
  return guarded([&] {
    runner->device.run({spirv, words}, {constants, constant_count}, {push, push_size}, groups);
    const std::vector<std::string> messages = runner->instance.take_messages();
    if (!messages.empty()) throw Error("validation layer: " + messages.front());
    return 1;
  });
}
}

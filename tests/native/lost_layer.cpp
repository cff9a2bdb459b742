// SPDX-License-Identifier: GPL-3.0-or-later
// A Vulkan layer that loses the device: from submission number COTORRA_TEST_LOST_AFTER on each one fails, as on a card
// whose driver was reset. All else goes to the driver. For tests/test_vulkan_lost.py alone.
#include <vulkan/vk_layer.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

#define COTORRA_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

PFN_vkGetInstanceProcAddr next_instance = nullptr;
PFN_vkGetDeviceProcAddr next_device = nullptr;
PFN_vkQueueSubmit next_submit = nullptr;
std::atomic<long> submissions{0};

// The link of the chain that was put there for layers.
template <class Link>
Link *find_link(const void *chain, VkStructureType type) {
  auto *link = static_cast<Link *>(const_cast<void *>(chain));
  while (link->sType != type || link->function != VK_LAYER_LINK_INFO) {
    link = static_cast<Link *>(const_cast<void *>(link->pNext));
  }
  return link;
}

VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *infos, VkFence fence) {
  const char *after = std::getenv("COTORRA_TEST_LOST_AFTER");
  if (after != nullptr && submissions++ >= std::atol(after)) return VK_ERROR_DEVICE_LOST;
  return next_submit(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator,
                                               VkInstance *instance) {
  auto *link = find_link<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  next_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  return reinterpret_cast<PFN_vkCreateInstance>(next_instance(nullptr, "vkCreateInstance"))(info, allocator, instance);
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                                             const VkAllocationCallbacks *allocator, VkDevice *device) {
  auto *link = find_link<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  next_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  const auto create =
      reinterpret_cast<PFN_vkCreateDevice>(link->u.pLayerInfo->pfnNextGetInstanceProcAddr(nullptr, "vkCreateDevice"));
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const VkResult result = create(physical, info, allocator, device);
  if (result != VK_SUCCESS) return result;
  next_submit = reinterpret_cast<PFN_vkQueueSubmit>(next_device(*device, "vkQueueSubmit"));
  submissions = 0;
  return result;
}

}  // namespace

COTORRA_EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL lost_get_device(VkDevice device, const char *name) {
  if (std::strcmp(name, "vkQueueSubmit") == 0) return reinterpret_cast<PFN_vkVoidFunction>(submit);
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(lost_get_device);
  return next_device(device, name);
}

COTORRA_EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL lost_get_instance(VkInstance instance, const char *name) {
  if (std::strcmp(name, "vkCreateInstance") == 0) return reinterpret_cast<PFN_vkVoidFunction>(create_instance);
  if (std::strcmp(name, "vkCreateDevice") == 0) return reinterpret_cast<PFN_vkVoidFunction>(create_device);
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(lost_get_device);
  if (std::strcmp(name, "vkGetInstanceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(lost_get_instance);
  return next_instance(instance, name);
}

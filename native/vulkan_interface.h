// SPDX-License-Identifier: GPL-3.0-or-later
// The part of Vulkan 1.2's C interface that Cotorra uses, so that building needs no Vulkan SDK; here its functions, by
// their types. Nothing is implemented; tests/test_vulkan_interface.py compares it all with the published headers.
#pragma once

#include "vulkan_structures.h"

using PFN_vkVoidFunction = void (*)();
using PFN_vkAllocateCommandBuffers = VkResult (*)(VkDevice, const VkCommandBufferAllocateInfo *, VkCommandBuffer *);
using PFN_vkAllocateMemory = VkResult (*)(VkDevice, const VkMemoryAllocateInfo *, const VkAllocationCallbacks *,
                                          VkDeviceMemory *);
using PFN_vkBeginCommandBuffer = VkResult (*)(VkCommandBuffer, const VkCommandBufferBeginInfo *);
using PFN_vkBindBufferMemory = VkResult (*)(VkDevice, VkBuffer, VkDeviceMemory, VkDeviceSize);
using PFN_vkCmdBindPipeline = void (*)(VkCommandBuffer, VkPipelineBindPoint, VkPipeline);
using PFN_vkCmdBuildAccelerationStructuresKHR = void (*)(VkCommandBuffer, std::uint32_t,
                                                         const VkAccelerationStructureBuildGeometryInfoKHR *,
                                                         const VkAccelerationStructureBuildRangeInfoKHR *const *);
using PFN_vkCmdCopyAccelerationStructureKHR = void (*)(VkCommandBuffer, const VkCopyAccelerationStructureInfoKHR *);
using PFN_vkCmdCopyBuffer = void (*)(VkCommandBuffer, VkBuffer, VkBuffer, std::uint32_t, const VkBufferCopy *);
using PFN_vkCmdDispatch = void (*)(VkCommandBuffer, std::uint32_t, std::uint32_t, std::uint32_t);
using PFN_vkCmdDispatchIndirect = void (*)(VkCommandBuffer, VkBuffer, VkDeviceSize);
using PFN_vkCmdFillBuffer = void (*)(VkCommandBuffer, VkBuffer, VkDeviceSize, VkDeviceSize, std::uint32_t);
using PFN_vkCmdPipelineBarrier = void (*)(VkCommandBuffer, VkPipelineStageFlags, VkPipelineStageFlags, VkFlags,
                                          std::uint32_t, const VkMemoryBarrier *, std::uint32_t,
                                          const VkBufferMemoryBarrier *, std::uint32_t, const VkImageMemoryBarrier *);
using PFN_vkCmdPushConstants = void (*)(VkCommandBuffer, VkPipelineLayout, VkFlags, std::uint32_t, std::uint32_t,
                                        const void *);
using PFN_vkCmdResetQueryPool = void (*)(VkCommandBuffer, VkQueryPool, std::uint32_t, std::uint32_t);
using PFN_vkCmdUpdateBuffer = void (*)(VkCommandBuffer, VkBuffer, VkDeviceSize, VkDeviceSize, const void *);
using PFN_vkCmdWriteAccelerationStructuresPropertiesKHR = void (*)(VkCommandBuffer, std::uint32_t,
                                                                   const VkAccelerationStructureKHR *, VkQueryType,
                                                                   VkQueryPool, std::uint32_t);
using PFN_vkCreateAccelerationStructureKHR = VkResult (*)(VkDevice, const VkAccelerationStructureCreateInfoKHR *,
                                                          const VkAllocationCallbacks *, VkAccelerationStructureKHR *);
using PFN_vkCreateBuffer = VkResult (*)(VkDevice, const VkBufferCreateInfo *, const VkAllocationCallbacks *,
                                        VkBuffer *);
using PFN_vkCreateCommandPool = VkResult (*)(VkDevice, const VkCommandPoolCreateInfo *, const VkAllocationCallbacks *,
                                             VkCommandPool *);
using PFN_vkCreateComputePipelines = VkResult (*)(VkDevice, VkPipelineCache, std::uint32_t,
                                                  const VkComputePipelineCreateInfo *, const VkAllocationCallbacks *,
                                                  VkPipeline *);
using PFN_vkCreateDebugUtilsMessengerEXT = VkResult (*)(VkInstance, const VkDebugUtilsMessengerCreateInfoEXT *,
                                                        const VkAllocationCallbacks *, VkDebugUtilsMessengerEXT *);
using PFN_vkCreateDevice = VkResult (*)(VkPhysicalDevice, const VkDeviceCreateInfo *, const VkAllocationCallbacks *,
                                        VkDevice *);
using PFN_vkCreateFence = VkResult (*)(VkDevice, const VkFenceCreateInfo *, const VkAllocationCallbacks *, VkFence *);
using PFN_vkCreateInstance = VkResult (*)(const VkInstanceCreateInfo *, const VkAllocationCallbacks *, VkInstance *);
using PFN_vkCreatePipelineCache = VkResult (*)(VkDevice, const VkPipelineCacheCreateInfo *,
                                               const VkAllocationCallbacks *, VkPipelineCache *);
using PFN_vkCreatePipelineLayout = VkResult (*)(VkDevice, const VkPipelineLayoutCreateInfo *,
                                                const VkAllocationCallbacks *, VkPipelineLayout *);
using PFN_vkCreateQueryPool = VkResult (*)(VkDevice, const VkQueryPoolCreateInfo *, const VkAllocationCallbacks *,
                                           VkQueryPool *);
using PFN_vkCreateShaderModule = VkResult (*)(VkDevice, const VkShaderModuleCreateInfo *, const VkAllocationCallbacks *,
                                              VkShaderModule *);
using PFN_vkDestroyAccelerationStructureKHR = void (*)(VkDevice, VkAccelerationStructureKHR,
                                                       const VkAllocationCallbacks *);
using PFN_vkDestroyBuffer = void (*)(VkDevice, VkBuffer, const VkAllocationCallbacks *);
using PFN_vkDestroyCommandPool = void (*)(VkDevice, VkCommandPool, const VkAllocationCallbacks *);
using PFN_vkDestroyDebugUtilsMessengerEXT = void (*)(VkInstance, VkDebugUtilsMessengerEXT,
                                                     const VkAllocationCallbacks *);
using PFN_vkDestroyDevice = void (*)(VkDevice, const VkAllocationCallbacks *);
using PFN_vkDestroyFence = void (*)(VkDevice, VkFence, const VkAllocationCallbacks *);
using PFN_vkDestroyInstance = void (*)(VkInstance, const VkAllocationCallbacks *);
using PFN_vkDestroyPipeline = void (*)(VkDevice, VkPipeline, const VkAllocationCallbacks *);
using PFN_vkDestroyPipelineCache = void (*)(VkDevice, VkPipelineCache, const VkAllocationCallbacks *);
using PFN_vkDestroyPipelineLayout = void (*)(VkDevice, VkPipelineLayout, const VkAllocationCallbacks *);
using PFN_vkDestroyQueryPool = void (*)(VkDevice, VkQueryPool, const VkAllocationCallbacks *);
using PFN_vkDestroyShaderModule = void (*)(VkDevice, VkShaderModule, const VkAllocationCallbacks *);
using PFN_vkDeviceWaitIdle = VkResult (*)(VkDevice);
using PFN_vkEndCommandBuffer = VkResult (*)(VkCommandBuffer);
using PFN_vkEnumerateDeviceExtensionProperties = VkResult (*)(VkPhysicalDevice, const char *, std::uint32_t *,
                                                              VkExtensionProperties *);
using PFN_vkEnumerateInstanceLayerProperties = VkResult (*)(std::uint32_t *, VkLayerProperties *);
using PFN_vkEnumeratePhysicalDevices = VkResult (*)(VkInstance, std::uint32_t *, VkPhysicalDevice *);
using PFN_vkFreeMemory = void (*)(VkDevice, VkDeviceMemory, const VkAllocationCallbacks *);
using PFN_vkGetAccelerationStructureBuildSizesKHR = void (*)(VkDevice, VkAccelerationStructureBuildTypeKHR,
                                                             const VkAccelerationStructureBuildGeometryInfoKHR *,
                                                             const std::uint32_t *,
                                                             VkAccelerationStructureBuildSizesInfoKHR *);
using PFN_vkGetAccelerationStructureDeviceAddressKHR =
    VkDeviceAddress (*)(VkDevice, const VkAccelerationStructureDeviceAddressInfoKHR *);
using PFN_vkGetBufferDeviceAddress = VkDeviceAddress (*)(VkDevice, const VkBufferDeviceAddressInfo *);
using PFN_vkGetBufferMemoryRequirements = void (*)(VkDevice, VkBuffer, VkMemoryRequirements *);
using PFN_vkGetDeviceProcAddr = PFN_vkVoidFunction (*)(VkDevice, const char *);
using PFN_vkGetDeviceQueue = void (*)(VkDevice, std::uint32_t, std::uint32_t, VkQueue *);
using PFN_vkGetInstanceProcAddr = PFN_vkVoidFunction (*)(VkInstance, const char *);
using PFN_vkGetPhysicalDeviceFeatures2 = void (*)(VkPhysicalDevice, VkPhysicalDeviceFeatures2 *);
using PFN_vkGetPhysicalDeviceMemoryProperties = void (*)(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties *);
using PFN_vkGetPhysicalDeviceProperties = void (*)(VkPhysicalDevice, VkPhysicalDeviceProperties *);
using PFN_vkGetPhysicalDeviceProperties2 = void (*)(VkPhysicalDevice, VkPhysicalDeviceProperties2 *);
using PFN_vkGetPhysicalDeviceQueueFamilyProperties = void (*)(VkPhysicalDevice, std::uint32_t *,
                                                              VkQueueFamilyProperties *);
using PFN_vkGetPipelineCacheData = VkResult (*)(VkDevice, VkPipelineCache, std::size_t *, void *);
using PFN_vkGetPipelineExecutableStatisticsKHR = VkResult (*)(VkDevice, const VkPipelineExecutableInfoKHR *,
                                                              std::uint32_t *, VkPipelineExecutableStatisticKHR *);
using PFN_vkGetQueryPoolResults = VkResult (*)(VkDevice, VkQueryPool, std::uint32_t, std::uint32_t, std::size_t, void *,
                                               VkDeviceSize, VkFlags);
using PFN_vkMapMemory = VkResult (*)(VkDevice, VkDeviceMemory, VkDeviceSize, VkDeviceSize, VkFlags, void **);
using PFN_vkQueueSubmit = VkResult (*)(VkQueue, std::uint32_t, const VkSubmitInfo *, VkFence);
using PFN_vkQueueWaitIdle = VkResult (*)(VkQueue);
using PFN_vkResetCommandPool = VkResult (*)(VkDevice, VkCommandPool, VkFlags);
using PFN_vkResetFences = VkResult (*)(VkDevice, std::uint32_t, const VkFence *);
using PFN_vkWaitForFences = VkResult (*)(VkDevice, std::uint32_t, const VkFence *, VkBool32, std::uint64_t);

// SPDX-License-Identifier: GPL-3.0-or-later
// Structures of Vulkan 1.2's C interface, as far as Cotorra uses them, under the names of its specification. The
// functions that take them stand in vulkan_interface.h.
#pragma once

#include "vulkan_values.h"

// ---- Structures that are only pointed to
struct VkAllocationCallbacks;
struct VkBufferMemoryBarrier;
struct VkCommandBufferInheritanceInfo;
struct VkDebugUtilsLabelEXT;
struct VkDebugUtilsObjectNameInfoEXT;
struct VkImageMemoryBarrier;

// ---- Structures
union VkDeviceOrHostAddressConstKHR {
  VkDeviceAddress deviceAddress;
  const void *hostAddress;
};
struct VkAccelerationStructureGeometryTrianglesDataKHR {
  VkStructureType sType;
  const void *pNext;
  VkFormat vertexFormat;
  VkDeviceOrHostAddressConstKHR vertexData;
  VkDeviceSize vertexStride;
  std::uint32_t maxVertex;
  VkIndexType indexType;
  VkDeviceOrHostAddressConstKHR indexData, transformData;
};
struct VkAccelerationStructureGeometryAabbsDataKHR {
  VkStructureType sType;
  const void *pNext;
  VkDeviceOrHostAddressConstKHR data;
  VkDeviceSize stride;
};
struct VkAccelerationStructureGeometryInstancesDataKHR {
  VkStructureType sType;
  const void *pNext;
  VkBool32 arrayOfPointers;
  VkDeviceOrHostAddressConstKHR data;
};
union VkAccelerationStructureGeometryDataKHR {
  VkAccelerationStructureGeometryTrianglesDataKHR triangles;
  VkAccelerationStructureGeometryAabbsDataKHR aabbs;
  VkAccelerationStructureGeometryInstancesDataKHR instances;
};
struct VkAccelerationStructureGeometryKHR {
  VkStructureType sType;
  const void *pNext;
  VkGeometryTypeKHR geometryType;
  VkAccelerationStructureGeometryDataKHR geometry;
  VkFlags flags;
};
union VkDeviceOrHostAddressKHR {
  VkDeviceAddress deviceAddress;
  void *hostAddress;
};
struct VkAccelerationStructureBuildGeometryInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkAccelerationStructureTypeKHR type;
  VkFlags flags;
  VkBuildAccelerationStructureModeKHR mode;
  VkAccelerationStructureKHR srcAccelerationStructure, dstAccelerationStructure;
  std::uint32_t geometryCount;
  const VkAccelerationStructureGeometryKHR *pGeometries;
  const VkAccelerationStructureGeometryKHR *const *ppGeometries;
  VkDeviceOrHostAddressKHR scratchData;
};
struct VkAccelerationStructureBuildRangeInfoKHR {
  std::uint32_t primitiveCount, primitiveOffset, firstVertex, transformOffset;
};
struct VkAccelerationStructureBuildSizesInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkDeviceSize accelerationStructureSize, updateScratchSize, buildScratchSize;
};
struct VkAccelerationStructureCreateInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkFlags createFlags;
  VkBuffer buffer;
  VkDeviceSize offset, size;
  VkAccelerationStructureTypeKHR type;
  VkDeviceAddress deviceAddress;
};
struct VkAccelerationStructureDeviceAddressInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkAccelerationStructureKHR accelerationStructure;
};
struct VkTransformMatrixKHR {
  float matrix[3][4];
};
struct VkAccelerationStructureInstanceKHR {
  VkTransformMatrixKHR transform;
  std::uint32_t instanceCustomIndex : 24, mask : 8, instanceShaderBindingTableRecordOffset : 24;
  VkFlags flags : 8;
  std::uint64_t accelerationStructureReference;
};
struct VkApplicationInfo {
  VkStructureType sType;
  const void *pNext;
  const char *pApplicationName;
  std::uint32_t applicationVersion;
  const char *pEngineName;
  std::uint32_t engineVersion, apiVersion;
};
struct VkBufferCopy {
  VkDeviceSize srcOffset, dstOffset, size;
};
struct VkBufferCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  VkDeviceSize size;
  VkFlags usage;
  VkSharingMode sharingMode;
  std::uint32_t queueFamilyIndexCount;
  const std::uint32_t *pQueueFamilyIndices;
};
struct VkBufferDeviceAddressInfo {
  VkStructureType sType;
  const void *pNext;
  VkBuffer buffer;
};
struct VkCommandBufferAllocateInfo {
  VkStructureType sType;
  const void *pNext;
  VkCommandPool commandPool;
  VkCommandBufferLevel level;
  std::uint32_t commandBufferCount;
};
struct VkCommandBufferBeginInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  const VkCommandBufferInheritanceInfo *pInheritanceInfo;
};
struct VkCommandPoolCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::uint32_t queueFamilyIndex;
};
struct VkSpecializationMapEntry {
  std::uint32_t constantID, offset;
  std::size_t size;
};
struct VkSpecializationInfo {
  std::uint32_t mapEntryCount;
  const VkSpecializationMapEntry *pMapEntries;
  std::size_t dataSize;
  const void *pData;
};
struct VkPipelineShaderStageCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  VkShaderStageFlagBits stage;
  VkShaderModule module;
  const char *pName;
  const VkSpecializationInfo *pSpecializationInfo;
};
struct VkComputePipelineCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  VkPipelineShaderStageCreateInfo stage;
  VkPipelineLayout layout;
  VkPipeline basePipelineHandle;
  std::int32_t basePipelineIndex;
};
struct VkCopyAccelerationStructureInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkAccelerationStructureKHR src, dst;
  VkCopyAccelerationStructureModeKHR mode;
};
struct VkDebugUtilsMessengerCallbackDataEXT {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  const char *pMessageIdName;
  std::int32_t messageIdNumber;
  const char *pMessage;
  std::uint32_t queueLabelCount;
  const VkDebugUtilsLabelEXT *pQueueLabels;
  std::uint32_t cmdBufLabelCount;
  const VkDebugUtilsLabelEXT *pCmdBufLabels;
  std::uint32_t objectCount;
  const VkDebugUtilsObjectNameInfoEXT *pObjects;
};
using PFN_vkDebugUtilsMessengerCallbackEXT = VkBool32 (*)(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                          VkDebugUtilsMessageTypeFlagsEXT,
                                                          const VkDebugUtilsMessengerCallbackDataEXT *, void *);
struct VkDebugUtilsMessengerCreateInfoEXT {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  VkFlags messageSeverity;
  VkDebugUtilsMessageTypeFlagsEXT messageType;
  PFN_vkDebugUtilsMessengerCallbackEXT pfnUserCallback;
  void *pUserData;
};
struct VkDeviceQueueCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::uint32_t queueFamilyIndex, queueCount;
  const float *pQueuePriorities;
};
struct VkPhysicalDeviceFeatures {
  VkBool32 robustBufferAccess, fullDrawIndexUint32, imageCubeArray, independentBlend, geometryShader,
      tessellationShader, sampleRateShading, dualSrcBlend, logicOp, multiDrawIndirect, drawIndirectFirstInstance,
      depthClamp, depthBiasClamp, fillModeNonSolid, depthBounds, wideLines, largePoints, alphaToOne, multiViewport,
      samplerAnisotropy, textureCompressionETC2, textureCompressionASTC_LDR, textureCompressionBC,
      occlusionQueryPrecise, pipelineStatisticsQuery, vertexPipelineStoresAndAtomics, fragmentStoresAndAtomics,
      shaderTessellationAndGeometryPointSize, shaderImageGatherExtended, shaderStorageImageExtendedFormats,
      shaderStorageImageMultisample, shaderStorageImageReadWithoutFormat, shaderStorageImageWriteWithoutFormat,
      shaderUniformBufferArrayDynamicIndexing, shaderSampledImageArrayDynamicIndexing,
      shaderStorageBufferArrayDynamicIndexing, shaderStorageImageArrayDynamicIndexing, shaderClipDistance,
      shaderCullDistance, shaderFloat64, shaderInt64, shaderInt16, shaderResourceResidency, shaderResourceMinLod,
      sparseBinding, sparseResidencyBuffer, sparseResidencyImage2D, sparseResidencyImage3D, sparseResidency2Samples,
      sparseResidency4Samples, sparseResidency8Samples, sparseResidency16Samples, sparseResidencyAliased,
      variableMultisampleRate, inheritedQueries;
};
struct VkDeviceCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::uint32_t queueCreateInfoCount;
  const VkDeviceQueueCreateInfo *pQueueCreateInfos;
  std::uint32_t enabledLayerCount;
  const char *const *ppEnabledLayerNames;
  std::uint32_t enabledExtensionCount;
  const char *const *ppEnabledExtensionNames;
  const VkPhysicalDeviceFeatures *pEnabledFeatures;
};
struct VkExtensionProperties {
  char extensionName[VK_MAX_EXTENSION_NAME_SIZE];
  std::uint32_t specVersion;
};
struct VkFenceCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
};
struct VkInstanceCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  const VkApplicationInfo *pApplicationInfo;
  std::uint32_t enabledLayerCount;
  const char *const *ppEnabledLayerNames;
  std::uint32_t enabledExtensionCount;
  const char *const *ppEnabledExtensionNames;
};
struct VkLayerProperties {
  char layerName[VK_MAX_EXTENSION_NAME_SIZE];
  std::uint32_t specVersion, implementationVersion;
  char description[VK_MAX_DESCRIPTION_SIZE];
};
struct VkMemoryAllocateFlagsInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::uint32_t deviceMask;
};
struct VkMemoryAllocateInfo {
  VkStructureType sType;
  const void *pNext;
  VkDeviceSize allocationSize;
  std::uint32_t memoryTypeIndex;
};
struct VkMemoryBarrier {
  VkStructureType sType;
  const void *pNext;
  VkFlags srcAccessMask, dstAccessMask;
};
struct VkMemoryRequirements {
  VkDeviceSize size, alignment;
  std::uint32_t memoryTypeBits;
};
struct VkPhysicalDeviceAccelerationStructureFeaturesKHR {
  VkStructureType sType;
  void *pNext;
  VkBool32 accelerationStructure, accelerationStructureCaptureReplay, accelerationStructureIndirectBuild,
      accelerationStructureHostCommands, descriptorBindingAccelerationStructureUpdateAfterBind;
};
struct VkPhysicalDeviceAccelerationStructurePropertiesKHR {
  VkStructureType sType;
  void *pNext;
  std::uint64_t maxGeometryCount, maxInstanceCount, maxPrimitiveCount;
  std::uint32_t maxPerStageDescriptorAccelerationStructures, maxPerStageDescriptorUpdateAfterBindAccelerationStructures,
      maxDescriptorSetAccelerationStructures, maxDescriptorSetUpdateAfterBindAccelerationStructures,
      minAccelerationStructureScratchOffsetAlignment;
};
struct VkConformanceVersion {
  std::uint8_t major, minor, subminor, patch;
};
struct VkPhysicalDeviceDriverProperties {
  VkStructureType sType;
  void *pNext;
  VkDriverId driverID;
  char driverName[VK_MAX_DRIVER_NAME_SIZE], driverInfo[VK_MAX_DRIVER_INFO_SIZE];
  VkConformanceVersion conformanceVersion;
};
struct VkPhysicalDeviceFeatures2 {
  VkStructureType sType;
  void *pNext;
  VkPhysicalDeviceFeatures features;
};
struct VkMemoryType {
  VkMemoryPropertyFlags propertyFlags;
  std::uint32_t heapIndex;
};
struct VkMemoryHeap {
  VkDeviceSize size;
  VkFlags flags;
};
struct VkPhysicalDeviceMemoryProperties {
  std::uint32_t memoryTypeCount;
  VkMemoryType memoryTypes[VK_MAX_MEMORY_TYPES];
  std::uint32_t memoryHeapCount;
  VkMemoryHeap memoryHeaps[VK_MAX_MEMORY_HEAPS];
};
struct VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR {
  VkStructureType sType;
  void *pNext;
  VkBool32 pipelineExecutableInfo;
};
struct VkPhysicalDeviceLimits {
  std::uint32_t maxImageDimension1D, maxImageDimension2D, maxImageDimension3D, maxImageDimensionCube,
      maxImageArrayLayers, maxTexelBufferElements, maxUniformBufferRange, maxStorageBufferRange, maxPushConstantsSize,
      maxMemoryAllocationCount, maxSamplerAllocationCount;
  VkDeviceSize bufferImageGranularity, sparseAddressSpaceSize;
  std::uint32_t maxBoundDescriptorSets, maxPerStageDescriptorSamplers, maxPerStageDescriptorUniformBuffers,
      maxPerStageDescriptorStorageBuffers, maxPerStageDescriptorSampledImages, maxPerStageDescriptorStorageImages,
      maxPerStageDescriptorInputAttachments, maxPerStageResources, maxDescriptorSetSamplers,
      maxDescriptorSetUniformBuffers, maxDescriptorSetUniformBuffersDynamic, maxDescriptorSetStorageBuffers,
      maxDescriptorSetStorageBuffersDynamic, maxDescriptorSetSampledImages, maxDescriptorSetStorageImages,
      maxDescriptorSetInputAttachments, maxVertexInputAttributes, maxVertexInputBindings, maxVertexInputAttributeOffset,
      maxVertexInputBindingStride, maxVertexOutputComponents, maxTessellationGenerationLevel, maxTessellationPatchSize,
      maxTessellationControlPerVertexInputComponents, maxTessellationControlPerVertexOutputComponents,
      maxTessellationControlPerPatchOutputComponents, maxTessellationControlTotalOutputComponents,
      maxTessellationEvaluationInputComponents, maxTessellationEvaluationOutputComponents, maxGeometryShaderInvocations,
      maxGeometryInputComponents, maxGeometryOutputComponents, maxGeometryOutputVertices,
      maxGeometryTotalOutputComponents, maxFragmentInputComponents, maxFragmentOutputAttachments,
      maxFragmentDualSrcAttachments, maxFragmentCombinedOutputResources, maxComputeSharedMemorySize,
      maxComputeWorkGroupCount[3], maxComputeWorkGroupInvocations, maxComputeWorkGroupSize[3], subPixelPrecisionBits,
      subTexelPrecisionBits, mipmapPrecisionBits, maxDrawIndexedIndexValue, maxDrawIndirectCount;
  float maxSamplerLodBias, maxSamplerAnisotropy;
  std::uint32_t maxViewports, maxViewportDimensions[2];
  float viewportBoundsRange[2];
  std::uint32_t viewportSubPixelBits;
  std::size_t minMemoryMapAlignment;
  VkDeviceSize minTexelBufferOffsetAlignment, minUniformBufferOffsetAlignment, minStorageBufferOffsetAlignment;
  std::int32_t minTexelOffset;
  std::uint32_t maxTexelOffset;
  std::int32_t minTexelGatherOffset;
  std::uint32_t maxTexelGatherOffset;
  float minInterpolationOffset, maxInterpolationOffset;
  std::uint32_t subPixelInterpolationOffsetBits, maxFramebufferWidth, maxFramebufferHeight, maxFramebufferLayers;
  VkFlags framebufferColorSampleCounts, framebufferDepthSampleCounts, framebufferStencilSampleCounts,
      framebufferNoAttachmentsSampleCounts;
  std::uint32_t maxColorAttachments;
  VkFlags sampledImageColorSampleCounts, sampledImageIntegerSampleCounts, sampledImageDepthSampleCounts,
      sampledImageStencilSampleCounts, storageImageSampleCounts;
  std::uint32_t maxSampleMaskWords;
  VkBool32 timestampComputeAndGraphics;
  float timestampPeriod;
  std::uint32_t maxClipDistances, maxCullDistances, maxCombinedClipAndCullDistances, discreteQueuePriorities;
  float pointSizeRange[2], lineWidthRange[2], pointSizeGranularity, lineWidthGranularity;
  VkBool32 strictLines, standardSampleLocations;
  VkDeviceSize optimalBufferCopyOffsetAlignment, optimalBufferCopyRowPitchAlignment, nonCoherentAtomSize;
};
struct VkPhysicalDeviceSparseProperties {
  VkBool32 residencyStandard2DBlockShape, residencyStandard2DMultisampleBlockShape, residencyStandard3DBlockShape,
      residencyAlignedMipSize, residencyNonResidentStrict;
};
struct VkPhysicalDeviceProperties {
  std::uint32_t apiVersion, driverVersion, vendorID, deviceID;
  VkPhysicalDeviceType deviceType;
  char deviceName[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
  std::uint8_t pipelineCacheUUID[VK_UUID_SIZE];
  VkPhysicalDeviceLimits limits;
  VkPhysicalDeviceSparseProperties sparseProperties;
};
struct VkPhysicalDeviceProperties2 {
  VkStructureType sType;
  void *pNext;
  VkPhysicalDeviceProperties properties;
};
struct VkPhysicalDeviceRayQueryFeaturesKHR {
  VkStructureType sType;
  void *pNext;
  VkBool32 rayQuery;
};
struct VkPhysicalDeviceVulkan12Features {
  VkStructureType sType;
  void *pNext;
  VkBool32 samplerMirrorClampToEdge, drawIndirectCount, storageBuffer8BitAccess, uniformAndStorageBuffer8BitAccess,
      storagePushConstant8, shaderBufferInt64Atomics, shaderSharedInt64Atomics, shaderFloat16, shaderInt8,
      descriptorIndexing, shaderInputAttachmentArrayDynamicIndexing, shaderUniformTexelBufferArrayDynamicIndexing,
      shaderStorageTexelBufferArrayDynamicIndexing, shaderUniformBufferArrayNonUniformIndexing,
      shaderSampledImageArrayNonUniformIndexing, shaderStorageBufferArrayNonUniformIndexing,
      shaderStorageImageArrayNonUniformIndexing, shaderInputAttachmentArrayNonUniformIndexing,
      shaderUniformTexelBufferArrayNonUniformIndexing, shaderStorageTexelBufferArrayNonUniformIndexing,
      descriptorBindingUniformBufferUpdateAfterBind, descriptorBindingSampledImageUpdateAfterBind,
      descriptorBindingStorageImageUpdateAfterBind, descriptorBindingStorageBufferUpdateAfterBind,
      descriptorBindingUniformTexelBufferUpdateAfterBind, descriptorBindingStorageTexelBufferUpdateAfterBind,
      descriptorBindingUpdateUnusedWhilePending, descriptorBindingPartiallyBound,
      descriptorBindingVariableDescriptorCount, runtimeDescriptorArray, samplerFilterMinmax, scalarBlockLayout,
      imagelessFramebuffer, uniformBufferStandardLayout, shaderSubgroupExtendedTypes, separateDepthStencilLayouts,
      hostQueryReset, timelineSemaphore, bufferDeviceAddress, bufferDeviceAddressCaptureReplay,
      bufferDeviceAddressMultiDevice, vulkanMemoryModel, vulkanMemoryModelDeviceScope,
      vulkanMemoryModelAvailabilityVisibilityChains, shaderOutputViewportIndex, shaderOutputLayer,
      subgroupBroadcastDynamicId;
};
struct VkPipelineCacheCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::size_t initialDataSize;
  const void *pInitialData;
};
struct VkPipelineExecutableInfoKHR {
  VkStructureType sType;
  const void *pNext;
  VkPipeline pipeline;
  std::uint32_t executableIndex;
};
union VkPipelineExecutableStatisticValueKHR {
  VkBool32 b32;
  std::int64_t i64;
  std::uint64_t u64;
  double f64;
};
struct VkPipelineExecutableStatisticKHR {
  VkStructureType sType;
  void *pNext;
  char name[VK_MAX_DESCRIPTION_SIZE], description[VK_MAX_DESCRIPTION_SIZE];
  VkPipelineExecutableStatisticFormatKHR format;
  VkPipelineExecutableStatisticValueKHR value;
};
struct VkPushConstantRange {
  VkFlags stageFlags;
  std::uint32_t offset, size;
};
struct VkPipelineLayoutCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::uint32_t setLayoutCount;
  const VkDescriptorSetLayout *pSetLayouts;
  std::uint32_t pushConstantRangeCount;
  const VkPushConstantRange *pPushConstantRanges;
};
struct VkQueryPoolCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  VkQueryType queryType;
  std::uint32_t queryCount;
  VkFlags pipelineStatistics;
};
struct VkExtent3D {
  std::uint32_t width, height, depth;
};
struct VkQueueFamilyProperties {
  VkFlags queueFlags;
  std::uint32_t queueCount, timestampValidBits;
  VkExtent3D minImageTransferGranularity;
};
struct VkShaderModuleCreateInfo {
  VkStructureType sType;
  const void *pNext;
  VkFlags flags;
  std::size_t codeSize;
  const std::uint32_t *pCode;
};
struct VkSubmitInfo {
  VkStructureType sType;
  const void *pNext;
  std::uint32_t waitSemaphoreCount;
  const VkSemaphore *pWaitSemaphores;
  const VkPipelineStageFlags *pWaitDstStageMask;
  std::uint32_t commandBufferCount;
  const VkCommandBuffer *pCommandBuffers;
  std::uint32_t signalSemaphoreCount;
  const VkSemaphore *pSignalSemaphores;
};

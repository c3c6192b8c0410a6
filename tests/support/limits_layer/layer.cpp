// A Vulkan layer that makes of any device the least that Regulus may meet, and stops the process when more is
// used than was claimed: allocations and buffers of 1 GiB, 65,535 groups a dispatch of at most 128
// invocations, 16 KiB of shared memory, subgroups of 4, no 64-bit integers. tests/cli/limits.cpp renders
// under it.
//
// Variables of the environment: REGULUS_LIMITS_SUBGROUP, REGULUS_LIMITS_SHARED (bytes) and
// REGULUS_LIMITS_ALLOCATION (MiB) claim others; REGULUS_LIMITS_HELD_ALLOCATION (MiB) holds the process to
// less than is claimed.
#include <vulkan/vk_layer.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <span>
#include <string>

#include "module_needs.hpp"

namespace {

uint64_t variable(const char* name, uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

struct Claims {
  uint32_t groups = 65535, workgroup_size = 128, push_constant_bytes = 128;
  uint32_t subgroup_size = static_cast<uint32_t>(variable("REGULUS_LIMITS_SUBGROUP", 4));
  uint32_t shared_bytes = static_cast<uint32_t>(variable("REGULUS_LIMITS_SHARED", 16384));
  uint64_t allocation_bytes = variable("REGULUS_LIMITS_ALLOCATION", 1024) << 20;
  uint64_t held_allocation_bytes = variable("REGULUS_LIMITS_HELD_ALLOCATION", allocation_bytes >> 20) << 20;
};

const Claims& claims() {
  static const Claims claims;
  return claims;
}

void hold(bool is_kept, const char* what, uint64_t used, uint64_t claimed) {
  if (is_kept) return;
  std::fprintf(stderr, "limits layer: %s: %llu used, %llu claimed\n", what,
               static_cast<unsigned long long>(used), static_cast<unsigned long long>(claimed));
  std::abort();
}

// The next layer's functions, by instance and device: their handles point to what all their children point
// to. They are asked for when those are made: later the loader's answers are this layer's own.
constexpr const char* INSTANCE_FUNCTIONS[] = {"vkCreateDevice", "vkGetPhysicalDeviceProperties",
                                              "vkGetPhysicalDeviceProperties2", "vkGetPhysicalDeviceFeatures",
                                              "vkGetPhysicalDeviceFeatures2"};
constexpr const char* DEVICE_FUNCTIONS[] = {"vkAllocateMemory", "vkCreateBuffer", "vkCreateShaderModule",
                                            "vkCmdDispatch"};
using Functions = std::map<std::string, PFN_vkVoidFunction>;
struct InstanceTable {
  PFN_vkGetInstanceProcAddr get;
  Functions functions;
};
struct DeviceTable {
  PFN_vkGetDeviceProcAddr get;
  Functions functions;
};

std::mutex tables_mutex;
std::map<void*, InstanceTable> instances;
std::map<void*, DeviceTable> devices;

template <typename Handle>
void* key_of(Handle handle) {
  return *reinterpret_cast<void**>(handle);
}

template <typename Function, typename Handle>
Function next_of_instance(Handle handle, const char* name) {
  const std::lock_guard lock(tables_mutex);
  return reinterpret_cast<Function>(instances.at(key_of(handle)).functions.at(name));
}

template <typename Function, typename Handle>
Function next_of_device(Handle handle, const char* name) {
  const std::lock_guard lock(tables_mutex);
  return reinterpret_cast<Function>(devices.at(key_of(handle)).functions.at(name));
}

template <typename Value, typename Least>
void at_most(Value& value, Least limit) {
  value = std::min<Value>(value, static_cast<Value>(limit));
}

void lower(VkPhysicalDeviceLimits& limits) {
  const uint32_t invocations = claims().workgroup_size;
  for (uint32_t& count : limits.maxComputeWorkGroupCount) at_most(count, claims().groups);
  for (uint32_t& size : limits.maxComputeWorkGroupSize) at_most(size, invocations);
  at_most(limits.maxComputeWorkGroupInvocations, invocations);
  at_most(limits.maxComputeSharedMemorySize, claims().shared_bytes);
  at_most(limits.maxPushConstantsSize, claims().push_constant_bytes);
}

void lower_chain(VkBaseOutStructure* next) {
  for (; next != nullptr; next = next->pNext) {
    switch (next->sType) {
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES: {
        auto& properties = *reinterpret_cast<VkPhysicalDeviceVulkan11Properties*>(next);
        at_most(properties.maxMemoryAllocationSize, claims().allocation_bytes);
        properties.subgroupSize = claims().subgroup_size;
        break;
      }
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES:
        at_most(reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(next)->maxMemoryAllocationSize,
                claims().allocation_bytes);
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES:
        reinterpret_cast<VkPhysicalDeviceSubgroupProperties*>(next)->subgroupSize = claims().subgroup_size;
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES:
        at_most(reinterpret_cast<VkPhysicalDeviceVulkan13Properties*>(next)->maxBufferSize,
                claims().allocation_bytes);
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES:
        at_most(reinterpret_cast<VkPhysicalDeviceMaintenance4Properties*>(next)->maxBufferSize,
                claims().allocation_bytes);
        break;
      default:
        break;
    }
  }
}

VKAPI_ATTR void VKAPI_CALL GetProperties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
  next_of_instance<PFN_vkGetPhysicalDeviceProperties>(physical, "vkGetPhysicalDeviceProperties")(physical,
                                                                                                 properties);
  lower(properties->limits);
}

VKAPI_ATTR void VKAPI_CALL GetProperties2(VkPhysicalDevice physical,
                                          VkPhysicalDeviceProperties2* properties) {
  next_of_instance<PFN_vkGetPhysicalDeviceProperties2>(physical, "vkGetPhysicalDeviceProperties2")(
      physical, properties);
  lower(properties->properties.limits);
  lower_chain(static_cast<VkBaseOutStructure*>(properties->pNext));
}

VKAPI_ATTR void VKAPI_CALL GetFeatures(VkPhysicalDevice physical, VkPhysicalDeviceFeatures* features) {
  next_of_instance<PFN_vkGetPhysicalDeviceFeatures>(physical, "vkGetPhysicalDeviceFeatures")(physical,
                                                                                             features);
  features->shaderInt64 = VK_FALSE;
}

VKAPI_ATTR void VKAPI_CALL GetFeatures2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
  next_of_instance<PFN_vkGetPhysicalDeviceFeatures2>(physical, "vkGetPhysicalDeviceFeatures2")(physical,
                                                                                               features);
  features->features.shaderInt64 = VK_FALSE;
}

VKAPI_ATTR VkResult VKAPI_CALL AllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                              const VkAllocationCallbacks* callbacks,
                                              VkDeviceMemory* memory) {
  const uint64_t most = claims().held_allocation_bytes;
  hold(info->allocationSize <= most, "bytes of an allocation", info->allocationSize, most);
  return next_of_device<PFN_vkAllocateMemory>(device, "vkAllocateMemory")(device, info, callbacks, memory);
}

VKAPI_ATTR VkResult VKAPI_CALL CreateBuffer(VkDevice device, const VkBufferCreateInfo* info,
                                            const VkAllocationCallbacks* callbacks, VkBuffer* buffer) {
  const uint64_t most = claims().held_allocation_bytes;
  hold(info->size <= most, "bytes of a buffer", info->size, most);
  return next_of_device<PFN_vkCreateBuffer>(device, "vkCreateBuffer")(device, info, callbacks, buffer);
}

VKAPI_ATTR VkResult VKAPI_CALL CreateShaderModule(VkDevice device, const VkShaderModuleCreateInfo* info,
                                                  const VkAllocationCallbacks* callbacks,
                                                  VkShaderModule* shader) {
  const regulus::test::ModuleNeeds needs =
      regulus::test::needs_of(std::span(info->pCode, info->codeSize / sizeof(uint32_t)));
  hold(!needs.int64, "64-bit integers of a module", 1, 0);
  hold(needs.shared_bytes <= claims().shared_bytes, "bytes of shared memory", needs.shared_bytes,
       claims().shared_bytes);
  hold(needs.workgroup_size <= claims().workgroup_size, "invocations of a group", needs.workgroup_size,
       claims().workgroup_size);
  return next_of_device<PFN_vkCreateShaderModule>(device, "vkCreateShaderModule")(device, info, callbacks,
                                                                                  shader);
}

VKAPI_ATTR void VKAPI_CALL CmdDispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
  const uint32_t most = std::max({x, y, z});
  hold(most <= claims().groups, "groups of a dispatch", most, claims().groups);
  next_of_device<PFN_vkCmdDispatch>(commands, "vkCmdDispatch")(commands, x, y, z);
}

// The link of the loader's chain that says who comes next.
template <typename Link, typename Info>
Link* link_of(const Info* info, VkStructureType type) {
  auto* link = static_cast<Link*>(const_cast<void*>(info->pNext));
  while (link != nullptr && (link->sType != type || link->function != VK_LAYER_LINK_INFO))
    link = static_cast<Link*>(const_cast<void*>(link->pNext));
  return link;
}

VKAPI_ATTR VkResult VKAPI_CALL CreateInstance(const VkInstanceCreateInfo* info,
                                              const VkAllocationCallbacks* callbacks, VkInstance* instance) {
  auto* link = link_of<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetInstanceProcAddr get = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(VK_NULL_HANDLE, "vkCreateInstance"));
  const VkResult result = create(info, callbacks, instance);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(tables_mutex);
  InstanceTable& table = instances[key_of(*instance)] = {get, {}};
  for (const char* name : INSTANCE_FUNCTIONS) table.functions[name] = get(*instance, name);
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL CreateDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* callbacks, VkDevice* device) {
  const VkPhysicalDeviceFeatures* wanted = info->pEnabledFeatures;
  for (auto* next = static_cast<const VkBaseInStructure*>(info->pNext); next != nullptr; next = next->pNext)
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2)
      wanted = &reinterpret_cast<const VkPhysicalDeviceFeatures2*>(next)->features;
  hold(wanted == nullptr || wanted->shaderInt64 == VK_FALSE, "shaderInt64", 1, 0);
  auto* link = link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetDeviceProcAddr next_get = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = next_of_instance<PFN_vkCreateDevice>(physical, "vkCreateDevice");
  const VkResult result = create(physical, info, callbacks, device);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(tables_mutex);
  DeviceTable& table = devices[key_of(*device)] = {next_get, {}};
  for (const char* name : DEVICE_FUNCTIONS) table.functions[name] = next_get(*device, name);
  return result;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance instance, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice device, const char* name);

template <typename Function>
PFN_vkVoidFunction plain(Function* function) {
  return reinterpret_cast<PFN_vkVoidFunction>(function);
}

PFN_vkVoidFunction own_function(const char* name) {
  static const std::map<std::string, PFN_vkVoidFunction> functions = {
      {"vkGetInstanceProcAddr", plain(GetInstanceProcAddr)},
      {"vkGetDeviceProcAddr", plain(GetDeviceProcAddr)},
      {"vkCreateInstance", plain(CreateInstance)},
      {"vkCreateDevice", plain(CreateDevice)},
      {"vkGetPhysicalDeviceProperties", plain(GetProperties)},
      {"vkGetPhysicalDeviceProperties2", plain(GetProperties2)},
      {"vkGetPhysicalDeviceProperties2KHR", plain(GetProperties2)},
      {"vkGetPhysicalDeviceFeatures", plain(GetFeatures)},
      {"vkGetPhysicalDeviceFeatures2", plain(GetFeatures2)},
      {"vkGetPhysicalDeviceFeatures2KHR", plain(GetFeatures2)},
      {"vkAllocateMemory", plain(AllocateMemory)},
      {"vkCreateBuffer", plain(CreateBuffer)},
      {"vkCreateShaderModule", plain(CreateShaderModule)},
      {"vkCmdDispatch", plain(CmdDispatch)}};
  const auto found = functions.find(name);
  return found != functions.end() ? found->second : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance instance, const char* name) {
  if (const PFN_vkVoidFunction own = own_function(name)) return own;
  if (instance == VK_NULL_HANDLE) return nullptr;
  const std::lock_guard lock(tables_mutex);
  return instances.at(key_of(instance)).get(instance, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice device, const char* name) {
  if (const PFN_vkVoidFunction own = own_function(name)) return own;
  const std::lock_guard lock(tables_mutex);
  return devices.at(key_of(device)).get(device, name);
}

}  // namespace

extern "C" VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* versions) {
  versions->loaderLayerInterfaceVersion = 2;
  versions->pfnGetInstanceProcAddr = GetInstanceProcAddr;
  versions->pfnGetDeviceProcAddr = GetDeviceProcAddr;
  versions->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}

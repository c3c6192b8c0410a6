#include "gpu/instance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "base/process.hpp"
#include "gpu/limits.hpp"
#include "gpu/machine.hpp"
#include "gpu/selection.hpp"

namespace regulus::gpu {
namespace {

DeviceKind kind_of(vk::PhysicalDeviceType type) {
  switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
      return DeviceKind::Discrete;
    case vk::PhysicalDeviceType::eIntegratedGpu:
      return DeviceKind::Integrated;
    case vk::PhysicalDeviceType::eVirtualGpu:
      return DeviceKind::Virtual;
    case vk::PhysicalDeviceType::eCpu:
      return DeviceKind::Software;
    default:
      return DeviceKind::Other;
  }
}

std::optional<uint32_t> compute_family(const std::vector<vk::QueueFamilyProperties>& families) {
  for (uint32_t i = 0; i < families.size(); ++i)
    if (families[i].queueFlags & vk::QueueFlagBits::eCompute) return i;
  return std::nullopt;
}

uint64_t largest_device_heap(const vk::PhysicalDeviceMemoryProperties& memory) {
  uint64_t largest = 0;
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i)
    if (memory.memoryHeaps[i].flags & vk::MemoryHeapFlagBits::eDeviceLocal)
      largest = std::max<uint64_t>(largest, memory.memoryHeaps[i].size);
  return largest;
}

/// Fills in whether the device has ray queries, and what building their structures needs.
void describe_ray_queries(const vk::raii::PhysicalDevice& physical, Candidate& candidate) {
  const std::vector<std::string> extensions = extensions_of(physical);
  const auto is_there = [&](const char* name) { return std::ranges::count(extensions, name) != 0; };
  if (!std::ranges::all_of(RAY_QUERY_EXTENSIONS, is_there)) return;
  const auto features =
      physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceAccelerationStructureFeaturesKHR,
                            vk::PhysicalDeviceRayQueryFeaturesKHR>();
  candidate.info.has_ray_query =
      features.get<vk::PhysicalDeviceAccelerationStructureFeaturesKHR>().accelerationStructure != 0 &&
      features.get<vk::PhysicalDeviceRayQueryFeaturesKHR>().rayQuery != 0;
  const auto properties = physical.getProperties2<vk::PhysicalDeviceProperties2,
                                                  vk::PhysicalDeviceAccelerationStructurePropertiesKHR>();
  candidate.scratch_alignment = properties.get<vk::PhysicalDeviceAccelerationStructurePropertiesKHR>()
                                    .minAccelerationStructureScratchOffsetAlignment;
}

/// Fills in what only a Vulkan 1.2 device can be asked.
void describe_1_2(const vk::raii::PhysicalDevice& physical, DeviceInfo& info) {
  const auto properties =
      physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan11Properties,
                              vk::PhysicalDeviceVulkan12Properties>();
  const auto& basic = properties.get<vk::PhysicalDeviceVulkan11Properties>();
  const auto& driver = properties.get<vk::PhysicalDeviceVulkan12Properties>();
  info.driver = fmt::format("{} {}", driver.driverName.data(), driver.driverInfo.data());
  info.uuid = fmt::format("{:02x}", fmt::join(basic.deviceUUID, ""));
  info.subgroup_size = basic.subgroupSize;
  info.max_allocation_bytes = basic.maxMemoryAllocationSize;
  if (info.api_version >= VK_API_VERSION_1_3) {
    const auto more =
        physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan13Properties>();
    info.max_allocation_bytes = std::min<uint64_t>(
        info.max_allocation_bytes, more.get<vk::PhysicalDeviceVulkan13Properties>().maxBufferSize);
  }

  const auto features =
      physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features>();
  const auto& has = features.get<vk::PhysicalDeviceVulkan12Features>();
  info.has_int64 = features.get<vk::PhysicalDeviceFeatures2>().features.shaderInt64;
  if (!has.bufferDeviceAddress) info.missing.emplace_back("bufferDeviceAddress");
  if (!has.scalarBlockLayout) info.missing.emplace_back("scalarBlockLayout");
}

void check_limit(DeviceInfo& info, const char* name, uint64_t has, uint64_t needs) {
  if (has < needs) info.missing.push_back(fmt::format("limit {} is {}, needs {}", name, has, needs));
}

Candidate describe(const vk::raii::PhysicalDevice& physical) {
  const vk::PhysicalDeviceProperties properties = physical.getProperties();
  const std::vector<vk::QueueFamilyProperties> families = physical.getQueueFamilyProperties();
  const std::optional<uint32_t> family = compute_family(families);

  Candidate candidate{.info = {}, .physical = physical};
  DeviceInfo& info = candidate.info;
  info.name = properties.deviceName.data();
  info.kind = kind_of(properties.deviceType);
  info.api_version = properties.apiVersion;
  info.heap_bytes = largest_device_heap(physical.getMemoryProperties());
  info.max_workgroup_size = properties.limits.maxComputeWorkGroupInvocations;
  info.max_groups = properties.limits.maxComputeWorkGroupCount[0];
  if (family) {
    candidate.queue_family = *family;
    candidate.timestamp_bits = families[*family].timestampValidBits;
    if (candidate.timestamp_bits > 0) info.timestamp_ns = properties.limits.timestampPeriod;
  } else {
    info.missing.emplace_back("a compute queue");
  }

  if (info.api_version < VK_API_VERSION_1_2) {
    info.missing.push_back(fmt::format("Vulkan 1.2 (has {}.{})", VK_API_VERSION_MAJOR(info.api_version),
                                       VK_API_VERSION_MINOR(info.api_version)));
    return candidate;
  }
  describe_1_2(physical, info);
  describe_ray_queries(physical, candidate);
  check_limit(info, "maxPushConstantsSize", properties.limits.maxPushConstantsSize, PUSH_CONSTANT_BYTES);
  check_limit(info, "maxComputeWorkGroupInvocations", info.max_workgroup_size, NEEDED_WORKGROUP_SIZE);
  check_limit(info, "maxComputeSharedMemorySize", properties.limits.maxComputeSharedMemorySize,
              NEEDED_SHARED_BYTES);
  check_limit(info, "maxMemoryAllocationSize", info.max_allocation_bytes, NEEDED_ALLOCATION_BYTES);
  return candidate;
}

/// lavapipe reads its vector width from the environment when its instance is made. The user's choice stands.
void choose_software_vector_width() {
  if (*SOFTWARE_VECTOR_BITS != '\0') set_default_variable("LP_NATIVE_VECTOR_WIDTH", SOFTWARE_VECTOR_BITS);
}

/// Drivers that are layered over another interface (MoltenVK) are shown to those only who ask for them.
/// Asking first is cheaper than looking whether the loader knows the question: it loads every driver for
/// that.
vk::raii::Instance create_instance(const vk::raii::Context& context, const vk::ApplicationInfo& application) {
  const char* portability = VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME;
  try {
    return {context, vk::InstanceCreateInfo(vk::InstanceCreateFlagBits::eEnumeratePortabilityKHR,
                                            &application, {}, portability)};
  } catch (const vk::ExtensionNotPresentError&) {
    return {context, vk::InstanceCreateInfo({}, &application)};
  }
}

}  // namespace

std::shared_ptr<Instance> Instance::open() {
  choose_software_vector_width();
  try {
    vk::raii::Context context;
    const vk::ApplicationInfo application("regulus", 1, nullptr, 0, VK_API_VERSION_1_3);
    vk::raii::Instance handle = create_instance(context, application);
    return std::make_shared<Instance>(Instance{std::move(context), std::move(handle)});
  } catch (const std::runtime_error&) {
    return nullptr;  // no libvulkan, or a loader without a driver
  }
}

std::vector<std::string> extensions_of(const vk::raii::PhysicalDevice& physical) {
  std::vector<std::string> names;
  for (const vk::ExtensionProperties& extension : physical.enumerateDeviceExtensionProperties())
    names.emplace_back(extension.extensionName.data());
  return names;
}

bool has_extension(const vk::raii::PhysicalDevice& physical, std::string_view name) {
  return std::ranges::count(extensions_of(physical), name) != 0;
}

std::vector<Candidate> find_devices(const Instance& instance) {
  std::vector<Candidate> candidates;
  try {
    for (const vk::raii::PhysicalDevice& physical : vk::raii::PhysicalDevices(instance.handle))
      candidates.push_back(describe(physical));
  } catch (const vk::SystemError&) {
    return {};  // a driver that fails to start is no device
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return preference(a.info.kind) < preference(b.info.kind);
  });
  for (uint32_t i = 0; i < candidates.size(); ++i) candidates[i].info.index = i;
  return candidates;
}

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> devices;
  if (const auto instance = Instance::open())
    for (Candidate& candidate : find_devices(*instance)) devices.push_back(std::move(candidate.info));
  return devices;
}

std::vector<std::string> split_device_list(const std::string& text) {
  if (text != "all" && text.find(',') == std::string::npos) return {text};
  std::vector<std::string> chosen;
  for (const size_t place : select_devices(list_devices(), text)) chosen.push_back(std::to_string(place));
  return chosen;
}

bool has_vulkan_loader() {
  try {
    const vk::raii::Context context;
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace regulus::gpu

// Opening a device.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "gpu/limits.hpp"
#include "gpu/selection.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

Candidate choose(const Instance* instance, std::string_view select) {
  std::vector<Candidate> candidates;
  if (instance) candidates = find_devices(*instance);
  std::vector<DeviceInfo> infos;
  infos.reserve(candidates.size());
  for (const Candidate& candidate : candidates) infos.push_back(candidate.info);
  return candidates[select_device(infos, select)];
}

/// Whether the driver tells what it made of a kernel.
bool can_tell_statistics(const vk::raii::PhysicalDevice& physical) {
  if (!has_extension(physical, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME)) return false;
  const auto features = physical.getFeatures2<vk::PhysicalDeviceFeatures2,
                                              vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR>();
  return features.get<vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR>().pipelineExecutableInfo !=
         0;
}

vk::raii::Device open(const Candidate& chosen, bool with_statistics) {
  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue({}, chosen.queue_family, 1, &priority);
  const std::vector<const char*> extensions =
      extensions_to_enable(extensions_of(chosen.physical), with_statistics, chosen.info.has_ray_query);

  vk::StructureChain<vk::DeviceCreateInfo, vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                     vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR,
                     vk::PhysicalDeviceAccelerationStructureFeaturesKHR,
                     vk::PhysicalDeviceRayQueryFeaturesKHR>
      create;
  create.get<vk::DeviceCreateInfo>().setQueueCreateInfos(queue).setPEnabledExtensionNames(extensions);
  create.get<vk::PhysicalDeviceFeatures2>().features.shaderInt64 = chosen.info.has_int64;
  create.get<vk::PhysicalDeviceVulkan12Features>().setBufferDeviceAddress(true).setScalarBlockLayout(true);
  create.get<vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR>().setPipelineExecutableInfo(true);
  if (!with_statistics) create.unlink<vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR>();
  create.get<vk::PhysicalDeviceAccelerationStructureFeaturesKHR>().setAccelerationStructure(true);
  create.get<vk::PhysicalDeviceRayQueryFeaturesKHR>().setRayQuery(true);
  if (!chosen.info.has_ray_query) {
    create.unlink<vk::PhysicalDeviceAccelerationStructureFeaturesKHR>();
    create.unlink<vk::PhysicalDeviceRayQueryFeaturesKHR>();
  }
  try {
    return {chosen.physical, create.get<vk::DeviceCreateInfo>()};
  } catch (const vk::SystemError& error) {
    throw Error(ErrorCode::NoDevice, fmt::format("device {} cannot be opened ({}); try another one",
                                                 chosen.info.name, error.what()));
  }
}

DriverIdentity identify(const vk::raii::PhysicalDevice& physical) {
  const auto all =
      physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan12Properties>();
  const vk::PhysicalDeviceProperties& properties = all.get<vk::PhysicalDeviceProperties2>().properties;
  DriverIdentity identity{.vendor = properties.vendorID,
                          .device = properties.deviceID,
                          .driver_version = properties.driverVersion};
  std::copy(properties.pipelineCacheUUID.begin(), properties.pipelineCacheUUID.end(),
            identity.cache_uuid.begin());
  identity.keeps_special_values =
      all.get<vk::PhysicalDeviceVulkan12Properties>().shaderSignedZeroInfNanPreserveFloat32;
  return identity;
}

}  // namespace

Faults& faults() {
  static Faults faults;
  return faults;
}

DeviceState::DeviceState(const DeviceOptions& options)
    : instance(Instance::open()), chosen(choose(instance.get(), options.select)) {
  chosen.info.max_groups = std::min(chosen.info.max_groups, faults().most_groups.value_or(UINT32_MAX));
  has_memory_budget = has_extension(chosen.physical, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME);
  const bool is_wanted = options.software_stage_times || info().kind != DeviceKind::Software;
  measures_time = is_wanted && info().timestamp_ns > 0;
  memory_bytes = options.memory_bytes != 0 ? options.memory_bytes : std::numeric_limits<uint64_t>::max();
  memory = chosen.physical.getMemoryProperties();
  tells_statistics = options.kernel_statistics && can_tell_statistics(chosen.physical);
  device = open(chosen, tells_statistics);
  queue = vk::raii::Queue(device, chosen.queue_family, 0);
  pool = vk::raii::CommandPool(device,
                               {vk::CommandPoolCreateFlagBits::eResetCommandBuffer, chosen.queue_family});
  const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0, PUSH_CONSTANT_BYTES);
  layout = vk::raii::PipelineLayout(device, vk::PipelineLayoutCreateInfo({}, {}, range));
  driver = identify(chosen.physical);
  if (options.pipeline_cache) cache_folder = gpu::cache_folder();
}

void DeviceState::throw_lost(std::span<const std::string> stages, int completed) {
  is_lost = true;
  throw Error(ErrorCode::NoDevice, lost_message(info().name, stages, completed));
}

Device::Device(const DeviceOptions& options)
    : impl(std::make_unique<Impl>(Impl{std::make_shared<DeviceState>(options)})) {}

Device::~Device() {
  DeviceState& state = *impl->state;
  try {
    if (!state.is_lost) state.device.waitIdle();
  } catch (const vk::SystemError&) {
    state.is_lost = true;  // nothing is left to wait for
  }
  if (state.has_new_pipelines) prune_cache(state.cache_folder, CACHED_KERNELS);
}

const DeviceInfo& Device::info() const {
  return impl->state->info();
}
uint64_t Device::allocated_bytes() const {
  return impl->state->allocated_bytes;
}
uint64_t Device::peak_allocated_bytes() const {
  return impl->state->peak_allocated_bytes;
}
uint64_t Device::free_bytes() const {
  return impl->state->free_bytes();
}
const std::vector<KernelStatistics>& Device::kernel_statistics() const {
  return impl->state->kernel_statistics;
}
void Device::watch_kernels(std::function<void(size_t done, size_t total)> watch) {
  impl->state->kernel_watcher = std::move(watch);
}
double Device::pipeline_seconds() const {
  return impl->state->pipeline_seconds;
}

}  // namespace regulus::gpu

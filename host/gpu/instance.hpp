// The Vulkan instance and the physical devices behind it. Internal to host/gpu.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "gpu/gpu.hpp"

namespace regulus::gpu {

/// Opens the Vulkan loader and an instance; null if there is no loader or no driver.
struct Instance {
  vk::raii::Context context;
  vk::raii::Instance handle;

  static std::shared_ptr<Instance> open();
};

/// A device that could be opened.
struct Candidate {
  DeviceInfo info;
  vk::raii::PhysicalDevice physical;
  uint32_t queue_family = 0;  ///< first one with compute
  uint32_t timestamp_bits = 0;
  uint64_t scratch_alignment = 1;  ///< of memory that structures are built in, bytes
};

/// The device extensions that a device has; whether it has one.
std::vector<std::string> extensions_of(const vk::raii::PhysicalDevice& physical);
bool has_extension(const vk::raii::PhysicalDevice& physical, std::string_view name);

/// All devices in order of preference, their indices set.
std::vector<Candidate> find_devices(const Instance& instance);

}  // namespace regulus::gpu

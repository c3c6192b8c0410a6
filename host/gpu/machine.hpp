// What of Vulkan is on this machine, whether a device can be opened or not.
#pragma once

#include <cstdint>
#include <filesystem>

namespace regulus::gpu {

/// Whether there is a Vulkan loader (libvulkan.so.1), with drivers or without.
bool has_vulkan_loader();

/// Compiled kernels of earlier runs.
struct KernelCache {
  std::filesystem::path folder;  ///< empty: there is no place for it; it may not exist yet
  uint64_t kernels = 0, bytes = 0;
  uint64_t most_kernels = 0;  ///< older ones are removed
};
KernelCache find_kernel_cache();

}  // namespace regulus::gpu

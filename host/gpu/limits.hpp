// What Regulus needs of a device, and the constants of the device layer. Internal to host/gpu.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace regulus::gpu {

// Every Vulkan device has the first three; they are checked because a driver's word is cheap to check.
inline constexpr uint32_t PUSH_CONSTANT_BYTES = 128;
inline constexpr uint32_t NEEDED_WORKGROUP_SIZE = 128;
inline constexpr uint32_t NEEDED_SHARED_BYTES = 16384;
inline constexpr uint64_t NEEDED_ALLOCATION_BYTES = uint64_t{256} << 20;

/// Copies between host and device go through memory of this size.
inline constexpr uint64_t STAGING_BYTES = uint64_t{16} << 20;

/// Timestamps are created in pools of this many.
inline constexpr uint32_t TIMESTAMPS_PER_POOL = 256;

/// Kernels kept in the user's cache folder.
inline constexpr size_t CACHED_KERNELS = 1024;

/// Value of LP_NATIVE_VECTOR_WIDTH ("128", "256", "512") that suits lavapipe best; empty: its own default.
/// Mesa's disk cache does not tell the widths apart: use a fresh cache folder (MESA_SHADER_CACHE_DIR) when
/// comparing them.
inline constexpr const char* SOFTWARE_VECTOR_BITS = "";

/// What ray queries need. (The names of vulkan_core.h, which this header does without.)
inline constexpr std::array RAY_QUERY_EXTENSIONS = {"VK_KHR_ray_query", "VK_KHR_acceleration_structure",
                                                    "VK_KHR_deferred_host_operations"};

}  // namespace regulus::gpu

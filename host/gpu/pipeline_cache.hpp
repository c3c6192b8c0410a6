// The compiled form of one kernel in the user's cache folder: one file per device, driver, shader and
// specialization. Knows files only; nothing that goes wrong with them is an error, the kernel is then
// compiled again. Internal to host/gpu and its tests.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "gpu/gpu.hpp"

namespace regulus::gpu {

/// What must agree before a driver may be given cached data.
struct DriverIdentity {
  uint32_t vendor = 0;
  uint32_t device = 0;
  uint32_t driver_version = 0;
  std::array<uint8_t, 16> cache_uuid{};
  uint32_t keeps_special_values = 0;  ///< kernels declare SignedZeroInfNanPreserve, see specialize.hpp
};

/// Hash of driver, shader and specialization: what a compiled pipeline depends on.
uint64_t kernel_key(const DriverIdentity& driver, const KernelDescription& kernel);

/// $XDG_CACHE_HOME/regulus or ~/.cache/regulus; empty if neither is set.
std::filesystem::path cache_folder();

/// What one file holds.
struct CachedKernel {
  std::vector<uint32_t> spirv;         ///< the specialized module
  std::vector<std::byte> driver_data;  ///< for vkCreatePipelineCache
  bool operator==(const CachedKernel&) const = default;
};

class PipelineCacheFile {
 public:
  /// An empty folder makes a cache that holds nothing.
  PipelineCacheFile(const std::filesystem::path& folder, const DriverIdentity& driver,
                    const KernelDescription& kernel);

  /// Both parts empty unless the file is there, whole, and of this driver and kernel.
  CachedKernel load() const;
  /// Replaces the file in one step: a reader finds the old or the new one.
  void store(const CachedKernel& kernel) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  DriverIdentity driver_;
  uint64_t key_ = 0;
  std::filesystem::path path_;
};

/// Deletes the files that were written longest ago until `keep` are left: kernels of older versions of the
/// renderer are never asked for again.
void prune_cache(const std::filesystem::path& folder, size_t keep);

}  // namespace regulus::gpu

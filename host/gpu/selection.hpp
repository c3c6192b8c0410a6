// Which of the machine's devices to open: pure functions of their descriptions. Internal to host/gpu and its
// tests.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "gpu/gpu.hpp"

namespace regulus::gpu {

/// Sort key of a device kind: discrete, integrated, virtual, other, software.
int preference(DeviceKind kind);

/// Position in `devices` of the one that `select` names: an index, or a part of exactly one name in any case;
/// empty: the first usable one. Throws Error (NoDevice) that lists what there is if the choice is unknown,
/// ambiguous or cannot be used.
size_t select_device(std::span<const DeviceInfo> devices, std::string_view select);

/// The same for `all`, which are those that can be used, and for a list with commas, unless one device has
/// them in its name. No device is chosen twice.
std::vector<size_t> select_devices(std::span<const DeviceInfo> devices, std::string_view select);

/// The error message for a lost device. `completed`: how many of the submission's stages are known to have
/// ended; negative: not known.
std::string lost_message(const std::string& device, std::span<const std::string> stages, int completed);

/// What a device that has the extensions `has` is opened with. Whoever has portability_subset must be asked
/// for it.
std::vector<const char*> extensions_to_enable(std::span<const std::string> has, bool with_statistics,
                                              bool with_ray_queries);

}  // namespace regulus::gpu

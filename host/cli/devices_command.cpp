// regulus devices: the Vulkan devices, whether each can be used, and why not.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "base/standard_streams.hpp"
#include "cli/commands.hpp"
#include "gpu/gpu.hpp"

namespace regulus::cli {

namespace {

const char* kind_name(gpu::DeviceKind kind) {
  switch (kind) {
    case gpu::DeviceKind::Discrete:
      return "discrete GPU";
    case gpu::DeviceKind::Integrated:
      return "integrated GPU";
    case gpu::DeviceKind::Virtual:
      return "virtual GPU";
    case gpu::DeviceKind::Software:
      return "software, runs on the CPU";
    case gpu::DeviceKind::Other:
      break;
  }
  return "other";
}

void print_devices() {
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
  if (devices.empty())
    throw Error(
        ErrorCode::NoDevice,
        "no Vulkan device found; install a Vulkan driver (Debian: mesa-vulkan-drivers) and try again");
  for (const gpu::DeviceInfo& device : devices) {
    say("{}: {} ({})\n   uuid:{}\n   driver {}, Vulkan {}.{}.{}, {:.1f} GiB of device memory\n", device.index,
        device.name, kind_name(device.kind), device.uuid, device.driver, device.api_version >> 22 & 0x7F,
        device.api_version >> 12 & 0x3FF, device.api_version & 0xFFF,
        static_cast<double>(device.heap_bytes) / (1 << 30));
    if (device.usable())
      say("   can be used{}\n", device.has_ray_query ? ", has ray queries (--rays hardware)" : "");
    else
      say("   cannot be used: {}\n", fmt::join(device.missing, "; "));
  }
}

}  // namespace

void add_devices_command(CLI::App& app) {
  app.add_subcommand("devices", "List the Vulkan devices and whether each can be used")
      ->callback(print_devices);
}

}  // namespace regulus::cli

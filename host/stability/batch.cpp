#include "stability/batch.hpp"

#include "interface/bvh.h"
#include "interface/wavefront.h"

namespace regulus::stability_shaders {
std::span<const uint32_t> spirv(std::string_view name);
}
namespace regulus::bench_shaders {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::stability {

gpu::Kernel create_kernel(gpu::Device& device, std::string_view name, const Constants& constants) {
  const std::string variant = std::string(name) + (device.info().has_int64 ? "" : ".int32");
  return device.create_kernel({std::string(name), stability_shaders::spirv(variant), constants});
}

gpu::Kernel create_bench_kernel(gpu::Device& device, std::string_view name) {
  const std::string variant = std::string(name) + (device.info().has_int64 ? "" : ".int32");
  return device.create_kernel({std::string(name), bench_shaders::spirv(variant), {}});
}

void dispatch_and_wait(gpu::Device& device, const gpu::Kernel& kernel, std::span<const std::byte> arguments,
                       size_t count) {
  constexpr size_t GROUP_SIZE = interface::STABILITY_GROUP_SIZE;
  static_assert(GROUP_SIZE == interface::WORKGROUP_SIZE, "kernels of shaders/bench have the same groups");
  gpu::CommandList commands(device);
  commands.dispatch(kernel, arguments, static_cast<uint32_t>((count + GROUP_SIZE - 1) / GROUP_SIZE));
  gpu::Submission submission = device.submit(std::move(commands));
  device.wait(submission);
}

}  // namespace regulus::stability

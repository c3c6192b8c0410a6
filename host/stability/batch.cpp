#include "stability/batch.hpp"

#include <span>

namespace regulus::stability_shaders {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::stability {

gpu::Kernel create_kernel(gpu::Device& device, std::string_view name, const Constants& constants) {
  const std::string variant = std::string(name) + (device.info().has_int64 ? "" : ".int32");
  return device.create_kernel({std::string(name), stability_shaders::spirv(variant), constants});
}

void run_kernel(gpu::Device& device, const gpu::Kernel& kernel,
                const interface::StabilityArguments& arguments) {
  gpu::CommandList commands(device);
  const uint32_t groups =
      (arguments.count + interface::STABILITY_GROUP_SIZE - 1) / interface::STABILITY_GROUP_SIZE;
  commands.dispatch(kernel, gpu::bytes_of(arguments), groups);
  gpu::Submission submission = device.submit(std::move(commands));
  device.wait(submission);
}

}  // namespace regulus::stability

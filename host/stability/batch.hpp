// Runs one function of the shader libraries over an array: the kernels of shaders/stability.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gpu/gpu.hpp"
#include "stability/interface.h"

namespace regulus::stability {

/// Specialization constants as (id, value).
using Constants = std::vector<std::pair<uint32_t, uint32_t>>;

/// The kernel `name` of shaders/stability, specialized.
gpu::Kernel create_kernel(gpu::Device& device, std::string_view name, const Constants& constants);

/// Runs a kernel with one invocation for each of `count` outputs, and waits.
void run_kernel(gpu::Device& device, const gpu::Kernel& kernel,
                const interface::StabilityArguments& arguments);

/// out[i] = f(in[i]) for all i.
template <typename Out, typename In>
std::vector<Out> map_on_device(gpu::Device& device, const gpu::Kernel& kernel,
                               const std::vector<In>& inputs) {
  if (inputs.empty()) return {};
  const gpu::Buffer in = gpu::upload_new(device, inputs, "stability inputs");
  const gpu::Buffer out = device.create_buffer(inputs.size() * sizeof(Out), "stability outputs");
  run_kernel(device, kernel,
             {interface::device_address(in.address()), interface::device_address(out.address()),
              static_cast<uint32_t>(inputs.size())});
  return gpu::download_all<Out>(device, out, inputs.size());
}

}  // namespace regulus::stability

// Runs one function of the shader libraries over an array: the kernels of shaders/stability.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
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

/// The same of shaders/bench.
gpu::Kernel create_bench_kernel(gpu::Device& device, std::string_view name);

/// Runs a kernel with these push constants for `count` invocations in workgroups of 64, and waits.
void dispatch_and_wait(gpu::Device& device, const gpu::Kernel& kernel, std::span<const std::byte> arguments,
                       size_t count);

/// out[i] = f(in[i]) for all i.
template <typename Out, typename In>
std::vector<Out> map_on_device(gpu::Device& device, const gpu::Kernel& kernel,
                               const std::vector<In>& inputs) {
  if (inputs.empty()) return {};
  const gpu::Buffer in = gpu::upload_new(device, inputs, "stability inputs");
  const gpu::Buffer out = device.create_buffer(inputs.size() * sizeof(Out), "stability outputs");
  const interface::StabilityArguments arguments {
    interface::device_address(in.address()), interface::device_address(out.address()),
        static_cast<uint32_t>(inputs.size())
  };
  dispatch_and_wait(device, kernel, gpu::bytes_of(arguments), inputs.size());
  return gpu::download_all<Out>(device, out, inputs.size());
}

}  // namespace regulus::stability

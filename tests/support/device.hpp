// The Vulkan device of device tests, and one call that runs a kernel over an array.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "gpu/gpu.hpp"

namespace regulus::test {

/// The device that all device tests of this process use: the first usable one, chosen by VK_DRIVER_FILES or
/// REGULUS_TEST_DEVICE (index or part of the name). nullptr only if no Vulkan device exists at all; a device
/// that exists and cannot be used is an error.
gpu::Device* device();

/// True on a device so slow that tests take fewer samples (SwiftShader, or any under validation layers).
/// Precondition: there is a device.
bool is_slow_device();

/// Skips the calling test where there is no Vulkan device.
#define REGULUS_SKIP_WITHOUT_DEVICE() \
  if (::regulus::test::device() == nullptr) GTEST_SKIP() << "no Vulkan device"

/// Specialization constants as (id, value).
using Constants = std::vector<std::pair<uint32_t, uint32_t>>;

/// Push constants of batch kernels: out[i] = f(in[i]) for i < count, one invocation each.
struct BatchArguments {
  uint64_t input = 0;   ///< device address
  uint64_t output = 0;  ///< device address
  uint32_t count = 0;
  uint32_t parameter = 0;  ///< meaning by kernel
};

/// A batch kernel with workgroups of 64 from SPIR-V that `find` (a registry of regulus_shaders) embeds:
/// `name` where the device has 64-bit integers, `name`.int32 where not.
template <typename Find>
gpu::Kernel create_batch_kernel(const Find& find, std::string_view name, const Constants& constants) {
  const std::string variant = std::string(name) + (device()->info().has_int64 ? "" : ".int32");
  return device()->create_kernel({std::string(name), find(variant), constants});
}

/// Runs a batch kernel on `count` invocations and waits.
void run_batch(const gpu::Kernel& kernel, const BatchArguments& arguments);

/// Runs a batch kernel that turns each In into `outputs_per_input` Outs.
template <typename Out, typename In>
std::vector<Out> map_on_device(const gpu::Kernel& kernel, const std::vector<In>& inputs,
                               uint32_t outputs_per_input = 1, uint32_t parameter = 0) {
  const size_t outputs = inputs.size() * outputs_per_input;
  const gpu::Buffer in = gpu::upload_new(*device(), inputs, "test inputs");
  const gpu::Buffer out = device()->create_buffer(outputs * sizeof(Out), "test outputs");
  run_batch(kernel, {in.address(), out.address(), static_cast<uint32_t>(outputs), parameter});
  return gpu::download_all<Out>(*device(), out, outputs);
}

}  // namespace regulus::test

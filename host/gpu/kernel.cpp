// Compute pipelines.
#include <fmt/format.h>

#include <chrono>

#include "base/error.hpp"
#include "gpu/specialize.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

/// All constants are 32-bit words.
struct Specialization {
  std::vector<uint32_t> values;
  std::vector<vk::SpecializationMapEntry> entries;

  explicit Specialization(const KernelDescription& description) {
    for (const auto& [id, value] : description.constants) {
      entries.emplace_back(id, static_cast<uint32_t>(values.size() * sizeof(uint32_t)), sizeof(uint32_t));
      values.push_back(value);
    }
  }
  vk::SpecializationInfo info() const {
    return {static_cast<uint32_t>(entries.size()), entries.data(), values.size() * sizeof(uint32_t),
            values.data()};
  }
};

/// spirv: the module, specialized or not.
vk::raii::Pipeline compile(const DeviceState& state, const KernelDescription& description,
                           std::span<const uint32_t> spirv, const vk::raii::PipelineCache& cache) {
  const vk::raii::ShaderModule shader(state.device,
                                      vk::ShaderModuleCreateInfo({}, spirv.size_bytes(), spirv.data()));
  const Specialization specialization(description);
  const vk::SpecializationInfo constants = specialization.info();
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *shader, "main",
                                                &constants);
  return {state.device, cache, vk::ComputePipelineCreateInfo({}, stage, *state.layout)};
}

/// Compiles with the help of the user's cache folder, and leaves there what was new.
vk::raii::Pipeline compile_cached(DeviceState& state, const KernelDescription& description) {
  const PipelineCacheFile file(state.cache_folder, state.driver, description);
  CachedKernel known = file.load();
  const bool is_new = known.spirv.empty();
  if (is_new) known.spirv = specialize(description);
  const vk::raii::PipelineCache cache(
      state.device, vk::PipelineCacheCreateInfo({}, known.driver_data.size(), known.driver_data.data()));
  vk::raii::Pipeline pipeline = compile(state, description, known.spirv, cache);
  // Not whenever the driver's data has changed: SwiftShader's grows by one header each time it is read.
  if (is_new) {
    const std::vector<uint8_t> data = cache.getData();
    const auto bytes = std::as_bytes(std::span(data));
    known.driver_data.assign(bytes.begin(), bytes.end());
    file.store(known);
    state.has_new_pipelines = true;
  }
  return pipeline;
}

}  // namespace

Kernel::Kernel() = default;
Kernel::~Kernel() = default;
Kernel::Kernel(Kernel&&) noexcept = default;
Kernel& Kernel::operator=(Kernel&&) noexcept = default;

Kernel Device::create_kernel(const KernelDescription& description) {
  const auto begin = std::chrono::steady_clock::now();
  DeviceState& state = *impl->state;
  Kernel kernel;
  try {
    std::shared_ptr<vk::raii::Pipeline>& pipeline = state.pipelines[kernel_key(state.driver, description)];
    if (!pipeline)
      pipeline = std::make_shared<vk::raii::Pipeline>(
          state.cache_folder.empty() ? compile(state, description, specialize(description), nullptr)
                                     : compile_cached(state, description));
    kernel.impl.reset(new Kernel::Impl{impl->state, description.name, pipeline});
  } catch (const vk::SystemError& error) {
    if (error.code() == vk::Result::eErrorDeviceLost) state.throw_lost({}, 0);
    throw Error(ExitStatus::Failed,
                fmt::format("the driver of {} cannot compile stage {} ({}); try another --device or driver",
                            state.info().name, description.name, error.what()));
  }
  state.pipeline_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return kernel;
}

}  // namespace regulus::gpu

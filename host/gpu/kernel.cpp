// Compute pipelines.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

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
  const vk::PipelineCreateFlags flags =
      state.tells_statistics ? vk::PipelineCreateFlagBits::eCaptureStatisticsKHR : vk::PipelineCreateFlags{};
  return {state.device, cache, vk::ComputePipelineCreateInfo(flags, stage, *state.layout)};
}

double number_of(const vk::PipelineExecutableStatisticKHR& statistic) {
  switch (statistic.format) {
    case vk::PipelineExecutableStatisticFormatKHR::eBool32:
      return statistic.value.b32;
    case vk::PipelineExecutableStatisticFormatKHR::eInt64:
      return static_cast<double>(statistic.value.i64);
    case vk::PipelineExecutableStatisticFormatKHR::eUint64:
      return static_cast<double>(statistic.value.u64);
    case vk::PipelineExecutableStatisticFormatKHR::eFloat64:
      return statistic.value.f64;
  }
  return 0;
}

/// What the driver tells of a pipeline, an entry for each executable that it made.
std::vector<KernelStatistics> statistics_of(const DeviceState& state, const std::string& name,
                                            const vk::raii::Pipeline& pipeline) {
  std::vector<KernelStatistics> all;
  const auto executables = state.device.getPipelineExecutablePropertiesKHR(vk::PipelineInfoKHR(*pipeline));
  for (uint32_t i = 0; i < executables.size(); ++i) {
    KernelStatistics& one =
        all.emplace_back(KernelStatistics{name, executables[i].name.data(), executables[i].subgroupSize, {}});
    for (const vk::PipelineExecutableStatisticKHR& statistic :
         state.device.getPipelineExecutableStatisticsKHR(vk::PipelineExecutableInfoKHR(*pipeline, i)))
      one.values.emplace_back(statistic.name.data(), number_of(statistic));
  }
  return all;
}

struct Compiled {
  vk::raii::Pipeline pipeline{nullptr};
  bool is_stored = false;  ///< the cache folder has a file more
};

/// Compiles with the help of the user's cache folder, if there is one, and leaves there what was new. Several
/// threads may do so at once: each kernel has a driver cache and a file of its own.
Compiled compile_cached(const DeviceState& state, const KernelDescription& description) {
  const bool keeps_special_values = state.driver.keeps_special_values != 0;
  if (state.cache_folder.empty())
    return {compile(state, description, specialize(description, keeps_special_values), nullptr)};
  const PipelineCacheFile file(state.cache_folder, state.driver, description);
  CachedKernel known = file.load();
  const bool is_new = known.spirv.empty();
  if (is_new) known.spirv = specialize(description, keeps_special_values);
  const vk::raii::PipelineCache cache(
      state.device, vk::PipelineCacheCreateInfo({}, known.driver_data.size(), known.driver_data.data()));
  Compiled compiled{compile(state, description, known.spirv, cache), is_new};
  // Not whenever the driver's data has changed: SwiftShader's grows by one header each time it is read.
  if (is_new) {
    const std::vector<uint8_t> data = cache.getData();
    const auto bytes = std::as_bytes(std::span(data));
    known.driver_data.assign(bytes.begin(), bytes.end());
    file.store(known);
  }
  return compiled;
}

/// compile_cached() with the driver's errors in words.
Compiled compile_or_say_why(DeviceState& state, const KernelDescription& description) {
  try {
    return compile_cached(state, description);
  } catch (const vk::SystemError& error) {
    if (error.code() == vk::Result::eErrorDeviceLost) state.throw_lost({}, 0);
    throw Error(ErrorCode::Failed,
                fmt::format("the driver of {} cannot compile stage {} ({}); try another device or driver",
                            state.info().name, description.name, error.what()));
  }
}

/// compile_or_say_why() for each, on as many threads as the machine has, each of which tells the device's
/// watcher what is done. Throws the first error in the order of `descriptions`, after all threads have ended.
std::vector<Compiled> compile_all(DeviceState& state,
                                  std::span<const KernelDescription* const> descriptions) {
  std::vector<Compiled> compiled(descriptions.size());
  std::vector<std::exception_ptr> errors(descriptions.size());
  std::atomic<size_t> next = 0;
  std::mutex telling;
  size_t done = 0;
  const auto tell = [&](size_t more) {
    const std::lock_guard lock(telling);
    done += more;
    if (state.kernel_watcher) state.kernel_watcher(done, descriptions.size());
  };
  if (!descriptions.empty()) tell(0);
  const auto work = [&] {
    for (size_t i = next++; i < descriptions.size(); i = next++) try {
        compiled[i] = compile_or_say_why(state, *descriptions[i]);
        tell(1);
      } catch (...) {
        errors[i] = std::current_exception();
      }
  };
  {
    const size_t threads = std::min<size_t>(std::thread::hardware_concurrency(), descriptions.size());
    std::vector<std::jthread> others;
    for (size_t i = 1; i < threads; ++i) others.emplace_back(work);
    work();
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  return compiled;
}

}  // namespace

Kernel::Kernel() = default;
Kernel::~Kernel() = default;
Kernel::Kernel(Kernel&&) noexcept = default;
Kernel& Kernel::operator=(Kernel&&) noexcept = default;

std::vector<Kernel> Device::create_kernels(std::span<const KernelDescription> descriptions) {
  const auto begin = std::chrono::steady_clock::now();
  DeviceState& state = *impl->state;
  std::map<uint64_t, const KernelDescription*> missing;
  std::vector<uint64_t> keys;
  for (const KernelDescription& description : descriptions) {
    keys.push_back(kernel_key(state.driver, description));
    if (!state.pipelines.contains(keys.back())) missing.emplace(keys.back(), &description);
  }
  std::vector<const KernelDescription*> to_compile;
  to_compile.reserve(missing.size());
  for (const auto& [key, description] : missing) to_compile.push_back(description);
  std::vector<Compiled> compiled = compile_all(state, to_compile);
  auto next = compiled.begin();
  for (const auto& [key, description] : missing) {
    state.has_new_pipelines = state.has_new_pipelines || next->is_stored;
    if (state.tells_statistics)
      for (KernelStatistics& told : statistics_of(state, description->name, next->pipeline))
        state.kernel_statistics.push_back(std::move(told));
    state.pipelines[key] = std::make_shared<vk::raii::Pipeline>(std::move(next++->pipeline));
  }
  std::vector<Kernel> kernels(descriptions.size());
  for (size_t i = 0; i < kernels.size(); ++i)
    kernels[i].impl.reset(new Kernel::Impl{impl->state, descriptions[i].name, state.pipelines.at(keys[i])});
  state.pipeline_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return kernels;
}

Kernel Device::create_kernel(const KernelDescription& description) {
  return std::move(create_kernels(std::span(&description, 1)).front());
}

}  // namespace regulus::gpu

// The device that tests of the device layer share, and a kernel that tells what ran.
#pragma once

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "gpu/gpu.hpp"

namespace probe {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::gpu {

inline constexpr uint32_t PROBE_WORKGROUP_SIZE = 64;
inline const DeviceOptions UNCACHED = {.select = "", .pipeline_cache = false, .software_stage_times = true};

/// Push constants of gpu_probe.comp: target[i] = FACTOR * source[i] + addend for i < count.
struct ProbeParameters {
  uint64_t source;
  uint64_t target;
  uint32_t addend;
  uint32_t count;
};

inline ProbeParameters probe_parameters(const Buffer& source, const Buffer& target, uint32_t addend) {
  return {source.address(), target.address(), addend, static_cast<uint32_t>(source.size() / 4)};
}

inline uint32_t groups_for(const Buffer& buffer) {
  return static_cast<uint32_t>((buffer.size() / 4 + PROBE_WORKGROUP_SIZE - 1) / PROBE_WORKGROUP_SIZE);
}

/// A device without a pipeline cache, opened per test; faults end with the test.
class GpuDevice : public testing::Test {
 protected:
  void TearDown() override { faults() = {}; }

  Kernel probe_variant(uint32_t factor, bool int64, std::string name = "probe") {
    return device.create_kernel({.name = std::move(name),
                                 .spirv = probe::spirv(int64 ? "gpu_probe" : "gpu_probe.int32"),
                                 .constants = {{0, PROBE_WORKGROUP_SIZE}, {1, factor}}});
  }
  Kernel probe_kernel(uint32_t factor, std::string name = "probe") {
    return probe_variant(factor, device.info().has_int64, std::move(name));
  }
  void run_probe(CommandList& commands, const Kernel& kernel, const Buffer& from, const Buffer& to,
                 uint32_t addend) {
    commands.dispatch(kernel, bytes_of(probe_parameters(from, to, addend)), groups_for(from));
  }
  std::vector<StageTime> run(CommandList&& commands) {
    Submission submission = device.submit(std::move(commands));
    return device.wait(submission);
  }
  Buffer iota(size_t count) {
    std::vector<uint32_t> values(count);
    std::iota(values.begin(), values.end(), 0u);
    return upload_new(device, values, "iota");
  }

  Device device{UNCACHED};
};

/// Runs `action`, which must throw an Error of this status, and returns its message.
template <typename Action>
std::string error_of(ErrorCode code, Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

inline bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

}  // namespace regulus::gpu

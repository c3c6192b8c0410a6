// The device layer on a real driver: whichever one VK_DRIVER_FILES selects.
//
// A software driver runs commands in order, so that a missing barrier shows here only under the validation
// layer's synchronization validation.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "unit/gpu_probe.hpp"

namespace regulus::gpu {
namespace {

namespace fs = std::filesystem;

TEST(GpuDevices, AreListedWithTheirIndices) {
  const std::vector<DeviceInfo> devices = list_devices();
  ASSERT_FALSE(devices.empty());
  for (size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].index, i);
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_TRUE(devices[i].usable()) << devices[i].name << " lacks " << devices[i].missing.front();
  }
}

TEST(GpuDevices, AreOpenedByTheirUuid) {
  for (const DeviceInfo& info : list_devices()) {
    ASSERT_EQ(info.uuid.size(), 32u);
    EXPECT_EQ(Device(DeviceOptions{.select = "uuid:" + info.uuid}).info().index, info.index);
  }
}

TEST(GpuDevices, UnknownNameIsNoDevice) {
  const std::string message =
      error_of(ErrorCode::NoDevice, [] { Device(DeviceOptions{.select = "no such device"}); });
  EXPECT_TRUE(contains(message, list_devices().front().name)) << message;
}

/// Sets an environment variable for as long as it lives.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    ::setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() {
    if (old_)
      ::setenv(name_, old_->c_str(), 1);
    else
      ::unsetenv(name_);
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

TEST(GpuDevices, AreNoneWithoutADriver) {
  const ScopedVariable none("VK_DRIVER_FILES", "/nonexistent/driver.json");
  EXPECT_TRUE(list_devices().empty());
  const std::string message = error_of(ErrorCode::NoDevice, [] { Device device(UNCACHED); });
  EXPECT_TRUE(contains(message, "no Vulkan device")) << message;
}

TEST_F(GpuDevice, CopiesAnySizeToAnyOffsetAndNothingElse) {
  constexpr size_t STAGING = size_t{16} << 20;
  std::mt19937 random(20240501);
  SCOPED_TRACE("seed 20240501");
  const std::vector<std::pair<size_t, size_t>> ranges = {
      {0, 1}, {1, 1}, {3, 3}, {5, 4096}, {7, 100'001}, {2, STAGING}, {0, STAGING + 3}};
  for (const auto& [offset, size] : ranges) {
    std::vector<uint8_t> expected(offset + size + 5, 0);
    Buffer buffer = device.create_buffer(expected.size(), "range");
    std::vector<uint8_t> data(size);
    for (uint8_t& byte : data) byte = static_cast<uint8_t>(random());
    std::copy(data.begin(), data.end(), expected.begin() + std::ptrdiff_t(offset));
    device.upload(buffer, offset, bytes_of(data));
    EXPECT_EQ(download_all<uint8_t>(device, buffer, expected.size()), expected) << offset << " + " << size;
    EXPECT_EQ(download_all<uint8_t>(device, buffer, size, offset), data) << offset << " + " << size;
  }
}

TEST_F(GpuDevice, NewBuffersAreZeroEvenInReusedMemory) {
  for (int round = 0; round < 4; ++round) {
    Buffer buffer = device.create_buffer(1'000'003, "zero");
    const auto bytes = download_all<uint8_t>(device, buffer, buffer.size());
    EXPECT_TRUE(std::all_of(bytes.begin(), bytes.end(), [](uint8_t b) { return b == 0; }));
    CommandList commands(device);
    commands.fill(buffer, 0, buffer.size(), 0xdeadbeefu);
    run(std::move(commands));
  }
}

TEST_F(GpuDevice, EmptyBufferHasNoAddressAndCopiesNothing) {
  Buffer buffer = device.create_buffer(0, "empty");
  EXPECT_EQ(buffer.size(), 0u);
  EXPECT_EQ(buffer.address(), 0u);
  device.upload(buffer, 0, {});
  device.download(buffer, 0, {});
  CommandList commands(device);
  commands.fill(buffer, 0, 0, 1);
  commands.copy(buffer, 0, buffer, 0, 0);
  run(std::move(commands));
}

TEST_F(GpuDevice, RangesOutsideABufferAreRefused) {
  Buffer buffer = device.create_buffer(16, "small");
  std::vector<std::byte> data(8);
  EXPECT_THROW(device.upload(buffer, 9, data), std::logic_error);
  EXPECT_THROW(device.upload(Buffer(), 0, data), std::logic_error);
  EXPECT_THROW(device.download(buffer, ~uint64_t{0}, data), std::logic_error);
  CommandList commands(device);
  EXPECT_THROW(commands.fill(buffer, 12, 8, 0), std::logic_error);
  EXPECT_THROW(commands.fill(buffer, 2, 4, 0), std::logic_error);
  EXPECT_THROW(commands.copy(buffer, 0, buffer, 12, 8), std::logic_error);
  Kernel kernel = probe_kernel(1);
  EXPECT_THROW(commands.dispatch_indirect(kernel, {}, buffer, 8), std::logic_error);
  EXPECT_THROW(commands.dispatch(kernel, std::vector<std::byte>(132), 1), std::logic_error);
  EXPECT_THROW(commands.dispatch(kernel, std::vector<std::byte>(6), 1), std::logic_error);
}

TEST_F(GpuDevice, SpecializationAndPushConstantsReachBothShaderVariants) {
  Buffer from = iota(1000);
  for (bool int64 : {false, true}) {
    if (int64 && !device.info().has_int64) continue;
    for (uint32_t factor : {3u, 5u}) {
      Kernel kernel = probe_variant(factor, int64);
      Buffer to = device.create_buffer(from.size(), "to");
      CommandList commands(device);
      run_probe(commands, kernel, from, to, 11);
      run(std::move(commands));
      const auto values = download_all<uint32_t>(device, to, 1000);
      for (uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(values[i], factor * i + 11) << "int64 " << int64;
    }
  }
}

TEST_F(GpuDevice, DependentDispatchesSeeEachOthersResults) {
  // x -> 3 x + n, 200 times, modulo 2^32.
  constexpr uint32_t COUNT = 10'000, STEPS = 200;
  Buffer a = iota(COUNT);
  Buffer b = device.create_buffer(a.size(), "b");
  Kernel kernel = probe_kernel(3);
  CommandList commands(device);
  for (uint32_t n = 0; n < STEPS; ++n) run_probe(commands, kernel, n % 2 ? b : a, n % 2 ? a : b, n);
  const std::vector<StageTime> times = run(std::move(commands));
  EXPECT_EQ(times.size(), STEPS);
  const auto values = download_all<uint32_t>(device, a, COUNT);
  for (uint32_t i = 0; i < COUNT; ++i) {
    uint32_t expected = i;
    for (uint32_t n = 0; n < STEPS; ++n) expected = 3 * expected + n;
    ASSERT_EQ(values[i], expected) << i;
  }
}

TEST_F(GpuDevice, FillCopyAndIndirectDispatchAreOrdered) {
  constexpr uint32_t COUNT = 256;
  Buffer source = device.create_buffer(COUNT * 4, "source");
  Buffer copy = device.create_buffer(COUNT * 4, "copy");
  Buffer target = device.create_buffer(COUNT * 4, "target");
  Buffer one_group = upload_new<uint32_t>(device, {0, 0, 1, 1}, "one_group");
  Buffer arguments = device.create_buffer(16, "arguments");
  Kernel add = probe_kernel(1);

  CommandList commands(device);
  commands.fill(source, 0, source.size(), 5);
  commands.copy(source, 0, copy, 0, copy.size());
  commands.fill(source, 0, source.size(), 9);        // must not reach the copy
  commands.fill(arguments, 0, arguments.size(), 7);  // replaced by the next two
  commands.copy(one_group, 0, arguments, 0, 16);
  run_probe(commands, add, one_group, arguments, 1);  // words {1, 1, 2, 2}
  // Two groups in the last dimension would repeat the work; the words at offset 0 are {1, 1, 2}.
  commands.dispatch_indirect(add, bytes_of(probe_parameters(copy, target, 100)), arguments, 0);
  run(std::move(commands));

  // One group covers 64 items, the rest stay zero.
  const auto values = download_all<uint32_t>(device, target, COUNT);
  for (uint32_t i = 0; i < COUNT; ++i) ASSERT_EQ(values[i], i < PROBE_WORKGROUP_SIZE ? 105u : 0u) << i;
}

TEST_F(GpuDevice, IndirectDispatchOfNoGroupsDoesNothing) {
  Buffer from = iota(64);
  Buffer to = device.create_buffer(from.size(), "to");
  Buffer arguments = upload_new<uint32_t>(device, {99, 0, 1, 1}, "arguments");
  Kernel kernel = probe_kernel(1);
  CommandList commands(device);
  commands.dispatch_indirect(kernel, bytes_of(probe_parameters(from, to, 1)), arguments, 4);
  EXPECT_EQ(run(std::move(commands)).size(), 1u);
  EXPECT_EQ(download_all<uint32_t>(device, to, 64), std::vector<uint32_t>(64, 0));
}

TEST_F(GpuDevice, IndependentCommandsAllRunBeforeTheNextDependentOne) {
  constexpr uint32_t PARTS = 16;
  Buffer from = iota(256);
  Buffer sum = device.create_buffer(from.size() * PARTS, "parts");
  Buffer result = device.create_buffer(sum.size(), "result");
  Kernel kernel = probe_kernel(1);
  CommandList commands(device);
  for (uint32_t part = 0; part < PARTS; ++part) {
    commands.independent();
    commands.dispatch(
        kernel, bytes_of(ProbeParameters{from.address(), sum.address() + part * from.size(), part, 256}),
        groups_for(from));
  }
  run_probe(commands, kernel, sum, result, 1000);
  run(std::move(commands));
  const auto values = download_all<uint32_t>(device, result, 256 * PARTS);
  for (uint32_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], i % 256 + i / 256 + 1000) << i;
}

TEST_F(GpuDevice, SubmissionsInFlightRunInOrderAndCanBeWaitedForInAny) {
  Buffer a = iota(5000);
  Buffer b = device.create_buffer(a.size(), "b");
  Kernel kernel = probe_kernel(3);
  std::vector<Submission> submissions;
  for (uint32_t n = 0; n < 8; ++n) {
    CommandList commands(device);
    run_probe(commands, kernel, n % 2 ? b : a, n % 2 ? a : b, n);
    submissions.push_back(device.submit(std::move(commands)));
  }
  for (auto submission = submissions.rbegin(); submission != submissions.rend(); ++submission)
    EXPECT_EQ(device.wait(*submission).size(), 1u);
  EXPECT_TRUE(device.wait(submissions.front()).empty()) << "a submission tells its times once";
  const auto values = download_all<uint32_t>(device, a, 5000);
  for (uint32_t i = 0; i < 5000; ++i) {
    uint32_t expected = i;
    for (uint32_t n = 0; n < 8; ++n) expected = 3 * expected + n;
    ASSERT_EQ(values[i], expected) << i;
  }
}

TEST_F(GpuDevice, UnusedListsAndUnwaitedSubmissionsCleanUp) {
  Buffer a = iota(1000);
  Buffer b = device.create_buffer(a.size(), "b");
  Kernel kernel = probe_kernel(2);
  for (int round = 0; round < 3; ++round) {
    CommandList dropped(device);
    run_probe(dropped, kernel, a, b, 77);
    CommandList used(device);
    run_probe(used, kernel, a, b, 1);
    device.submit(std::move(used));
  }
  EXPECT_EQ(download_all<uint32_t>(device, b, 2), (std::vector<uint32_t>{1, 3}));
}

TEST_F(GpuDevice, TimesAreThoseOfTheStagesAndFitInTheWallTime) {
  if (device.info().timestamp_ns == 0) GTEST_SKIP() << "no timestamps";
  Buffer large_from = iota(2'000'000), large_to = device.create_buffer(large_from.size(), "large_to");
  Buffer small_from = iota(64), small_to = device.create_buffer(small_from.size(), "small_to");
  Kernel large = probe_kernel(3, "large"), small = probe_kernel(5, "small");
  double large_ms = 0, small_ms = 0, sum_ms = 0, wall_ms = 0;
  for (int round = 0; round < 2; ++round) {  // the first compiles
    const auto begin = std::chrono::steady_clock::now();
    CommandList commands(device);
    for (int i = 0; i < 150; ++i) run_probe(commands, small, small_from, small_to, 0);
    run_probe(commands, large, large_from, large_to, 0);
    commands.fill(small_to, 0, small_to.size(), 0);
    run_probe(commands, small, small_from, small_to, 0);
    const std::vector<StageTime> times = run(std::move(commands));
    wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    ASSERT_EQ(times.size(), 152u);
    EXPECT_EQ(times[149].stage, "small");
    EXPECT_EQ(times[150].stage, "large");
    sum_ms = 0;
    for (const StageTime& time : times) {
      EXPECT_GE(time.device_ms, 0);
      sum_ms += time.device_ms;
    }
    large_ms = times[150].device_ms;
    small_ms = times[151].device_ms;
  }
  std::printf("2,000,000 items %.3f ms, 64 items %.3f ms, all %.3f of %.3f ms\n", large_ms, small_ms, sum_ms,
              wall_ms);
  // 31,250 times the work; the two clocks may differ by their granularity and drift.
  EXPECT_GT(large_ms, small_ms);
  EXPECT_LE(sum_ms, wall_ms * 1.001 + 0.01);
}

TEST_F(GpuDevice, KernelsMadeAtOnceAreTheOnesThatWereAskedForInOrder) {
  constexpr uint32_t COUNT = 24;
  std::vector<KernelDescription> wanted;
  for (uint32_t i = 0; i < COUNT; ++i)  // every factor twice
    wanted.push_back({.name = "probe " + std::to_string(i),
                      .spirv = probe::spirv("gpu_probe.int32"),
                      .constants = {{0, PROBE_WORKGROUP_SIZE}, {1, 100 + i / 2}}});
  const std::vector<Kernel> kernels = device.create_kernels(wanted);
  ASSERT_EQ(kernels.size(), COUNT);
  Buffer one = upload_new<uint32_t>(device, {1}, "one");
  for (uint32_t i = 0; i < COUNT; ++i) {
    Buffer to = device.create_buffer(one.size(), "to");
    CommandList commands(device);
    run_probe(commands, kernels[i], one, to, 0);
    const std::vector<StageTime> times = run(std::move(commands));
    EXPECT_EQ(times.front().stage, wanted[i].name);
    EXPECT_EQ(download_all<uint32_t>(device, to, 1).front(), 100 + i / 2);
  }
  EXPECT_TRUE(device.create_kernels({}).empty());
}

TEST_F(GpuDevice, StagesAreNamedWithoutTimesIfNoneAreWanted) {
  if (device.info().kind != DeviceKind::Software) GTEST_SKIP() << "times cost this device nothing";
  Device untimed({.select = "", .pipeline_cache = false, .software_stage_times = false});
  Kernel kernel = untimed.create_kernel(
      {.name = "probe", .spirv = probe::spirv("gpu_probe.int32"), .constants = {{0, PROBE_WORKGROUP_SIZE}}});
  Buffer buffer = untimed.create_buffer(1024, "buffer");
  CommandList commands(untimed);
  run_probe(commands, kernel, buffer, buffer, 4);
  Submission submission = untimed.submit(std::move(commands));
  const std::vector<StageTime> times = untimed.wait(submission);
  ASSERT_EQ(times.size(), 1u);
  EXPECT_EQ(times[0].stage, "probe");
  EXPECT_EQ(times[0].device_ms, 0);
  EXPECT_EQ(download_all<uint32_t>(untimed, buffer, 256), std::vector<uint32_t>(256, 4));
}

/// A cache folder of the test's own, in place of the user's.
class GpuDeviceCache : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder); }

  /// Opens a device, compiles the probe and checks that it computes.
  static void compile_and_run() {
    Device device;
    Kernel kernel = device.create_kernel(
        {.name = "probe", .spirv = probe::spirv("gpu_probe.int32"), .constants = {{0, 64}, {1, 3}}});
    Buffer from = upload_new<uint32_t>(device, {1, 2, 3}, "from");
    Buffer to = device.create_buffer(from.size(), "to");
    CommandList commands(device);
    commands.dispatch(kernel, bytes_of(probe_parameters(from, to, 1)), 1);
    Submission submission = device.submit(std::move(commands));
    device.wait(submission);
    EXPECT_EQ(download_all<uint32_t>(device, to, 3), (std::vector<uint32_t>{4, 7, 10}));
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder / "regulus")) found.push_back(entry.path());
    return found;
  }

  const fs::path folder =
      fs::temp_directory_path() / ("regulus_device_cache_test_" + std::to_string(::getpid()));
  const ScopedVariable users_cache{"XDG_CACHE_HOME", folder};
  // Mesa would keep a cache of its own in the folder, and complain if it cannot.
  const ScopedVariable no_driver_cache{"MESA_SHADER_CACHE_DISABLE", "true"};
};

TEST_F(GpuDeviceCache, IsWrittenOnceAndUsedAgain) {
  compile_and_run();
  ASSERT_EQ(files().size(), 1u);
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
  fs::last_write_time(files().front(), long_ago);
  compile_and_run();
  ASSERT_EQ(files().size(), 1u);
  EXPECT_EQ(fs::last_write_time(files().front()), long_ago) << "written again";
}

TEST_F(GpuDeviceCache, DamagedFilesAreReplaced) {
  compile_and_run();
  const auto size = fs::file_size(files().front());
  for (const std::string& damage : {std::string(), std::string("short"), std::string(size, 'x')}) {
    std::ofstream(files().front(), std::ios::binary) << damage;
    compile_and_run();
    ASSERT_EQ(files().size(), 1u);
    EXPECT_EQ(fs::file_size(files().front()), size);
  }
}

TEST_F(GpuDeviceCache, FolderThatCannotBeWrittenIsNoError) {
  std::ofstream(folder) << "a file where the folder should be";
  compile_and_run();
}

}  // namespace
}  // namespace regulus::gpu

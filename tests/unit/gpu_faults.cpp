// Memory of the device layer, and what happens when there is none left or the device is lost.
#include <cstdio>

#include "unit/gpu_probe.hpp"

namespace regulus::gpu {
namespace {

TEST_F(GpuDevice, ManyBuffersKeepTheirContentsAndAreAccountedFor) {
  constexpr uint32_t COUNT = 500;
  iota(1);  // the first copy allocates staging memory, for good
  const uint64_t before = device.allocated_bytes();
  {
    std::vector<Buffer> buffers;
    for (uint32_t i = 0; i < COUNT; ++i)
      buffers.push_back(upload_new(device, std::vector<uint32_t>(1024, i), "many"));
    EXPECT_GE(device.allocated_bytes(), before + COUNT * 4096);
    EXPECT_GE(device.peak_allocated_bytes(), device.allocated_bytes());
    for (uint32_t i = 0; i < COUNT; ++i)
      ASSERT_EQ(download_all<uint32_t>(device, buffers[i], 1024), std::vector<uint32_t>(1024, i));
  }
  EXPECT_EQ(device.allocated_bytes(), before);
}

TEST_F(GpuDevice, HandlesMayOutliveTheDevice) {
  Buffer buffer;
  Kernel kernel;
  {
    Device other(UNCACHED);
    buffer = other.create_buffer(100, "survivor");
    kernel =
        other.create_kernel({.name = "survivor", .spirv = probe::spirv("gpu_probe.int32"), .constants = {}});
  }
  EXPECT_NE(buffer.address(), 0u);
}

TEST_F(GpuDevice, FreeMemoryIsPlausible) {
  const uint64_t free = device.free_bytes();
  std::printf("%.2f GiB of %.2f GiB free\n", double(free) / (1 << 30),
              double(device.info().heap_bytes) / (1 << 30));
  EXPECT_GT(free, uint64_t{64} << 20);
  EXPECT_LE(free, device.info().heap_bytes);
}

TEST_F(GpuDevice, TooLargeABufferIsAnErrorThatNamesItAndTheLimit) {
  const uint64_t limit = device.info().max_allocation_bytes;
  const std::string message = error_of(ErrorCode::Failed, [&] { device.create_buffer(limit + 1, "film"); });
  EXPECT_TRUE(contains(message, "buffer film")) << message;
  EXPECT_TRUE(contains(message, "at most")) << message;
  error_of(ErrorCode::Failed, [&] { device.create_buffer(~uint64_t{0}, "film"); });
}

TEST_F(GpuDevice, OutOfMemoryIsAnErrorThatNamesTheBuffer) {
  faults().out_of_memory = true;
  const uint64_t before = device.allocated_bytes();
  const std::string message = error_of(ErrorCode::Failed, [&] { device.create_buffer(3 << 20, "queue"); });
  EXPECT_TRUE(contains(message, "buffer queue")) << message;
  EXPECT_TRUE(contains(message, "3.0 MiB")) << message;
  EXPECT_EQ(device.allocated_bytes(), before);
  faults() = {};
  EXPECT_EQ(device.create_buffer(3 << 20, "queue").size(), 3u << 20) << "the device is still usable";
}

TEST_F(GpuDevice, LossIsReportedWithTheStage) {
  Buffer a = iota(100);
  Kernel first = probe_kernel(1, "first_stage"), second = probe_kernel(2, "second_stage");
  CommandList commands(device);
  run_probe(commands, first, a, a, 1);
  run_probe(commands, second, a, a, 1);
  Submission submission = device.submit(std::move(commands));
  faults().lost_at_wait = true;
  const std::string message = error_of(ErrorCode::NoDevice, [&] { device.wait(submission); });
  EXPECT_TRUE(contains(message, "device " + device.info().name + " lost")) << message;
  EXPECT_TRUE(contains(message, "stage")) << message;
  EXPECT_TRUE(contains(message, "second_stage")) << message;
  faults() = {};
  error_of(ErrorCode::NoDevice, [&] { download_all<uint32_t>(device, a, 1); });  // stays lost
}

TEST_F(GpuDevice, LossAtSubmissionNamesItsStages) {
  Buffer a = iota(100);
  Kernel kernel = probe_kernel(1, "first_stage");
  CommandList commands(device);
  run_probe(commands, kernel, a, a, 1);
  faults().lost_at_submit = true;
  const std::string message = error_of(ErrorCode::NoDevice, [&] { device.submit(std::move(commands)); });
  EXPECT_TRUE(contains(message, "while running stage first_stage")) << message;
}

}  // namespace
}  // namespace regulus::gpu

// The cache files of compiled kernels: what comes back, and that nothing damaged or foreign does.
#include <gtest/gtest.h>
#include <unistd.h>
#include <vulkan/vulkan_core.h>

#include <cstring>
#include <fstream>

#include "gpu/pipeline_cache.hpp"

namespace regulus::gpu {
namespace {

namespace fs = std::filesystem;

class GpuPipelineCache : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder); }
  void TearDown() override { fs::remove_all(folder); }

  PipelineCacheFile file() const { return {folder, driver, kernel}; }

  /// A module, and data as this driver would give it: the header that Vulkan prescribes, then anything.
  CachedKernel compiled() const {
    VkPipelineCacheHeaderVersionOne header{};
    header.headerSize = sizeof(header);
    header.headerVersion = VK_PIPELINE_CACHE_HEADER_VERSION_ONE;
    header.vendorID = driver.vendor;
    header.deviceID = driver.device;
    std::copy(driver.cache_uuid.begin(), driver.cache_uuid.end(), header.pipelineCacheUUID);
    std::vector<std::byte> data(sizeof(header) + 100, std::byte{0x5a});
    std::memcpy(data.data(), &header, sizeof(header));
    return {{7, 8, 9}, data};
  }

  bool is_empty(const PipelineCacheFile& cached) const { return cached.load() == CachedKernel{}; }

  std::vector<char> read() const {
    std::ifstream stream(file().path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write(const std::vector<char>& bytes) const {
    std::ofstream(file().path(), std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  }

  const fs::path folder =
      fs::temp_directory_path() / ("regulus_pipeline_cache_test_" + std::to_string(::getpid()));
  const std::vector<uint32_t> spirv = {1, 2, 3, 4};
  DriverIdentity driver{.vendor = 1, .device = 2, .driver_version = 3, .cache_uuid = {4, 5, 6}};
  KernelDescription kernel{.name = "probe", .spirv = spirv, .constants = {{0, 64}}};
};

TEST_F(GpuPipelineCache, GivesBackWhatWasStored) {
  EXPECT_TRUE(is_empty(file()));
  file().store(compiled());
  EXPECT_TRUE(file().load() == compiled());
}

TEST_F(GpuPipelineCache, LeavesNoTemporaryFile) {
  file().store(compiled());
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST_F(GpuPipelineCache, AnotherKernelConstantOrDriverHasAFileOfItsOwn) {
  const std::vector<uint32_t> other_spirv = {1, 2, 3, 5};
  const fs::path own = file().path();
  EXPECT_NE(PipelineCacheFile(folder, driver, {"probe", other_spirv, {{0, 64}}}).path(), own);
  EXPECT_NE(PipelineCacheFile(folder, driver, {"probe", spirv, {{0, 32}}}).path(), own);
  EXPECT_NE(PipelineCacheFile(folder, driver, {"probe", spirv, {{1, 64}}}).path(), own);
  DriverIdentity newer = driver;
  newer.driver_version = 4;
  EXPECT_NE(PipelineCacheFile(folder, newer, kernel).path(), own);
}

TEST_F(GpuPipelineCache, IgnoresAFileOfAnotherKernelUnderItsName) {
  file().store(compiled());
  kernel.constants = {{0, 32}};
  const PipelineCacheFile other(folder, driver, kernel);
  kernel.constants = {{0, 64}};
  fs::rename(file().path(), other.path());
  EXPECT_TRUE(is_empty(other));
}

TEST_F(GpuPipelineCache, IgnoresDataOfAnotherDriver) {
  CachedKernel foreign = compiled();
  foreign.driver_data[offsetof(VkPipelineCacheHeaderVersionOne, pipelineCacheUUID)] ^= std::byte{1};
  file().store(foreign);
  EXPECT_TRUE(is_empty(file()));
}

TEST_F(GpuPipelineCache, IgnoresAFileTruncatedAnywhere) {
  file().store(compiled());
  const std::vector<char> whole = read();
  for (size_t length = 0; length < whole.size(); ++length) {
    write({whole.begin(), whole.begin() + std::ptrdiff_t(length)});
    ASSERT_TRUE(is_empty(file())) << "truncated to " << length << " of " << whole.size();
  }
}

TEST_F(GpuPipelineCache, IgnoresAFileWithAnyByteChanged) {
  file().store(compiled());
  const std::vector<char> whole = read();
  for (size_t i = 0; i < whole.size(); ++i) {
    std::vector<char> changed = whole;
    changed[i] = char(changed[i] ^ 0x10);
    write(changed);
    ASSERT_TRUE(is_empty(file())) << "byte " << i;
  }
}

TEST_F(GpuPipelineCache, IgnoresTrailingBytes) {
  file().store(compiled());
  std::vector<char> longer = read();
  longer.push_back('x');
  write(longer);
  EXPECT_TRUE(is_empty(file()));
}

TEST_F(GpuPipelineCache, WithoutAFolderHoldsNothing) {
  const PipelineCacheFile nowhere({}, driver, kernel);
  nowhere.store(compiled());
  EXPECT_TRUE(is_empty(nowhere));
}

TEST_F(GpuPipelineCache, AFolderThatCannotBeMadeIsNoError) {
  std::ofstream(folder) << "a file where the folder should be";
  file().store(compiled());
  EXPECT_TRUE(is_empty(file()));
}

TEST_F(GpuPipelineCache, PruningKeepsTheNewestAndForeignFiles) {
  std::vector<fs::path> paths;
  const auto now = fs::file_time_type::clock::now();
  for (uint32_t i = 0; i < 6; ++i) {
    kernel.constants = {{0, i}};
    file().store(compiled());
    paths.push_back(file().path());
    fs::last_write_time(paths.back(), now - std::chrono::hours(6 - i));
  }
  std::ofstream(folder / "note.txt") << "not ours";
  prune_cache(folder, 2);
  for (size_t i = 0; i < paths.size(); ++i) EXPECT_EQ(fs::exists(paths[i]), i >= 4) << i;
  EXPECT_TRUE(fs::exists(folder / "note.txt"));
}

}  // namespace
}  // namespace regulus::gpu

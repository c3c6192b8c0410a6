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

  /// Data as this driver would give it: the header that Vulkan prescribes, then anything.
  std::vector<std::byte> driver_data() const {
    VkPipelineCacheHeaderVersionOne header{};
    header.headerSize = sizeof(header);
    header.headerVersion = VK_PIPELINE_CACHE_HEADER_VERSION_ONE;
    header.vendorID = driver.vendor;
    header.deviceID = driver.device;
    std::copy(driver.cache_uuid.begin(), driver.cache_uuid.end(), header.pipelineCacheUUID);
    std::vector<std::byte> data(sizeof(header) + 100, std::byte{0x5a});
    std::memcpy(data.data(), &header, sizeof(header));
    return data;
  }

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
  EXPECT_TRUE(file().load().empty());
  file().store(driver_data());
  EXPECT_EQ(file().load(), driver_data());
}

TEST_F(GpuPipelineCache, LeavesNoTemporaryFile) {
  file().store(driver_data());
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
  file().store(driver_data());
  kernel.constants = {{0, 32}};
  const PipelineCacheFile other(folder, driver, kernel);
  kernel.constants = {{0, 64}};
  fs::rename(file().path(), other.path());
  EXPECT_TRUE(other.load().empty());
}

TEST_F(GpuPipelineCache, IgnoresDataOfAnotherDriver) {
  std::vector<std::byte> foreign = driver_data();
  foreign[offsetof(VkPipelineCacheHeaderVersionOne, pipelineCacheUUID)] ^= std::byte{1};
  file().store(foreign);
  EXPECT_TRUE(file().load().empty());
}

TEST_F(GpuPipelineCache, IgnoresAFileTruncatedAnywhere) {
  file().store(driver_data());
  const std::vector<char> whole = read();
  for (size_t length = 0; length < whole.size(); ++length) {
    write({whole.begin(), whole.begin() + std::ptrdiff_t(length)});
    ASSERT_TRUE(file().load().empty()) << "truncated to " << length << " of " << whole.size();
  }
}

TEST_F(GpuPipelineCache, IgnoresAFileWithAnyByteChanged) {
  file().store(driver_data());
  const std::vector<char> whole = read();
  for (size_t i = 0; i < whole.size(); ++i) {
    std::vector<char> changed = whole;
    changed[i] = char(changed[i] ^ 0x10);
    write(changed);
    ASSERT_TRUE(file().load().empty()) << "byte " << i;
  }
}

TEST_F(GpuPipelineCache, IgnoresTrailingBytes) {
  file().store(driver_data());
  std::vector<char> longer = read();
  longer.push_back('x');
  write(longer);
  EXPECT_TRUE(file().load().empty());
}

TEST_F(GpuPipelineCache, WithoutAFolderHoldsNothing) {
  const PipelineCacheFile nowhere({}, driver, kernel);
  nowhere.store(driver_data());
  EXPECT_TRUE(nowhere.load().empty());
}

TEST_F(GpuPipelineCache, AFolderThatCannotBeMadeIsNoError) {
  std::ofstream(folder) << "a file where the folder should be";
  file().store(driver_data());
  EXPECT_TRUE(file().load().empty());
}

TEST_F(GpuPipelineCache, PruningKeepsTheNewestAndForeignFiles) {
  std::vector<fs::path> paths;
  const auto now = fs::file_time_type::clock::now();
  for (uint32_t i = 0; i < 6; ++i) {
    kernel.constants = {{0, i}};
    file().store(driver_data());
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

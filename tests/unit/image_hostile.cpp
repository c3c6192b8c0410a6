// Corrupt OpenEXR files: an error of status BadFile or, where the damage cannot be seen, an image of the size
// that the header claims; never another exception, and never memory out of proportion to the file.

#include <cstring>

#include "base/process_usage.hpp"
#include "image_files.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

enum class Outcome { Refused, Read };

/// Reads the bytes as a file; anything but an image or a BadFile error fails the test.
Outcome read(const TemporaryFolder& folder, const std::string& bytes, const std::string& what) {
  std::filesystem::remove(folder / "hostile.exr");  // some file systems flush a file that is overwritten
  write_bytes(folder / "hostile.exr", bytes);
  try {
    const image::Image image = image::read_exr(folder / "hostile.exr");
    EXPECT_EQ(image.rgb.size(), size_t{3} * image.width * image.height) << what;
    return Outcome::Read;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::BadFile) << what << ": " << error.what();
    EXPECT_NE(std::string(error.what()).find("hostile.exr"), std::string::npos) << what;
  }
  return Outcome::Refused;
}

std::string valid_file(const TemporaryFolder& folder) {
  Random random(2);
  const image::Image image = make_image(40, 50, [&](size_t) { return static_cast<float>(random.uniform()); });
  image::write_exr(folder / "valid.exr", image, {{"regulus:seed", "1"}}, {{"Z", std::vector<float>(2000)}});
  return read_bytes(folder / "valid.exr");
}

// OpenEXR would take the memory that an attribute claims before it finds the file too short.
TEST(HostileExr, AttributesMustFitTheFile) {
  const TemporaryFolder folder;
  std::string bytes = valid_file(folder);
  const size_t size = bytes.find(std::string("chlist\0", 7)) + 7;
  const uint32_t claimed = 0x70000000;
  std::memcpy(&bytes[size], &claimed, 4);
  const uint64_t before = process_peak_bytes();
  EXPECT_EQ(read(folder, bytes, "a list of channels of 1.75 GiB"), Outcome::Refused);
  EXPECT_LT(process_peak_bytes(), before + (uint64_t{64} << 20));
}

// The library reads types that it knows without regard to their size, and takes what follows for attributes.
TEST(HostileExr, AttributesHaveTheSizeOfTheirType) {
  const TemporaryFolder folder;
  const std::string bytes = valid_file(folder), null(1, '\0');
  const auto expect_refused = [&](const std::string& damaged, const std::string& attribute) {
    write_bytes(folder / "hostile.exr", damaged);
    expect_error([&] { image::read_exr(folder / "hostile.exr"); }, ErrorCode::BadFile,
                 "attribute " + attribute + " has ");
  };
  for (const auto& [name, type] :
       std::vector<std::pair<std::string, std::string>>{{"dataWindow", "box2i"},
                                                        {"pixelAspectRatio", "float"},
                                                        {"screenWindowCenter", "v2f"},
                                                        {"lineOrder", "lineOrder"}}) {
    const std::string start = name + null + type + null;
    std::string damaged = bytes;
    const size_t size = bytes.find(start) + start.size();
    ASSERT_LT(size, bytes.size());
    ++damaged[size];
    damaged.insert(size + 4, "x");
    expect_refused(damaged, name);
  }
  // The name of the first channel swallows what follows it.
  std::string damaged = bytes;
  const std::string channel = "chlist" + null;
  const size_t name = bytes.find(channel) + channel.size() + 4;
  damaged[name + 1] = 'x';
  expect_refused(damaged, "channels");
}

TEST(HostileExr, EveryTruncationIsRefused) {
  const TemporaryFolder folder;
  const std::string bytes = valid_file(folder);
  for (size_t length = 0; length < bytes.size(); length += length < 600 ? 3 : 211)
    EXPECT_EQ(read(folder, bytes.substr(0, length), "length " + std::to_string(length)), Outcome::Refused);
  EXPECT_EQ(read(folder, bytes, "whole"), Outcome::Read);
}

TEST(HostileExr, GarbageIsRefused) {
  const TemporaryFolder folder;
  const std::string magic = valid_file(folder).substr(0, 8);
  Random random(3);
  for (int trial = 0; trial < 60; ++trial) {
    std::string bytes(random.index(4000), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.index(256));
    EXPECT_EQ(read(folder, bytes, "garbage"), Outcome::Refused);
    EXPECT_EQ(read(folder, magic + bytes, "garbage after the magic number"), Outcome::Refused);
  }
}

TEST(HostileExr, ChangedBytesNeverCrash) {
  const TemporaryFolder folder;
  const std::string bytes = valid_file(folder);
  Random random(4);
  size_t refused = 0;
  constexpr int TRIALS = 1000;
  constexpr uint64_t MAX_GROWTH = uint64_t{256} << 20;  // sanitizers keep what was freed
  const uint64_t before = process_peak_bytes();
  for (int trial = 0; trial < TRIALS; ++trial) {
    std::string damaged = bytes;
    const uint32_t changes = 1 + random.index(4);
    for (uint32_t k = 0; k < changes; ++k) {
      // Half of the changes hit the header and the line offset table, where they do most harm.
      const auto range = static_cast<uint32_t>(random.uniform() < 0.5 ? 600 : bytes.size());
      damaged[random.index(range)] = static_cast<char>(random.index(256));
    }
    refused += read(folder, damaged, "trial " + std::to_string(trial)) == Outcome::Refused;
  }
  std::printf("refused %zu of %d\n", refused, TRIALS);
  EXPECT_GT(refused, 0u);
  EXPECT_LT(process_peak_bytes(), before + MAX_GROWTH);
}

/// Overwrites the data window of a file of ours.
std::string with_window(std::string bytes, const std::array<int32_t, 4>& window) {
  const std::string key("dataWindow\0box2i\0", 17);
  const size_t at = bytes.find(key) + key.size() + 4;
  std::memcpy(&bytes[at], window.data(), sizeof window);
  return bytes;
}

TEST(HostileExr, HugeWindowsAreRefusedBeforeAllocation) {
  const TemporaryFolder folder;
  const std::string bytes = valid_file(folder);
  constexpr int32_t LARGEST = std::numeric_limits<int32_t>::max();
  const uint64_t before = process_peak_bytes();
  for (const std::array<int32_t, 4>& window : {std::array<int32_t, 4>{0, 0, LARGEST, LARGEST},
                                               {-LARGEST, -LARGEST, LARGEST, LARGEST},
                                               {0, 0, 65535, 65535},
                                               {0, 0, 39, LARGEST},
                                               {0, 0, LARGEST, 49},
                                               {5, 5, 4, 4},
                                               {0, 0, 30000, 30000}})
    EXPECT_EQ(read(folder, with_window(bytes, window), "window"), Outcome::Refused) << window[2];
  // Line buffers of the widest allowed image, 4 channels of 16 lines, are 16 MiB; a frame would be 12 GiB.
  EXPECT_LT(process_peak_bytes() - before, uint64_t{256} << 20);
}

}  // namespace
}  // namespace regulus::test

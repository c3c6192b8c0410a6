// Radiance pictures: both ways of run-length coding, and every damage refused, soon.
#include <cmath>
#include <cstdio>
#include <ctime>

#include "image_files.hpp"

namespace regulus::test {
namespace {

std::string header(uint32_t width, uint32_t height) {
  return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
         std::to_string(width) + "\n";
}

std::string bytes_of(std::initializer_list<int> values) {
  std::string bytes;
  for (const int value : values) bytes.push_back(static_cast<char>(value));
  return bytes;
}

image::Image decode(const std::string& file) {
  return image::decode_radiance("sky.hdr",
                                std::span(reinterpret_cast<const unsigned char*>(file.data()), file.size()));
}

std::string refusal(const std::string& file) {
  try {
    decode(file);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::BadFile);
    EXPECT_NE(std::string(error.what()).find("sky.hdr"), std::string::npos);
    return error.what();
  }
  return {};
}

/// Row of ten pixels: red 128 five times and 1 2 3 4 5, green 64, blue 0, exponent 129 (times 2^(129 - 136)).
const std::string CODED_ROW =
    bytes_of({2, 2, 0, 10, 128 + 5, 128, 5, 1, 2, 3, 4, 5, 128 + 10, 64, 128 + 10, 0, 128 + 10, 129});

TEST(Radiance, RunsAndLiteralsOfEachChannel) {
  const image::Image image = decode(header(10, 2) + CODED_ROW + CODED_ROW);
  ASSERT_EQ(image.rgb.size(), 60u);
  for (size_t x = 0; x < 20; ++x) {
    const float red = x % 10 < 5 ? 128.0F : static_cast<float>(x % 10 - 4);
    EXPECT_EQ(image.rgb[3 * x], red / 128);
    EXPECT_EQ(image.rgb[3 * x + 1], 0.5F);
    EXPECT_EQ(image.rgb[3 * x + 2], 0);
  }
}

// 1 1 1 n repeats the last pixel n times; a second one in a row counts 256 each.
TEST(Radiance, RunsOfWholePixels) {
  const image::Image image = decode(
      header(300, 1) + bytes_of({128, 0, 0, 129, 1, 1, 1, 2, 1, 1, 1, 1, 0, 128, 0, 129, 1, 1, 1, 40}));
  ASSERT_EQ(image.rgb.size(), 900u);
  for (size_t x = 0; x < 300; ++x) {
    EXPECT_EQ(image.rgb[3 * x], x < 259 ? 1.0F : 0.0F) << x;
    EXPECT_EQ(image.rgb[3 * x + 1], x < 259 ? 0.0F : 1.0F) << x;
  }
}

TEST(Radiance, ZeroExponentIsBlackAndTheLargestIsFinite) {
  const image::Image image = decode(header(2, 1) + bytes_of({255, 255, 255, 0, 255, 1, 1, 255}));
  EXPECT_EQ(image.rgb[0], 0);
  EXPECT_EQ(image.rgb[3], std::ldexp(255.0F, 119));
}

TEST(Radiance, OtherFormatsAndOrdersAreNamed) {
  const std::string xyze = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + bytes_of({1, 2, 3, 4});
  EXPECT_NE(refusal(xyze).find("32-bit_rle_xyze"), std::string::npos);
  EXPECT_NE(refusal("#?RADIANCE\n\n+Y 1 +X 1\n" + bytes_of({1, 2, 3, 4})).find("-Y height +X width"),
            std::string::npos);
  for (const char* size : {"-Y 0 +X 1\n", "-Y 99999999999 +X 1\n", "-Y 1 +X -1\n", "-Y 1 +X\n", "\n"})
    EXPECT_NE(refusal(std::string("#?RADIANCE\n\n") + size + bytes_of({1, 2, 3, 4})), "") << size;
}

TEST(Radiance, DeclaredPixelsMustFitTheFile) {
  EXPECT_NE(refusal(header(30000, 30000) + bytes_of({1, 2, 3, 4})).find("30000 x 30000"), std::string::npos);
  const std::string file = header(10, 2) + CODED_ROW + CODED_ROW;
  EXPECT_THROW(
      image::decode_radiance("sky.hdr",
                             std::span(reinterpret_cast<const unsigned char*>(file.data()), file.size()), 19),
      Error);
}

// Every prefix is refused, every bit that is flipped gives a picture of that size or an error; no decoder may
// hang on runs of length 0 or runs beyond the row.
TEST(Radiance, CutAndFlippedFilesEnd) {
  const std::string file = header(10, 2) + CODED_ROW + CODED_ROW;
  const std::clock_t start = std::clock();
  for (size_t length = 0; length < file.size(); ++length)
    EXPECT_NE(refusal(file.substr(0, length)), "") << length;
  size_t read = 0;
  for (size_t bit = 0; bit < 8 * file.size(); ++bit) {
    std::string flipped = file;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
    read += refusal(flipped).empty() ? 1 : 0;
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%zu prefixes, %zu flips of which %zu can be read: %.3f s (bound 2)\n", file.size(),
              8 * file.size(), read, seconds);
  EXPECT_LT(seconds, 2);
  EXPECT_NE(
      refusal(header(10, 1) + bytes_of({2, 2, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0})).find("a run leaves its row"),
      std::string::npos);
}

}  // namespace
}  // namespace regulus::test

// Pictures in the formats that are not OpenEXR: which one, and what is in it.
#include "image/formats.hpp"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_NO_FAILURE_STRINGS
#include <stb_image.h>

#include <cmath>
#include <limits>
#include <memory>

#include "image_files.hpp"

namespace regulus::test {
namespace {

using image::Format;

TEST(Formats, FollowTheExtension) {
  EXPECT_EQ(image::format_of("a/b.exr"), Format::Exr);
  EXPECT_EQ(image::format_of("b.PNG"), Format::Png);
  EXPECT_EQ(image::format_of("b.exr.jpg"), Format::Jpeg);
  EXPECT_EQ(image::format_of("b.Jpeg"), Format::Jpeg);
  EXPECT_EQ(image::format_of("b.hdr"), Format::Hdr);
  for (const char* name : {"b", ".exr", "b.tif", "b.exr.bak", "b.png~", "exr", "b."})
    EXPECT_EQ(image::format_of(name), std::nullopt) << name;
}

TEST(Formats, OthersAreRefusedWithAList) {
  const std::vector<Format> allowed = {Format::Exr, Format::Jpeg};
  EXPECT_EQ(image::require_format("--output", "a.jpg", allowed), Format::Jpeg);
  EXPECT_EQ(image::require_format("--output", "/dev/null", allowed), Format::Exr);
  for (const char* name : {"a.png", "a", "a.bmp"})
    expect_error([&] { image::require_format("--output", name, allowed); }, ErrorCode::BadUsage,
                 "name a file that ends in .exr, .jpeg, .jpg");
}

// A picture that is narrower than 8 pixels is not compressed: four bytes a pixel after the header, of which
// Ward's format says: value = (mantissa + 0.5) / 256 * 2^(exponent - 128), or without the half. The writer
// rounds, so that the decoders without it have no bias.
TEST(Formats, HdrKeepsEightBitsOfEveryMagnitude) {
  constexpr float INFINITE = std::numeric_limits<float>::infinity();
  const std::vector<std::array<float, 3>> colors = {
      {0, 0, 0},       {1, 0.5f, 0.25f},   {0.999f, 0.001f, 0}, {1e-9f, 2e-9f, 3e-9f},    {3e37f, 1e37f, 1},
      {-1, 2, -3},     {INFINITE, 1, 2},   {NAN, 7, 7},         {255.9f, 255.9f, 255.9f}, {1e30f, 1e-30f, 5},
      {NAN, NAN, NAN}, {1e-38f, 0, 1e-38f}};
  image::Image picture{1, static_cast<uint32_t>(colors.size()), {}};
  for (const auto& color : colors) picture.rgb.insert(picture.rgb.end(), color.begin(), color.end());
  const std::string bytes = image::encode_hdr(picture, "test");
  EXPECT_TRUE(bytes.starts_with("#?RADIANCE\n")) << bytes.substr(0, 20);
  const size_t start = bytes.size() - 4 * colors.size();
  EXPECT_NE(bytes.find("-Y 12 +X 1\n"), std::string::npos);
  double largest_error = 0;
  for (size_t i = 0; i < colors.size(); ++i) {
    const auto* rgbe = reinterpret_cast<const unsigned char*>(bytes.data() + start + 4 * i);
    double peak = 0;
    std::array<double, 3> wanted{};
    for (size_t c = 0; c < 3; ++c) {
      wanted[c] = std::isnan(colors[i][c]) ? 0 : std::clamp(double{colors[i][c]}, 0.0, 1.69e38);
      peak = std::max(peak, wanted[c]);
    }
    for (size_t c = 0; c < 3; ++c) {
      const double read = rgbe[3] == 0 ? 0 : std::ldexp(rgbe[c], rgbe[3] - 136);
      // Half a unit of a mantissa of 8 bits, at least 128 for the largest; below 1e-32 there is nothing.
      const double bound = std::max(peak * 0.5 / 128, 1e-32);
      EXPECT_NEAR(read, wanted[c], bound * 1.0001) << i << " " << c;
      if (peak > 1e-30) largest_error = std::max(largest_error, std::abs(read - wanted[c]) / peak);
    }
  }
  std::printf("largest error over the largest component %.3g (bound %.3g)\n", largest_error, 0.5 / 128);
}

TEST(Formats, JpegIsThePictureOfThePng) {
  // Smooth, so that what JPEG drops is small.
  const image::Image picture =
      make_image(32, 24, [](size_t i) { return 0.5f + 0.4f * std::sin(0.01f * static_cast<float>(i / 3)); });
  const std::string bytes = image::encode_picture(Format::Jpeg, picture, 0, {}, {}, {}, "test");
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                            &width, &height, &channels, 3),
      stbi_image_free);
  ASSERT_TRUE(pixels);
  EXPECT_EQ(width, 32);
  EXPECT_EQ(height, 24);
  for (size_t i = 0; i < picture.rgb.size(); ++i) {
    const float encoded =
        255 * image::srgb_encode(image::tone_map({picture.rgb[i], picture.rgb[i], picture.rgb[i]})[0]);
    EXPECT_NEAR(pixels.get()[i], encoded,
                6);  // quantizer steps of quality 95 are at most 10 in 64 frequencies
  }
}

TEST(Formats, EachIsWhatItSays) {
  const image::Image picture = make_image(9, 5, [](size_t) { return 0.5f; });
  const auto start = [&](Format format) {
    return image::encode_picture(format, picture, 0, {}, {}, {}, "test").substr(0, 4);
  };
  EXPECT_EQ(start(Format::Exr), "\x76\x2f\x31\x01");
  EXPECT_EQ(start(Format::Png), "\x89PNG");
  EXPECT_EQ(start(Format::Jpeg).substr(0, 3), "\xff\xd8\xff");
  EXPECT_EQ(start(Format::Hdr), "#?RA");
}

}  // namespace
}  // namespace regulus::test

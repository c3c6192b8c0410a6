// Tone mapping, the sRGB curve and the pixels of a written PNG.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_FAILURE_STRINGS
#include <stb_image.h>

#include <cmath>
#include <limits>
#include <memory>

#include "image/flip_picture.hpp"
#include "image_files.hpp"

namespace regulus::test {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

std::vector<uint8_t> read_png(const std::filesystem::path& path, int& width, int& height) {
  int channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load(path.c_str(), &width, &height, &channels, 0), stbi_image_free);
  EXPECT_EQ(channels, 3);
  if (!pixels) return {};
  return {pixels.get(), pixels.get() + size_t{3} * static_cast<size_t>(width * height)};
}

TEST(ToneMap, KeepsColoursUpToEightTenths) {
  for (const std::array<float, 3> color :
       {std::array<float, 3>{0, 0, 0}, {0.1f, 0.02f, 0.799f}, {0.5f, 0.5f, 0}})
    EXPECT_EQ(image::tone_map(color), color);
}

TEST(ToneMap, IsContinuousAndRisesToOne) {
  float previous = 0;
  for (int i = 0; i < 4000; ++i) {
    const float value = std::exp(0.01f * static_cast<float>(i - 2000));
    const float mapped = image::tone_map({value, value, value})[0];
    EXPECT_GE(mapped, previous);
    // The slope never exceeds 1; float error of a value below 1 is added.
    EXPECT_LE(mapped - previous, value * 0.00996f + 1e-6f) << value;
    EXPECT_LE(mapped, 1);
    previous = mapped;
  }
  EXPECT_GT(previous, 0.99f);
}

TEST(ToneMap, HighlightsTurnWhiteAndInvalidValuesBlack) {
  const std::array<float, 3> bright = image::tone_map({1000, 10, 10});
  EXPECT_GT(bright[1], 0.9f);
  EXPECT_GT(image::tone_map({INFINITE, INFINITE, INFINITE})[0], 0.99f);
  EXPECT_EQ(image::tone_map({-1, std::nanf(""), 0.5f}), (std::array<float, 3>{0, 0, 0.5f}));
}

TEST(Srgb, HasTheStandardsAnchors) {
  EXPECT_EQ(image::srgb_encode(0), 0);
  EXPECT_NEAR(image::srgb_encode(1), 1, 1e-6);
  EXPECT_NEAR(image::srgb_encode(0.0031308f), 0.04045, 1e-5);  // IEC 61966-2-1
  EXPECT_NEAR(image::srgb_encode(0.21404114f), 0.5,
              1e-6);  // its decoding of 0.5: ((0.5 + 0.055) / 1.055)^2.4
}

TEST(Png, HoldsTheEncodedPixelsFromTheTopRow) {
  const TemporaryFolder folder;
  const image::Image image{2,
                           2,
                           {0, 0.21404114f, 0.0031308f, 0.5f, 0.5f, 0.5f,  //
                            INFINITE, INFINITE, INFINITE, -1, 0, std::nanf("")}};
  image::write_png(folder / "a.png", image);
  int width = 0, height = 0;
  const std::vector<uint8_t> bytes = read_png(folder / "a.png", width, height);
  EXPECT_EQ(width, 2);
  EXPECT_EQ(height, 2);
  // 0.5 * 255 rounds to 128 or 127 within float error; 255 * srgb(0.5) = 187.5 + 0.02.
  ASSERT_EQ(bytes.size(), 12u);
  EXPECT_EQ(bytes[0], 0);
  EXPECT_NEAR(bytes[1], 127.5, 0.5);
  EXPECT_EQ(bytes[2], 10);  // 255 * 0.04045 = 10.3
  EXPECT_EQ(bytes[3], 188);
  EXPECT_EQ(bytes[6], 255);
  EXPECT_EQ(bytes[9], 0);
  EXPECT_EQ(bytes[11], 0);
}

TEST(Png, ExposureIsInStops) {
  const TemporaryFolder folder;
  image::write_png(folder / "a.png", make_image(3, 1, [](size_t i) { return 0.05f * static_cast<float>(i); }),
                   1);
  image::write_png(folder / "b.png", make_image(3, 1, [](size_t i) { return 0.1f * static_cast<float>(i); }),
                   0);
  EXPECT_EQ(read_bytes(folder / "a.png"), read_bytes(folder / "b.png"));
  expect_error([&] { image::write_png(folder / "c.png", image::Image{}); }, ErrorCode::Failed, "c.png");
}

TEST(HeatMap, ShowsRelativeErrorOnALogarithmicScale) {
  const TemporaryFolder folder;
  // Relative errors 0, 1 and NaN: the reference is 0, so the scale is sqrt(0.01).
  const image::Image reference = make_image(3, 1, [](size_t) { return 0.0f; });
  const image::Image image{3, 1, {0, 0, 0, 0.1f, 0.1f, 0.1f, std::nanf(""), 0, 0}};
  EXPECT_NEAR(image::relative_error(&image.rgb[3], &reference.rgb[3]), 1, 1e-6);
  image::write_heat_map(folder / "heat.png", image, reference);
  int width = 0, height = 0;
  const std::vector<uint8_t> bytes = read_png(folder / "heat.png", width, height);
  EXPECT_EQ(bytes, (std::vector<uint8_t>{0, 0, 0, 252, 255, 164, 0, 255, 255}));
}

// What a pixel is shown as is its own error: the map's largest is where the images differ, equal images are
// black.
TEST(FlipPicture, IsBlackWhereNothingDiffers) {
  const TemporaryFolder folder;
  const image::Image reference = make_image(64, 2, [](size_t) { return 0.2f; });
  image::Image image = reference;
  for (size_t i = 0; i < 3; ++i) image.rgb[i] = 1;  // far from the right end
  image::write_flip_picture(folder / "flip.png", image, reference);
  int width = 0, height = 0;
  const std::vector<uint8_t> bytes = read_png(folder / "flip.png", width, height);
  EXPECT_EQ(width, 64);
  EXPECT_EQ(height, 2);
  EXPECT_GT(int{bytes[0]} + bytes[1] + bytes[2], 100);
  EXPECT_EQ((std::vector<uint8_t>(bytes.begin() + 3 * 63, bytes.begin() + 3 * 64)),
            (std::vector<uint8_t>{0, 0, 0}));
}

}  // namespace
}  // namespace regulus::test

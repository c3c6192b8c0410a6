// Textures' images as codes: every kind of PNG, and what headers may claim.
#include <gtest/gtest.h>
#include <png.h>

#include <cstdio>

#include "scene/image_decoder.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

struct Kind {
  const char* name;
  int color_type, depth;
  bool has_transparency;  // a tRNS chunk: grey 1 or red 1, green 1, blue 1 is clear; of a palette the alphas
                          // 0, 1, 2, ...
  bool is_interlaced;
};

constexpr uint32_t WIDTH = 11, HEIGHT = 9;

/// Sample of channel c at (x, y), below 2^depth.
uint32_t sample(const Kind& kind, uint32_t x, uint32_t y, uint32_t c) {
  const uint32_t bits = (x * 977 + y * 3181 + c * 641) % 65536;
  return bits >> (16 - kind.depth);
}

void append(png_structp png, png_bytep data, size_t size) {
  auto* bytes = static_cast<Bytes*>(png_get_io_ptr(png));
  bytes->insert(bytes->end(), data, data + size);
}

/// The picture of `sample`, written by libpng. Palette entry i has the colour (i, 255 - i, 7).
Bytes write(const Kind& kind) {
  Bytes bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, &append, nullptr);
  png_set_IHDR(png, info, WIDTH, HEIGHT, kind.depth, kind.color_type,
               kind.is_interlaced ? PNG_INTERLACE_ADAM7 : 0, 0, 0);
  const bool is_palette = kind.color_type == PNG_COLOR_TYPE_PALETTE;
  std::vector<png_color> palette;
  std::vector<png_byte> alphas;
  for (int i = 0; i < 1 << std::min(kind.depth, 8); ++i) {
    palette.push_back({static_cast<png_byte>(i), static_cast<png_byte>(255 - i), 7});
    alphas.push_back(static_cast<png_byte>(i));
  }
  png_color_16 clear{0, 1, 1, 1, 1};
  if (is_palette) png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  if (kind.has_transparency)
    png_set_tRNS(png, info, is_palette ? alphas.data() : nullptr,
                 is_palette ? static_cast<int>(alphas.size()) : 1, &clear);
  png_write_info(png, info);
  const uint32_t channels = png_get_channels(png, info);
  std::vector<Bytes> rows(HEIGHT, Bytes(png_get_rowbytes(png, info), 0));
  std::vector<png_bytep> pointers;
  for (uint32_t y = 0; y < HEIGHT; ++y) {
    for (uint32_t i = 0; i < WIDTH * channels; ++i) {
      const uint32_t value = sample(kind, i / channels, y, i % channels),
                     bit = i * static_cast<uint32_t>(kind.depth);
      if (kind.depth == 16) {
        rows[y][2 * i] = static_cast<unsigned char>(value >> 8);
        rows[y][2 * i + 1] = static_cast<unsigned char>(value);
      } else {
        rows[y][bit / 8] = static_cast<unsigned char>(rows[y][bit / 8] | value << (8 - kind.depth - bit % 8));
      }
    }
    pointers.push_back(rows[y].data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

/// Channel c of RGBA as the PNG specification defines it, scaled to the codes of the result.
uint32_t expected(const Kind& kind, uint32_t x, uint32_t y, uint32_t c) {
  const uint32_t largest = kind.depth == 16 ? 65535 : 255, scale = largest / ((1u << kind.depth) - 1);
  const bool is_color = (kind.color_type & PNG_COLOR_MASK_COLOR) != 0,
             has_alpha = (kind.color_type & PNG_COLOR_MASK_ALPHA) != 0;
  if (kind.color_type == PNG_COLOR_TYPE_PALETTE) {
    const uint32_t index = sample(kind, x, y, 0);
    return c == 0 ? index : c == 1 ? 255 - index : c == 2 ? 7 : kind.has_transparency ? index : 255;
  }
  if (c < 3) return scale * sample(kind, x, y, is_color ? c : 0);
  if (has_alpha) return scale * sample(kind, x, y, is_color ? 3 : 1);
  bool is_clear = kind.has_transparency;
  for (uint32_t i = 0; i < (is_color ? 3u : 1u); ++i) is_clear = is_clear && sample(kind, x, y, i) == 1;
  return is_clear ? 0 : largest;
}

TEST(SceneImages, EveryKindOfPng) {
  std::string reason;
  size_t kinds = 0;
  for (const bool is_interlaced : {false, true})
    for (const Kind& of : {Kind{"grey 1", 0, 1, false, false}, Kind{"grey 2 clear", 0, 2, true, false},
                           Kind{"grey 4", 0, 4, false, false}, Kind{"grey 8 clear", 0, 8, true, false},
                           Kind{"grey 16", 0, 16, false, false}, Kind{"rgb 8", 2, 8, false, false},
                           Kind{"rgb 8 clear", 2, 8, true, false}, Kind{"rgb 16", 2, 16, false, false},
                           Kind{"palette 1", 3, 1, false, false}, Kind{"palette 4", 3, 4, true, false},
                           Kind{"palette 8", 3, 8, true, false}, Kind{"grey alpha 8", 4, 8, false, false},
                           Kind{"grey alpha 16", 4, 16, false, false}, Kind{"rgba 8", 6, 8, false, false},
                           Kind{"rgba 16", 6, 16, false, false}}) {
      Kind kind = of;
      kind.is_interlaced = is_interlaced;
      SCOPED_TRACE(std::string(kind.name) + (is_interlaced ? " interlaced" : ""));
      const Bytes file = write(kind);
      const auto header = read_image_header(file, reason);
      ASSERT_TRUE(header) << reason;
      EXPECT_EQ(header->width, WIDTH);
      EXPECT_EQ(header->height, HEIGHT);
      ASSERT_EQ(header->is_16_bit, kind.depth == 16);
      const auto words = decode_image(file, *header, reason);
      ASSERT_TRUE(words) << reason;
      for (uint32_t i = 0; i < WIDTH * HEIGHT * 4; ++i) {
        const uint32_t value = kind.depth == 16 ? (*words)[i / 2] >> (16 * (i % 2)) & 0xFFFF
                                                : (*words)[i / 4] >> (8 * (i % 4)) & 0xFF;
        ASSERT_EQ(value, expected(kind, i / 4 % WIDTH, i / 4 / WIDTH, i % 4)) << "value " << i;
      }
      ++kinds;
    }
  std::printf("%zu kinds\n", kinds);
}

/// A file whose stream holds more than its header says: inflated no further than that.
TEST(SceneImages, TrailingPixelsAreNotInflated) {
  Bytes file = write({"rgb 8", 2, 8, false, false});
  const Bytes larger = make_png(2000, 2000, 3, 8, std::vector<uint16_t>(size_t{2000} * 2000 * 3, 9));
  std::string reason;
  auto header = *read_image_header(larger, reason);
  header.height = 1;  // asked for one row of a larger file
  EXPECT_FALSE(decode_image(larger, header, reason));
  EXPECT_EQ(reason, "its header is not what it was");
}

TEST(SceneImages, HeadersMustFitTheFile) {
  std::string reason;
  EXPECT_FALSE(read_image_header(make_png(8000, 8000, 3, 8, {}), reason));
  EXPECT_NE(reason.find("which cannot be"), std::string::npos) << reason;
  // One bit a pixel: 1032 * 8 of them to a byte at most.
  EXPECT_FALSE(read_image_header(make_png(8000, 8000, 1, 1, {}), reason));
  Bytes jpeg = {0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0x20, 0, 0x20, 0, 1, 1, 0x11, 0};  // 8192 x 8192, grey
  EXPECT_FALSE(read_image_header(jpeg, reason));
  EXPECT_NE(reason.find("which cannot be"), std::string::npos) << reason;
  jpeg[7] = jpeg[9] = 0;  // no size
  EXPECT_FALSE(read_image_header(jpeg, reason));
}

TEST(SceneImages, ScansOfAJpegAreCounted) {
  Bytes jpeg = {0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0};
  std::string reason;
  EXPECT_TRUE(read_image_header(jpeg, reason)) << reason;
  for (int i = 0; i < 101; ++i) jpeg.insert(jpeg.end(), {0xFF, 0xDA});
  EXPECT_FALSE(read_image_header(jpeg, reason));
  EXPECT_NE(reason.find("scans"), std::string::npos) << reason;
}

}  // namespace
}  // namespace regulus::scene::test

// Damaged pictures: cut and flipped files of every format that scenes refer to. Each gives a scene or an
// error within its processor time.
#include <gtest/gtest.h>
#include <stb_image_write.h>
#include <webp/encode.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>

#include "../unit/scene_files.hpp"
#include "image/image.hpp"

namespace regulus::scene::test {
namespace {

constexpr int WIDTH = 96, HEIGHT = 64;
constexpr double MAX_SECONDS = 2;

/// Noise over a gradient, so that no coder finds it trivial.
std::vector<unsigned char> codes() {
  std::mt19937 random(1);
  std::vector<unsigned char> rgb;
  for (int i = 0; i < WIDTH * HEIGHT * 3; ++i)
    rgb.push_back(static_cast<unsigned char>(i / 3 % WIDTH + random() % 32 + (i % 3) * 32));
  return rgb;
}

void append(void* bytes, void* data, int size) {
  const auto* first = static_cast<unsigned char*>(data);
  static_cast<Bytes*>(bytes)->insert(static_cast<Bytes*>(bytes)->end(), first, first + size);
}

Bytes png() {
  Bytes bytes;
  stbi_write_png_to_func(append, &bytes, WIDTH, HEIGHT, 3, codes().data(), 3 * WIDTH);
  return bytes;
}

Bytes jpeg() {
  Bytes bytes;
  stbi_write_jpg_to_func(append, &bytes, WIDTH, HEIGHT, 3, codes().data(), 90);
  return bytes;
}

Bytes webp(bool is_lossless) {
  uint8_t* encoded = nullptr;
  const std::vector<unsigned char> rgb = codes();
  const size_t size = is_lossless ? WebPEncodeLosslessRGB(rgb.data(), WIDTH, HEIGHT, 3 * WIDTH, &encoded)
                                  : WebPEncodeRGB(rgb.data(), WIDTH, HEIGHT, 3 * WIDTH, 80, &encoded);
  const Bytes bytes(encoded, encoded + size);
  WebPFree(encoded);
  return bytes;
}

Bytes radiance() {
  Bytes bytes;
  std::vector<float> rgb;
  for (const unsigned char code : codes()) rgb.push_back(static_cast<float>(code / 16));  // with runs
  stbi_write_hdr_to_func(append, &bytes, WIDTH, HEIGHT, 3, rgb.data());
  return bytes;
}

Bytes exr() {
  image::Image image{WIDTH, HEIGHT, {}};
  for (const unsigned char code : codes()) image.rgb.push_back(code);
  const TemporaryFolder folder;
  image::write_exr(folder.path() / "sky.exr", image);
  std::ifstream stream(folder.path() / "sky.exr", std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

struct Format {
  const char* name;
  Bytes (*make)();
  bool is_environment;
};

void PrintTo(const Format& format, std::ostream* stream) {
  *stream << format.name;
}

class ImageDamage : public testing::TestWithParam<Format> {
 protected:
  /// Empty if the scene with this picture loads.
  std::string error_of_scene(const Bytes& picture) const {
    Gltf file;
    if (GetParam().is_environment) {
      file.triangle();
      file.root["scenes"][0]["extras"]["regulus"]["environment"]["file"] =
          "data:application/octet-stream;base64," + base64(picture);
    } else {
      file.triangle_of(
          {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", file.texture(picture)}}}}}});
    }
    LoadOptions strict;
    strict.is_strict = true;  // otherwise a scene does without
    return error_of([&] { file.load(strict); });
  }
};

TEST_P(ImageDamage, GivesASceneOrAnErrorInTime) {
  const Bytes whole = GetParam().make();
  ASSERT_EQ(error_of_scene(whole), "");
  std::mt19937 random(7);
  double slowest = 0;
  size_t read = 0, cut_read = 0;
  constexpr int CUTS = 40, FLIPS = 80;
  for (int i = 0; i < CUTS + FLIPS; ++i) {
    Bytes damaged = whole;
    if (i < CUTS)
      damaged.resize(whole.size() * static_cast<size_t>(i) / CUTS);
    else  // half of them in the header
      for (uint32_t flips = 1 + random() % 4; flips > 0; --flips)
        damaged[random() % (i % 2 == 0 ? std::min<size_t>(64, whole.size()) : whole.size())] ^=
            static_cast<unsigned char>(1 << random() % 8);
    const std::clock_t start = std::clock();
    const std::string error = error_of_scene(damaged);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    slowest = std::max(slowest, seconds);
    EXPECT_LT(seconds, MAX_SECONDS) << "case " << i << ": " << error;
    EXPECT_EQ(error.find("more than one line"), std::string::npos) << error;
    EXPECT_EQ(error.find("wrong exit status"), std::string::npos) << error;
    read += error.empty() ? 1 : 0;
    cut_read += error.empty() && i < CUTS ? 1 : 0;
  }
  EXPECT_EQ(cut_read, 0u) << "a picture that ends early is not shown as if it were whole";
  std::printf("%s, %zu bytes: %d cut, %d flipped; %zu read; slowest %.3f s (bound %.0f)\n", GetParam().name,
              whole.size(), CUTS, FLIPS, read, slowest, MAX_SECONDS);
}

INSTANTIATE_TEST_SUITE_P(Formats, ImageDamage,
                         testing::Values(Format{"png", png, false}, Format{"jpeg", jpeg, false},
                                         Format{"webp", [] { return webp(false); }, false},
                                         Format{"webp_lossless", [] { return webp(true); }, false},
                                         Format{"hdr", radiance, true}, Format{"exr", exr, true}),
                         [](const auto& format) { return format.param.name; });

}  // namespace
}  // namespace regulus::scene::test

// Texels on the device against the host's, over all codes, in one buffer and in several.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "interface/wavefront.h"
#include "render/device_images.hpp"
#include "scene/texture.hpp"
#include "support/device.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using namespace interface;

constexpr uint32_t SIDE = 16;

Texture texture(uint32_t image, uint32_t flags) {
  Texture result{};
  result.image = image;
  result.width = result.height = SIDE;
  result.flags = flags;
  return result;
}

/// Four images of 256 texels: all 8-bit codes, twice; 16-bit codes; half floats.
scene::Scene scene_of_texels() {
  scene::Scene scene;
  scene.images.resize(4);
  for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
    scene.images[0].push_back(i | (255 - i) << 8 | (i * 7 & 255) << 16 | i << 24);
    scene.images[1].push_back(i * 0x01010101u);
    for (const uint32_t word : {i * 257 | (65535 - i) << 16, i * 3 | i << 16})
      scene.images[2].push_back(word);
    for (const uint32_t word : {i * 60 | i * 50 << 16, i * 7 | 0x3C000000}) scene.images[3].push_back(word);
  }
  scene.textures = {texture(0, TEXTURE_SRGB), texture(1, 0), texture(2, TEXTURE_UNORM16),
                    texture(3, TEXTURE_HALF), texture(0, 0)};
  return scene;
}

/// Largest error of all texels of all textures, relative to the host's value.
double worst_error(const std::vector<Texture>& on_device, const scene::Scene& scene) {
  const gpu::Buffer textures = gpu::upload_new(*device(), on_device, "textures");
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "texel",
                                                 {{SPEC_FEATURES, FEATURE_TEXTURES | FEATURE_WIDE_TEXELS}});
  constexpr uint32_t TEXELS = SIDE * SIDE;
  const gpu::Buffer out = device()->create_buffer(2 * TEXELS * sizeof(vec4), "texels");
  double worst = 0;
  for (uint32_t t = 0; t < on_device.size(); ++t) {
    run_batch(kernel, {textures.address(), out.address(), 2 * TEXELS, t});
    const auto values = gpu::download_all<vec4>(*device(), out, 2 * TEXELS);
    const bool is_color = (on_device[t].flags & TEXTURE_SRGB) != 0;
    for (uint32_t i = 0; i < TEXELS; ++i) {
      const vec4 expected = scene::texel(scene, scene.textures[t], i % SIDE, i / SIDE);
      for (int c = 0; c < 4; ++c) {
        const double value = values[i + (is_color ? 0 : TEXELS)][c];
        worst = std::max(worst, std::abs(value - expected[c]) / std::max(expected[c], 1e-10F));
      }
    }
  }
  return worst;
}

// Two roundings: drivers may divide and take roots with an error of more than half a unit.
constexpr double BOUND = 2.4e-7;

TEST(Texels, AreThoseOfTheHost) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const scene::Scene scene = scene_of_texels();
  // Images take 1 KiB, 1, 2 and 2.
  for (const auto& [largest, buffers] :
       {std::pair(8192u, 1u), std::pair(4096u, 2u), std::pair(2048u, 3u), std::pair(1u, 4u)}) {
    std::vector<Texture> textures = scene.textures;
    const auto uploaded = render::upload_images(*device(), scene.images, largest, textures);
    EXPECT_EQ(uploaded.size(), buffers);
    const double worst = worst_error(textures, scene);
    std::printf("%zu buffers: largest error %.2e (bound %.1e)\n", uploaded.size(), worst, BOUND);
    EXPECT_LE(worst, BOUND);
  }
}

// IEC 61966-2-1 in double precision.
TEST(Texels, HostDecodesEveryCodeExactlyEnough) {
  const scene::Scene scene = scene_of_texels();
  double worst = 0, worst_fraction = 0;
  float before = -1;
  for (int code = 0; code < 256; ++code) {
    const float value = scene::texel(scene, scene.textures[0], code % SIDE, code / SIDE).r;
    const double encoded = code / 255.0;
    const double exact = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    if (code > 0) worst = std::max(worst, std::abs(value / exact - 1));
    EXPECT_GT(value, before);
    before = value;
    const float fraction = scene::texel(scene, scene.textures[1], code % SIDE, code / SIDE).r;
    if (code > 0) worst_fraction = std::max(worst_fraction, std::abs(fraction / encoded - 1));
  }
  std::printf("sRGB within %.2e (bound 4.2e-7), fractions within %.2e (bound 1.2e-7)\n", worst,
              worst_fraction);
  EXPECT_LE(worst, 4.2e-7);
  EXPECT_LE(worst_fraction, 1.2e-7);
  EXPECT_EQ(scene::texel(scene, scene.textures[0], 0, 0).r, 0);
  EXPECT_EQ(scene::texel(scene, scene.textures[0], 15, 15).r, 1);
  EXPECT_EQ(scene::texel(scene, scene.textures[1], 15, 15), vec4(1));
}

}  // namespace
}  // namespace regulus::test

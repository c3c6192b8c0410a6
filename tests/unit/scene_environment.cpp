// Environment maps as files: what is read, what is refused, what is made of values that are no radiance.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/image.hpp"
#include "interface/wavefront.h"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

// A scene of one triangle in a folder of its own, with this environment.
class EnvironmentFile : public testing::Test {
 protected:
  EnvironmentFile() { file_.triangle(); }

  Scene load(const json& environment, const EnvironmentOptions& options = {}, bool is_strict = false) {
    file_.root["scenes"][0]["extras"]["regulus"]["environment"] = environment;
    LoadOptions load_options;
    load_options.environment = options;
    load_options.is_strict = is_strict;
    return scene::load(folder_.write("scene.gltf", file_.root.dump()), load_options);
  }
  void write(const std::string& name, uint32_t width, uint32_t height, const std::vector<float>& grey) {
    image::Image image{width, height, {}};
    for (const float value : grey) image.rgb.insert(image.rgb.end(), 3, value);
    image::write_exr(folder_.path() / name, image);
  }
  std::string refusal(const json& environment, const EnvironmentOptions& options = {}) {
    try {
      load(environment, options, true);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::BadFile);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "";
  }

  Gltf file_;
  TemporaryFolder folder_;
};

TEST_F(EnvironmentFile, IsReadWithRotationAndScale) {
  write("sky.exr", 3, 1, {1, 2, 3});
  const Scene scene = load({{"file", "sky.exr"}, {"rotation", -90}, {"scale", 2}});
  ASSERT_TRUE(scene.environment && scene.environment->is_map());
  EXPECT_EQ(scene.environment->parameters.width, 3u);
  EXPECT_EQ(scene.environment->parameters.height, 1u);
  EXPECT_EQ(scene.environment->parameters.rotation, 0.75f);
  EXPECT_EQ(scene.environment->texels[2], glm::vec3(6));
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_FALSE(scene.settings.contains("environment"));
}

// Blocks hold all channels, also those that are not read: 100 more make 412 bytes a pixel, packed and not.
TEST_F(EnvironmentFile, WhatOpenExrTakesIsCountedBeforeItIsTaken) {
  constexpr uint32_t WIDTH = 512, HEIGHT = 16;
  image::Channels channels;
  for (int i = 0; i < 100; ++i)
    channels["more." + std::to_string(i)] = std::vector<float>(size_t{WIDTH} * HEIGHT);
  image::write_exr(folder_.path() / "sky.exr", {WIDTH, HEIGHT, std::vector<float>(3 * WIDTH * HEIGHT, 1.0f)},
                   {}, channels);
  file_.root["scenes"][0]["extras"]["regulus"]["environment"]["file"] = "sky.exr";
  const auto file = folder_.write("scene.gltf", file_.root.dump());
  const uint64_t blocks = 2 * WIDTH * HEIGHT * (12 + 100 * 4);
  LoadOptions options;
  options.memory_bytes = blocks;
  const std::string error = error_of([&] { scene::load(file, options); });
  EXPECT_NE(error.find("sky.exr needs 6."), std::string::npos) << error;
  EXPECT_NE(error.find("6.4 MiB of memory are allowed"), std::string::npos) << error;
  options.memory_bytes = 2 * blocks;
  EXPECT_EQ(error_of([&] { scene::load(file, options); }), "");
}

TEST_F(EnvironmentFile, OptionsWin) {
  write("sky.exr", 2, 1, {1, 2});
  write("other.exr", 1, 2, {5, 7});
  EnvironmentOptions options;
  options.file = folder_.path() / "other.exr";
  options.scale = 3;
  const Scene scene = load({{"file", "sky.exr"}, {"rotation", 36}, {"scale", 2}}, options);
  EXPECT_EQ(scene.environment->texels[1], glm::vec3(21));
  EXPECT_NEAR(scene.environment->parameters.rotation, 0.1, 1e-7);
}

TEST_F(EnvironmentFile, EqualTexelsAreNoMap) {
  write("one.exr", 1, 1, {4});
  write("even.exr", 4, 2, std::vector<float>(8, 0.25f));
  EXPECT_FALSE(load({{"file", "one.exr"}}).environment->is_map());
  const Scene scene = load({{"file", "even.exr"}});
  EXPECT_FALSE(scene.environment->is_map());
  EXPECT_EQ(scene.environment->parameters.radiance, glm::vec3(0.25f));
}

TEST_F(EnvironmentFile, BlackMapsAreToldAndGiveNoLight) {
  write("black.exr", 8, 4, std::vector<float>(32, 0.0f));
  Scene scene = load({{"file", "black.exr"}});
  build_lights(scene);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_TRUE(has_warning(scene, "is black"));
  EXPECT_EQ(find_features(scene).bits & interface::FEATURE_ENVIRONMENT, 0u);
}

TEST_F(EnvironmentFile, ValuesThatAreNoRadianceAreReplaced) {
  constexpr float INF = std::numeric_limits<float>::infinity();
  write("odd.exr", 5, 1, {std::nanf(""), INF, -INF, -1, 3e38f});
  Scene scene = load({{"file", "odd.exr"}});
  ASSERT_TRUE(scene.environment->is_map());
  const float expected[] = {0, 1e10f, 0, 0, 1e10f};  // infinite ones count no less than finite ones
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(scene.environment->texels[i], glm::vec3(expected[i])) << i;
  EXPECT_TRUE(has_warning(scene, "15 values are no radiance"));
  EXPECT_TRUE(has_warning(scene, "infinite ones (3)"));
  build_lights(scene);
  EXPECT_EQ(scene.environment->parameters.selection_pdf, 1);
}

// However unlike the values are, every cell that shines can be drawn: its share is at least two steps of the
// random numbers.
TEST_F(EnvironmentFile, EveryCellThatShinesHasAShare) {
  std::vector<float> values(size_t{1024} * 16, 1e-6f);
  values[5000] = 1e9f;
  write("sun.exr", 1024, 16, values);
  const Scene scene = load({{"file", "sun.exr"}});
  const std::vector<float>& cdf = scene.environment->cdf;
  ASSERT_EQ(cdf.size(), 17u + 16 * 1025);
  for (size_t row = 0; row < 16; ++row) {
    EXPECT_GE(cdf[row + 1] - cdf[row], 0x1p-23);
    const float* columns = &cdf[17 + row * 1025];
    EXPECT_EQ(columns[0], 0);
    EXPECT_EQ(columns[1024], 1);
    for (size_t x = 0; x < 1024; ++x) EXPECT_GE(columns[x + 1] - columns[x], 0x1p-23) << row << " " << x;
  }
}

TEST_F(EnvironmentFile, WhatCannotBeReadIsRefusedByName) {
  folder_.write("text.exr", "not an image");
  folder_.write("text.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n");
  EXPECT_NE(refusal({{"file", "missing.exr"}}).find("missing.exr"), std::string::npos);
  EXPECT_NE(refusal({{"file", "text.exr"}}).find("text.exr"), std::string::npos);
  EXPECT_NE(refusal({{"file", "text.hdr"}}).find("text.hdr"), std::string::npos);
  EXPECT_NE(refusal({{"file", "../scene.exr"}}).find("outside the scene's folder"), std::string::npos);
  EXPECT_NE(refusal({{"file", 3}}), "");
  EXPECT_NE(refusal("sky.exr"), "");
  EXPECT_NE(refusal(json::object()), "");
  EXPECT_NE(refusal({{"color", {1, 2}}}), "");
  EXPECT_NE(refusal({{"color", {1, 2, -1}}}), "");
  EXPECT_NE(refusal({{"color", {1, 2, 1e30}}}), "");
  EXPECT_NE(refusal({{"color", {1, 2, 3}}, {"scale", -1}}), "");
  EXPECT_NE(refusal({{"color", {1, 2, 3}}, {"rotation", "left"}}), "");
  EnvironmentOptions options;
  options.file = folder_.path() / "none.exr";
  EXPECT_NE(refusal({{"color", {1, 2, 3}}}, options).find("none.exr"), std::string::npos);
}

// Uncompressed scan lines: four bytes a pixel, red, green, blue times 2^(e - 136).
TEST_F(EnvironmentFile, RadianceFilesAreRead) {
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
  for (const int byte : {128, 64, 32, 129, 128, 128, 128, 140}) bytes.push_back(static_cast<char>(byte));
  folder_.write("sky.hdr", bytes);
  const Scene scene = load({{"file", "sky.hdr"}});
  ASSERT_TRUE(scene.environment->is_map());
  EXPECT_EQ(scene.environment->texels[0], glm::vec3(1, 0.5f, 0.25f));
  EXPECT_EQ(scene.environment->texels[1], glm::vec3(2048));
}

}  // namespace
}  // namespace regulus::scene::test

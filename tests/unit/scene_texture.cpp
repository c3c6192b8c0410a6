// Textures against the glTF specification, and the features that materials and textures make.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>

#include "interface/wavefront.h"
#include "scene/texture.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

// Of decoding 8-bit codes, relative (interface/srgb.h).
constexpr double CODE_ERROR = 4.2e-7;

TEST(SceneTexture, ColorsAreDecodedFromSrgbAndDataIsNot) {
  Gltf file;
  const size_t texture = file.texture(make_png(2, 1, 4, 8, {0, 10, 128, 64, 255, 188, 55, 255}));
  file.triangle_of(
      {{"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", texture}}}, {"metallicRoughnessTexture", {{"index", texture}}}}}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.textures.size(), 2u);
  ASSERT_EQ(scene.images.size(), 1u);  // the same codes, whatever they mean
  EXPECT_EQ(scene.images[0].size(), 2u);
  const glm::vec4 color = texel(scene, scene.textures[scene.materials[0].base_color_texture], 0, 0);
  const glm::vec4 data = texel(scene, scene.textures[scene.materials[0].metallic_roughness_texture], 0, 0);
  const auto srgb = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  EXPECT_EQ(color.r, 0.0f);
  EXPECT_NEAR(color.g, srgb(10 / 255.0), srgb(10 / 255.0) * CODE_ERROR);
  EXPECT_NEAR(color.b, srgb(128 / 255.0), srgb(128 / 255.0) * CODE_ERROR);
  EXPECT_NEAR(color.a, 64 / 255.0, 64 / 255.0 * CODE_ERROR);
  EXPECT_NEAR(data.g, 10 / 255.0, 10 / 255.0 * CODE_ERROR);
  EXPECT_EQ(texel(scene, scene.textures[0], 1, 0).r, 1.0f);
}

TEST(SceneTexture, SixteenBitsSurvive) {
  Gltf file;
  // Two neighbours in 16 bit that 8 bit would not tell apart.
  const size_t texture = file.texture(make_png(2, 1, 3, 16, {0, 1000, 0, 0, 1010, 0}));
  file.triangle_of({{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", texture}}}}}});
  const Scene scene = file.load();
  EXPECT_EQ(scene.textures[0].flags & interface::TEXTURE_UNORM16, interface::TEXTURE_UNORM16);
  EXPECT_EQ(texel(scene, scene.textures[0], 0, 0).g, 1000 / 65535.0f);
  EXPECT_EQ(texel(scene, scene.textures[0], 1, 0).g, 1010 / 65535.0f);
  EXPECT_EQ(texel(scene, scene.textures[0], 1, 0).a, 1.0f);
  EXPECT_NE(find_features(scene).bits & interface::FEATURE_WIDE_TEXELS, 0u);
}

TEST(SceneTexture, SamplersSetWrapAndFilter) {
  Gltf file;
  const size_t texture = file.texture(make_png(1, 1, 3, 8, {1, 2, 3}),
                                      {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
  file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
  const Scene scene = file.load();
  EXPECT_EQ(scene.textures[0].flags, interface::TEXTURE_SRGB | interface::TEXTURE_WRAP_CLAMP |
                                         interface::TEXTURE_WRAP_MIRROR << interface::TEXTURE_WRAP_T_SHIFT |
                                         interface::TEXTURE_NEAREST);
}

TEST(SceneTexture, EvaluationWrapsAndInterpolates) {
  Scene scene;
  // One row of four texels 0, 1, 2, 3 in red.
  std::vector<uint32_t> words;
  for (const float value : {0.0f, 1.0f, 2.0f, 3.0f}) {
    words.push_back(glm::packHalf2x16({value, 0}));
    words.push_back(0);
  }
  scene.images = {words};
  const auto red = [&](uint32_t flags, float u) {
    flags |= interface::TEXTURE_HALF;
    return sample_texture(scene, interface::Texture{{}, 0, 4, 1, flags, {1, 0, 0}, {0, 1, 0}}, {{u, 0.5}}).r;
  };
  EXPECT_EQ(red(interface::TEXTURE_WRAP_REPEAT, 0.125f), 0.0f);  // centre of the first texel
  EXPECT_EQ(red(interface::TEXTURE_WRAP_REPEAT, 0.25f), 0.5f);   // between first and second
  EXPECT_EQ(red(interface::TEXTURE_WRAP_REPEAT, 1.0f), 1.5f);    // between last and first
  EXPECT_EQ(red(interface::TEXTURE_WRAP_REPEAT, -0.875f), 0.0f);
  EXPECT_EQ(red(interface::TEXTURE_WRAP_CLAMP, 2.0f), 3.0f);
  EXPECT_EQ(red(interface::TEXTURE_WRAP_MIRROR, 1.125f), 3.0f);
  EXPECT_EQ(red(interface::TEXTURE_WRAP_MIRROR, -0.375f), 1.0f);
  EXPECT_EQ(red(interface::TEXTURE_NEAREST, 0.26f), 1.0f);
}

TEST(SceneTexture, BrokenImagesNameTheirTexture) {
  const auto error_for = [](const Bytes& image) {
    Gltf file;
    const size_t texture = file.texture(image);
    file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
    return load_error(file);
  };
  EXPECT_NE(error_for({'G', 'I', 'F', '8'}).find("texture 0 image 0 is neither PNG, JPEG nor WebP"),
            std::string::npos);
  Bytes truncated = make_png(4, 4, 3, 8, std::vector<uint16_t>(48, 7));
  truncated.erase(truncated.end() - 40, truncated.end());
  EXPECT_NE(error_for(truncated).find("cannot be decoded"), std::string::npos) << error_for(truncated);
  const Bytes bomb = make_png(30000, 8000, 4, 8, {});
  EXPECT_NE(error_for(bomb).find("which cannot be"), std::string::npos) << error_for(bomb);
  const Bytes giant = make_png(60000, 60000, 4, 8, {});
  EXPECT_NE(error_for(giant).find("has no readable header or is too large"), std::string::npos)
      << error_for(giant);
  const Bytes large = make_png(20000, 20000, 1, 8, {});
  EXPECT_NE(error_for(large).find("the limit is"), std::string::npos) << error_for(large);
}

TEST(SceneFeatures, RoughnessTexturesAreSearchedForZero) {
  const auto features_of = [](uint16_t green, double factor) {
    Gltf file;
    const size_t texture = file.texture(make_png(2, 1, 3, 8, {0, 128, 0, 0, green, 0}));
    file.triangle_of({{"pbrMetallicRoughness",
                       {{"metallicRoughnessTexture", {{"index", texture}}}, {"roughnessFactor", factor}}}});
    return find_features(file.load()).bits &
           (interface::FEATURE_ROUGH_SPECULAR | interface::FEATURE_DELTA_SPECULAR);
  };
  EXPECT_EQ(features_of(128, 1), interface::FEATURE_ROUGH_SPECULAR);
  EXPECT_EQ(features_of(0, 1), interface::FEATURE_ROUGH_SPECULAR | interface::FEATURE_DELTA_SPECULAR);
  EXPECT_EQ(features_of(128, 0), interface::FEATURE_DELTA_SPECULAR);
}

// alpha = roughness^2; refraction by n = 1.5 counts a third of it.
TEST(SceneFeatures, TellTheSharpestLobes) {
  Gltf file;
  const size_t texture = file.texture(make_png(2, 1, 3, 8, {0, 255, 0, 0, 204, 0}));
  file.triangle_of({{"pbrMetallicRoughness",
                     {{"metallicRoughnessTexture", {{"index", texture}}}, {"roughnessFactor", 0.5}}}});
  EXPECT_NEAR(find_features(file.load()).least_reflection_alpha, 0.4 * 0.4, 1e-3);
  EXPECT_TRUE(std::isinf(find_features(file.load()).least_refraction_alpha));
  file.triangle_of({{"pbrMetallicRoughness", {{"roughnessFactor", 0.6}}},
                    {"extensions",
                     {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                      {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}});
  EXPECT_NEAR(find_features(file.load()).least_refraction_alpha, 0.36 / 3, 1e-6);
}

TEST(SceneFeatures, FollowTheScene) {
  const json matte = {{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                      {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}};
  Gltf file;
  file.triangle_of(matte);
  Scene scene = file.load();
  build_lights(scene);
  EXPECT_EQ(find_features(scene).bits, uint32_t{interface::FEATURE_ENVIRONMENT}) << "nothing else lights it";
  EXPECT_EQ(find_features(scene).material_classes, 1u << interface::MATERIAL_CLASS_DIFFUSE);

  json lamp = matte;
  lamp["emissiveFactor"] = {1, 1, 1};
  lamp["doubleSided"] = true;
  file.triangle_of(lamp);
  file.triangle_of(
      {{"pbrMetallicRoughness", {{"roughnessFactor", 0}}},
       {"extensions",
        {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
         {"KHR_materials_volume",
          {{"thicknessFactor", 1}, {"attenuationDistance", 1}, {"attenuationColor", {0.5, 1, 1}}}}}}});
  file.light({{"type", "directional"}});
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(std::vector<float>{0, 0, 1, 0, 1, 0, 0, 0, 1}, "VEC3", FLOAT);
  scene = file.load();
  build_lights(scene);
  // Along the edge from the second corner to the third, (-1, 1, 0), the normal turns by (0, -1, 1): they
  // spread.
  EXPECT_EQ(find_features(scene).bits,
            interface::FEATURE_TRIANGLE_LIGHTS | interface::FEATURE_TWO_SIDED_LIGHTS |
                interface::FEATURE_DIRECTIONAL_LIGHTS | interface::FEATURE_DELTA_SPECULAR |
                interface::FEATURE_ABSORPTION | interface::FEATURE_MANY_LIGHTS |
                interface::FEATURE_SMOOTH_NORMALS | interface::FEATURE_BULGES);
}

}  // namespace
}  // namespace regulus::scene::test

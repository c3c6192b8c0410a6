// Materials against the glTF specification and its extensions.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>

#include "interface/wavefront.h"
#include "scene/texture.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

using interface::INVALID_INDEX;

// Half of the spacing of halfs below 1, plus rounding of the float that is converted.
constexpr double HALF_ERROR = 0x1p-12 + 0x1p-24;

Scene load_material(const json& material) {
  Gltf file;
  file.triangle_of(material);
  return file.load();
}

json with_extension(const std::string& name, const json& content) {
  return {{"extensions", {{name, content}}}};
}

TEST(SceneMaterial, PrimitivesWithoutMaterialGetTheDefault) {
  Gltf file;
  file.triangle();
  const Scene scene = file.load();
  ASSERT_EQ(scene.materials.size(), 1u);
  const interface::Material& material = scene.materials[scene.triangles[0].material];
  EXPECT_EQ(material.base_color, glm::vec3(1));
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_EQ(material.roughness, 1.0f);
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_EQ(material.specular, 1.0f);
  EXPECT_EQ(material.flags, 0u);
  EXPECT_EQ(material.base_color_texture, INVALID_INDEX);
}

TEST(SceneMaterial, FactorsAreRead) {
  const Scene scene = load_material(
      {{"doubleSided", true},
       {"emissiveFactor", {0.5, 0, 1}},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.25, 0.5, 0.75, 1}}, {"metallicFactor", 0.125}, {"roughnessFactor", 0.375}}},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
         {"KHR_materials_ior", {{"ior", 1.25}}},
         {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 2, 3}}}}}}});
  const interface::Material& material = scene.materials[0];
  EXPECT_EQ(material.base_color, glm::vec3(0.25, 0.5, 0.75));
  EXPECT_EQ(material.metallic, 0.125f);
  EXPECT_EQ(material.roughness, 0.375f);
  EXPECT_EQ(material.emission, glm::vec3(4, 0, 8));
  EXPECT_EQ(material.ior, 1.25f);
  EXPECT_EQ(material.specular, 0.5f);
  EXPECT_EQ(material.specular_color, glm::vec3(1, 2, 3));
  EXPECT_EQ(material.flags, interface::MATERIAL_DOUBLE_SIDED | interface::MATERIAL_EMISSIVE);
}

TEST(SceneMaterial, SpecularReflectionIsTextured) {
  Gltf file;
  const json image = {{"index", file.texture(make_png(1, 1, 4, 8, {255, 0, 51, 128}))}};
  file.triangle_of(with_extension("KHR_materials_specular",
                                  {{"specularTexture", image}, {"specularColorTexture", image}}));
  const Scene scene = file.load();
  const interface::Material& material = scene.materials.at(0);
  const auto value = [&](uint32_t texture) {
    return sample_texture(scene, scene.textures.at(texture), {glm::dvec2(0.5)});
  };
  EXPECT_NEAR(value(material.specular_texture).a, 128 / 255.0, HALF_ERROR);
  // 51 / 255 = 0.2 is encoded: ((0.2 + 0.055) / 1.055)^2.4.
  EXPECT_NEAR(value(material.specular_color_texture).b, std::pow(0.255 / 1.055, 2.4), HALF_ERROR);
  EXPECT_NE(find_features(scene).bits & interface::FEATURE_SPECULAR_TEXTURES, 0u);
}

TEST(SceneMaterial, UnlitGlowsInItsBaseColourAndReflectsNothing) {
  Gltf file;
  const size_t texture = file.texture(make_png(1, 1, 3, 8, {255, 0, 0}));
  file.triangle_of(
      {{"extensions",
        {{"KHR_materials_unlit", json::object()},
         {"KHR_materials_transmission", {{"transmissionFactor", 1}}}}},
       {"emissiveFactor", {1, 1, 1}},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.25, 0.5, 0.75, 1}}, {"baseColorTexture", {{"index", texture}}}}}});
  file.root["extensionsRequired"] = {"KHR_materials_unlit"};
  const interface::Material material = file.load().materials.at(0);
  EXPECT_EQ(material.emission, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(material.emissive_texture, 0u);
  EXPECT_EQ(material.base_color_texture, interface::INVALID_INDEX);
  EXPECT_EQ(material.base_color, glm::vec3(0));
  EXPECT_EQ(material.material_class, interface::MATERIAL_CLASS_DIFFUSE);
  EXPECT_EQ(material.flags,
            interface::MATERIAL_DOUBLE_SIDED | interface::MATERIAL_EMISSIVE | interface::MATERIAL_UNLIT);
}

TEST(SceneMaterial, VolumesAttenuate) {
  const json transmission = {{"transmissionFactor", 1}};
  const auto volume = [&](const json& content) {
    return load_material(
               {{"extensions",
                 {{"KHR_materials_transmission", transmission}, {"KHR_materials_volume", content}}}})
        .materials[0];
  };
  const interface::Material solid = volume({{"thicknessFactor", 1},
                                            {"attenuationDistance", 0.5},
                                            {"attenuationColor", {std::exp(-1.0), 1, std::exp(-2.0)}}});
  EXPECT_EQ(solid.flags & interface::MATERIAL_VOLUME, interface::MATERIAL_VOLUME);
  // exp(-sigma d) = color: sigma = 1 / 0.5, 0, 2 / 0.5; the color was rounded to float.
  EXPECT_NEAR(solid.absorption.r, 2, 2 * 4 * std::numeric_limits<float>::epsilon());
  EXPECT_EQ(solid.absorption.g, 0.0f);
  EXPECT_NEAR(solid.absorption.b, 4, 4 * 4 * std::numeric_limits<float>::epsilon());

  const interface::Material thin =
      volume({{"attenuationDistance", 0.5}, {"attenuationColor", {0.5, 0.5, 0.5}}});
  EXPECT_EQ(thin.flags & interface::MATERIAL_VOLUME, 0u);
  EXPECT_EQ(thin.absorption, glm::vec3(0));

  const interface::Material black =
      volume({{"thicknessFactor", 1}, {"attenuationDistance", 1}, {"attenuationColor", {0, 0, 0}}});
  EXPECT_TRUE(std::isfinite(black.absorption.r));
  EXPECT_GT(black.absorption.r, 80.0f);
}

TEST(SceneMaterial, AttenuationOverNoDistanceIsRefused) {
  Gltf file;
  file.triangle_of(
      {{"name", "glass"},
       {"extensions", {{"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 0}}}}}});
  EXPECT_NE(load_error(file).find("material 0 'glass': attenuationDistance"), std::string::npos)
      << load_error(file);
}

TEST(SceneMaterial, ClassesNameTheLobes) {
  const auto class_of = [](json material, double metallic) {
    material["pbrMetallicRoughness"]["metallicFactor"] = metallic;
    return load_material(material).materials[0].material_class;
  };
  const json no_specular = with_extension("KHR_materials_specular", {{"specularFactor", 0}});
  const json ior_one = with_extension("KHR_materials_ior", {{"ior", 1}});
  const json glass = with_extension("KHR_materials_transmission", {{"transmissionFactor", 0.5}});
  EXPECT_EQ(class_of(json::object(), 0), interface::MATERIAL_CLASS_OPAQUE);
  EXPECT_EQ(class_of(no_specular, 0), interface::MATERIAL_CLASS_DIFFUSE);
  EXPECT_EQ(class_of(no_specular, 0.5), interface::MATERIAL_CLASS_OPAQUE);
  EXPECT_EQ(class_of(ior_one, 0), interface::MATERIAL_CLASS_DIFFUSE);
  EXPECT_EQ(class_of(glass, 0), interface::MATERIAL_CLASS_TRANSMISSIVE);
}

// Infinite indices reflect the specular colour at normal incidence: min(F_0 of the index * colour, 1).
TEST(SceneMaterial, InfiniteIorReflectsTheSpecularColor) {
  const auto reflectance_of = [](double ior) {
    const interface::Material material =
        load_material({{"extensions",
                        {{"KHR_materials_ior", {{"ior", ior}}},
                         {"KHR_materials_specular", {{"specularColorFactor", {0.04, 0.2, 1}}}}}}})
            .materials[0];
    const float x = (material.ior - 1) / (material.ior + 1);
    return glm::min(x * x * material.specular_color, glm::vec3(1));
  };
  const double of_1000 = std::pow(999.0 / 1001.0, 2);
  for (int i = 0; i < 3; ++i) {
    const double color = glm::dvec3(0.04, 0.2, 1)[i];
    EXPECT_NEAR(reflectance_of(0)[i], color, 1e-5 * color);
    EXPECT_NEAR(reflectance_of(1000)[i], of_1000 * color, 1e-5 * color);
  }
  const json transmitting = {{"KHR_materials_ior", {{"ior", 0}}},
                             {"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
  EXPECT_EQ(load_material({{"extensions", transmitting}}).materials[0].ior, 1e6f);
}

// KHR_materials_pbrSpecularGlossiness: F_0 = specular, roughness = 1 - glossiness, diffuse as base colour.
TEST(SceneMaterial, SpecularGlossinessIsConverted) {
  const json factors = {{"diffuseFactor", {0.25, 0.5, 0.75, 0.5}},
                        {"specularFactor", {0.04, 0.2, 1}},
                        {"glossinessFactor", 0.25}};
  json source = with_extension("KHR_materials_pbrSpecularGlossiness", factors);
  source["pbrMetallicRoughness"] = {{"baseColorFactor", {1, 0, 0, 1}}, {"roughnessFactor", 0.125}};
  source["alphaMode"] = "BLEND";
  const interface::Material material = load_material(source).materials[0];
  EXPECT_EQ(material.base_color, glm::vec3(0.25, 0.5, 0.75));
  EXPECT_EQ(material.alpha, 0.5f);
  EXPECT_EQ(material.metallic, 0.0f);
  EXPECT_EQ(material.roughness, 0.75f);
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_EQ(material.specular, 1.0f);
  EXPECT_LT(glm::length(material.specular_color - glm::vec3(1, 5, 25)), 25e-5);

  const interface::Material standard =
      load_material(with_extension("KHR_materials_pbrSpecularGlossiness", json::object())).materials[0];
  EXPECT_EQ(standard.roughness, 0.0f);
  EXPECT_EQ(standard.base_color, glm::vec3(1));
  EXPECT_NEAR(standard.specular_color.r, 25, 1e-4);

  source["extensions"]["KHR_materials_unlit"] = json::object();
  EXPECT_EQ(load_material(source).materials[0].emission, glm::vec3(1, 0, 0));
}

// RGB of the texture is the specular colour, sRGB, and alpha times the factor the glossiness, linear.
TEST(SceneMaterial, SpecularGlossinessTexturesAreSplit) {
  Gltf file;
  const size_t texture = file.texture(make_png(2, 1, 4, 8, {255, 128, 0, 51, 0, 0, 0, 255}));
  for (const double glossiness : {1.0, 0.5})
    file.triangle_of(with_extension(
        "KHR_materials_pbrSpecularGlossiness",
        {{"specularGlossinessTexture", {{"index", texture}}}, {"glossinessFactor", glossiness}}));
  const Scene scene = file.load();
  ASSERT_EQ(scene.images.size(), 3u);  // one colour, two roughnesses
  for (const size_t i : {0u, 1u}) {
    const interface::Material& material = scene.materials[i];
    const double factor = i == 0 ? 1 : 0.5;
    EXPECT_EQ(material.roughness, 1.0f);
    const auto roughness = [&](int64_t x) {
      return texel(scene, scene.textures[material.metallic_roughness_texture], x, 0).g;
    };
    EXPECT_NEAR(roughness(0), 1 - factor * 0.2, HALF_ERROR);
    EXPECT_NEAR(roughness(1), 1 - factor, HALF_ERROR);
    const glm::vec4 color = texel(scene, scene.textures[material.specular_color_texture], 0, 0);
    EXPECT_EQ(color.r, 1.0f);
    EXPECT_NEAR(color.g, std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 0.22 * 2 * HALF_ERROR);
    EXPECT_EQ(color.b, 0.0f);
  }
}

// Two primitives: the first has a material of its own in both variants, the second only in the second one.
TEST(SceneMaterial, VariantsChooseMaterialsByName) {
  Gltf file;
  file.root["extensionsUsed"] = file.root["extensionsRequired"] = {"KHR_materials_variants"};
  file.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "red"}}, {{"name", "blue"}}};
  for (int i = 0; i < 4; ++i) file.root["materials"].push_back(json::object());
  const auto mapped = [](size_t material, const json& mappings) {
    return json{{"material", material},
                {"extensions", {{"KHR_materials_variants", {{"mappings", mappings}}}}}};
  };
  file.triangle(mapped(0, {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1}}}}));
  file.triangle(mapped(0, {{{"material", 3}, {"variants", {1}}}}));
  const auto materials_of = [&](const std::string& variant) {
    LoadOptions options;
    options.variant = variant;
    const Scene scene = file.load(options);
    return glm::uvec2(scene.triangles[0].material, scene.triangles[1].material);
  };
  EXPECT_EQ(materials_of(""), glm::uvec2(0, 0));
  EXPECT_EQ(materials_of("red"), glm::uvec2(1, 0));
  EXPECT_EQ(materials_of("blue"), glm::uvec2(2, 3));
  EXPECT_EQ(file.load().inventory.variants, (std::vector<std::string>{"red", "blue"}));
  EXPECT_NE(error_of([&] { materials_of("green"); }).find("\"green\", choose one of [\"red\",\"blue\"]"),
            std::string::npos);
  file.root["scenes"][0]["extras"]["regulus"]["variant"] = "blue";
  EXPECT_EQ(materials_of(""), glm::uvec2(2, 3));
  EXPECT_EQ(materials_of("red"), glm::uvec2(1, 0));
  file.root["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["variants"] =
      {2};
  EXPECT_NE(load_error(file).find("variants/0 is 2, but there are 2 variants"), std::string::npos);
}

TEST(SceneMaterial, FactorsOutOfRangeAreClampedWithAWarning) {
  const Scene scene =
      load_material({{"pbrMetallicRoughness", {{"roughnessFactor", 1.5}, {"metallicFactor", -1}}}});
  EXPECT_EQ(scene.materials[0].roughness, 1.0f);
  EXPECT_EQ(scene.materials[0].metallic, 0.0f);
  EXPECT_TRUE(has_warning(scene, "roughnessFactor 1.5 is out of range; correct it (clamped to 1)"));
}

TEST(SceneMaterial, IgnoredPropertiesAreWarnedOf) {
  Gltf file;
  const size_t texture = file.texture(make_png(1, 1, 3, 8, {0, 0, 0}));
  file.triangle_of({{"alphaMode", "DITHER"}, {"normalTexture", {{"index", texture}}}});
  file.root["extensionsUsed"] = {"KHR_materials_diffuse_transmission"};
  const Scene scene = file.load();
  EXPECT_TRUE(has_warning(scene, "alphaMode 'DITHER'"));
  EXPECT_TRUE(has_warning(scene, "KHR_materials_diffuse_transmission"));
}

// Alpha is asked for where something is less than whole, by factor, texture or vertex.
TEST(SceneMaterial, AlphaIsDroppedWhereSurfacesAreWhole) {
  constexpr uint32_t ALPHA = interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND;
  const auto flags_of = [](const char* mode, double factor, uint16_t texel, double cutoff, double of_vertex) {
    Gltf file;
    const size_t texture = file.texture(make_png(1, 1, 4, 8, {255, 255, 255, texel}));
    file.root["materials"] = {
        {{"alphaMode", mode},
         {"alphaCutoff", cutoff},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {1, 1, 1, factor}}, {"baseColorTexture", {{"index", texture}}}}}}};
    const std::vector<float> colors = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, static_cast<float>(of_vertex)};
    file.triangle({{"material", 0},
                   {"attributes",
                    {{"POSITION", file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})},
                     {"COLOR_0", file.accessor(colors, "VEC4", FLOAT)}}}});
    return file.load().materials.at(0).flags & ALPHA;
  };
  EXPECT_EQ(flags_of("OPAQUE", 0.25, 51, 0.5, 0.5), 0u);
  EXPECT_EQ(flags_of("BLEND", 1, 255, 0.5, 1), 0u);
  EXPECT_EQ(flags_of("BLEND", 0.5, 255, 0.5, 1), interface::MATERIAL_ALPHA_BLEND);
  EXPECT_EQ(flags_of("BLEND", 1, 254, 0.5, 1), interface::MATERIAL_ALPHA_BLEND);
  EXPECT_EQ(flags_of("BLEND", 1, 255, 0.5, 0.5), interface::MATERIAL_ALPHA_BLEND);
  EXPECT_EQ(flags_of("MASK", 0.75, 204, 0.5, 1), 0u);  // 0.6 everywhere
  EXPECT_EQ(flags_of("MASK", 0.75, 102, 0.5, 1), interface::MATERIAL_ALPHA_MASK);
}

TEST(SceneMaterial, SheenIsReadAndMakesALobe) {
  const Scene scene = load_material(
      {{"extensions",
        {{"KHR_materials_sheen", {{"sheenColorFactor", {0.25, 0.5, 1}}, {"sheenRoughnessFactor", 0.3}}},
         {"KHR_materials_specular", {{"specularFactor", 0}}}}},
       {"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
  EXPECT_EQ(scene.materials[0].sheen_color, glm::vec3(0.25F, 0.5F, 1));
  EXPECT_EQ(scene.materials[0].sheen_roughness, 0.3F);
  EXPECT_EQ(scene.materials[0].material_class, interface::MATERIAL_CLASS_OPAQUE);
  EXPECT_NE(find_features(scene).bits & interface::FEATURE_SHEEN, 0U);
}

TEST(SceneMaterial, IridescenceIsReadWithItsDefaults) {
  const auto film = [](const nlohmann::json& members) {
    return load_material(
        {{"extensions",
          {{"KHR_materials_iridescence", members}, {"KHR_materials_specular", {{"specularFactor", 0}}}}},
         {"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
  };
  const Scene plain = film({{"iridescenceFactor", 0.5}});
  EXPECT_EQ(plain.materials[0].iridescence, 0.5F);
  EXPECT_EQ(plain.materials[0].iridescence_ior, 1.3F);
  EXPECT_EQ(plain.materials[0].iridescence_thickness, glm::vec2(100, 400));
  EXPECT_EQ(plain.materials[0].material_class, interface::MATERIAL_CLASS_OPAQUE);
  EXPECT_NE(find_features(plain).bits & interface::FEATURE_IRIDESCENCE, 0U);
  const Scene whole = film({{"iridescenceFactor", 1},
                            {"iridescenceIor", 1.8},
                            {"iridescenceThicknessMinimum", 700},
                            {"iridescenceThicknessMaximum", 1e30}});
  EXPECT_EQ(whole.materials[0].iridescence_ior, 1.8F);
  EXPECT_EQ(whole.materials[0].iridescence_thickness, glm::vec2(700, 1e5F));  // thicker ones look the same
  EXPECT_TRUE(whole.warnings.empty());
  const Scene none = film({{"iridescenceIor", 1.8}});
  EXPECT_EQ(none.materials[0].material_class, interface::MATERIAL_CLASS_DIFFUSE);
  EXPECT_EQ(find_features(none).bits & interface::FEATURE_IRIDESCENCE, 0U);
}

TEST(SceneMaterial, OnlySolidsDisperse) {
  const auto glass = [](double transmission, double thickness, double ior) {
    return load_material({{"extensions",
                           {{"KHR_materials_dispersion", {{"dispersion", 0.36}}},
                            {"KHR_materials_ior", {{"ior", ior}}},
                            {"KHR_materials_transmission", {{"transmissionFactor", transmission}}},
                            {"KHR_materials_volume", {{"thicknessFactor", thickness}}}}}});
  };
  const Scene diamond = glass(1, 1, 2.417);
  EXPECT_TRUE(diamond.warnings.empty());
  EXPECT_EQ(diamond.materials[0].dispersion, 0.36F);
  EXPECT_NE(find_features(diamond).bits & interface::FEATURE_DISPERSION, 0U);
  for (const Scene& scene : {glass(0, 1, 2.417), glass(1, 0, 2.417), glass(1, 1, 1)}) {
    EXPECT_EQ(scene.materials[0].dispersion, 0);
    EXPECT_EQ(find_features(scene).bits & interface::FEATURE_DISPERSION, 0U);
  }
  const Scene mended = load_material(with_extension("KHR_materials_dispersion", {{"dispersion", -1}}));
  EXPECT_TRUE(has_warning(mended, "dispersion -1 is out of range; correct it (clamped to 0)"));
  EXPECT_TRUE(has_warning(load_material(with_extension("KHR_materials_dispersion", {{"dispersion", "much"}})),
                          "dispersion"));
}

TEST(SceneMaterial, FaultyFilmsAreMendedOrRefused) {
  const auto film = [](const nlohmann::json& members) {
    return load_material({{"extensions", {{"KHR_materials_iridescence", members}}}});
  };
  const Scene mended =
      film({{"iridescenceFactor", 2}, {"iridescenceIor", 0.5}, {"iridescenceThicknessMaximum", -3}});
  EXPECT_EQ(mended.materials[0].iridescence, 1.0F);
  EXPECT_EQ(mended.materials[0].iridescence_ior, 1.0F);
  EXPECT_EQ(mended.materials[0].iridescence_thickness, glm::vec2(100, 0));
  EXPECT_TRUE(has_warning(mended, "iridescenceFactor 2 is out of range; correct it (clamped to 1)"));
  EXPECT_TRUE(has_warning(mended, "iridescenceIor 0.5 is out of range; correct it (clamped to 1)"));
  EXPECT_TRUE(
      has_warning(mended, "iridescenceThicknessMaximum -3 is out of range; correct it (clamped to 0)"));
  EXPECT_TRUE(has_warning(film({{"iridescenceIor", "glass"}}), "iridescenceIor"));
  EXPECT_TRUE(has_warning(film({{"iridescenceTexture", 3}}), "iridescenceTexture"));
}

}  // namespace
}  // namespace regulus::scene::test

// Images that are missing or cannot be decoded: what stands for them, by the role of their texture.
#include <gtest/gtest.h>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

using interface::INVALID_INDEX;

/// The one material of a file whose texture 0 shows a file that is not there.
struct Loaded {
  Scene scene;
  const interface::Material& material() const { return scene.materials.at(0); }
};

Loaded without_image(json material, const std::string& shown) {
  Gltf file;
  file.root["images"] = {{{"uri", "gone.png"}}};
  file.root["textures"] = {{{"source", 0}}};
  file.triangle_of(std::move(material));
  Loaded loaded{file.load()};
  bool is_said = false;
  std::string all;
  for (const std::string& warning : loaded.scene.warnings) {
    is_said |= warning.find("texture 0 image 0: '") != std::string::npos &&
               warning.find("gone.png': no such file; check the path (" + shown + ")") != std::string::npos;
    all += warning + "\n";
  }
  EXPECT_TRUE(is_said) << "of: " << all;
  EXPECT_NE(load_error(file).find("gone.png': no such file"), std::string::npos) << load_error(file);
  EXPECT_TRUE(loaded.scene.textures.empty());
  return loaded;
}

const json TEXTURE = {{"index", 0}};

TEST(SceneMissingImages, BaseColourIsItsFactor) {
  const Loaded loaded = without_image(
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {0.25, 0.5, 0.75, 0.5}}, {"baseColorTexture", TEXTURE}, {"metallicFactor", 0}}}},
      "base colour by its factor");
  EXPECT_EQ(loaded.material().base_color, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(loaded.material().base_color_texture, INVALID_INDEX);
}

TEST(SceneMissingImages, AlphaIsItsFactor) {
  const Loaded loaded = without_image(
      {{"alphaMode", "BLEND"},
       {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}, {"baseColorTexture", TEXTURE}}}},
      "base colour and alpha by their factors");
  EXPECT_EQ(loaded.material().alpha, 0.5f);
  EXPECT_EQ(loaded.material().alpha_texture, INVALID_INDEX);
}

TEST(SceneMissingImages, SurfacesAreNoMetal) {
  const Loaded loaded = without_image(
      {{"pbrMetallicRoughness", {{"metallicRoughnessTexture", TEXTURE}, {"roughnessFactor", 0.5}}}},
      "roughness by its factor, no metal");
  EXPECT_EQ(loaded.material().metallic, 0.0f);
  EXPECT_EQ(loaded.material().roughness, 0.5f);
}

TEST(SceneMissingImages, NothingGlows) {
  const Loaded loaded =
      without_image({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", TEXTURE}}, "no emission");
  EXPECT_EQ(loaded.material().emission, glm::vec3(0));
  EXPECT_EQ(loaded.material().flags & interface::MATERIAL_EMISSIVE, 0u);
}

TEST(SceneMissingImages, UnlitSurfacesGlowByTheirFactor) {
  const Loaded loaded = without_image(
      {{"extensions", {{"KHR_materials_unlit", json::object()}}},
       {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"baseColorTexture", TEXTURE}}}},
      "base colour by its factor");
  EXPECT_EQ(loaded.material().emission, glm::vec3(0.5f));
}

TEST(SceneMissingImages, NormalsAreTheVertices) {
  const Loaded loaded = without_image({{"normalTexture", TEXTURE}}, "no bumps");
  EXPECT_EQ(loaded.material().normal_texture, INVALID_INDEX);
}

TEST(SceneMissingImages, LobesOfExtensionsAreLeftOut) {
  const auto material = [](const char* extension, json members) {
    return json{{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                {"extensions", {{extension, std::move(members)}}}};
  };
  const Loaded glass = without_image(
      material("KHR_materials_transmission", {{"transmissionFactor", 1}, {"transmissionTexture", TEXTURE}}),
      "no transmission");
  EXPECT_EQ(glass.material().transmission, 0.0f);
  EXPECT_EQ(glass.material().material_class, interface::MATERIAL_CLASS_OPAQUE);
  const Loaded coat = without_image(
      material("KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatTexture", TEXTURE}}),
      "no clearcoat");
  EXPECT_EQ(coat.material().clearcoat, 0.0f);
  const Loaded brushed = without_image(
      material("KHR_materials_anisotropy", {{"anisotropyStrength", 1}, {"anisotropyTexture", TEXTURE}}),
      "no anisotropy");
  EXPECT_EQ(brushed.material().anisotropy, 0.0f);
  const Loaded specular = without_image(
      material("KHR_materials_specular", {{"specularFactor", 0.5}, {"specularTexture", TEXTURE}}),
      "specular by its factor");
  EXPECT_EQ(specular.material().specular, 0.5f);
  without_image(material("KHR_materials_specular", {{"specularColorTexture", TEXTURE}}),
                "specular colour by its factor");
  without_image(
      material("KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatRoughnessTexture", TEXTURE}}),
      "the clearcoat's roughness by its factor");
  without_image(
      material("KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", TEXTURE}}),
      "no bumps of the clearcoat");
}

TEST(SceneMissingImages, OneTextureIsMissingWhereverItIsUsed) {
  Gltf file;
  file.root["images"] = {{{"uri", "gone.png"}}};
  file.root["textures"] = {{{"source", 0}}};
  for (int i = 0; i < 2; ++i) file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", TEXTURE}}}});
  const Scene scene = file.load();
  for (const interface::Material& material : scene.materials)
    EXPECT_EQ(material.base_color_texture, INVALID_INDEX);
}

TEST(SceneMissingImages, OtherFaultsOfImagesAreTheSame) {
  const auto shown = [](const json& image, const json& texture, const std::string& fault) {
    Gltf file;
    file.root["images"] = {image};
    file.root["textures"] = {texture};
    file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", TEXTURE}}}});
    const Scene scene = file.load();
    EXPECT_EQ(scene.materials.at(0).base_color_texture, INVALID_INDEX);
    EXPECT_TRUE(has_warning(scene, fault)) << fault << " not in " << json(scene.warnings).dump();
    EXPECT_NE(load_error(file).find(fault), std::string::npos) << load_error(file);
  };
  const json source = {{"source", 0}};
  shown({{"uri", "data:image/png;base64,AAAA"}}, source, "is neither PNG, JPEG nor WebP");
  shown(json::object(), source, "has neither uri nor bufferView");
  shown({{"bufferView", 99}}, source, "images/0/bufferView is 99");
  shown({{"uri", "x.png"}}, json::object(), "texture 0 has no PNG, JPEG or WebP image");
  shown({{"uri", "x.png"}}, {{"source", 5}}, "textures/0/source is 5");
  shown({{"uri", "http://example.org/x.png"}}, source, "cannot read 'http' URIs");
}

// KTX2 is not read: a plain image beside it stands for it, or it is missing; where the file cannot do without
// the extension it is refused.
TEST(SceneMissingImages, Ktx2IsNamed) {
  Gltf file;
  const json only_ktx2 = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  file.root["extensionsUsed"] = {"KHR_texture_basisu"};
  file.root["images"] = {{{"uri", "wood.ktx2"}}};
  file.root["textures"] = {only_ktx2};
  file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", TEXTURE}}}});
  const Scene scene = file.load();
  EXPECT_EQ(scene.materials.at(0).base_color_texture, INVALID_INDEX);
  const std::string note = "textures are read from PNG, JPEG and WebP files, not from KTX2";
  EXPECT_TRUE(has_warning(scene, "extension KHR_texture_basisu is not read: " + note));
  EXPECT_TRUE(has_warning(scene, "texture 0 has no PNG, JPEG or WebP image"));

  json with_plain = only_ktx2;
  with_plain["source"] = 1;
  file.root["textures"] = {with_plain};
  file.root["images"].push_back({{"uri", "plain.png"}});
  EXPECT_TRUE(has_warning(file.load(), "plain.png': no such file")) << "what is looked for";

  file.root["extensionsRequired"] = {"KHR_texture_basisu"};
  EXPECT_NE(load_error(file).find(
                "requires the extension KHR_texture_basisu, which is not read; export without it: " + note),
            std::string::npos)
      << load_error(file);
}

}  // namespace
}  // namespace regulus::scene::test

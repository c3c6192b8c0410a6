// Cryptomattes, decoded by their manifests, against the shares of pixels that geometry gives.
#include "render/cryptomatte.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "check/reference_render.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using Plane = std::vector<float>;

constexpr uint32_t SIDE = 8;
constexpr float EDGE = 3.3F;  // pixels from the left: here one wall ends and the other begins

/// Left and right wall, of one mesh material each; the upper half of the film sees neither.
std::filesystem::path write_walls(const TemporaryFolder& folder) {
  GltfScene scene;
  const double left = EDGE / SIDE * 2 - 1;
  scene.add({quad({-1, -1, 0}, {left + 1, 0, 0}, {0, 1, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({left, -1, 0}, {1 - left, 0, 0}, {0, 1, 0})}, lambert({0.2, 0.2, 0.2}));
  scene.set_orthographic(look_at({0, 0, 2}, {0, 0, 0}), 1, 1);
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  scene.write(folder / "plain.gltf");
  nlohmann::json gltf = nlohmann::json::parse(std::ifstream(folder / "plain.gltf"));
  gltf["nodes"][0]["name"] = "left wall";
  gltf["nodes"][1]["name"] = "W\u00e4nde/\"rechts\"";
  gltf["materials"][0]["name"] = "plaster";
  std::ofstream(folder / "walls.gltf") << gltf;
  return folder / "walls.gltf";
}

/// The share of each pixel that a name has: the sum of the coverages whose id is its hash in the manifest.
Plane decode(const image::Channels& channels, const std::string& matte, const nlohmann::json& manifest,
             const std::string& name) {
  const auto id = static_cast<uint32_t>(std::stoul(manifest.at(name).get<std::string>(), nullptr, 16));
  Plane share(SIDE * SIDE);
  for (const char* level : {"00", "01", "02"})
    for (const auto& [hash, coverage] : {std::pair(".R", ".G"), std::pair(".B", ".A")}) {
      const auto& ids = std::get<Plane>(channels.at(matte + level + hash));
      const auto& shares = std::get<Plane>(channels.at(matte + level + coverage));
      for (size_t i = 0; i < share.size(); ++i)
        if (std::bit_cast<uint32_t>(ids[i]) == id && shares[i] > 0) share[i] += shares[i];
    }
  return share;
}

/// Entry of the only matte of that name.
std::string entry(const image::Attributes& attributes, const std::string& matte, const std::string& what) {
  for (const auto& [key, value] : attributes)
    if (key.starts_with("cryptomatte/") && key.ends_with("/name") && value == matte)
      return attributes.at(key.substr(0, key.size() - 4) + what);
  throw std::runtime_error("no cryptomatte " + matte);
}

// The hashes that Psyop's own tests name.
TEST(Cryptomatte, HashesAreThoseOfTheSpecification) {
  EXPECT_EQ(render::murmur3(""), 0u);
  EXPECT_EQ(render::murmur3("hello"), 0x248bfa47u);
  EXPECT_EQ(render::murmur3("hello, world"), 0x149bbb7fu);
  EXPECT_FLOAT_EQ(render::cryptomatte_id("hello"), 6.0705627102400005616e-17F);
  EXPECT_FLOAT_EQ(render::cryptomatte_id("cube"), -4.08461912519e+15F);
  EXPECT_FLOAT_EQ(render::cryptomatte_id("sphere"), 2.79018604383e+15F);
  EXPECT_FLOAT_EQ(render::cryptomatte_id("plane"), 3.66557617593e-11F);
  for (int i = 0; i < 100'000; ++i)
    ASSERT_TRUE(std::isnormal(render::cryptomatte_id("object " + std::to_string(i)))) << i;
}

TEST(Cryptomatte, SharesAreThoseOfTheWalls) {
  const TemporaryFolder folder;
  const PreparedScene prepared = prepare(write_walls(folder));
  render::RenderSettings settings = box_filtered(SIDE, SIDE, 1, 2);
  settings.aovs = render::CRYPTO_AOVS;
  const render::Plan plan = make_plan(prepared, settings);
  std::vector<image::Channels> all = {
      check::render_with_reference(prepared, plan, [](uint64_t, uint64_t) { return true; }).channels};
  if (device() != nullptr) {
    render::Renderer renderer(*device(), prepared, plan);
    renderer.surface_aovs();
    render::add_cryptomattes(prepared.scene, renderer.ray_ids(), plan.aovs, all.emplace_back());
    EXPECT_TRUE(all[0] == all[1]) << "device and reference";
  }
  image::Attributes attributes;
  render::add_cryptomatte_attributes(prepared.scene, plan.aovs, attributes);
  EXPECT_EQ(entry(attributes, "CryptoObject", "hash"), "MurmurHash3_32");
  EXPECT_EQ(entry(attributes, "CryptoObject", "conversion"), "uint32_to_float32");
  const auto objects = nlohmann::json::parse(entry(attributes, "CryptoObject", "manifest"));
  const auto materials = nlohmann::json::parse(entry(attributes, "CryptoMaterial", "manifest"));
  EXPECT_EQ(objects.size(), 2u) << "nodes without a mesh are no objects";
  for (const image::Channels& channels : all) {
    const Plane left = decode(channels, "CryptoObject", objects, "left wall"),
                right = decode(channels, "CryptoObject", objects, "W\u00e4nde/\"rechts\"");
    EXPECT_EQ(decode(channels, "CryptoMaterial", materials, "plaster"), left);
    EXPECT_EQ(decode(channels, "CryptoMaterial", materials, "material 1"), right);
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
      const float column = static_cast<float>(i % SIDE);
      const float share = i / SIDE < SIDE / 2 ? 0 : std::clamp(EDGE - column, 0.0F, 1.0F);
      // Of 16 Sobol points of two dimensions one lies in each sixteenth of a side.
      EXPECT_NEAR(left[i], share, 1.0F / 16) << i;
      EXPECT_EQ(left[i] + right[i], i / SIDE < SIDE / 2 ? 0 : 1) << i;
    }
    // The larger share comes first.
    EXPECT_GT(std::get<Plane>(channels.at("CryptoObject00.G"))[7 * SIDE + 3], 0.5F);
    EXPECT_LT(std::get<Plane>(channels.at("CryptoObject00.A"))[7 * SIDE + 3], 0.5F);
  }
}

}  // namespace
}  // namespace regulus::test

// What Nuke, Blender and tev make of the names of a picture's channels, by the rules of their sources.
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <map>
#include <set>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "render/aov.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;
using Names = std::set<std::string>;

Names parts_of(const std::string& name) {
  Names parts;
  for (size_t begin = 0; begin <= name.size();) {
    const size_t end = std::min(name.find('.', begin), name.size());
    parts.insert(name.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// Layers (what is before the last dot, "" for none) and their components.
std::map<std::string, Names> layers_of(const image::Channels& channels) {
  std::map<std::string, Names> layers;
  for (const auto& [name, values] : channels) {
    const size_t dot = name.rfind('.');
    if (dot == std::string::npos)
      layers[""].insert(name);
    else
      layers[name.substr(0, dot)].insert(name.substr(dot + 1));
  }
  return layers;
}

class ChannelNames : public testing::Test {
 protected:
  // With every channel there is, of lamps with a short name, one that begins with a digit, and two long ones
  // that differ at the end and where a letter of two bytes would be cut.
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    GltfScene scene;
    scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
    scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
    for (int lamp = 0; lamp < 4; ++lamp) scene.add_point_light({0.1 * lamp, 0, 1}, {1, 1, 1});
    scene.write(file("plain.gltf"));
    json gltf = json::parse(std::ifstream(file("plain.gltf")));
    const std::string names[] = {"Key", "2nd lamp.left", std::string(54, 'a') + "b",
                                 std::string(54, 'a') + "\u00f6"};
    size_t lamp = 0;
    for (json& node : gltf["nodes"])
      if (node.contains("extensions")) node["name"] = names[lamp++];
    ASSERT_EQ(lamp, 4u);
    std::ofstream(file("scene.gltf")) << gltf;
    std::string all;
    for (const std::string& aov : render::known_aovs()) all += (all.empty() ? "" : ",") + aov;
    const Finished finished = run({"render", file("scene.gltf"), "-o", file("all.exr"), "--size", "4x4", "-s",
                                   "2", "--aov", all, "--quiet"});
    ASSERT_EQ(finished.status, 0) << finished.err;
    channels_ = image::read_exr_contents(file("all.exr")).channels;
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  TemporaryFolder folder_;
  image::Channels channels_;
};

// Nuke (ExrChannelNameToNuke.cpp of its developers' kit): digits at the beginning of a part go away, what is
// no letter and no digit becomes an underscore, and all parts but the last are joined to the layer's name.
// Names that this leaves alone are what its menus show.
TEST_F(ChannelNames, NukeChangesNone) {
  for (const auto& [name, values] : channels_) {
    EXPECT_LE(std::ranges::count(name, '.'), 1) << name;
    for (const std::string& part : parts_of(name)) {
      EXPECT_TRUE(!part.empty() && std::isdigit(static_cast<unsigned char>(part[0])) == 0) << name;
      for (const char c : part)
        EXPECT_TRUE(std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || (c & 0x80) != 0) << name;
    }
  }
}

// Blender (openexr_api.cpp of its imbuf): buffers of 64 bytes; R, G, B without a layer are the pass Combined,
// and a Z without an X and Y is Depth; three or four components are a colour if there is a B, a vector if
// there is a Y, and nothing else has a known order.
TEST_F(ChannelNames, BlenderFindsColorsVectorsAndDepth) {
  for (const auto& [name, values] : channels_) EXPECT_LE(name.size(), 63u) << name;
  for (const auto& [layer, components] : layers_of(channels_)) {
    if (layer.empty() || components.size() < 3) continue;
    const bool is_known = components == Names{"R", "G", "B"} || components == Names{"R", "G", "B", "A"} ||
                          components == Names{"X", "Y", "Z"};
    EXPECT_TRUE(is_known) << layer;
  }
  const Names plain = layers_of(channels_).at("");
  for (const char* name : {"R", "G", "B", "Z"}) EXPECT_TRUE(plain.contains(name)) << name;
  EXPECT_FALSE(plain.contains("X") || plain.contains("Y"));
}

// tev (getGroupedChannels of its Image.cpp): R, G, B of a layer and X, Y, Z of one are a group, in this
// order; of the rest each channel is one.
TEST_F(ChannelNames, TevGroupsThem) {
  const std::map<std::string, Names> layers = layers_of(channels_);
  for (const char* colors : {"albedo", "variance", "emission", "direct", "caustics", "indirect", "light_Key"})
    EXPECT_EQ(layers.at(colors), (Names{"R", "G", "B"})) << colors;
  for (const char* vectors : {"N", "Ng", "P"})
    EXPECT_EQ(layers.at(vectors), (Names{"X", "Y", "Z"})) << vectors;
  EXPECT_EQ(layers.at("sigma"), (Names{"angle", "position"}));
}

TEST_F(ChannelNames, LampsThatTheNamesTellApartAre) {
  Names lamps;
  for (const auto& [layer, components] : layers_of(channels_))
    if (layer.starts_with("light_")) lamps.insert(layer);
  const std::string same = "light_" + std::string(54, 'a');
  EXPECT_EQ(lamps, (Names{"light_Key", "light_2nd_lamp_left", same, same + "b"}));
}

}  // namespace
}  // namespace regulus::test

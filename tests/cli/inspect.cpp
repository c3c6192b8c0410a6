// regulus inspect as a user runs it, against what is counted in the file itself.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "images/support/render_scene.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;

json read_json(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return json::parse(stream);
}

std::set<std::string> names(const json& array) {
  return array.get<std::set<std::string>>();
}

json inspected(const std::string& scene) {
  const TemporaryFolder folder;
  const std::string file = (folder / "inspect.json").string();
  const Finished finished = run({"inspect", scene, "--json", file});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_GE(count_lines(finished.out), 10u);
  return read_json(file);
}

// Cornell: two spheres, a mirror and a glass one, a lamp of two triangles, no textures.
TEST(Inspect, CountsWhatTheFileHolds) {
  const std::string path = (own_scenes() / "cornell" / "cornell.gltf").string();
  const json file = read_json(path), scene = inspected(path);
  uint64_t triangles = 0, instances = 0;
  for (const json& node : file["nodes"]) {
    if (!node.contains("mesh")) continue;
    ++instances;
    for (const json& primitive : file["meshes"][node["mesh"].get<size_t>()]["primitives"])
      triangles += file["accessors"][primitive["indices"].get<size_t>()]["count"].get<uint64_t>() / 3;
  }
  EXPECT_EQ(scene["triangles"], triangles);
  EXPECT_EQ(scene["instances"], instances);
  EXPECT_EQ(scene["meshes"], file["meshes"].size());
  EXPECT_EQ(scene["materials"].size(), file["materials"].size());
  EXPECT_EQ(names(scene["extensions"]["read"]), names(file["extensionsUsed"]));
  EXPECT_TRUE(scene["extensions"]["ignored"].empty());
  EXPECT_EQ(scene["lights"]["triangle"], 2);
  EXPECT_EQ(scene["lights"]["point"], 0);
  EXPECT_EQ(scene["textures"], 0);
  uint64_t total = 0;
  for (const auto& [part, bytes] : scene["bytes"].items())
    if (part != "total") total += bytes.get<uint64_t>();
  EXPECT_EQ(scene["bytes"]["total"], total);
  EXPECT_GE(scene["bytes"]["geometry"].get<uint64_t>(), triangles * 24);  // three indices at the least
  EXPECT_EQ(names(scene["features"]["present"]),
            (std::set<std::string>{"bulges", "triangle_lights", "delta_specular", "many_lights",
                                   "smooth_normals"}));
  EXPECT_TRUE(scene["features"]["absent"].contains("textures"));
  EXPECT_EQ(scene["regularization"]["used"], true);
}

// A diffuse quad under a point light: nothing specular, so the stages of those classes are skipped.
TEST(Inspect, NamesTheStagesThatAreSkipped) {
  const TemporaryFolder folder;
  GltfScene scene;
  scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  scene.write((folder / "scene.gltf").string());
  const json result = inspected((folder / "scene.gltf").string());
  const auto run_stages = names(result["stages"]["run"]), skipped = names(result["stages"]["skipped"]);
  EXPECT_TRUE(run_stages.contains("camera_bounce.diffuse"));
  EXPECT_TRUE(skipped.contains("camera_bounce.opaque"));
  EXPECT_TRUE(skipped.contains("camera_bounce.transmissive"));
  EXPECT_EQ(names(result["features"]["present"]), std::set<std::string>{"point_lights"});
  EXPECT_EQ(result["lights"]["point"], 1);
  EXPECT_EQ(result["regularization"]["used"], false);
  EXPECT_EQ(result["regularization"]["why"], "dropped: no surface has a microfacet lobe");
  EXPECT_EQ(result["cameras"].size(), 1u);
  EXPECT_EQ(result["cameras"][0]["from_file"], false);
}

TEST(Inspect, ReportsABrokenFileInOneLine) {
  const TemporaryFolder folder;
  std::ofstream(folder / "broken.gltf") << "{";
  expect_error(run({"inspect", (folder / "broken.gltf").string()}), 3, {"broken.gltf"});
  expect_error(run({"inspect", (folder / "missing.gltf").string()}), 3, {"missing.gltf"});
  EXPECT_EQ(run({"inspect"}).status, 2);
}

// The same radius whatever is rendered of the picture, in the header with its rule as inspect says it. A wall
// of 2 m fills the orthographic picture; half of its points lie within 2 / sqrt(2 pi) m of the middle.
TEST(Inspect, MergeRadiusIsThatOfTheWholePicture) {
  const TemporaryFolder folder;
  const std::string gltf = (folder / "wall.gltf").string(), exr = (folder / "wall.exr").string();
  GltfScene wall;
  wall.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
  wall.add_point_light({0, 0, 1}, {1, 1, 1});
  wall.set_orthographic(look_at({0, 0, 2}, {0, 0, 0}), 1, 1);
  wall.write(gltf);
  const json scene = inspected(gltf);
  EXPECT_FLOAT_EQ(scene["merge_radius"]["metres"].get<float>(), 0.002F);
  const auto radius = [&](Arguments more, const std::string& rule) {
    Arguments arguments = {"render", gltf, "-o", exr, "-i", "vcm", "--backend", "reference"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished finished = run(arguments);
    EXPECT_EQ(finished.status, 0) << finished.err;
    image::Attributes attributes;
    image::read_exr(exr, &attributes);
    EXPECT_EQ(attributes["regulus:merge_radius_rule"], rule);
    return std::pair(std::stof(attributes["regulus:merge_radius"]), finished.err);
  };
  const auto rule = scene["merge_radius"]["rule"].get<std::string>();
  for (const Arguments& more :
       {Arguments{"--size", "4x4", "-s", "1"},
        {"--size", "9x5", "-s", "2", "--seed", "7"},
        {"--size", "8x8", "-s", "1", "--crop", "0,0,2,1", "--max-depth", "3", "--light-paths", "10"}})
    EXPECT_FLOAT_EQ(radius(more, rule).first, 0.002F);
  const auto [clamped, warning] = radius({"--size", "4x4", "-s", "1", "--merge-radius", "1e3"},
                                         "given, clamped to 10 % of the extent seen");
  EXPECT_NEAR(clamped, 0.1 * 2 / std::sqrt(2 * M_PI), 0.1 * 2.0 / 32);
  EXPECT_NEAR(radius({"--size", "4x4", "-s", "1", "--merge-radius", "5%"}, "given").first, 0.5 * clamped,
              0.005 * clamped);
  EXPECT_EQ(count_lines(warning), 1u);
  EXPECT_NE(warning.find("merge radius 1000 m"), std::string::npos) << warning;
}

// Names of a file say nothing to the terminal but themselves.
TEST(Inspect, ControlCharactersAreWrittenOut) {
  const TemporaryFolder folder;
  const std::string evil =
      "\x1b]0;owned\x07\xc2\x9b"
      "2J";
  GltfScene scene;
  json material = lambert({0.5, 0.5, 0.5});
  material["name"] = evil;
  scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, material);
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  const std::string path = (folder / "scene.gltf").string();
  scene.write(path);
  json document = read_json(path);
  document["extensionsUsed"].push_back("EXT_" + evil);
  document["scenes"][0]["extras"]["regulus"][evil] = 1;
  document["scenes"][0]["extras"]["regulus"]["camera"] = evil;
  std::ofstream(path) << document.dump();
  for (const Arguments& arguments :
       {Arguments{"inspect", path}, Arguments{"render", path, "--backend", "reference"},
        Arguments{"inspect", path + evil}}) {
    const Finished finished = run(arguments);
    for (const std::string& text : {finished.out, finished.err})
      for (const char* control : {"\x1b", "\x07", "\xc2\x9b"})
        EXPECT_EQ(text.find(control), std::string::npos) << arguments[0];
    EXPECT_NE((finished.out + finished.err).find("\\x1b]0;owned\\x07"), std::string::npos) << finished.err;
  }
}

TEST(Inspect, MemoryThatIsNotAllowedIsRefusedWithBothNumbers) {
  const TemporaryFolder folder;
  GltfScene scene;
  scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.write(folder / "scene.gltf");
  const std::string path = (folder / "scene.gltf").string();
  expect_error(run({"inspect", path, "--memory", "1K"}), 3,
               {"scene.gltf", "needs", "but 0.0 MiB of memory are allowed"});
  EXPECT_EQ(run({"inspect", path, "--memory", "1G"}).status, 0);
  for (const char* size : {"0", "-1", "much", "4X"})
    EXPECT_EQ(run({"inspect", path, "--memory", size}).status, 2) << size;
}

}  // namespace
}  // namespace regulus::test

// Small files that claim to be enormous or nest without end: a clean error, soon and without the memory.
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "../unit/scene_files.hpp"

namespace regulus::scene::test {
namespace {

// Processor time of one load (a busy machine does not count), sanitizers included.
constexpr double MAX_SECONDS = 5;

std::string timed_error(const std::function<void()>& action) {
  const std::clock_t start = std::clock();
  std::string error = error_of(action);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%.3f s (bound %.0f): %s\n", seconds, MAX_SECONDS, error.substr(0, 160).c_str());
  EXPECT_LT(seconds, MAX_SECONDS);
  return error;
}

std::string text_error(const std::string& text) {
  const TemporaryFolder folder;
  const auto path = folder.write("bomb.gltf", text);
  return timed_error([&] { load(path); });
}

TEST(SceneBombs, AccessorsThatClaimMoreThanTheirBytes) {
  for (const uint64_t count : {uint64_t{1000000000000}, uint64_t{4294967295}, uint64_t{9007199254740992}}) {
    Gltf file;
    file.triangle();
    file.root["accessors"][0]["count"] = count;
    EXPECT_NE(text_error(file.root.dump()), "");
    file.root["accessors"][0].erase("bufferView");
    EXPECT_NE(text_error(file.root.dump()), "");
  }
}

TEST(SceneBombs, OffsetsThatOverflow) {
  Gltf file;
  file.triangle();
  file.root["accessors"][0]["byteOffset"] = uint64_t{9007199254740991};
  EXPECT_NE(text_error(file.root.dump()), "");
  Gltf view;
  view.triangle();
  view.root["bufferViews"][0]["byteOffset"] = uint64_t{9007199254740991};
  EXPECT_NE(text_error(view.root.dump()), "");
  Gltf huge;
  huge.triangle();
  huge.root["bufferViews"][0]["byteLength"] = 18446744073709551615u;
  EXPECT_NE(text_error(huge.root.dump()), "");
}

TEST(SceneBombs, ZerosWithoutDataAreNoScene) {
  Gltf file;
  file.root["accessors"].push_back({{"componentType", FLOAT}, {"type", "VEC3"}, {"count", 4000000}});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}})}});
  EXPECT_NE(text_error(file.root.dump()).find("no triangle"), std::string::npos);
}

TEST(SceneBombs, InstancesThatMultiplyBeyondMemory) {
  Gltf file;
  const std::vector<uint32_t> indices(300000, 0);
  const size_t accessor = file.accessor(indices, "SCALAR", UNSIGNED_INT);
  const json primitive = {{"attributes", {{"POSITION", file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}}},
                          {"indices", accessor}};
  file.mesh(primitive);
  for (int i = 0; i < 30000; ++i) file.node({{"mesh", 0}});
  EXPECT_NE(text_error(file.root.dump()), "");
}

TEST(SceneBombs, DeepJsonDoesNotOverflowTheStack) {
  const size_t depth = 1000000;
  EXPECT_NE(text_error(std::string(depth, '[')), "");
  EXPECT_NE(text_error("{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(depth, '[') +
                       std::string(depth, ']') + "}"),
            "");
  std::string objects = "{\"asset\":{\"version\":\"2.0\"}";
  for (size_t i = 0; i < depth; ++i) objects += ",\"a\":{\"a\":0";
  EXPECT_NE(text_error(objects), "");
}

TEST(SceneBombs, DeepNodesDoNotOverflowTheStack) {
  const int depth = 200000;
  Gltf file;
  file.triangle();
  json nodes = json::array();
  for (int i = 0; i < depth; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  file.root["nodes"] = nodes;
  file.root["scenes"][0]["nodes"] = {0};
  EXPECT_EQ(text_error(file.root.dump()), "");
  file.root["nodes"].back()["children"] = {0};
  EXPECT_NE(text_error(file.root.dump()).find("its own ancestor"), std::string::npos);
}

TEST(SceneBombs, NumbersBeyondDoubleAreAnError) {
  EXPECT_NE(text_error("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"translation\":[1e999,0,0]}]}"), "");
  Gltf file;
  file.triangle({}, {{"scale", {1e300, 1e300, 1e300}}});
  EXPECT_NE(text_error(file.root.dump()).find("not finite"), std::string::npos);
}

TEST(SceneBombs, TextThatIsNoGltf) {
  for (const char* text : {"", "{", "[]", "null", "42", "glTF", "{}", "{\"asset\":7}",
                           "{\"asset\":{\"version\":2}}", "\xff\xfe"})
    EXPECT_NE(text_error(text), "") << text;
}

}  // namespace
}  // namespace regulus::scene::test

// Small files that claim to be enormous or nest without end: a clean error, soon and without the memory.
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "../support/sanitizers.hpp"
#include "../unit/scene_files.hpp"
#include "base/process_usage.hpp"

namespace regulus::scene::test {
namespace {

// Processor time of one load. It is to find work that grows with the square of a file: 200,000 nodes would
// take 10^10 steps. A machine whose cores are shared may take twice the time of an idle one (1.2 s at most),
// and sanitizers ten times that.
constexpr double MAX_SECONDS = ::regulus::test::IS_SANITIZED ? 50 : 5;

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
  EXPECT_NE(text_error(file.root.dump()).find("a triangle with an area"), std::string::npos);
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

LoadOptions with_memory(uint64_t bytes) {
  LoadOptions options;
  options.memory_bytes = bytes;
  return options;
}

/// "... needs N MiB, with the rest of the scene M MiB, but --memory allows 256.0 MiB": M.
double needed_mebibytes(const std::string& error) {
  const std::string before = "with the rest of the scene ";
  const size_t at = error.find(before);
  EXPECT_NE(at, std::string::npos) << error;
  EXPECT_NE(error.find("256.0 MiB of memory are allowed"), std::string::npos) << error;
  return at == std::string::npos ? 0 : std::stod(error.substr(at + before.size()));
}

/// Loads under --memory 256M, and says by how much the process grew meanwhile.
std::string limited_error(const std::string& text) {
  const TemporaryFolder folder;
  const auto path = folder.write("bomb.gltf", text);
  const uint64_t before = process_peak_bytes();
  std::string error = timed_error([&] { load(path, with_memory(uint64_t{256} << 20)); });
  EXPECT_LE(process_peak_bytes(), before + (uint64_t{256} << 20)) << "taken before it was counted";
  return error;
}

// A few kilobytes of JSON place a triangle 2^22 times: at least a matrix each, 128 bytes.
TEST(SceneBombs, InstancesAreCountedBeforeTheyAreMade) {
  Gltf file;
  file.triangle();
  file.root["accessors"].push_back({{"componentType", FLOAT}, {"type", "VEC3"}, {"count", 1 << 22}});
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 2;
  EXPECT_GT(needed_mebibytes(limited_error(file.root.dump())), 512);
}

// 1,000 nodes show a mesh of 1,000 primitives.
TEST(SceneBombs, PrimitivesAreCountedBeforeTheyAreMade) {
  Gltf file;
  file.triangle();
  json& primitives = file.root["meshes"][0]["primitives"];
  for (int i = 1; i < 1000; ++i) primitives.push_back(primitives[0]);
  for (int i = 1; i < 1000; ++i) file.node({{"mesh", 0}});
  EXPECT_GT(needed_mebibytes(limited_error(file.root.dump())), 256);
}

// A thousand primitives of one triangle each claim four million vertices.
TEST(SceneBombs, VerticesAreCountedBeforeAnyIsLookedAt) {
  Gltf file;
  file.triangle();
  file.root["accessors"].push_back({{"componentType", FLOAT}, {"type", "VEC3"}, {"count", 1 << 22}});
  const size_t indices = file.accessor(std::vector<uint32_t>{0, 1, 2}, "SCALAR", UNSIGNED_INT);
  json& primitives = file.root["meshes"][0]["primitives"];
  for (int i = 0; i < 1000; ++i)
    primitives.push_back({{"attributes", {{"POSITION", 2}}}, {"indices", indices}});
  EXPECT_GT(needed_mebibytes(limited_error(file.root.dump())), 1000.0 * (1 << 22) * 32 / (1 << 20));
}

// 16,384 x 16,384 pixels of one bit, all 0, deflated to 211 KB; four bytes each as a texture.
TEST(SceneBombs, PixelsAreCountedBeforeTheyAreDecoded) {
  Gltf file;
  const size_t texture = file.texture(make_blank_png(16384, 16384));
  file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
  EXPECT_GT(needed_mebibytes(limited_error(file.root.dump())), 1024);
}

// 12 MB of lists within lists, of empty objects and of numbers, where nobody looks.
TEST(SceneBombs, JsonIsCountedBeforeItIsParsed) {
  for (const std::string& part :
       {std::string(100, '[') + std::string(100, ']'), std::string("{}"), std::string("0")}) {
    std::string text = R"({"asset":{"version":"2.0"},"extras":[)";
    while (text.size() < 12000000) text += part + ",";
    EXPECT_GT(needed_mebibytes(limited_error(text + "0]}")), 256);
  }
}

TEST(SceneBombs, FilesAreCountedBeforeTheyAreRead) {
  const TemporaryFolder folder;
  folder.write("huge.bin", "");
  std::filesystem::resize_file(folder.path() / "huge.bin", uint64_t{1} << 40);  // a hole
  Gltf file;
  file.triangle();
  file.root["buffers"][0]["uri"] = "huge.bin";
  const std::string error = timed_error([&] { load(folder.write("test.gltf", file.root.dump())); });
  EXPECT_NE(error.find("huge.bin"), std::string::npos);
  EXPECT_NE(error.find("needs 1048576.0 MiB"), std::string::npos);
}

// What is counted covers what a scene takes: the grid of 200,000 triangles needs more than its arrays alone.
TEST(SceneBombs, EstimatesAreNoGuessesBelow) {
  constexpr uint32_t SIDE = 316;
  Gltf file;
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= SIDE; ++y)
    for (uint32_t x = 0; x <= SIDE; ++x)
      for (const uint32_t value : {x, y, x * y % 7}) positions.push_back(static_cast<float>(value));
  for (uint32_t y = 0; y < SIDE; ++y)
    for (uint32_t x = 0; x < SIDE; ++x)
      for (const uint32_t corner : {0u, 1u, SIDE + 1, 1u, SIDE + 2, SIDE + 1})
        indices.push_back(y * (SIDE + 1) + x + corner);
  const json primitive = {{"attributes", {{"POSITION", file.positions(positions)}}},
                          {"indices", file.accessor(indices, "SCALAR", UNSIGNED_INT)}};
  file.node({{"mesh", file.mesh(primitive)}});
  const auto needs = [&](uint64_t memory) { return error_of([&] { file.load(with_memory(memory << 20)); }); };
  EXPECT_EQ(needs(256), "");
  const std::string error = needs(64);
  EXPECT_NE(error.find("geometry of 199712 triangles needs"), std::string::npos) << error;
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

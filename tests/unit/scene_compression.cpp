// Compressed geometry and images against the same data uncompressed, encoded by the libraries' own encoders,
// and instances against nodes.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <webp/encode.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// A wavy grid of SIDE x SIDE vertices.
struct Grid {
  static constexpr uint32_t SIDE = 9;
  std::vector<float> positions;
  std::vector<uint32_t> indices;

  Grid() {
    for (uint32_t y = 0; y < SIDE; ++y)
      for (uint32_t x = 0; x < SIDE; ++x) {
        positions.insert(positions.end(), {static_cast<float>(x) * 0.37f, static_cast<float>(y) * -1.1f,
                                           std::sin(static_cast<float>(3 * x + 5 * y))});
        if (x + 1 == SIDE || y + 1 == SIDE) continue;
        const uint32_t i = y * SIDE + x;
        indices.insert(indices.end(), {i, i + 1, i + SIDE, i + 1, i + SIDE + 1, i + SIDE});
      }
  }
  size_t vertices() const { return positions.size() / 3; }

  Gltf plain() const {
    Gltf file;
    const size_t points = file.positions(positions);
    const size_t list = file.accessor(indices, "SCALAR", UNSIGNED_INT);
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", points}}}, {"indices", list}})}});
    return file;
  }
};

/// Corner positions of all triangles, in order.
std::vector<glm::vec3> corners(const Scene& scene) {
  std::vector<glm::vec3> result;
  for (const interface::Triangle& t : scene.triangles)
    for (const uint32_t v : {t.v0, t.v1, t.v2}) result.push_back(scene.vertices.at(v).position);
  return result;
}

/// Turns a view into a compressed one whose own buffer holds nothing.
void compress_view(Gltf& file, size_t view, const Bytes& encoded, size_t stride, size_t count,
                   const char* mode, const char* filter = "NONE") {
  const size_t source = file.root["bufferViews"][file.view(encoded)]["buffer"];
  json& buffer = file.root["buffers"][file.root["bufferViews"][view]["buffer"].get<size_t>()];
  buffer.erase("uri");
  buffer["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  file.root["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", source},     {"byteOffset", 0}, {"byteLength", encoded.size()},
      {"byteStride", stride}, {"count", count},  {"mode", mode},
      {"filter", filter}};
}

size_t view_of(const Gltf& file, size_t accessor) {
  return file.root["accessors"][accessor]["bufferView"];
}

Bytes encoded_vertices(const void* data, size_t count, size_t stride) {
  Bytes bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), data, count, stride));
  return bytes;
}

Bytes encoded_triangles(const std::vector<uint32_t>& indices, size_t vertices) {
  Bytes bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

Gltf meshopt_grid(const Grid& grid) {
  Gltf file = grid.plain();
  compress_view(file, view_of(file, 0), encoded_vertices(grid.positions.data(), grid.vertices(), 12), 12,
                grid.vertices(), "ATTRIBUTES");
  compress_view(file, view_of(file, 1), encoded_triangles(grid.indices, grid.vertices()), 4,
                grid.indices.size(), "TRIANGLES");
  file.root["extensionsRequired"] = {"EXT_meshopt_compression"};
  return file;
}

/// Triangles as sets: the index codec may rotate a triangle's corners.
std::vector<glm::vec3> rotated_to_smallest(std::vector<glm::vec3> points) {
  const auto less = [](const glm::vec3& a, const glm::vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  for (size_t i = 0; i < points.size(); i += 3) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(i);
    std::rotate(first, std::min_element(first, first + 3, less), first + 3);
  }
  return points;
}

TEST(SceneCompression, MeshoptGivesTheSameTriangles) {
  const Grid grid;
  const Scene plain = grid.plain().load(), compressed = meshopt_grid(grid).load();
  EXPECT_EQ(compressed.triangles.size(), 128u);
  EXPECT_EQ(rotated_to_smallest(corners(compressed)), rotated_to_smallest(corners(plain)));
}

TEST(SceneCompression, MeshoptIndexSequencesAreDecoded) {
  const Grid grid;
  Gltf file = grid.plain();
  Bytes bytes(meshopt_encodeIndexSequenceBound(grid.indices.size(), grid.vertices()));
  bytes.resize(
      meshopt_encodeIndexSequence(bytes.data(), bytes.size(), grid.indices.data(), grid.indices.size()));
  compress_view(file, view_of(file, 1), bytes, 4, grid.indices.size(), "INDICES");
  EXPECT_EQ(corners(file.load()), corners(grid.plain().load()));
}

// The exponential filter keeps 15 of 24 bits here: the error is below half a unit of the largest component's
// last.
TEST(SceneCompression, MeshoptFiltersAreUndone) {
  const Grid grid;
  Gltf file = grid.plain();
  std::vector<uint32_t> filtered(grid.positions.size());
  meshopt_encodeFilterExp(filtered.data(), grid.vertices(), 12, 15, grid.positions.data());
  compress_view(file, view_of(file, 0), encoded_vertices(filtered.data(), grid.vertices(), 12), 12,
                grid.vertices(), "ATTRIBUTES", "EXPONENTIAL");
  const auto expected = corners(grid.plain().load()), actual = corners(file.load());
  ASSERT_EQ(actual.size(), expected.size());
  double worst = 0;
  for (size_t i = 0; i < actual.size(); ++i)
    worst = std::max(worst, double{glm::distance(actual[i], expected[i])});
  std::printf("largest distance %.2g\n", worst);
  EXPECT_LT(worst, std::sqrt(3.0) * 16 * 0x1p-15);  // components below 16, 14 bits and a sign
  EXPECT_GT(worst, 0.0) << "nothing was quantized: the filter was not exercised";
}

TEST(SceneCompression, BrokenMeshoptHeadersAreErrors) {
  const auto error_with = [](const char* member, const json& value) {
    Gltf file = meshopt_grid(Grid());
    file.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][member] = value;
    return load_error(file);
  };
  EXPECT_NE(error_with("count", 1u << 30).find("are not the"), std::string::npos);
  EXPECT_NE(error_with("byteStride", 0).find("are not the"), std::string::npos);
  EXPECT_NE(error_with("byteStride", 18446744073709551615u).find("must be an integer"), std::string::npos);
  EXPECT_NE(error_with("mode", "TRIANGLES").find("indices have 2 or 4 bytes"), std::string::npos);
  EXPECT_NE(error_with("mode", 3).find("must be a string"), std::string::npos);
  EXPECT_NE(error_with("filter", "OCTAHEDRAL").find("4 or 8 bytes"), std::string::npos);
  EXPECT_NE(error_with("byteOffset", 100000).find("leave its buffer"), std::string::npos);
  EXPECT_NE(error_with("byteLength", 20).find("cannot be decoded"), std::string::npos);
  Gltf wrong_codec = meshopt_grid(Grid());
  json& views = wrong_codec.root["bufferViews"];
  views[0]["extensions"]["EXT_meshopt_compression"]["buffer"] =
      views[1]["extensions"]["EXT_meshopt_compression"]["buffer"];
  views[0]["extensions"]["EXT_meshopt_compression"]["byteLength"] =
      views[1]["extensions"]["EXT_meshopt_compression"]["byteLength"];
  EXPECT_NE(load_error(wrong_codec).find("cannot be decoded"), std::string::npos);
}

/// The grid in Draco, positions with `bits` of quantization over the largest extent.
Gltf draco_grid(const Grid& grid, int bits) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(grid.indices.size() / 3));
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (size_t face = 0; face < grid.indices.size() / 3; ++face)
    builder.SetAttributeValuesForFace(
        positions, draco::FaceIndex(static_cast<uint32_t>(face)), &grid.positions[3 * grid.indices[3 * face]],
        &grid.positions[3 * grid.indices[3 * face + 1]], &grid.positions[3 * grid.indices[3 * face + 2]]);
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer encoded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());

  Gltf file = grid.plain();
  const size_t view = file.view(Bytes(encoded.data(), encoded.data() + encoded.size()));
  for (json& accessor : file.root["accessors"]) accessor.erase("bufferView");
  const auto id = mesh->attribute(positions)->unique_id();
  file.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", id}}}};
  file.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return file;
}

// Draco reorders triangles and rotates their corners: every original triangle must have one counterpart whose
// corners are within the quantization, the largest extent (8.8) over 2^bits in each component.
TEST(SceneCompression, DracoGivesTheSameTrianglesWithinItsQuantization) {
  const Grid grid;
  const auto expected = rotated_to_smallest(corners(grid.plain().load()));
  for (const int bits : {11, 14}) {
    const auto actual = rotated_to_smallest(corners(draco_grid(grid, bits).load()));
    ASSERT_EQ(actual.size(), expected.size());
    const double tolerance = std::sqrt(3.0) * 8.8 / (1 << bits);
    double worst = 0;
    std::vector<bool> is_taken(actual.size() / 3);
    for (size_t i = 0; i < expected.size(); i += 3) {
      size_t best = 0;
      double best_distance = 1e30;
      for (size_t k = 0; k < actual.size(); k += 3)
        for (size_t turn = 0; turn < 3; ++turn) {
          double distance = 0;
          for (size_t c = 0; c < 3; ++c)
            distance = std::max(distance, double{glm::distance(expected[i + c], actual[k + (c + turn) % 3])});
          if (distance < best_distance) {
            best_distance = distance;
            best = k / 3;
          }
        }
      EXPECT_FALSE(is_taken[best]);
      is_taken[best] = true;
      worst = std::max(worst, best_distance);
    }
    std::printf("%d bits: largest distance %.2g (bound %.2g)\n", bits, worst, tolerance);
    EXPECT_LT(worst, tolerance);
  }
}

/// A stream of Draco 2.2 that ends after it has said how many faces and vertices it holds.
Bytes draco_claim(bool is_edgebreaker, uint64_t faces, uint64_t points) {
  Bytes bytes = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, static_cast<unsigned char>(is_edgebreaker ? 1 : 0), 0, 0};
  if (is_edgebreaker) bytes.push_back(0);
  for (uint64_t count : {is_edgebreaker ? points : faces, is_edgebreaker ? faces : points}) {
    for (; count > 127; count >>= 7) bytes.push_back(static_cast<unsigned char>(count | 128));
    bytes.push_back(static_cast<unsigned char>(count));
  }
  return bytes;
}

// Draco's entropy coder makes a few bytes of millions of faces that are all alike.
TEST(SceneCompression, DracoFacesAreCountedBeforeTheyAreDecoded) {
  LoadOptions options;
  options.memory_bytes = uint64_t{256} << 20;
  const Grid grid;
  for (const bool is_edgebreaker : {false, true}) {
    Gltf file = draco_grid(grid, 11);
    const size_t view =
        file.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"];
    const size_t claim = file.view(draco_claim(is_edgebreaker, 1 << 22, 1 << 21));
    file.root["bufferViews"][view] = file.root["bufferViews"][claim];
    const std::string error = error_of([&] { file.load(options); });
    // 60 bytes and 100 for the positions: 640 MiB.
    EXPECT_NE(error.find("KHR_draco_mesh_compression needs 640.0 MiB"), std::string::npos) << error;
    EXPECT_NE(error.find("256.0 MiB of memory are allowed"), std::string::npos) << error;
  }
}

TEST(SceneCompression, BrokenDracoDataIsAnError) {
  const Grid grid;
  Gltf truncated = draco_grid(grid, 11);
  const size_t view = truncated.root["bufferViews"].size() - 1;
  truncated.root["bufferViews"][view]["byteLength"] = 20;
  EXPECT_NE(load_error(truncated).find("cannot be decoded"), std::string::npos);
  Gltf other_attribute = draco_grid(grid, 11);
  other_attribute.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]
                      ["POSITION"] = 77;
  EXPECT_NE(load_error(other_attribute).find("POSITION is missing"), std::string::npos);
  Gltf wrong_type = draco_grid(grid, 11);
  wrong_type.root["accessors"][0]["type"] = "VEC2";
  EXPECT_NE(load_error(wrong_type).find("components"), std::string::npos);
}

TEST(SceneCompression, DamagedDataNeverCrashes) {
  std::mt19937 random(17);
  const Grid grid;
  const Gltf files[] = {meshopt_grid(grid), draco_grid(grid, 11)};
  int errors = 0, loaded = 0;
  for (int i = 0; i < 400; ++i) {
    const Gltf& original = files[i % 2];
    Gltf file = original;
    json& buffers = file.root["buffers"];
    const size_t at = i % 2 == 0 ? 2 + random() % 2 : buffers.size() - 1;
    std::string uri = buffers[at]["uri"];
    const size_t start = uri.find(',') + 1;
    for (size_t edits = 1 + random() % 4; edits > 0; --edits) {
      char& c = uri[start + random() % (uri.size() - start - 2)];
      c = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdef0123"[random() % 36];
    }
    buffers[at]["uri"] = uri;
    const std::string message = load_error(file);
    ++(message.empty() ? loaded : errors);
  }
  std::printf("%d loaded, %d refused\n", loaded, errors);
  EXPECT_GT(errors, 20);
}

/// Texels of the only texture, used as a base colour.
std::vector<uint32_t> texels_of(Gltf& file, size_t texture) {
  file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
  return file.load().images.at(0);
}

TEST(SceneCompression, LosslessWebpGivesTheTexelsOfPng) {
  constexpr uint32_t width = 7, height = 5;
  std::vector<uint16_t> samples;
  Bytes rgba;
  for (uint32_t i = 0; i < width * height * 4; ++i) {
    // Opaque: where alpha is 0, a lossless encoder may still drop the colour.
    samples.push_back(static_cast<uint16_t>(i % 4 == 3 ? 255 : (i * 37) % 256));
    rgba.push_back(static_cast<unsigned char>(samples.back()));
  }
  uint8_t* encoded = nullptr;
  const size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &encoded);
  ASSERT_GT(size, 0u);
  const Bytes webp(encoded, encoded + size);
  WebPFree(encoded);

  Gltf png_file, webp_file;
  const auto expected = texels_of(png_file, png_file.texture(make_png(width, height, 4, 8, samples)));
  // Beside a PNG of another size, which only those take that do not know the extension.
  const size_t texture = webp_file.texture(make_png(1, 1, 3, 8, {1, 2, 3}));
  webp_file.root["images"].push_back({{"uri", "data:image/webp;base64," + base64(webp)}});
  webp_file.root["textures"][texture]["extensions"]["EXT_texture_webp"]["source"] = 1;
  EXPECT_EQ(texels_of(webp_file, texture), expected);

  Gltf damaged;
  const size_t broken = damaged.texture(Bytes(webp.begin(), webp.end() - 8));
  damaged.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", broken}}}}}});
  EXPECT_NE(load_error(damaged).find("cannot be decoded"), std::string::npos);
}

TEST(SceneInstancing, PlacesAreThoseOfNodesWithTheSameTransforms) {
  const std::vector<float> translations = {0, 0, 0, 3, 1, -2, 0.5f, 0, 7},
                           scales = {1, 1, 1, 2, 1, 0.5f, -1, 1, 1};
  const std::vector<int16_t> rotations = {0, 0, 0, 32767, 23170, 0, 0, 23170, 0, -32767, 0, 0};
  const json parent = {{"translation", {5, 0, 0}}, {"scale", {1, 2, 1}}};
  Gltf instanced;
  instanced.triangle(json::object(), parent);
  const size_t rotation = instanced.accessor(rotations, "VEC4", SHORT);
  instanced.root["accessors"][rotation]["normalized"] = true;
  instanced.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", instanced.positions(translations)},
      {"ROTATION", rotation},
      {"SCALE", instanced.positions(scales)}};
  instanced.root["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};

  Gltf nodes;
  nodes.triangle();
  json root = parent;
  for (size_t i = 0; i < 3; ++i) {
    json child = {{"mesh", 0}};
    for (size_t k = 0; k < 3; ++k) {
      child["translation"].push_back(translations[3 * i + k]);
      child["scale"].push_back(scales[3 * i + k]);
    }
    for (size_t k = 0; k < 4; ++k) child["rotation"].push_back(rotations[4 * i + k] / 32767.0);
    nodes.root["nodes"].push_back(child);
    root["children"].push_back(i + 1);
  }
  nodes.root["nodes"].push_back(root);
  nodes.root["scenes"][0]["nodes"] = {4};

  const Scene expected = nodes.load(), actual = instanced.load();
  EXPECT_EQ(actual.inventory.instances, 3u);
  const auto expected_corners = corners(expected), actual_corners = corners(actual);
  ASSERT_EQ(actual_corners.size(), 9u);
  for (size_t i = 0; i < 9; ++i)
    EXPECT_LT(glm::distance(actual_corners[i], expected_corners[i]), 2e-6f) << i;  // a few ulp of 7 metres
}

TEST(SceneInstancing, BrokenAttributesAreErrors) {
  const auto error_with = [](const std::function<void(Gltf&, json&)>& change) {
    Gltf file;
    file.triangle();
    json& extension = file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
    extension["attributes"]["TRANSLATION"] = file.positions({0, 0, 0, 1, 1, 1});
    change(file, extension);
    return load_error(file);
  };
  EXPECT_NE(error_with([](Gltf&, json& e) { e.erase("attributes"); }).find("has no attributes"),
            std::string::npos);
  EXPECT_NE(error_with([](Gltf&, json& e) {
              e["attributes"] = {{"_ID", 0}};
            }).find("has neither"),
            std::string::npos);
  EXPECT_NE(error_with([](Gltf&, json& e) { e["attributes"]["SCALE"] = 99; }).find("there are"),
            std::string::npos);
  EXPECT_NE(error_with([](Gltf& file, json& e) {
              e["attributes"]["SCALE"] = file.positions({1, 1, 1});
            }).find("another attribute"),
            std::string::npos);
  EXPECT_NE(error_with([](Gltf& file, json& e) {
              e["attributes"]["SCALE"] = file.positions({1, 1, 1, 1, 1, std::nanf("")});
            }).find("not finite"),
            std::string::npos);
}

}  // namespace
}  // namespace regulus::scene::test

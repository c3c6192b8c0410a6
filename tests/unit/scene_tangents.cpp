// Tangents against values worked out by hand from the definition of MikkTSpace.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// A mesh with a normal map; corners of triangle t are vertices 3t, 3t + 1, 3t + 2 unless indices are given.
struct Mesh {
  std::vector<float> positions, normals, uvs, tangents;
  std::vector<uint16_t> indices;
  json node = json::object();

  Scene load() const {
    Gltf file;
    const size_t texture = file.texture(make_png(1, 1, 3, 8, {128, 128, 255}));
    file.root["materials"] = {{{"normalTexture", {{"index", texture}, {"scale", 0.5}}}}};
    json primitive = {
        {"attributes",
         {{"POSITION", file.positions(positions)}, {"TEXCOORD_0", file.accessor(uvs, "VEC2", FLOAT)}}},
        {"material", 0}};
    if (!normals.empty()) primitive["attributes"]["NORMAL"] = file.positions(normals);
    if (!tangents.empty()) primitive["attributes"]["TANGENT"] = file.accessor(tangents, "VEC4", FLOAT);
    if (!indices.empty()) primitive["indices"] = file.accessor(indices, "SCALAR", UNSIGNED_SHORT);
    json placed = node;
    placed["mesh"] = file.mesh(primitive);
    file.node(placed);
    return file.load();
  }
};

glm::vec4 tangent_at(const Scene& scene, size_t triangle, int corner) {
  const interface::Triangle& t = scene.triangles.at(triangle);
  const uint32_t vertex[3] = {t.v0, t.v1, t.v2};
  return scene.vertex_tangents.at(vertex[corner]);
}

// In single precision, from a few dozen operations.
void expect_near(const glm::vec4& found, const glm::dvec3& tangent, float sign) {
  EXPECT_LT(glm::length(glm::dvec3(found) - tangent), 1e-6)
      << found.x << " " << found.y << " " << found.z << ", not " << tangent.x << " " << tangent.y << " "
      << tangent.z;
  EXPECT_EQ(found.w, sign);
}

// With coordinates of its own the normal texture decides: here those of a second set, turned by its
// transform.
TEST(SceneTangents, FollowTheCoordinatesOfTheNormalTexture) {
  const auto tangent = [](const json& transform) {
    Gltf file;
    const size_t texture = file.texture(make_png(1, 1, 3, 8, {128, 128, 255}));
    json normal = {{"index", texture}, {"texCoord", 1}};
    if (!transform.is_null()) normal["extensions"]["KHR_texture_transform"] = transform;
    file.root["materials"] = {
        {{"normalTexture", normal}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}}};
    json primitive = {{"attributes",
                       {{"POSITION", file.positions(TRIANGLE)},
                        {"TEXCOORD_0", file.accessor(std::vector<float>{0, 1, 1, 1, 0, 0}, "VEC2", FLOAT)},
                        {"TEXCOORD_1", file.accessor(std::vector<float>{0, 1, 0, 0, -1, 1}, "VEC2", FLOAT)}}},
                      {"material", 0}};
    file.node({{"mesh", file.mesh(primitive)}});
    return tangent_at(file.load(), 0, 0);
  };
  expect_near(tangent(json()), {0, -1, 0}, 1);
  // (u, v) becomes (v, -u): u grows where v did, along -x.
  expect_near(tangent({{"rotation", std::numbers::pi / 2}}), {-1, 0, 0}, 1);
}

// glTF's v points down: with u along +x and v along -y the bitangent, which points up in the image, is +y.
TEST(SceneTangents, FollowTheImage) {
  struct Layout {
    std::vector<float> uvs;
    glm::dvec3 tangent;
    float sign;
  };
  for (const Layout& layout :
       {Layout{{0, 1, 1, 1, 0, 0}, {1, 0, 0}, 1}, Layout{{1, 1, 0, 1, 1, 0}, {-1, 0, 0}, -1},
        Layout{{0, 1, 0, 0, -1, 1}, {0, -1, 0}, 1}, Layout{{0, 0, 1, 0, 0, 1}, {1, 0, 0}, -1}}) {
    const Scene scene = Mesh{TRIANGLE, {}, layout.uvs, {}, {}}.load();
    ASSERT_EQ(scene.vertex_tangents.size(), scene.vertices.size());
    for (int i = 0; i < 3; ++i) expect_near(tangent_at(scene, 0, i), layout.tangent, layout.sign);
  }
}

// Two triangles of a unit square with different images: u = x on both, v = 1 - y on the first and 2 - x - 2 y
// on the second, where the direction of constant v and growing u is (2, -1). At the shared corners both have
// 45 degrees. At a third of the corner (0, 0) a further triangle, of 90 degrees, shows the weights.
TEST(SceneTangents, AreWeightedByAngle) {
  std::vector<float> normals;
  for (int i = 0; i < 5; ++i) normals.insert(normals.end(), {0, 0, 1});
  const Scene scene = Mesh{
      {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, -1, 0},
      normals,
      {0, 1, 1, 1, 0, 0, 1, -1, 3, 2},
      {},
      {0, 1, 2, 2, 1, 3, 0, 4,
       1}}.load();
  ASSERT_EQ(scene.vertices.size(), 5u);
  // Third triangle: (0, 0) (2, -1) (1, 0) with uv (0, 1) (3, 2) (1, 1): u = x - y, v = 1 - y, so constant v
  // runs along x.
  const glm::dvec3 first(1, 0, 0), second = glm::normalize(glm::dvec3(2, -1, 0));
  expect_near(tangent_at(scene, 1, 2), second, 1);
  expect_near(tangent_at(scene, 0, 2), glm::normalize(first + second), 1);
  // At (1, 0): 45 degrees of the first, 45 of the second, 135 of the third.
  expect_near(tangent_at(scene, 0, 1), glm::normalize(first + second + 3.0 * first), 1);
}

// The image is mirrored at x = 0: the two vertices there exist once for each side.
TEST(SceneTangents, SplitAtMirroredSeams) {
  std::vector<float> normals;
  for (int i = 0; i < 4; ++i) normals.insert(normals.end(), {0, 0, 1});
  const Scene scene =
      Mesh{{0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0}, normals, {0, 1, 1, 1, 0, 0, 1, 1}, {}, {0, 1, 2, 0, 2, 3}}
          .load();
  EXPECT_EQ(scene.vertices.size(), 6u);
  for (int i = 0; i < 3; ++i) {
    expect_near(tangent_at(scene, 0, i), {1, 0, 0}, 1);
    expect_near(tangent_at(scene, 1, i), {-1, 0, 0}, -1);
  }
}

// A tube of 12 sides with the image around it, its vertices not shared between triangles: by symmetry every
// tangent is the tangent of the circle.
TEST(SceneTangents, AreSmoothOverWeldedCorners) {
  Mesh mesh;
  constexpr int SIDES = 12;
  const auto add = [&](int side, int level) {
    const double angle = 2 * M_PI * side / SIDES;
    // Exactly the same floats wherever the corner appears.
    const float x = static_cast<float>(std::cos(angle)), z = static_cast<float>(-std::sin(angle));
    mesh.positions.insert(mesh.positions.end(), {x, static_cast<float>(level), z});
    mesh.normals.insert(mesh.normals.end(), {x, 0, z});
    mesh.uvs.insert(mesh.uvs.end(), {static_cast<float>(side) / SIDES, 1 - static_cast<float>(level)});
  };
  for (int side = 1; side < 4; ++side) {
    add(side, 0), add(side + 1, 0), add(side + 1, 1);
    add(side, 0), add(side + 1, 1), add(side, 1);
  }
  const Scene scene = mesh.load();
  // Triangles 2 and 3 are the middle side; its corners have neighbours on both sides.
  for (size_t triangle = 2; triangle < 4; ++triangle)
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec4 tangent = tangent_at(scene, triangle, corner);
      const interface::Triangle& t = scene.triangles[triangle];
      const uint32_t vertex[3] = {t.v0, t.v1, t.v2};
      const glm::vec3 n = scene.vertices[vertex[corner]].normal;
      expect_near(tangent, {n.z, 0, -n.x}, 1);
    }
}

TEST(SceneTangents, OfTheFileAreTransformed) {
  Mesh mesh{TRIANGLE,
            {0, 0, 1, 0, 0, 1, 0, 0, 1},
            {0, 0, 0, 0, 0, 0},
            {0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, 1, 0, 0, 0, -1},
            {}};
  mesh.node = {{"scale", {-2, 2, 2}}};
  const Scene scene = mesh.load();
  EXPECT_TRUE(has_warning(scene, "tangents"));  // of the zero one
  // Mirroring turns the bitangent; corners 1 and 2 have changed places.
  expect_near(tangent_at(scene, 0, 0), {-0.6, 0.8, 0}, -1);
  expect_near(tangent_at(scene, 0, 2), {-0.6, 0.8, 0}, -1);
}

// Those of the mesh are transformed, not made anew where the transform has changed angles: a bent strip,
// stretched, sheared and mirrored by two nodes.
TEST(SceneTangents, OfTheMeshAreTransformed) {
  Mesh mesh{{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5f},
            {-0.2f, 0, 0.9798f, 0.3f, -0.3f, 0.9055f, 0, 0, 1, 0.1f, 0.2f, 0.9747f},
            {0, 1, 0.7f, 0.8f, 0.1f, 0, 1, 0.3f},
            {},
            {0, 1, 2, 2, 1, 3}};
  const Scene plain = mesh.load();
  mesh.node = {{"matrix", {-2, 0, 0, 0, 1.5, 0.5, 0, 0, 0, 0.25, 3, 0, 7, 8, 9, 1}}};
  const Scene transformed = mesh.load();
  const glm::dmat3 matrix(-2, 0, 0, 1.5, 0.5, 0, 0, 0.25, 3);
  for (size_t triangle = 0; triangle < 2; ++triangle)
    for (const int corner : {0, 1, 2}) {
      const glm::vec4 tangent = tangent_at(plain, triangle, corner);
      const int mirrored = corner == 0 ? 0 : 3 - corner;  // corners 1 and 2 have changed places
      expect_near(tangent_at(transformed, triangle, mirrored), glm::normalize(matrix * glm::dvec3(tangent)),
                  -tangent.w);
    }
}

TEST(SceneTangents, AreNotMadeWithoutNormalMaps) {
  Gltf file;
  file.triangle();
  EXPECT_TRUE(file.load().vertex_tangents.empty());
}

TEST(SceneTangents, ImagesWithoutAreaGetSomeFrame) {
  const Scene scene = Mesh{TRIANGLE, {}, {0, 0, 0, 0, 0, 0}, {}, {}}.load();
  for (const glm::vec4& tangent : scene.vertex_tangents) {
    EXPECT_NEAR(glm::length(glm::vec3(tangent)), 1, 1e-6);
    EXPECT_NEAR(tangent.z, 0, 1e-6);
  }
}

}  // namespace
}  // namespace regulus::scene::test

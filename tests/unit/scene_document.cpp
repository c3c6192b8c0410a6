// The document around the scene: cameras, settings, extensions, URIs, the container.
#include <gtest/gtest.h>

#include <cmath>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

Scene with_camera(const json& camera, const json& node_members = json::object()) {
  Gltf file;
  file.triangle();
  file.root["cameras"] = {camera};
  json node = {{"camera", 0}};
  node.update(node_members);
  file.node(node);
  return file.load();
}

/// Film coordinates in [0, 1]^2 of a point seen by a perspective camera; depth in z.
glm::vec3 project(const interface::Camera& camera, const glm::vec3& point) {
  const glm::vec3 offset = point - camera.position;
  const float depth = glm::dot(offset, camera.forward);
  const float x = glm::dot(offset, camera.right) / glm::dot(camera.right, camera.right) / depth;
  const float y = glm::dot(offset, camera.up) / glm::dot(camera.up, camera.up) / depth;
  return {0.5f + 0.5f * x, 0.5f - 0.5f * y, depth};
}

TEST(SceneCamera, PerspectiveKeepsItsVerticalField) {
  const Scene scene = with_camera(
      {{"name", "eye"}, {"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}},
      {{"translation", {1, 2, 3}}, {"scale", {5, 5, 5}}});
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].name, "eye");
  const interface::Camera camera = make_camera(scene.cameras[0], 200, 100);
  EXPECT_EQ(camera.kind, interface::CAMERA_PERSPECTIVE);
  EXPECT_EQ(camera.position, glm::vec3(1, 2, 3));
  EXPECT_LT(glm::length(camera.forward - glm::vec3(0, 0, -1)), 1e-6f);
  EXPECT_NEAR(camera.up.y, std::tan(0.5), 1e-6);
  EXPECT_NEAR(camera.right.x, 2 * std::tan(0.5), 2e-6);
  EXPECT_EQ(camera.lens_radius, 0.0f);
}

TEST(SceneCamera, TurnedCamerasLookAlongTheirNode) {
  // A quarter turn about y: -z turns to -x.
  const Scene scene = with_camera({{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}},
                                  {{"rotation", {0, std::sqrt(0.5), 0, std::sqrt(0.5)}}});
  const interface::Camera camera = make_camera(scene.cameras[0], 100, 100);
  EXPECT_LT(glm::length(camera.forward - glm::vec3(-1, 0, 0)), 1e-6f);
  EXPECT_LT(glm::length(glm::normalize(camera.right) - glm::vec3(0, 0, -1)), 1e-6f);
}

TEST(SceneCamera, OrthographicExtentsAreHalfTheView) {
  const Scene scene = with_camera(
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0}, {"zfar", 10}}}});
  const interface::Camera camera = make_camera(scene.cameras[0], 200, 100);
  EXPECT_EQ(camera.kind, interface::CAMERA_ORTHOGRAPHIC);
  EXPECT_EQ(camera.right, glm::vec3(4, 0, 0));
  EXPECT_EQ(camera.up, glm::vec3(0, 2, 0));
  EXPECT_EQ(scene.cameras[0].aspect_ratio, 2.0f);
}

TEST(SceneCamera, LensComesFromExtras) {
  const Scene scene =
      with_camera({{"type", "perspective"},
                   {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}},
                   {"extras", {{"regulus", {{"lens_radius", 0.25}, {"focus_distance", 7}}}}}});
  EXPECT_EQ(make_camera(scene.cameras[0], 1, 1).lens_radius, 0.25f);
  EXPECT_EQ(make_camera(scene.cameras[0], 1, 1).focus_distance, 7.0f);
}

TEST(SceneCamera, WithoutCameraTheBoundsAreInView) {
  Gltf file;
  file.triangle({}, {{"scale", {30, 2, 1}}, {"translation", {-100, 5, 40}}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.cameras.size(), 1u);
  const interface::Camera camera = make_camera(scene.cameras[0], 100, 100);
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 corner((i & 1) != 0 ? scene.bounds_max.x : scene.bounds_min.x,
                           (i & 2) != 0 ? scene.bounds_max.y : scene.bounds_min.y,
                           (i & 4) != 0 ? scene.bounds_max.z : scene.bounds_min.z);
    const glm::vec3 film = project(camera, corner);
    EXPECT_GT(film.z, 0.0f);
    EXPECT_GE(film.x, 0.0f);
    EXPECT_LE(film.x, 1.0f);
    EXPECT_GE(film.y, 0.0f);
    EXPECT_LE(film.y, 1.0f);
  }
}

TEST(SceneCamera, FieldsOfViewWithoutMeaningGiveWay) {
  for (const double yfov : {0.0, -1.0, 3.2}) {
    const Scene scene =
        with_camera({{"type", "perspective"}, {"perspective", {{"yfov", yfov}, {"znear", 0.1}}}});
    EXPECT_EQ(scene.cameras.at(0).y_fov, 0.8f);
    EXPECT_TRUE(has_warning(scene, "camera 0: yfov"));
  }
}

TEST(SceneDocument, SettingsAndResolutionAreRead) {
  Gltf file;
  file.triangle();
  file.root["asset"]["extras"]["resolution"] = {320, 200};
  file.root["scenes"][0]["extras"]["regulus"] = {
      {"integrator", "pt"}, {"spp", 64}, {"tau", 0.5}, {"energy-compensation", true}, {"aov", {1, 2}}};
  const Scene scene = file.load();
  EXPECT_EQ(scene.resolution, glm::uvec2(320, 200));
  const std::map<std::string, std::string> expected = {
      {"integrator", "pt"}, {"spp", "64"}, {"tau", "0.5"}, {"energy-compensation", "true"}};
  EXPECT_EQ(scene.settings, expected);
  EXPECT_TRUE(has_warning(scene, "regulus/aov"));
  for (const int side : {0, 32769}) {
    file.root["asset"]["extras"]["resolution"] = {side, 200};
    EXPECT_FALSE(file.load().resolution.has_value()) << side;
  }
  file.root["asset"]["extras"]["resolution"] = {32768, 200};
  EXPECT_EQ(file.load().resolution, glm::uvec2(32768, 200));
}

TEST(SceneDocument, RequiredExtensionsAreReadOrNamed) {
  Gltf file;
  file.triangle();
  file.root["extensionsRequired"] = {"KHR_materials_ior", "ACME_gizmo"};
  EXPECT_NE(load_error(file).find("ACME_gizmo"), std::string::npos) << load_error(file);
}

TEST(SceneDocument, OtherVersionsAreRefused) {
  Gltf file;
  file.triangle();
  file.root["asset"]["version"] = "1.0";
  EXPECT_NE(load_error(file).find("glTF version '1.0'"), std::string::npos);
  file.root.erase("asset");
  EXPECT_NE(load_error(file).find("asset.version is missing"), std::string::npos);
}

TEST(SceneDocument, EmptyScenesAreRefused) {
  EXPECT_NE(load_error(Gltf()).find("the file has no mesh"), std::string::npos);
}

TEST(SceneDocument, MembersOfTheWrongTypeAreNamedByPath) {
  const auto error_with = [](const std::string& pointer, const json& value) {
    Gltf file;
    file.triangle_of({{"pbrMetallicRoughness", {{"metallicFactor", 0.5}}}});
    file.root[json::json_pointer(pointer)] = value;
    return load_error(file);
  };
  EXPECT_NE(error_with("/accessors/0/bufferView", "x").find("accessors/0/bufferView must be an integer"),
            std::string::npos);
  EXPECT_NE(error_with("/accessors/0/bufferView", 4294967296).find("accessors/0/bufferView"),
            std::string::npos);
  EXPECT_NE(error_with("/nodes/0/mesh", 5).find("nodes/0/mesh is 5, but there are 1 meshes"),
            std::string::npos);
  EXPECT_NE(error_with("/nodes/0/translation", {1, 2}).find("nodes/0/translation must be an array of 3"),
            std::string::npos);
  EXPECT_NE(error_with("/materials/0/pbrMetallicRoughness/metallicFactor", true).find("must be a number"),
            std::string::npos);
  EXPECT_NE(error_with("/meshes/0/primitives/0", 7).find("meshes/0/primitives/0 must be an object"),
            std::string::npos);
  EXPECT_EQ(error_with("/nodes/0/mesh", 0.0), "");  // an integer written as 0.0
}

// --- URIs ---

/// A triangle whose positions lie in the file `uri`.
Gltf external_triangle(const std::string& uri) {
  Gltf file;
  file.root["buffers"].push_back({{"byteLength", 36}, {"uri", uri}});
  file.root["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 36}});
  file.root["accessors"].push_back(
      {{"bufferView", 0}, {"componentType", FLOAT}, {"type", "VEC3"}, {"count", 3}});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}})}});
  return file;
}

TEST(SceneUris, FilesBelowTheFolderAreRead) {
  const TemporaryFolder folder;
  folder.write("scene/data/a b.bin", TRIANGLE.data(), 36);
  for (const char* uri : {"data/a%20b.bin", "data/a b.bin", "data/../data/a%20b.bin", "./data/a b.bin"}) {
    const auto path = folder.write("scene/test.gltf", external_triangle(uri).root.dump());
    EXPECT_EQ(load(path).triangles.size(), 1u) << uri;
  }
}

TEST(SceneUris, PathsThatLeaveTheFolderNeedAllowExternal) {
  const TemporaryFolder folder;
  const std::string outside = folder.write("outside.bin", TRIANGLE.data(), 36).string();
  std::filesystem::create_directories(folder.path() / "scene");
  std::filesystem::create_symlink(outside, folder.path() / "scene" / "link.bin");
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("%2e%2e/outside.bin"), outside, std::string("link.bin")}) {
    const auto path = folder.write("scene/test.gltf", external_triangle(uri).root.dump());
    const std::string error = error_of([&] { load(path); });
    EXPECT_NE(error.find("outside the scene's folder; allow external files"), std::string::npos)
        << uri << ": " << error;
    LoadOptions options;
    options.allow_external = true;
    EXPECT_EQ(load(path, options).triangles.size(), 1u) << uri;
  }
}

TEST(SceneUris, NamesThatNobodyEncodedAreFoundWithAWarning) {
  const TemporaryFolder folder;
  folder.write("scene/data/more/a b.bin", TRIANGLE.data(), 36);
  folder.write("scene/100%25.bin", TRIANGLE.data(), 36);
  for (const char* uri : {"data\\more\\a b.bin", "data/more\\a%20b.bin", ".\\data/more/a b.bin",
                          "data%5Cmore%5ca%20b.bin", "data\\more\\..\\more\\a b.bin", "100%25.bin"}) {
    const auto path = folder.write("scene/test.gltf", external_triangle(uri).root.dump());
    const Scene scene = load(path);
    EXPECT_EQ(scene.triangles.size(), 1u) << uri;
    EXPECT_TRUE(has_warning(scene, std::string("buffer 0: '") + uri + "' is no URI")) << uri;
    EXPECT_NE(error_of([&] { load(path, {.is_strict = true}); }).find("is no URI"), std::string::npos) << uri;
  }
}

TEST(SceneUris, ABackslashMayBePartOfAName) {
  const TemporaryFolder folder;
  folder.write("data\\a.bin", TRIANGLE.data(), 36);
  const std::vector<float> other = {0, 0, 0, 7, 0, 0, 0, 1, 0};
  folder.write("data/a.bin", other.data(), 36);
  const Scene scene =
      load(folder.write("test.gltf", external_triangle("data%5Ca.bin").root.dump()), {.is_strict = true});
  EXPECT_EQ(scene.bounds_max.x, 1.0f) << "the file of exactly that name comes first";
}

TEST(SceneUris, BackslashesInImagesAndEnvironments) {
  const TemporaryFolder folder;
  const Bytes png = make_png(1, 1, 3, 8, {255, 255, 255});
  folder.write("scene/tex/a.png", png.data(), png.size());
  const std::string radiance =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n" + std::string("\x80\x80\x80\x81", 4);
  folder.write("scene/env/sky.hdr", radiance.data(), radiance.size());
  Gltf file;
  file.root["images"] = {{{"uri", "tex\\a.png"}}};
  file.root["textures"] = {{{"source", 0}}};
  file.triangle_of({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  file.root["scenes"][0]["extras"]["regulus"]["environment"] = {{"file", "env\\sky.hdr"}};
  const Scene scene = load(folder.write("scene/test.gltf", file.root.dump()));
  EXPECT_EQ(scene.textures.size(), 1u);
  ASSERT_TRUE(scene.environment.has_value());
  EXPECT_EQ(scene.environment->parameters.radiance, glm::vec3(1));
  EXPECT_TRUE(has_warning(scene, "'env\\sky.hdr' is no URI"));
}

TEST(SceneUris, BackslashesDoNotLeaveTheFolder) {
  const TemporaryFolder folder;
  folder.write("outside.bin", TRIANGLE.data(), 36);
  for (const char* uri :
       {"..\\outside.bin", "data\\..\\..\\outside.bin", "..%5Coutside.bin", "data/..\\../outside.bin"}) {
    const auto path = folder.write("scene/test.gltf", external_triangle(uri).root.dump());
    const std::string error = error_of([&] { load(path); });
    EXPECT_NE(error.find("outside the scene's folder; allow external files"), std::string::npos)
        << uri << ": " << error;
    EXPECT_EQ(load(path, {.allow_external = true}).triangles.size(), 1u) << uri;
  }
}

TEST(SceneUris, AMissingEnvironmentIsNoReasonToRefuseTheScene) {
  Gltf file;
  file.triangle();
  file.root["scenes"][0]["extras"]["regulus"]["environment"] = {{"file", "gone.exr"}};
  Scene scene = file.load();
  EXPECT_FALSE(scene.environment.has_value());
  EXPECT_TRUE(has_warning(scene, "gone.exr': no such file; check the path (no environment"));
  EXPECT_NE(load_error(file).find("gone.exr"), std::string::npos);
  EXPECT_NE(error_of([&] { file.load({.environment = {.file = "gone.exr"}}); }).find("gone.exr"),
            std::string::npos)
      << "but what the command line asks for must be there";
}

TEST(SceneUris, BadReferencesNameTheirElement) {
  const auto error_for = [](const std::string& uri) { return load_error(external_triangle(uri)); };
  EXPECT_NE(error_for("missing.bin").find("buffer 0: "), std::string::npos);
  EXPECT_NE(error_for("missing.bin").find("no such file"), std::string::npos);
  EXPECT_NE(error_for("http://example.org/a.bin").find("cannot read 'http' URIs"), std::string::npos);
  EXPECT_NE(error_for("file:///etc/passwd").find("cannot read 'file' URIs"), std::string::npos);
  EXPECT_NE(error_for("data:application/octet-stream,abc").find("not base64"), std::string::npos);
  EXPECT_NE(error_for("").find("empty or malformed"), std::string::npos);
  EXPECT_NE(error_for("a%00b").find("empty or malformed"), std::string::npos);
  EXPECT_NE(error_for("data:application/octet-stream;base64,AAAA").find("declares 36 bytes but has 3"),
            std::string::npos);
}

TEST(SceneUris, HashFollowsEveryFile) {
  const TemporaryFolder folder;
  const auto path = folder.write("test.gltf", external_triangle("a.bin").root.dump());
  folder.write("a.bin", TRIANGLE.data(), 36);
  const uint64_t first = load(path).hash;
  EXPECT_EQ(load(path).hash, first);
  std::vector<float> moved = TRIANGLE;
  moved[0] = -1;
  folder.write("a.bin", moved.data(), 36);
  EXPECT_NE(load(path).hash, first);
}

// --- GLB ---

void append_u32(std::string& bytes, size_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift);
}

std::string make_glb(std::string text, const std::string& binary) {
  while (text.size() % 4 != 0) text += ' ';
  std::string glb = "glTF";
  append_u32(glb, 2);
  append_u32(glb, 12 + 8 + text.size() + 8 + binary.size());
  append_u32(glb, text.size());
  glb += "JSON" + text;
  append_u32(glb, binary.size());
  glb += std::string("BIN\0", 4) + binary;
  return glb;
}

std::string triangle_glb() {
  Gltf file = external_triangle("");
  file.root["buffers"][0].erase("uri");
  return make_glb(file.root.dump(), std::string(reinterpret_cast<const char*>(TRIANGLE.data()), 36));
}

TEST(SceneGlb, TheBinaryChunkIsTheFirstBuffer) {
  const TemporaryFolder folder;
  EXPECT_EQ(load(folder.write("a.glb", triangle_glb())).triangles.size(), 1u);
}

TEST(SceneGlb, EveryTruncationIsAnError) {
  const TemporaryFolder folder;
  const std::string glb = triangle_glb();
  for (size_t size = 0; size < glb.size(); ++size) {
    const auto path = folder.write("a.glb", glb.substr(0, size));
    EXPECT_NE(error_of([&] { load(path); }), "") << size << " bytes";
  }
}

TEST(SceneGlb, MissingFilesAndFoldersAreErrors) {
  const TemporaryFolder folder;
  EXPECT_NE(error_of([&] { load(folder.path() / "none.glb"); }).find("no such file"), std::string::npos);
  EXPECT_NE(error_of([&] { load(folder.path()); }).find("not a file"), std::string::npos);
}

}  // namespace
}  // namespace regulus::scene::test

// Cameras as files give them: clipping planes, and which of them hide something; frames on films of any
// shape.
#include <gtest/gtest.h>

#include <cmath>

#include "interface/wavefront.h"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// A wall of 2 x 2 m at z = 0 and a camera at z = `distance` that looks at it.
Gltf wall(const json& camera, double distance = 5) {
  Gltf file;
  file.triangle({}, {{"translation", {-1, -1, 0}}, {"scale", {2, 2, 1}}});
  file.root["cameras"] = {camera};
  file.node({{"camera", 0}, {"translation", {0, 0, distance}}});
  return file;
}

json perspective(const json& members) {
  json camera = {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}};
  camera["perspective"].update(members);
  return camera;
}

bool clips(const Scene& scene) {
  return (find_features(scene).bits & interface::FEATURE_CLIPPING) != 0;
}

TEST(SceneClipping, PlanesThatHideNothingAreNotThere) {
  for (const auto& [nearest, farthest] : {std::pair(0.1, 100.0), {4.9, 5.1}, {0.0, 6.0}}) {
    const Scene scene = wall(perspective({{"znear", nearest}, {"zfar", farthest}})).load();
    EXPECT_EQ(scene.cameras[0].z_near, 0);
    EXPECT_EQ(scene.cameras[0].z_far, NO_FAR_PLANE);
    EXPECT_FALSE(clips(scene));
  }
}

TEST(SceneClipping, PlanesThatHideSomethingStay) {
  const Scene near_plane = wall(perspective({{"znear", 5.5}})).load();
  EXPECT_EQ(make_camera(near_plane.cameras[0], 10, 10).z_near, 5.5f);
  EXPECT_EQ(make_camera(near_plane.cameras[0], 10, 10).z_far, NO_FAR_PLANE);
  EXPECT_TRUE(clips(near_plane));
  const Scene far_plane = wall(perspective({{"zfar", 4.5}})).load();
  EXPECT_EQ(make_camera(far_plane.cameras[0], 10, 10).z_near, 0);
  EXPECT_EQ(make_camera(far_plane.cameras[0], 10, 10).z_far, 4.5f);
  EXPECT_TRUE(clips(far_plane));
  const json orthographic = {{"type", "orthographic"},
                             {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 2}}}};
  EXPECT_EQ(wall(orthographic).load().cameras[0].z_far, 2);
  EXPECT_EQ(wall(orthographic, 1.5).load().cameras[0].z_far, NO_FAR_PLANE);
}

// A camera in a corridor: the walls run past it, but not through what it sees before its near plane.
TEST(SceneClipping, WallsBesideTheCameraAreNotHidden) {
  Gltf file = wall(perspective({{"znear", 0.1}}));
  const size_t side = file.positions({-1, -1, -9, -1, -1, 9, -1, 3, 0});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", side}}}})}});
  EXPECT_FALSE(clips(file.load()));
  const size_t across = file.positions({-1, 0.05, 4.95, 1, 0.05, 4.95, 0, 0.04, 4.95});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", across}}}})}});
  EXPECT_TRUE(clips(file.load())) << "a speck before the near plane";
}

TEST(SceneClipping, CopiesAreLookedAtToo) {
  Gltf file = wall(perspective({{"znear", 1.0}}));
  const size_t places = file.accessor(std::vector<float>{0, 0, 0, 0, 0, 4.5f}, "VEC3", FLOAT);
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {
      {"attributes", {{"TRANSLATION", places}}}};
  const Scene scene = file.load({.sharing_gain = 0});
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.cameras[0].z_near, 1.0f);
}

TEST(SceneClipping, ImpossiblePlanesClipNothing) {
  for (const auto& [nearest, farthest] : {std::pair(-1.0, 4.0), {3.0, 2.0}, {2.0, 2.0}, {0.1, -4.0}}) {
    const Gltf file = wall(perspective({{"znear", nearest}, {"zfar", farthest}}));
    const Scene scene = file.load();
    EXPECT_FALSE(clips(scene));
    EXPECT_TRUE(has_warning(scene, "camera 0: znear"));
    EXPECT_NE(load_error(file).find("camera 0: znear"), std::string::npos);
  }
}

// glTF 2.0, 3.10.3: "client implementations SHOULD NOT crop": the frame is in view on every film.
TEST(SceneClipping, TheFrameOfACameraIsNeverCut) {
  const json orthographic = {{"type", "orthographic"},
                             {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0}, {"zfar", 100}}}};
  const double half = std::tan(0.5);
  for (const bool is_orthographic : {false, true}) {
    const Scene scene = wall(is_orthographic ? orthographic : perspective({{"aspectRatio", 2.0}})).load();
    const double height = is_orthographic ? 2 : half, width = 2 * height;
    for (const auto& [film_width, film_height] :
         {std::pair(200u, 100u), {100u, 100u}, {300u, 100u}, {50u, 200u}}) {
      const interface::Camera camera = make_camera(scene.cameras[0], film_width, film_height);
      const double right = glm::length(camera.right), up = glm::length(camera.up);
      EXPECT_NEAR(right / up, static_cast<double>(film_width) / film_height, 1e-5) << "pixels are square";
      EXPECT_NEAR(std::min(right / width, up / height), 1, 1e-6) << "the frame touches the film's border";
      EXPECT_GE(right, width * (1 - 1e-6));
      EXPECT_GE(up, height * (1 - 1e-6));
    }
  }
}

TEST(SceneClipping, WithoutAspectRatioTheVerticalFieldIsKept) {
  const Scene scene = wall(perspective(json::object())).load();
  EXPECT_NEAR(glm::length(make_camera(scene.cameras[0], 10, 100).up), std::tan(0.5), 1e-6);
}

}  // namespace
}  // namespace regulus::scene::test

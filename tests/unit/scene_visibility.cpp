// KHR_node_visibility: what is hidden, and what is not.
#include <gtest/gtest.h>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

json visibility(bool is_visible) {
  return {{"extensions", {{"KHR_node_visibility", {{"visible", is_visible}}}}}};
}

TEST(SceneVisibility, HiddenMeshesAreNotPlaced) {
  for (const char* used : {"extensionsUsed", "extensionsRequired"}) {
    Gltf file;
    file.root[used] = {"KHR_node_visibility"};
    file.triangle({}, visibility(false));
    file.triangle({}, visibility(true));
    file.triangle({}, {{"extensions", {{"KHR_node_visibility", json::object()}}}});
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangles.size(), 2u) << used;
    EXPECT_EQ(scene.inventory.instances, 2u);
    EXPECT_FALSE(has_warning(scene, "KHR_node_visibility"));
  }
}

TEST(SceneVisibility, ChildrenOfHiddenNodesAreHiddenWhateverTheySay) {
  Gltf file;
  file.triangle();                       // node 0
  file.triangle({}, visibility(true));   // node 1, below a hidden node
  file.triangle({}, visibility(false));  // node 2, hidden below a visible node
  file.triangle();                       // node 3, below node 2
  json hidden = visibility(false), visible = visibility(true);
  hidden["children"] = {1};
  visible["children"] = {2};
  file.root["nodes"][2]["children"] = {3};
  file.root["nodes"].push_back(hidden);   // node 4
  file.root["nodes"].push_back(visible);  // node 5
  file.root["scenes"][0]["nodes"] = {0, 4, 5};
  EXPECT_EQ(file.load().triangles.size(), 1u);
}

TEST(SceneVisibility, HiddenLightsDoNotShineAndHiddenCamerasSee) {
  Gltf file;
  file.triangle();
  file.light({{"type", "point"}});
  file.root["nodes"][1]["extensions"]["KHR_node_visibility"] = {{"visible", false}};
  file.root["cameras"] = {
      {{"name", "eye"}, {"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}}};
  json camera = visibility(false);
  camera["camera"] = 0;
  file.node(camera);
  const Scene scene = file.load();
  EXPECT_TRUE(scene.lights.empty());
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].name, "eye");
}

TEST(SceneVisibility, HiddenNodesHideAllTheirInstances) {
  Gltf file;
  file.triangle();
  file.triangle();
  const size_t places = file.accessor(std::vector<float>{0, 0, 0, 3, 0, 0}, "VEC3", FLOAT);
  for (const size_t node : {0u, 1u})
    file.root["nodes"][node]["extensions"]["EXT_mesh_gpu_instancing"] = {
        {"attributes", {{"TRANSLATION", places}}}};
  file.root["nodes"][1]["extensions"]["KHR_node_visibility"] = {{"visible", false}};
  EXPECT_EQ(file.load({.sharing_gain = NEVER_SHARE}).triangles.size(), 2u);
  EXPECT_EQ(file.load({.sharing_gain = 0}).instances.size(), 2u);
}

TEST(SceneVisibility, AScenesWhoseMeshesAreAllHiddenSaysSo) {
  Gltf file;
  file.triangle({}, visibility(false));
  EXPECT_NE(load_error(file).find("all 1 nodes with a mesh are invisible"), std::string::npos)
      << load_error(file);
}

}  // namespace
}  // namespace regulus::scene::test

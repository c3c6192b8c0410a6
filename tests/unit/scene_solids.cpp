// Which solids a scene has, how they are ranked, and whether paths need to know.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "bvh/scene_bvh.hpp"
#include "images/support/gltf_scene.hpp"
#include "interface/wavefront.h"
#include "scene/scene.hpp"

namespace regulus::test {
namespace {

using glm::dmat4;
using glm::dvec3;

scene::Scene load(const GltfScene& gltf) {
  const TemporaryFolder folder;
  gltf.write(folder / "scene.gltf");
  scene::Scene scene = scene::load(folder / "scene.gltf", {});
  bvh::build_for_scene(scene);
  return scene;
}

bool has_contacts(const GltfScene& gltf) {
  return (scene::find_features(load(gltf)).bits & interface::FEATURE_CONTACTS) != 0;
}

GltfScene lit() {
  GltfScene scene;
  scene.add_point_light({0, 9, 0}, dvec3(1));
  scene.set_perspective(look_at({0, 0, 9}, {0, 0, 0}), 0.5);
  return scene;
}

GltfScene with(const std::vector<Polygons>& solids) {
  GltfScene scene = lit();
  for (const Polygons& solid : solids) scene.add(solid, glass(1.5));
  return scene;
}

Polygons joined(Polygons a, const Polygons& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(Solids, VolumesAndRanks) {
  GltfScene gltf = with({box({-1, -1, -1}, {1, 1, 1})});
  nlohmann::json first = glass(1.3);
  first["extras"] = {{"regulus", {{"priority", 2}}}};
  gltf.add(box({2, 0, 0}, {5, 3, 3}), first);
  gltf.add(sphere({-4, 0, 0}, 0.5, 24), glass(1.1));
  const scene::Scene scene = load(gltf);
  const auto& ranked = scene.solids.ranked;
  ASSERT_EQ(ranked.size(), 3u);
  EXPECT_DOUBLE_EQ(ranked[0].volume, 27) << "priority goes before volume";
  // A sphere's polyhedron of latitude and longitude cells has nearly its volume.
  EXPECT_NEAR(ranked[1].volume, 4.0 / 3 * 3.14159265 * 0.125, 0.02);
  EXPECT_NEAR(ranked[2].volume, 8, 1e-12);
  for (const scene::RankedSolid& solid : ranked) EXPECT_TRUE(solid.is_closed);
  EXPECT_FALSE(scene.solids.has_contacts);
}

// Of equal volume the first node's; a block in two places is two solids.
TEST(Solids, NodesDecideBetweenEqualVolumes) {
  GltfScene gltf = with({box({0, 0, 0}, {1, 1, 1})});
  gltf.add_copy(glm::translate(dmat4(1), dvec3(0.5, 0, 0)));
  const scene::Scene scene = load(gltf);
  ASSERT_EQ(scene.solids.ranked.size(), 2u);
  EXPECT_LT(scene.solids.ranked[0].place, scene.solids.ranked[1].place);
  EXPECT_TRUE(scene.solids.has_contacts);
}

TEST(Solids, ACavityBelongsToWhatIsAroundIt) {
  const scene::Scene scene =
      load(with({joined(box({0, 0, 0}, {3, 3, 3}), turned(box({1, 1, 1}, {2, 2, 2})))}));
  ASSERT_EQ(scene.solids.ranked.size(), 1u);
  EXPECT_NEAR(scene.solids.ranked[0].volume, 26, 1e-12);
  EXPECT_FALSE(scene.solids.has_contacts);
}

// Two blocks of one mesh that share a face, or an edge, are two solids.
TEST(Solids, BlocksOfOneMeshThatTouchAreTwo) {
  for (const dvec3& corner : {dvec3(1, 0, 0), dvec3(1, 1, 0)}) {
    const scene::Scene scene = load(with({joined(box({0, 0, 0}, {1, 1, 1}), box(corner, corner + 1.0))}));
    ASSERT_EQ(scene.solids.ranked.size(), 2u);
    for (const scene::RankedSolid& solid : scene.solids.ranked) {
      EXPECT_TRUE(solid.is_closed);
      EXPECT_NEAR(solid.volume, 1, 1e-12);
    }
    EXPECT_TRUE(scene.solids.has_contacts);
  }
}

// A side cut in two where its neighbours are not: nothing is open.
TEST(Solids, SidesThatAreCutDifferentlyAreClosed) {
  Polygons block = box({0, 0, 0}, {1, 1, 1});
  std::erase_if(block, [](const Polygon& side) {
    return std::all_of(side.begin(), side.end(), [](const dvec3& p) { return p.y == 1; });
  });
  block.push_back(quad({0, 1, 1}, {0.3, 0, 0}, {0, 0, -1}));
  block.push_back(quad({0.3, 1, 1}, {0.7, 0, 0}, {0, 0, -1}));
  scene::Scene scene = load(with({block}));
  ASSERT_EQ(scene.solids.ranked.size(), 1u);
  EXPECT_TRUE(scene.solids.ranked[0].is_closed);
  EXPECT_NEAR(scene.solids.ranked[0].volume, 1, 1e-12);
  block.pop_back();
  scene = load(with({block}));
  EXPECT_FALSE(scene.solids.ranked[0].is_closed);
}

// Both ends of a tube: their areas cancel, and still it is open.
TEST(Solids, ATubeIsOpen) {
  Polygons tube = box({0, 0, 0}, {1, 1, 3});
  std::erase_if(tube, [](const Polygon& side) {
    return std::all_of(side.begin(), side.end(), [&](const dvec3& p) { return p.z == side.front().z; });
  });
  const scene::Scene scene = load(with({tube}));
  ASSERT_EQ(scene.solids.ranked.size(), 1u);
  EXPECT_FALSE(scene.solids.ranked[0].is_closed);
}

TEST(Solids, WhatIsOpenIsKnownToBe) {
  Polygons open = box({0, 0, 0}, {1, 1, 1});
  open.pop_back();
  const scene::Scene scene = load(with({open}));
  ASSERT_EQ(scene.solids.ranked.size(), 1u);
  EXPECT_FALSE(scene.solids.ranked[0].is_closed);
}

TEST(Contacts, AreFoundWhereThereAreAny) {
  const Polygons block = box({-1, -1, -1}, {1, 1, 1});
  EXPECT_FALSE(has_contacts(with({block})));
  EXPECT_FALSE(has_contacts(with({block, box({1.001, -1, -1}, {2, 1, 1})}))) << "a millimetre apart";
  EXPECT_TRUE(has_contacts(with({block, box({1, -1, -1}, {2, 1, 1})}))) << "a shared face";
  EXPECT_TRUE(has_contacts(with({block, box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})}))) << "nested";
  EXPECT_TRUE(has_contacts(with({box({-1, 0, -1}, {1, 1e-5, 1})}))) << "thin";
  // Spheres whose boxes overlap, but not they.
  EXPECT_FALSE(has_contacts(with({sphere({0, 0, 0}, 1, 24), sphere({1.3, 1.3, 1.3}, 1, 24)})));

  GltfScene lamp = with({block});
  lamp.add_point_light({0, 0.5, 0}, dvec3(1));
  EXPECT_TRUE(has_contacts(lamp)) << "a lamp in it";
  GltfScene camera = with({block});
  camera.set_perspective(look_at({0, 0, 0.5}, {0, 0, 0}), 0.5);
  EXPECT_TRUE(has_contacts(camera)) << "a camera in it";

  GltfScene table = with({box({-1, 0, -1}, {1, 1, 1})});
  table.add({quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4})}, lambert(dvec3(0.5)));
  EXPECT_TRUE(has_contacts(table)) << "a block on a table";
}

TEST(Contacts, OfOpaqueSurfacesCountWhereTheyAreSeen) {
  const Polygon floor = quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
  const Polygon paper = quad({-0.5, 0, 0.5}, {1, 0, 0}, {0, 0, -1.5});
  const auto on_floor = [&](const Polygons& other, const nlohmann::json& material) {
    GltfScene scene = lit();
    scene.add({floor}, lambert(dvec3(0.5)));
    scene.add(other, material);
    return has_contacts(scene);
  };
  EXPECT_TRUE(on_floor({paper}, lambert(dvec3(0.9))));
  EXPECT_FALSE(on_floor({paper}, lambert(dvec3(0.5)))) << "of the same material";
  EXPECT_FALSE(on_floor(box({-0.5, 0, -0.5}, {0.5, 1, 0.5}), lambert(dvec3(0.9)))) << "a box's bottom";
  EXPECT_TRUE(on_floor(turned({paper}), emitter(dvec3(1)))) << "a lamp, whichever way it faces";
  EXPECT_TRUE(on_floor(turned({floor}), lambert(dvec3(0.9)))) << "the other side of a leaf";
  EXPECT_FALSE(on_floor({quad({-0.5, 0.001, 0.5}, {1, 0, 0}, {0, 0, -1})}, lambert(dvec3(0.9))))
      << "above it";
}

}  // namespace
}  // namespace regulus::test

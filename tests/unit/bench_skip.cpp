// Features that are present but unused: each of them is found, and none of the others.
#include <gtest/gtest.h>

#include "bench/skip.hpp"
#include "bvh/scene_bvh.hpp"
#include "images/support/gltf_scene.hpp"
#include "interface/wavefront.h"

namespace regulus::test {
namespace {

TEST(BenchSkip, EachFeatureCanBeAddedToASceneThatLacksIt) {
  GltfScene gltf;
  gltf.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
  gltf.add_spot_light({0, 1, 0}, {0, -1, 0}, 1, 0.2, 0.5);
  const TemporaryFolder folder;
  gltf.write(folder / "scene.gltf");
  const scene::Scene plain = scene::load(folder / "scene.gltf", {});
  scene::Scene prepared = plain;
  bvh::build_for_scene(prepared);
  const uint32_t present = scene::find_features(prepared).bits;
  ASSERT_EQ(present, interface::FEATURE_POINT_LIGHTS);
  for (const scene::FeatureDescription& feature : scene::feature_descriptions()) {
    scene::Scene changed = plain;
    if ((present & feature.bit) != 0 || !bench::add_unused_feature(changed, feature.bit)) {
      // Light from everywhere is never unused, and a mesh in several places is no speck.
      constexpr uint32_t NOT_ADDED =
          interface::FEATURE_ENVIRONMENT | interface::FEATURE_ENVIRONMENT_MAP | interface::FEATURE_INSTANCES;
      EXPECT_TRUE((feature.bit & (present | NOT_ADDED)) != 0) << feature.name;
      continue;
    }
    bvh::build_for_scene(changed);
    EXPECT_NE(scene::find_features(changed).bits & feature.bit, 0u) << feature.name;
    EXPECT_EQ(changed.triangles.size(),
              plain.triangles.size() + (feature.bit == interface::FEATURE_CONTACTS ? 4 : 1))
        << feature.name;
  }
}

}  // namespace
}  // namespace regulus::test

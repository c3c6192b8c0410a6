// The room that guides are tested in, and its renders.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "images/support/gltf_scene.hpp"
#include "images/support/prepared_scene.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {

/// A room with a light of every kind: lamps in it and before its window, a sun and a sky behind that. Much of
/// the light of all but the lamps is lost outside.
inline PreparedScene room_of_all_lights() {
  GltfScene scene;
  const nlohmann::json white = lambert({0.7, 0.7, 0.7});
  const Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  for (const size_t wall : {0u, 1u, 2u, 4u, 5u})
    scene.add({walls[wall]}, wall == 2 ? plastic({0.4, 0.4, 0.6}, 0.5) : white);
  scene.add({quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 0.6}), quad({-1, 1, 0.2}, {2, 0, 0}, {0, 0, 0.8})}, white);
  scene.add(box({-0.6, -1, -0.5}, {-0.1, -0.4, 0}), metal({0.9, 0.7, 0.4}, 0.6));
  scene.add(box({0.2, -0.9, -0.3}, {0.6, -0.6, 0.2}), glass(1.5, 0.6));
  scene.add({quad({-0.2, 0.2, -0.999}, {0.4, 0, 0}, {0, 0.2, 0})}, emitter({1, 0.5, 0.5}));
  scene.add({quad({-0.3, 1.6, -0.4}, {0.3, 0.1, 0}, {0, 0, 0.3})}, emitter({2, 4, 3}, true));
  scene.add({quad({-4, -1, 3}, {0, 0, 2}, {2, 0, 0})}, white);  // the scene is larger than the room
  scene.add_point_light({0.4, 1.3, -0.2}, {0.8, 0.9, 1.2});
  scene.add_spot_light({-0.6, 0.7, 0.4}, {0.3, -1, -0.4}, 0.8, 0.2, 0.7);
  scene.add_directional_light({0.1, -1, 0.05}, 1.5);
  scene.set_perspective(look_at({0, -0.2, 0.95}, {0, -1, -0.6}), 0.85);
  image::Image sky{16, 8, {}};
  for (uint32_t i = 0; i < 16 * 8; ++i)
    for (const double channel : {0.4, 0.6, 1.0})
      sky.rgb.push_back(static_cast<float>(i == 2 * 16 + 5 ? 40 : i < 64 ? channel * (1 + i % 3) : 0.1));
  return prepare(scene, sky, 25);
}

/// Few pixels and samples of these techniques, merges within 2 cm.
inline render::RenderSettings guided_settings(uint32_t techniques) {
  render::RenderSettings settings = box_filtered(16, 16, 24, 5);
  settings.techniques = techniques;
  if ((techniques & interface::TECHNIQUE_MERGE) != 0) {
    settings.light_paths = 2048;
    settings.merge_radius = 0.02f;
    settings.merge_reduction = 0;
  }
  return settings;
}

/// Eleven renders that differ in their seed alone, all with the guide that `set_guide` puts into the plan.
inline std::vector<image::Image> guided_batches(const PreparedScene& prepared, uint32_t techniques,
                                                uint32_t stream,
                                                const std::function<void(render::Plan&)>& set_guide) {
  constexpr uint32_t BATCHES = 11;
  std::vector<image::Image> result;
  render::RenderSettings settings = guided_settings(techniques);
  for (uint32_t i = 0; i < BATCHES; ++i) {
    settings.seed = static_cast<uint32_t>(base_seed() + 1000 * stream) + i;
    render::Plan plan = make_plan(prepared, settings);
    set_guide(plan);
    render::Renderer renderer(*device(), prepared, plan);
    renderer.render([](uint64_t, uint64_t) { return true; });
    EXPECT_EQ(renderer.statistics().non_finite, 0u);
    result.push_back(resolve(renderer.film()));
  }
  return result;
}

}  // namespace regulus::test

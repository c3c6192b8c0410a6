// Techniques that can find the same light must agree, alone and combined. The lights are out of the camera's
// view: what it sees itself can be found by hits alone.
#include <gtest/gtest.h>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using render::RenderSettings;

constexpr int BATCHES = 17;
constexpr uint32_t SIZE = 16;

void expect_techniques_agree(const char* name, const GltfScene& scene, uint32_t stream) {
  const PreparedScene prepared = prepare(scene);
  RenderSettings settings = box_filtered(SIZE, SIZE, is_slow_device() ? 4 : 32, 4);
  const auto batches = [&](uint32_t techniques, uint32_t number) {
    settings.techniques = techniques;
    return render_batches(prepared, settings, BATCHES, stream + number);
  };
  const auto hit = batches(interface::TECHNIQUE_HIT, 0), nee = batches(interface::TECHNIQUE_NEE, 1),
             both = batches(interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE, 2);
  const std::array<double, 3> mean = mean_of(both[0]);
  std::printf("%s: mean %.4f %.4f %.4f\n", name, mean[0], mean[1], mean[2]);
  EXPECT_GT(mean[0], 0);
  expect_equal((std::string(name) + ", hit and nee").c_str(), hit, nee);
  expect_equal((std::string(name) + ", hit and hit,nee").c_str(), hit, both);
  expect_equal((std::string(name) + ", nee and hit,nee").c_str(), nee, both);
}

class Techniques : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

TEST_F(Techniques, AgreeOnDiffuseSurfaces) {
  GltfScene scene = room(WHITE, WHITE, WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_techniques_agree("diffuse room", scene, 1);
}

TEST_F(Techniques, AgreeOnGlossySurfaces) {
  GltfScene scene =
      room(plastic({0.4, 0.4, 0.6}, 0.5), metal({0.9, 0.7, 0.4}, 0.5), plastic({0.2, 0.5, 0.3}, 0.7));
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_techniques_agree("glossy room", scene, 11);
}

TEST_F(Techniques, AgreeOnRoughGlass) {
  GltfScene scene = room(WHITE, glass(1.5, 0.6), glass(1.3, 0.8, {0.3, 0.8, 0.9}));
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  expect_techniques_agree("rough glass", scene, 21);
}

// One double-sided light in the middle of the room, which lights the ceiling too, and one that is one-sided.
TEST_F(Techniques, AgreeOnDoubleSidedLights) {
  GltfScene scene = room(WHITE, metal({0.9, 0.7, 0.4}, 0.5), WHITE);
  scene.add({quad({-0.4, 0.35, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})}, emitter({1, 1, 1}, true));
  scene.add({quad({-0.6, 0.3, 0.999}, {0, 0.5, 0}, {1.2, 0, 0})}, emitter({0.5, 1, 2}));  // on the front wall
  expect_techniques_agree("double-sided light", scene, 31);
}

// The back of a one-sided light is dark, whichever technique looks at it.
TEST_F(Techniques, OneSidedLightsAreDarkFromBehind) {
  for (const bool is_double_sided : {false, true}) {
    GltfScene scene;
    scene.add({quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})}, lambert({0.5, 0.5, 0.5}));
    scene.add({quad({-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0})},
              emitter({1, 1, 1}, is_double_sided));  // faces up
    scene.set_orthographic(look_at({0, 0, 0.05}, {0, 0, 0}), 1, 1);
    const PreparedScene prepared = prepare(scene);
    for (const uint32_t techniques : {interface::TECHNIQUE_HIT, interface::TECHNIQUE_NEE}) {
      RenderSettings settings = box_filtered(8, 8, 64, 2);
      settings.techniques = techniques;
      const double mean = mean_of(render(prepared, settings).image)[0];
      if (is_double_sided)
        EXPECT_GT(mean, 0.01);
      else
        EXPECT_EQ(mean, 0);
    }
  }
}

}  // namespace
}  // namespace regulus::test

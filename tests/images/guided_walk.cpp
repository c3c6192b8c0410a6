// Guided camera walks change no picture's mean: against path tracing without a guide, with the scene's own
// guide and with one that points anywhere; and what is done of what is asked.
#include <gtest/gtest.h>

#include <algorithm>

#include "images/support/comparison.hpp"
#include "images/support/lit_room.hpp"
#include "images/support/render_scene.hpp"
#include "probe/walk_cells.hpp"
#include "render/names.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using namespace technique_sets;
using render::RenderSettings;

/// Cells that each look another way, and all with a large share.
std::shared_ptr<const scene::WalkGuide> wrong_guide() {
  const glm::vec3 extent(2.4F);
  const scene::WalkGuide bounds{{}, glm::vec3(-1.23F), 1.0F / extent};
  Random random(600);
  std::vector<probe::CellKey> visits;
  std::vector<probe::Arrival> arrivals;
  for (int i = 0; i < 20000; ++i) {
    probe::CellKey key;
    for (uint16_t& place : key.place) place = static_cast<uint16_t>(random.index(1u << GUIDE_HALVINGS));
    key.sides = static_cast<uint8_t>(random.index(64));
    visits.push_back(key);
    probe::Arrival arrival;
    arrival.key = key;
    const uint32_t way = key.sides * 37u + (key.place[0] >> 9) * 11u + (key.place[1] >> 9) * 5u;
    arrival.direction = {static_cast<uint16_t>((way * 129u + random.index(150)) % (1u << GUIDE_HALVINGS)),
                         static_cast<uint16_t>((way * 311u + random.index(150)) % (1u << GUIDE_HALVINGS))};
    arrival.cosine = 0.5F;
    arrival.weight = 100;
    arrival.is_second = i % 2 != 0;
    arrivals.push_back(arrival);
  }
  return std::make_shared<scene::WalkGuide>(probe::make_walk_guide(bounds, visits, arrivals).guide);
}

/// True if some cell has a share.
bool guides(const scene::WalkGuide& guide) {
  return std::ranges::any_of(guide.nodes, [](const GuideNode& node) {
    return node.next != GUIDE_LEAF && (node.next & WALK_GUIDE_AXIS_MASK) == WALK_GUIDE_CELL &&
           node.first_share > 0.2F;
  });
}

class GuidedWalk : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (is_slow_device()) GTEST_SKIP() << "slow device";
    prepared_ = room_of_all_lights();
  }

  std::vector<image::Image> batches(uint32_t techniques, std::shared_ptr<const scene::WalkGuide> guide,
                                    uint32_t stream) const {
    return guided_batches(prepared_, techniques, stream,
                          [&](render::Plan& plan) { plan.walk_guide = guide; });
  }

  PreparedScene prepared_;
};

TEST_F(GuidedWalk, KeepsTheMean) {
  RenderSettings settings = guided_settings(PT);
  settings.walk_guide = LIGHT_GUIDE_ON;
  const render::Plan plan = make_plan(prepared_, settings);
  ASSERT_TRUE(plan.walk_guide);
  std::printf("%s\n", plan.walk_guide_rule.c_str());
  const std::vector<image::Image> known = batches(PT, nullptr, 610);
  uint32_t stream = 611;
  for (const auto& [name, guide] :
       {std::pair("own guide", plan.walk_guide), std::pair("wrong guide", wrong_guide())}) {
    EXPECT_TRUE(guides(*guide)) << name;
    for (const uint32_t techniques : {PT, VCM}) {
      ComparisonOptions options;
      // A merge averages over its disk, which matters near edges and corners.
      if ((techniques & TECHNIQUE_MERGE) != 0) options.relative_tolerance = 3e-3;
      expect_equal((std::string(name) + ", " + render::technique_set_name(techniques)).c_str(),
                   batches(techniques, guide, stream++), known, options);
    }
  }
}

TEST_F(GuidedWalk, IsDoneWherePathsGoOn) {
  RenderSettings settings = guided_settings(TECHNIQUE_SPLAT);
  settings.walk_guide = LIGHT_GUIDE_ON;
  const render::Plan plan = make_plan(prepared_, settings);
  EXPECT_FALSE(plan.walk_guide);
  EXPECT_NE(plan.why_dropped("guided camera walks"), nullptr);
  settings = guided_settings(PT);
  EXPECT_FALSE(make_plan(prepared_, settings).walk_guide);
  EXPECT_EQ(make_plan(prepared_, settings).walk_guide_rule, "");
}

// The guide follows what is done, whoever asked for it: a part that repeats another's choice has its guide.
// Light of a point through clear glass is found by regularized next-event estimation alone, so that it
// matters here.
TEST_F(GuidedWalk, FollowsTheRegularizationThatIsDone) {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add(turned(box({-1, -0.1, -1}, {1, 2, 1})), lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.5, 0.3, -0.5}, {0.5, 0.9, 0.5}), glass(1.5));
  scene.add_point_light({0.1, 1.6, 0.1}, {3, 3, 3});
  scene.set_perspective(look_at({0, 0.8, 0.95}, {0, 0.2, 0}), 1.2);
  const PreparedScene prepared = prepare(scene);
  const auto hash = [&](std::optional<uint32_t> regularization) {
    RenderSettings settings = guided_settings(PT);
    settings.walk_guide = LIGHT_GUIDE_ON;
    settings.regularization = regularization;
    const render::Plan plan = make_plan(prepared, settings);
    return plan.walk_guide ? hash_of(*plan.walk_guide) : 0;
  };
  RenderSettings chosen = guided_settings(PT);
  chosen.regularization = std::nullopt;
  const uint32_t done = make_plan(prepared, chosen).regularization;
  ASSERT_NE(done & REGULARIZATION_ROUGHNESS, 0u);
  EXPECT_EQ(hash(std::nullopt), hash(REGULARIZATION_ROUGHNESS));
  EXPECT_NE(hash(std::nullopt), hash(REGULARIZATION_NONE));
}

}  // namespace
}  // namespace regulus::test

// Guided emission changes no picture's mean: guided sets of techniques against path tracing, which has no
// light paths, with the scene's own guide and with one that points anywhere.
#include <gtest/gtest.h>

#include "images/support/comparison.hpp"
#include "images/support/lit_room.hpp"
#include "images/support/render_scene.hpp"
#include "probe/guide_tree.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;

using namespace technique_sets;

// Whatever it was made for, a guide leaves all light some share.
std::shared_ptr<const scene::LightGuide> wrong_guide(const PreparedScene& prepared) {
  Random random(400);
  std::vector<probe::Deposit> deposits;
  for (uint32_t light = 0; light < prepared.scene.lights.size(); ++light) {
    const glm::dvec4 corner(0.5 * random.square(), 0.5 * random.square());
    for (int i = 0; i < 2000; ++i) {
      probe::Deposit deposit{light, {}, 1};
      for (size_t axis = 0; axis < 4; ++axis)
        deposit.cell[axis] = static_cast<uint16_t>((corner[static_cast<int>(axis)] + random.uniform(0, 0.4)) *
                                                   (1u << GUIDE_HALVINGS));
      deposits.push_back(deposit);
    }
  }
  return std::make_shared<scene::LightGuide>(probe::make_light_guide(prepared.scene, deposits));
}

class GuidedEmission : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (is_slow_device()) GTEST_SKIP() << "slow device";
    prepared_ = room_of_all_lights();
  }

  std::vector<image::Image> batches(uint32_t techniques, std::shared_ptr<const scene::LightGuide> guide,
                                    uint32_t stream) const {
    return guided_batches(prepared_, techniques, stream,
                          [&](render::Plan& plan) { plan.light_guide = guide; });
  }

  void expect_sets_agree(const char* name, const std::shared_ptr<const scene::LightGuide>& guide,
                         const std::vector<std::pair<const char*, uint32_t>>& sets, uint32_t stream) const {
    ASSERT_TRUE(guide);
    const std::vector<image::Image> known = batches(PT, nullptr, stream++);
    for (const auto& [set, techniques] : sets) {
      ComparisonOptions options;
      // A merge averages over its disk, which matters near edges and corners.
      if ((techniques & TECHNIQUE_MERGE) != 0) options.relative_tolerance = 3e-3;
      expect_equal((std::string(name) + ", " + set).c_str(), batches(techniques, guide, stream++), known,
                   options);
    }
  }

  PreparedScene prepared_;
};

TEST_F(GuidedEmission, KeepsTheMean) {
  RenderSettings settings = guided_settings(VCM);
  settings.light_guide = LIGHT_GUIDE_ON;
  const render::Plan plan = make_plan(prepared_, settings);
  std::printf("%s\n", plan.light_guide_rule.c_str());
  expect_sets_agree("own guide", plan.light_guide,
                    {{"bpt", BPT},
                     {"vcm", VCM},
                     {"nee, splat", TECHNIQUE_NEE | TECHNIQUE_SPLAT},
                     {"hit, nee, merge", TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_MERGE}},
                    410);
}

TEST_F(GuidedEmission, KeepsTheMeanWithAGuideThatPointsAnywhere) {
  expect_sets_agree("wrong guide", wrong_guide(prepared_),
                    {{"bpt", BPT}, {"vcm", VCM}, {"nee, splat", TECHNIQUE_NEE | TECHNIQUE_SPLAT}}, 420);
}

// What `auto` and `on` come to, and what they leave alone.
TEST_F(GuidedEmission, IsDoneWhereThereAreLightPaths) {
  RenderSettings settings = guided_settings(PT);
  settings.light_guide = LIGHT_GUIDE_ON;
  const render::Plan plain = make_plan(prepared_, settings);
  EXPECT_FALSE(plain.light_guide);
  EXPECT_NE(plain.why_dropped("guided emission"), nullptr);
  settings.light_guide = LIGHT_GUIDE_AUTO;
  EXPECT_EQ(make_plan(prepared_, settings).why_dropped("guided emission"), nullptr);
  settings = guided_settings(BPT);
  EXPECT_FALSE(make_plan(prepared_, settings).light_guide);
  EXPECT_EQ(make_plan(prepared_, settings).light_guide_rule, "");
}

}  // namespace
}  // namespace regulus::test

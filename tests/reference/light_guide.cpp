// Guided emission: the numbers of a start are those it was made of, moved ones have their density, and no
// start is less likely than the defensive share of what it is by power.
#include "probe/light_guide.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "probe/guide_tree.hpp"
#include "reference/light_guide.hpp"
#include "reference/support/reference_images.hpp"
#include "support/chi_square.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using namespace interface;

// One light of every kind over a floor, and many small ones.
test::GltfScene scene_of_lights(int small_lights = 0) {
  test::GltfScene scene;
  scene.add({test::quad({-1, 0, -1}, {0, 0, 2}, {2, 0, 0})}, test::lambert({0.5, 0.5, 0.5}));
  scene.add({{{0, 1, 0}, {0.2, 1, 0}, {0, 1.3, 0.2}}}, test::emitter({1, 2, 3}));
  scene.add({{{0, 2, 0}, {0.2, 2, 0.1}, {0, 2.3, 0.2}}}, test::emitter({1, 2, 3}, true));
  for (int i = 0; i < small_lights; ++i) {
    const double x = 0.01 * i - 1;
    scene.add({{{x, 0.5, 0}, {x + 0.005, 0.5, 0}, {x, 0.5, 0.005}}}, test::emitter({20, 2, 3}));
  }
  scene.add_point_light({0, 1, 1}, {1, 1, 1});
  scene.add_spot_light({0, 1, -1}, {0.2, -1, 0.1}, 3, 0.3, 0.9);
  scene.add_directional_light({0.1, -1, 0}, 2);
  scene.set_perspective(test::look_at({0, 3, 5}, {0, 0, 0}), 0.8);
  return scene;
}

image::Image sky() {
  image::Image map{16, 8, {}};
  for (uint32_t i = 0; i < 16 * 8; ++i)
    for (const double channel : {0.4, 0.6, 1.0})
      map.rgb.push_back(static_cast<float>(i == 2 * 16 + 5 ? 40 : channel * (1 + i % 3)));
  return map;
}

const char* const KINDS[] = {"triangle", "point", "spot", "directional", "environment"};

void expect_numbers_inverted(const PreparedScene& prepared) {
  const World world(prepared);
  for (uint32_t light = 0; light < prepared.scene.lights.size(); ++light) {
    test::Random random(60 + light);
    const uint32_t kind = prepared.scene.lights[light].kind;
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const dvec2 place = random.square();
      const dvec2 direction = random.square();
      const LightPoint point = sample_light_point(world, light, place);
      const EmissionRay ray = sample_emission(world, point, place, direction);
      const dvec3 along = ray.origin + random.uniform(0.1, 2) * ray.direction;
      const dvec4 found = start_numbers(world, point, ray.direction, along);
      const bool has_place = kind == LIGHT_DIRECTIONAL || kind == LIGHT_ENVIRONMENT;
      const dvec4 made(has_place ? place : dvec2(0), kind == LIGHT_DIRECTIONAL ? dvec2(0) : direction);
      for (int axis = 0; axis < 4; ++axis) worst = std::max(worst, std::abs(found[axis] - made[axis]));
    }
    // Around an axis a turn is known as well as the sine; the environment's cells are of single precision.
    std::printf("%s: numbers differ by %.2g (bound 1e-6)\n", KINDS[kind], worst);
    EXPECT_LT(worst, 1e-6) << KINDS[kind];
  }
}

TEST(LightGuide, NumbersAreThoseOfTheStart) {
  expect_numbers_inverted(test::prepare(scene_of_lights(), sky(), 25));
}

/// Deposits around a few random starts of each light.
std::vector<probe::Deposit> random_deposits(const scene::Scene& scene, test::Random& random) {
  std::vector<probe::Deposit> deposits;
  for (uint32_t light = 0; light < scene.lights.size(); ++light) {
    const dvec4 middle(random.square(), random.square());
    const int count = scene.lights.size() > 10 && light % 7 != 0 ? 1 : 3000;
    for (int i = 0; i < count; ++i) {
      probe::Deposit deposit{light, {}, 1 + static_cast<uint64_t>(random.uniform(0, 1000))};
      for (size_t axis = 0; axis < 4; ++axis) {
        const double around = middle[static_cast<int>(axis)] + 0.1 * std::pow(random.uniform(-1, 1), 3);
        deposit.cell[axis] = static_cast<uint16_t>(std::clamp(around, 0.0, 0.9999) * (1u << GUIDE_HALVINGS));
      }
      deposits.push_back(deposit);
    }
  }
  return deposits;
}

class LightGuides : public testing::Test {
 protected:
  explicit LightGuides(int small_lights = 0)
      : prepared_(test::prepare(scene_of_lights(small_lights), sky(), 25)) {
    test::Random random(70);
    deposits_ = random_deposits(prepared_.scene, random);
    guide_ = std::make_shared<scene::LightGuide>(probe::make_light_guide(prepared_.scene, deposits_));
  }

  PreparedScene prepared_;
  std::vector<probe::Deposit> deposits_;
  std::shared_ptr<const scene::LightGuide> guide_;
};

struct Box {
  dvec4 lower{0}, upper{1};
  dvec4 middle() const { return (lower + upper) / 2.0; }
  double volume() const {
    const dvec4 size = upper - lower;
    return size.x * size.y * size.z * size.w;
  }
  Box half(int axis, bool is_upper) const {
    Box half = *this;
    (is_upper ? half.lower : half.upper)[axis] = middle()[axis];
    return half;
  }
};

/// Calls visit(box) for each leaf below a node.
void for_each_leaf(const scene::LightGuide& guide, uint32_t node, const Box& box,
                   const std::function<void(const Box&)>& visit) {
  const GuideNode& at = guide.nodes[node];
  if (at.next == GUIDE_LEAF) return visit(box);
  for (uint32_t i = 0; i < 2; ++i)
    for_each_leaf(guide, (at.next >> GUIDE_AXIS_BITS) + i,
                  box.half(static_cast<int>(at.next & GUIDE_AXIS_MASK), i == 1), visit);
}

/// Number of the leaf, as for_each_leaf() counts them, and the box.
std::pair<size_t, Box> leaf_of(const scene::LightGuide& guide, uint32_t light, const dvec4& numbers) {
  std::pair<size_t, Box> found;
  size_t count = 0;
  for_each_leaf(guide, guide.lights[light].root, {}, [&](const Box& box) {
    bool is_inside = true;
    for (int axis = 0; axis < 4; ++axis)
      is_inside = is_inside && numbers[axis] >= box.lower[axis] && numbers[axis] < box.upper[axis];
    if (is_inside) found = {count, box};
    ++count;
  });
  return found;
}

// Counts in both halves of each leaf, against the density in their middle times their volume.
TEST_F(LightGuides, StartsHaveTheirDensity) {
  constexpr int SAMPLES = 100000;
  for (uint32_t light = 0; light < prepared_.scene.lights.size(); ++light) {
    std::vector<double> expected;
    double whole = 0;
    for_each_leaf(*guide_, guide_->lights[light].root, {}, [&](const Box& box) {
      for (const bool is_upper : {false, true}) {
        const Box half = box.half(static_cast<int>(expected.size() / 2 % 4), is_upper);
        const double mass = guide_density(*guide_, light, half.middle()) * half.volume();
        expected.push_back(mass * SAMPLES);
        whole += mass;
      }
    });
    test::Random random(80 + light);
    std::vector<double> observed(expected.size());
    for (int i = 0; i < SAMPLES; ++i) {
      const dvec4 moved = guide_start(*guide_, light, {random.square(), random.square()});
      const auto [leaf, box] = leaf_of(*guide_, light, moved);
      const auto axis = static_cast<int>(leaf % 4);
      observed[2 * leaf + (moved[axis] >= box.middle()[axis] ? 1 : 0)] += 1;
    }
    const test::ChiSquare result = test::chi_square_test(observed, expected);
    std::printf("%s: %zu leaves, integral 1 + %.1g, p %.3g\n", KINDS[prepared_.scene.lights[light].kind],
                expected.size() / 2, whole - 1, result.p_value);
    EXPECT_GT(expected.size(), 2u * 20) << "the test is about nothing";
    EXPECT_NEAR(whole, 1, 1e-9);
    EXPECT_TRUE(result.problem.empty()) << result.problem;
    EXPECT_GT(result.p_value, test::significance_per_test(1e-4, 6));
  }
}

// By lights and starts together. A share of a half and what it leaves are rounded to single precision and not
// less than 2^-14, which a tree of twenty levels adds up to a part in 500.
void expect_defended(const PreparedScene& prepared, const scene::LightGuide& guide) {
  test::Random random(90);
  double least = 1;
  double most = 0;
  double whole = 0;
  for (uint32_t light = 0; light < prepared.scene.lights.size(); ++light) {
    const double selection =
        double{guide.lights[light].selection_pdf} / double{prepared.scene.lights[light].selection_pdf};
    whole += double{guide.lights[light].selection_pdf};
    for (int i = 0; i < 1000; ++i) {
      const dvec4 numbers(random.square(), random.square());
      const double share = selection * guide_density(guide, light, numbers);
      least = std::min(least, share);
      most = std::max(most, share);
    }
  }
  std::printf("a start is %.4f to %.3g times as likely as by power (bound %g)\n", least, most,
              probe::DEFENSIVE_SHARE);
  EXPECT_NEAR(whole, 1, 1e-5);
  EXPECT_GT(least, probe::DEFENSIVE_SHARE * (1 - 2e-3));
  EXPECT_GT(most, 3) << "the test is about nothing";
}

TEST_F(LightGuides, NoStartIsLessLikelyThanTheDefensiveShare) {
  expect_defended(prepared_, *guide_);
}

// Of which most have a single deposit and share with their neighbours.
class LightGuidesOfManyLights : public LightGuides {
 protected:
  LightGuidesOfManyLights() : LightGuides(200) {}
};

TEST_F(LightGuidesOfManyLights, NoStartIsLessLikelyThanTheDefensiveShare) {
  expect_defended(prepared_, *guide_);
}

Settings small_film() {
  Settings settings;
  settings.width = settings.height = 32;
  settings.samples = 8;
  settings.max_depth = 5;
  return settings;
}

// A camera that looks at a hundredth of a plain under a sun, and one that looks into a closed room.
TEST(LightGuideTraining, TellsWhereLightIsWasted) {
  test::GltfScene plain;
  plain.add({test::quad({-50, 0, -50}, {0, 0, 100}, {100, 0, 0})}, test::lambert({0.5, 0.5, 0.5}));
  plain.add_directional_light({0.1, -1, 0}, 2);
  plain.set_perspective(test::look_at({20, 8, 20}, {20, 0, 20.1}), 0.8);
  const PreparedScene wide = test::prepare(plain);
  const probe::TrainedLightGuide guided = probe::train_light_guide(World(wide), small_film());
  ASSERT_TRUE(guided.guide);
  std::printf("a plain: gain %.3g\n", guided.gain);
  // Of the sun's disk, of 71 m radius, the camera sees 6.8 m by 6.8 m: 1 / 340, of which the rest is left to
  // power and to boxes that are wider than what is seen.
  EXPECT_GT(guided.gain, 50);
  EXPECT_LT(guided.gain, 345);

  test::GltfScene room;
  for (const test::Polygon& wall : test::box({-1, -1, -1}, {1, 1, 1}))
    room.add({test::Polygon(wall.rbegin(), wall.rend())}, test::lambert({0.5, 0.5, 0.5}));
  room.add({test::quad({-0.3, 0.99, -0.3}, {0.6, 0, 0}, {0, 0, 0.6})}, test::emitter({1, 1, 1}));
  room.set_perspective(test::look_at({0, 0, 0.9}, {0, 0, -1}), 1.2);
  const PreparedScene closed = test::prepare(room);
  const probe::TrainedLightGuide useless = probe::train_light_guide(World(closed), small_film());
  std::printf("a room: gain %.3g\n", useless.gain);
  EXPECT_LT(useless.gain, 2);
}

TEST(LightGuideTraining, DependsOnNothingElse) {
  const PreparedScene prepared = test::prepare(scene_of_lights());
  const probe::TrainedLightGuide first = probe::train_light_guide(World(prepared), small_film());
  const probe::TrainedLightGuide second = probe::train_light_guide(World(prepared), small_film());
  ASSERT_TRUE(first.guide && second.guide);
  EXPECT_EQ(hash_of(*first.guide), hash_of(*second.guide));
  EXPECT_EQ(first.gain, second.gain);
  Settings other = small_film();
  other.first_sample = 8;
  EXPECT_NE(hash_of(*probe::train_light_guide(World(prepared), other).guide), hash_of(*first.guide));
}

}  // namespace
}  // namespace regulus::reference

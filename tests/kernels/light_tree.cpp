// The light tree: probabilities that add up, that are never 0 where light falls, and that device and
// reference agree on; samples that follow them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "images/support/prepared_scene.hpp"
#include "kernels/light_tree_batch.h"
#include "reference/light_choice.hpp"
#include "reference/lights.hpp"
#include "support/chi_square.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using glm::dvec3;
using namespace interface;
using reference::Receiver;

// Lamps of every kind in a box of 4 m, far more of them in one corner; one- and two-sided triangles, points,
// spots and two distant lights.
GltfScene scene_of_lamps(uint32_t triangles) {
  GltfScene scene;
  scene.add({quad({-2, -2, -2}, {0, 0, 4}, {4, 0, 0})}, lambert({0.5, 0.5, 0.5}));
  Random random(70);
  std::map<int, Polygons> by_kind;
  for (uint32_t i = 0; i < triangles; ++i) {
    const dvec3 place = i % 2 == 0 ? 4.0 * random.cube() - 2.0 : 1.5 + 0.5 * random.cube();
    const double size = random.log_uniform(1e-3, 0.3);
    by_kind[static_cast<int>(i % 4)].push_back(
        {place, place + size * random.direction(), place + size * random.direction()});
  }
  scene.add(by_kind[0], emitter({1, 2, 3}));
  scene.add(by_kind[1], emitter({5, 1, 1}));
  scene.add(by_kind[2], emitter({0.2, 0.2, 0.1}, true));
  scene.add(by_kind[3], emitter({9, 9, 9}, true));
  for (int i = 0; i < 8; ++i) {
    scene.add_point_light(4.0 * random.cube() - 2.0, {0.1, 0.2, 0.1});
    scene.add_spot_light(4.0 * random.cube() - 2.0, random.direction(), random.log_uniform(0.1, 10),
                         random.uniform(0, 0.5), random.uniform(0.6, 1.5));
  }
  scene.add_directional_light({0, -1, 0.1}, 0.5);
  scene.add_directional_light({1, -1, 0.1}, 0.1);
  scene.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), 0.8);
  return scene;
}

/// A receiver anywhere near the lights, a third of them lit from both sides, some of them on a light.
Receiver random_receiver(Random& random, const scene::Scene& scene) {
  Receiver receiver{5.0 * random.cube() - 2.5, random.direction()};
  if (random.index(3) == 0) receiver.normal = dvec3(0);
  if (random.index(5) == 0)
    receiver.position = scene.vertices[random.index(static_cast<uint32_t>(scene.vertices.size()))].position;
  // As the device gets it.
  receiver.position = glm::vec3(receiver.position);
  receiver.normal = glm::vec3(receiver.normal);
  return receiver;
}

/// True if light of the light falls on the receiver, at a random point of it.
bool reaches(const reference::World& world, const Receiver& receiver, uint32_t light, Random& random) {
  const reference::LightPoint point = sample_light_point(world, light, random.square());
  const dvec3 to_light = point.is_distant() ? point.direction : point.surface.position - receiver.position;
  const dvec3 w = normalize(to_light);
  // Cosines that rounding of the directions can make.
  constexpr double GRAZING = 1e-5;
  if (receiver.normal != dvec3(0) && dot(receiver.normal, w) < GRAZING) return false;
  if (point.is_triangle() && std::abs(dot(point.surface.geometric_normal, w)) < GRAZING) return false;
  return length(to_light) > 1e-6 && reference::luminance(emitted(world, point, -w)) > 0;
}

class LightTree : public testing::Test {
 protected:
  LightTree() : prepared_(prepare(scene_of_lamps(1000))), world_(prepared_) {}

  uint32_t light_count() const { return static_cast<uint32_t>(prepared_.scene.lights.size()); }

  std::vector<LightAnswer> ask(const std::vector<LightQuery>& queries) const {
    const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "light_tree", {});
    return map_on_device<LightAnswer>(kernel, queries);
  }
  /// The tree on the device.
  struct Uploaded {
    gpu::Buffer pairs, trails;
    LightTreeRoot root;
  };
  Uploaded upload() const {
    const scene::LightTree& tree = prepared_.scene.light_tree;
    Uploaded uploaded{gpu::upload_new(*device(), tree.pairs, "light pairs"),
                      gpu::upload_new(*device(), tree.trails, "light trails"),
                      {}};
    uploaded.root = {device_address(uploaded.pairs.address()), device_address(uploaded.trails.address()),
                     tree.center, tree.radius};
    return uploaded;
  }
  static LightQuery query(const Receiver& receiver, const Uploaded& tree, uint32_t light, glm::vec2 u = {}) {
    return {{glm::vec3(receiver.position), glm::vec3(receiver.normal)}, u, light, tree.root};
  }

  PreparedScene prepared_;
  reference::World world_;
};

// What is left to 1 is chosen for nothing: a node that could light the receiver, for all its bounds tell, and
// whose children cannot.
TEST_F(LightTree, ProbabilitiesAddUpAndNoLightThatFallsIsLeftOut) {
  Random random(71);
  double most = 0, least = 1, mean = 0;
  int lit = 0;
  constexpr int RECEIVERS = 100;
  for (int i = 0; i < RECEIVERS; ++i) {
    const Receiver receiver = random_receiver(random, prepared_.scene);
    double sum = 0;
    for (uint32_t light = 0; light < light_count(); ++light) {
      const double probability = choice_probability(world_, receiver, light);
      sum += probability;
      if (!reaches(world_, receiver, light, random)) continue;
      ++lit;
      ASSERT_GT(probability, 0) << "light " << light << " of kind " << prepared_.scene.lights[light].kind;
    }
    most = std::max(most, sum);
    least = std::min(least, sum);
    mean += sum / RECEIVERS;
  }
  std::printf("sum of probabilities: %.3f to %.3f, %.3f in the mean; %d lit\n", least, most, mean, lit);
  EXPECT_LE(most, 1 + 1e-12);
  EXPECT_GT(mean, 0.9);
  EXPECT_GT(lit, 10000);
}

TEST_F(LightTree, DeviceAndReferenceAgree) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Uploaded tree = upload();
  Random random(72);
  std::vector<LightQuery> queries;
  std::vector<double> expected;
  for (int i = 0; i < 40; ++i) {
    const Receiver receiver = random_receiver(random, prepared_.scene);
    for (uint32_t light = 0; light < light_count(); ++light) {
      queries.push_back(query(receiver, tree, light));
      expected.push_back(choice_probability(world_, receiver, light));
    }
  }
  const std::vector<LightAnswer> answers = ask(queries);
  // At each of some 12 pairs four heights and two distances are rounded, by a few 2^-24 of the distance each.
  // A node on the verge of darkness has a share of 2^-20 or none, as rounding has it.
  constexpr double BOUND = 12 * 6 * 4 * 0x1p-24, VERGE = 0x1p-20;
  size_t beyond = 0;
  double sum = 0;
  double sum_of_errors = 0;
  for (size_t i = 0; i < answers.size(); ++i) {
    const double error = std::abs(answers[i].of_light - expected[i]);
    sum += expected[i];
    sum_of_errors += error;
    beyond += error > BOUND * expected[i] + VERGE ? 1 : 0;
  }
  std::printf(
      "%zu probabilities: %zu err by more than %.1e of themselves; all together by %.1e of their sum\n",
      answers.size(), beyond, BOUND, sum_of_errors / sum);
  EXPECT_EQ(beyond, 0U);
  EXPECT_LT(sum_of_errors, BOUND * sum);
}

TEST_F(LightTree, SamplesFollowTheProbabilities) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr int RECEIVERS = 4;
  constexpr size_t SAMPLES = 1u << 17;
  const Uploaded tree = upload();
  Random random(73);
  for (int i = 0; i < RECEIVERS; ++i) {
    const Receiver receiver = random_receiver(random, prepared_.scene);
    std::vector<LightQuery> queries;
    for (size_t k = 0; k < SAMPLES; ++k)
      queries.push_back(
          query(receiver, tree, 0, glm::vec2(random.index(1u << 24), random.index(1u << 24)) * 0x1p-24F));
    std::vector<double> observed(light_count() + 1), expected;  // the last cell: none
    for (const LightAnswer& answer : ask(queries)) {
      observed[std::min(answer.light, light_count())] += 1;
      if (answer.light == INVALID_INDEX) continue;
      ASSERT_LT(answer.light, light_count());
      const double known = choice_probability(world_, receiver, answer.light);
      ASSERT_NEAR(answer.probability, known, 1e-3 * known) << "light " << answer.light;
    }
    double rest = double{SAMPLES};
    for (uint32_t light = 0; light < light_count(); ++light) {
      expected.push_back(double{SAMPLES} * choice_probability(world_, receiver, light));
      rest -= expected.back();
    }
    expected.push_back(rest);
    const ChiSquare result = chi_square_test(observed, expected);
    const double alarm = significance_per_test(1e-4, RECEIVERS);
    std::printf("receiver %d: p-value %.3g of %d degrees of freedom, alarm below %.1e\n", i, result.p_value,
                result.degrees_of_freedom, alarm);
    EXPECT_TRUE(result.problem.empty()) << result.problem;
    EXPECT_GT(result.p_value, alarm);
  }
}

}  // namespace
}  // namespace regulus::test

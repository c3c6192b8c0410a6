// Guided camera walks: directions have their density, walks draw what the mixture of guide and bsdf says, and
// a training finds a window.
#include "probe/walk_guide.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "images/support/room.hpp"
#include "probe/walk_cells.hpp"
#include "reference/path.hpp"
#include "reference/support/reference_images.hpp"
#include "reference/walk_guide.hpp"
#include "support/chi_square.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;

// Bounds [-1, 1]^3.
const scene::WalkGuide BOUNDS{{}, glm::vec3(-1), glm::vec3(0.5F)};

/// Surfaces all over the bounds that face all ways along the axes, and get light from around their normal:
/// from the upper half of the directions to their right or to their left, by which half of x they are in.
scene::WalkGuide made_guide(int vertices) {
  test::Random random(500);
  std::vector<probe::CellKey> visits;
  std::vector<probe::Arrival> arrivals;
  for (int i = 0; i < vertices; ++i) {
    const dvec3 position = 2.0 * random.cube() - 1.0;
    dvec3 normal(0);
    normal[static_cast<int>(random.index(3))] = random.index(2) == 0 ? -1 : 1;
    const probe::CellKey key = probe::cell_key(BOUNDS, position, normal);
    visits.push_back(key);
    const dvec3 side =
        position.x < 0 ? dvec3(normal.y, normal.z, normal.x) : dvec3(normal.z, normal.x, normal.y);
    for (int k = 0; k < 4; ++k) {
      const dvec3 w = normalize(normal + 0.7 * side + 0.3 * random.direction());
      const dvec2 numbers = sphere_numbers(w);
      probe::Arrival arrival;
      arrival.key = key;
      for (int axis = 0; axis < 2; ++axis)
        arrival.direction[static_cast<size_t>(axis)] =
            static_cast<uint16_t>(numbers[axis] * (1u << GUIDE_HALVINGS));
      arrival.cosine = static_cast<float>(std::abs(dot(w, normal)));
      arrival.weight = 1 + random.index(100);
      arrival.is_second = k % 2 != 0;
      arrivals.push_back(arrival);
    }
  }
  return probe::make_walk_guide(BOUNDS, visits, arrivals).guide;
}

TEST(WalkGuide, NumbersOfTheSphereAreInverted) {
  test::Random random(510);
  double worst = 0;
  for (int i = 0; i < 10000; ++i) {
    const dvec2 u = random.square();
    const dvec2 found = sphere_numbers(sample_sphere(u));
    worst = std::max({worst, std::abs(found.x - u.x), std::abs(found.y - u.y)});
  }
  EXPECT_LT(worst, 1e-7);
}

TEST(WalkGuide, DirectionsHaveTheirDensity) {
  constexpr int SAMPLES = 100000, CELLS = 6;
  const scene::WalkGuide guide = made_guide(8000);
  test::Random random(520);
  double largest = 0;
  for (int i = 0; i < CELLS; ++i) {
    const GuideCell cell =
        guide_cell(guide, 2.0 * random.cube() - 1.0, i % 2 == 0 ? dvec3(0, 1, 0) : dvec3(-1, 0, 0));
    EXPECT_GT(cell.share, 0);
    const auto density = [&](const dvec3& w) { return guided_pdf(guide, cell, w); };
    // Its boxes are halves of halves, as these cells are: their integrals are exact but for the finest.
    test::SphereHistogram histogram(16, 16);
    for (int k = 0; k < SAMPLES; ++k) histogram.add(guided_direction(guide, cell, random.square()));
    const double integral = histogram.integral(density, 4);
    const test::ChiSquare result = histogram.test(density, 4);
    for (int k = 0; k < 100; ++k)
      largest = std::max(largest, density(guided_direction(guide, cell, random.square())));
    std::printf("cell %d: share %g, integral 1 + %.1g, p %.3g\n", i, cell.share, integral - 1,
                result.p_value);
    EXPECT_NEAR(integral, 1, 1e-5);
    EXPECT_TRUE(result.problem.empty()) << result.problem;
    EXPECT_GT(result.p_value, test::significance_per_test(1e-4, CELLS));
  }
  EXPECT_GT(largest, 10 / (4 * 3.14)) << "the test is about nothing";
}

// Light comes from another side on both sides of a wall, and from another one beyond the middle.
TEST(WalkGuide, CellsTellPlacesAndNormalsApart) {
  const scene::WalkGuide guide = made_guide(8000);
  const auto density = [&](const dvec3& position, const dvec3& normal, const dvec3& w) {
    return guided_pdf(guide, guide_cell(guide, position, normal), normalize(w));
  };
  for (const double x : {-0.7, 0.6})
    for (const double side : {-1.0, 1.0}) {
      const dvec3 position(x, 0.1, 0.2);
      const dvec3 up(0, side, 0);
      const dvec3 along = x < 0 ? dvec3(side, 0, 0) : dvec3(0, 0, side);
      const double lit = density(position, up, up + 0.7 * along);
      const double behind = density(position, up, -up - 0.7 * along);
      const double across = density(position, up, up - 0.7 * along);
      EXPECT_GT(lit, 20 * behind) << x << " " << side;
      EXPECT_GT(lit, 5 * across) << x << " " << side;
    }
}

/// Directions that walks take from a floor of this material, and where they end there, against the pdf that
/// weights use.
void expect_walks_drawn(const char* name, const nlohmann::json& material, const test::GltfScene& textures,
                        uint32_t stream) {
  constexpr uint32_t SAMPLES = 50000;
  test::GltfScene scene = textures;
  scene.add({test::quad({-5, 0.13, 5}, {10, 0, 0}, {0, 0, -10})}, material);
  scene.add_point_light({0, 3, 0}, {1, 1, 1});
  scene.set_orthographic(test::look_at({1.1, 1, 0.8}, {0.3, 0.13, 0.2}), 1e-4, 1e-4);
  const PreparedScene prepared = test::prepare(scene);
  const auto guide = std::make_shared<scene::WalkGuide>(made_guide(3000));
  const World world(prepared, NDF_GGX, SHADOWING_SMITH, LIGHT_SAMPLING_AUTO, false, nullptr, guide);
  Settings settings;
  settings.width = settings.height = 1;
  settings.samples = SAMPLES;
  settings.max_depth = 2;
  settings.sampler = SAMPLER_HASH;
  settings.seed = static_cast<uint32_t>(test::base_seed()) + stream;
  const Camera camera(scene::make_camera(prepared.scene.cameras[0], 1, 1), 1, 1);
  test::SphereHistogram histogram(16, 32);
  std::optional<WalkVertex> vertex;
  double guided = 0;
  for (uint32_t i = 0; i < SAMPLES; ++i) {
    const CameraSubpath path = walk_from_camera(world, camera, settings, 0, i);
    ASSERT_EQ(path.vertices.size(), 1u);
    vertex = path.vertices[0];
    if (!path.escape || vertex->sample.is_delta) {
      histogram.add_invalid();
    } else {
      histogram.add(path.escape->direction);
      guided = std::max(guided, vertex->scattering.guiding);
    }
  }
  const auto density = [&](const dvec3& w) {
    return w.y > 0 ? scattering_between(vertex->surface, vertex->bsdf, w, vertex->w_back).reverse : 0;
  };
  const test::ChiSquare result = histogram.test(density, 4);
  std::printf("%s: pdfs up to %.3g times those of the bsdf, p %.3g\n", name, guided, result.p_value);
  EXPECT_GT(guided, 1.5) << "the test is about nothing";
  EXPECT_TRUE(result.problem.empty()) << result.problem;
  EXPECT_GT(result.p_value, test::significance_per_test(1e-4, 4));
}

TEST(WalkGuide, WalksDrawTheMixture) {
  test::GltfScene none;
  expect_walks_drawn("lambert", test::lambert({0.5, 0.5, 0.5}), none, 530);
  expect_walks_drawn("plastic", test::plastic({0.3, 0.4, 0.5}, 0.6), none, 531);
  expect_walks_drawn("coated", test::coated(test::plastic({0.6, 0.4, 0.5}, 0.7), 0), none, 532);
  expect_walks_drawn("cloth", test::cloth(test::lambert({0.5, 0.4, 0.5}), {0.4, 0.4, 0.4}, 0.5), none, 533);
}

/// A closed room of dark walls, lit through a window from a bright room behind it, or one of white walls and
/// a ceiling that shines.
PreparedScene lit_room(bool has_window) {
  test::GltfScene scene;
  const nlohmann::json dark = test::lambert({0.2, 0.2, 0.2});
  const nlohmann::json white = test::lambert({0.8, 0.8, 0.8});
  const test::Polygons walls = test::turned(test::box({-1, -1, -1}, {1, 1, 1}));
  for (const size_t wall : {0u, 1u, 2u, 4u}) scene.add({walls[wall]}, has_window ? dark : white);
  if (has_window) {
    scene.add({walls[3]}, dark);
    scene.add(
        {test::quad({1, -1, -1}, {0, 0, 2}, {0, 1.6, 0}), test::quad({1, 0.6, -1}, {0, 0, 1.6}, {0, 0.4, 0})},
        dark);
    const test::Polygons behind = test::turned(test::box({1, -1, -1}, {3, 1, 1}));
    for (const size_t wall : {0u, 1u, 2u, 3u, 5u}) scene.add({behind[wall]}, white);
    scene.add({test::quad({1.2, -0.9, 0.3}, {0, 0, 0.6}, {0.6, 0, 0})}, test::emitter({30, 30, 30}));
  } else {
    scene.add({walls[5]}, white);
    scene.add({walls[3]}, test::emitter({1, 1, 1}));
  }
  scene.set_perspective(test::look_at({-0.9, 0, 0}, {0, -0.2, 0}), 1.2);
  return test::prepare(scene);
}

Settings window_film() {
  Settings settings;
  settings.width = settings.height = 32;
  settings.samples = 2;
  settings.max_depth = 6;
  settings.light_paths = 1 << 15;
  return settings;
}

TEST(WalkGuideTraining, FindsAWindow) {
  const PreparedScene prepared = lit_room(true);
  const probe::TrainedWalkGuide trained = probe::train_walk_guide(World(prepared), window_film());
  ASSERT_TRUE(trained.guide);
  const dvec3 position(-0.2, -1, 0.3);
  const GuideCell cell = guide_cell(*trained.guide, position, {0, 1, 0});
  const double window = guided_pdf(*trained.guide, cell, normalize(dvec3(1, 0.8, 0.8) - position));
  const double wall = guided_pdf(*trained.guide, cell, normalize(dvec3(-1, 0.85, 0) - position));
  std::printf("gain %.3g, %zu nodes; share %g, window %.3g /sr, wall %.3g /sr\n", trained.gain,
              trained.guide->nodes.size(), cell.share, window, wall);
  EXPECT_GT(trained.gain, 1.1);
  EXPECT_GT(cell.share, 0);
  EXPECT_GT(window, 3 * wall);
}

// Next-event estimation finds the light of a ceiling, and what walls reflect comes from everywhere.
TEST(WalkGuideTraining, LeavesEvenLightAlone) {
  const PreparedScene prepared = lit_room(false);
  const probe::TrainedWalkGuide trained = probe::train_walk_guide(World(prepared), window_film());
  std::printf("gain %.3g\n", trained.gain);
  EXPECT_LT(trained.gain, 1.3);
}

TEST(WalkGuideTraining, DependsOnNothingElse) {
  const PreparedScene prepared = lit_room(true);
  const probe::TrainedWalkGuide first = probe::train_walk_guide(World(prepared), window_film());
  const probe::TrainedWalkGuide second = probe::train_walk_guide(World(prepared), window_film());
  ASSERT_TRUE(first.guide && second.guide);
  EXPECT_EQ(hash_of(*first.guide), hash_of(*second.guide));
  Settings other = window_film();
  other.first_sample = 8;
  EXPECT_NE(hash_of(*probe::train_walk_guide(World(prepared), other).guide), hash_of(*first.guide));
}

// What a guide has to be to leave pictures alone is that its pdfs are true: here the mean of a whole film.
TEST(WalkGuide, KeepsTheLightOfARoom) {
  const PreparedScene prepared = lit_room(true);
  const auto guide = std::make_shared<scene::WalkGuide>(made_guide(8000));  // of other directions
  const auto mean = [&](std::shared_ptr<const scene::WalkGuide> by, uint32_t techniques, uint32_t stream) {
    const World world(prepared, NDF_GGX, SHADOWING_SMITH, LIGHT_SAMPLING_AUTO, false, nullptr, std::move(by));
    Settings settings = window_film();
    settings.width = settings.height = 8;
    settings.samples = 160;
    settings.light_paths = 0;
    settings.techniques = techniques;
    settings.seed = static_cast<uint32_t>(test::base_seed()) + stream;
    const Film film = render(world, settings, {}, 1);
    double sum = 0, variance = 0;
    for (size_t i = 0; i < 64; ++i) {
      sum += film.mean(i).g / 64;
      variance += film.variance_of_mean(i).g / (64 * 64);
    }
    return std::pair(sum, variance);
  };
  const auto [plain, plain_variance] = mean(nullptr, test::PT, 540);
  for (const uint32_t techniques : {test::PT, test::BPT, uint32_t{TECHNIQUE_NEE | TECHNIQUE_SPLAT}}) {
    const auto [found, variance] = mean(guide, techniques, 550 + techniques);
    const double z = (found - plain) / std::sqrt(variance + plain_variance);
    std::printf("techniques %u: mean %.4g against %.4g, z %.2f\n", techniques, found, plain, z);
    EXPECT_LT(std::abs(z), 4.2);  // of three tests at a false-alarm rate of 1e-4
  }
}

}  // namespace
}  // namespace regulus::reference

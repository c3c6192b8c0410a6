// Light from everywhere: furnaces, a single bright texel, the sampler's distribution.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "images/support/bright_texel.hpp"
#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "render/stage_recorder.hpp"
#include "render/technique_sets.hpp"
#include "support/chi_square.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;
using std::numbers::pi;

constexpr int BATCHES = 11;
using namespace technique_sets;
const glm::dvec3 SKY(0.5, 1, 2);

struct NamedSet {
  const char* name;
  uint32_t techniques;
};

class Environment : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

GltfScene under_sky(const Polygons& solid, const nlohmann::json& material) {
  GltfScene scene;
  scene.add(solid, material);
  scene.set_perspective(look_at({1.6, 1.5, 1.7}, {0, 0, 0}), 0.5);
  scene.set_setting("environment", {{"color", {SKY.x, SKY.y, SKY.z}}});
  return scene;
}

const Polygons CUBE = box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});

RenderSettings settings_of(uint32_t techniques, uint32_t samples, uint32_t max_depth) {
  RenderSettings settings = box_filtered(12, 12, is_slow_device() ? 2 : samples, max_depth);
  settings.techniques = techniques;
  if ((techniques & TECHNIQUE_MERGE) != 0) {
    settings.light_paths = 1024;
    settings.merge_radius = 0.02f;
  }
  return settings;
}

// A convex body sees nothing of itself: with albedo 1 its radiance is the environment's, by every set.
TEST_F(Environment, WhiteCubeCannotBeSeen) {
  const PreparedScene scene = prepare(under_sky(CUBE, lambert({1, 1, 1})));
  uint32_t stream = 300;
  for (const NamedSet set : {NamedSet{"pt", PT}, {"bpt", BPT}, {"vcm", VCM}}) {
    if (is_slow_device() && set.techniques != PT) continue;  // minutes of compiling
    ComparisonOptions options;
    // Merges within their radius of 0.02 of an edge, on 8 percent of a face, miss a fifth of their disk on
    // average.
    if ((set.techniques & TECHNIQUE_MERGE) != 0) options.relative_tolerance = 0.016;
    expect_known((std::string("white cube, ") + set.name).c_str(),
                 render_batches(scene, settings_of(set.techniques, 24, 4), BATCHES, stream++),
                 uniform_image(12, 12, {SKY.x, SKY.y, SKY.z}), options);
  }
}

// Perfect mirrors and clear glass: every path has weight 1 and ends on the environment, whatever else is
// tried.
TEST_F(Environment, MirrorAndGlassCubesCannotBeSeen) {
  for (const auto& [name, material] :
       {std::pair("mirror", metal({1, 1, 1}, 0)), std::pair("glass", glass(1.5))}) {
    const PreparedScene scene = prepare(under_sky(CUBE, material));
    for (const NamedSet set : {NamedSet{"pt", PT}, {"bpt", BPT}}) {
      if (is_slow_device() && set.techniques != PT) continue;
      const Rendered rendered = render(scene, settings_of(set.techniques, 8, 32));
      size_t off = 0;
      for (size_t i = 0; i < rendered.image.rgb.size(); ++i)
        if (std::abs(rendered.image.rgb[i] / SKY[static_cast<int>(i % 3)] - 1) > 2e-5) ++off;
      std::printf("%s, %s: %zu values off of %zu\n", name, set.name, off, rendered.image.rgb.size());
      EXPECT_LE(off, rendered.image.rgb.size() / 100) << "paths longer than 32 edges are lost";
    }
  }
}

// Rough bodies, which lose light by single scattering: the same as in a room whose walls emit the same.
TEST_F(Environment, RoughBodiesLookAsInAGlowingRoom) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  uint32_t stream = 320;
  for (const auto& [name, material] :
       {std::pair("rough metal", metal({1, 0.9, 0.8}, 0.6)), std::pair("rough glass", glass(1.5, 0.5)),
        std::pair("plastic", plastic({0.9, 0.9, 0.9}, 0.3))}) {
    const GltfScene open = under_sky(CUBE, material);
    GltfScene closed;
    closed.add(CUBE, material);
    closed.set_perspective(look_at({1.6, 1.5, 1.7}, {0, 0, 0}), 0.5);
    closed.add(turned(box({-3, -3, -3}, {3, 3, 3})), emitter(SKY));
    const auto known = render_batches(prepare(closed), settings_of(PT, 24, 6), BATCHES, stream++);
    const PreparedScene scene = prepare(open);
    for (const NamedSet set : {NamedSet{"pt", PT}, {"bpt", BPT}})
      expect_equal((std::string(name) + ", " + set.name).c_str(),
                   render_batches(scene, settings_of(set.techniques, 24, 6), BATCHES, stream++), known);
  }
}

// A square under one bright texel reflects albedo / pi times the irradiance, whichever technique finds it;
// turned away or with the environment turned away it is black.
TEST_F(Environment, OneBrightTexelIsALampInItsDirection) {
  struct Case {
    const char* name;
    uint32_t column, row;
    double rotation;
    glm::dvec3 normal;
    bool is_lit;
  };
  const Case cases[] = {
      {"middle of the map is +x", 32, 10, 0, {1, 0, 0}, true},
      {"and nothing of it is -x", 32, 10, 0, {-1, 0, 0}, false},
      {"a quarter to its right +z", 48, 10, 0, {0, 0, 1}, true},
      {"turned by 90 degrees -z", 32, 10, 90, {0, 0, -1}, true},
      {"turned by -50 degrees", 20, 13, -50, glm::normalize(glm::dvec3(0.3, -0.2, 0.1)), true},
      {"top row is up", 3, 0, 77, {0, 1, 0}, true},
      {"the seam", 0, 12, 0, {-1, 0, 0}, true},
  };
  uint32_t stream = 340;
  for (const Case& test : cases) {
    const BrightTexel texel{test.column, test.row};
    const PreparedScene scene = prepare(white_square(test.normal), texel.map(), test.rotation);
    const double irradiance = texel.irradiance(test.normal, test.rotation);
    const glm::dvec3 radiance = texel.radiance * (irradiance / pi);
    if (!test.is_lit) {
      EXPECT_EQ(mean_of(render(scene, settings_of(PT, 8, 2)).image)[0], 0) << test.name;
      continue;
    }
    EXPECT_GT(irradiance, 1e-3) << test.name;
    for (const NamedSet set :
         {NamedSet{"nee", TECHNIQUE_NEE}, {"pt", PT}, {"lt", TECHNIQUE_SPLAT}, {"bpt", BPT}}) {
      if (is_slow_device() && set.techniques != PT) continue;
      ComparisonOptions options;
      options.tile = 12;
      options.relative_tolerance = 3e-5;  // the known value's quadrature
      expect_known((std::string(test.name) + ", " + set.name).c_str(),
                   render_batches(scene, settings_of(set.techniques, 64, 2), BATCHES, stream++),
                   uniform_image(12, 12, {radiance.x, radiance.y, radiance.z}), options);
    }
  }
}

// A map of grey values with dark texels among bright ones.
struct GreyMap {
  static constexpr uint32_t WIDTH = 11, HEIGHT = 6;
  std::vector<double> values;

  GreyMap() {
    Random random(381);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i)
      values.push_back(random.index(3) == 0 ? 0.0 : static_cast<float>(std::exp(5 * random.uniform())));
  }
  image::Image image() const {
    image::Image image{WIDTH, HEIGHT, {}};
    for (const double value : values)
      for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<float>(value));
    return image;
  }
  // At (x, y) in texels.
  double at(double x, double y) const {
    double sum = 0;
    for (int row = -1; row <= static_cast<int>(HEIGHT); ++row)
      for (int column = -1; column <= static_cast<int>(WIDTH); ++column) {
        const double share =
            std::max(0.0, 1 - std::abs(x - column - 0.5)) * std::max(0.0, 1 - std::abs(y - row - 0.5));
        if (share > 0)
          sum +=
              share * values[static_cast<size_t>(std::clamp(row, 0, static_cast<int>(HEIGHT) - 1)) * WIDTH +
                             static_cast<size_t>(column + static_cast<int>(WIDTH)) % WIDTH];
      }
    return sum;
  }
  // Probability of each cell: mean value times solid angle. The value is bilinear in quarters of a cell, so
  // that the mean over their centres is exact.
  std::vector<double> cells() const {
    std::vector<double> weights;
    double total = 0;
    for (uint32_t row = 0; row < HEIGHT; ++row)
      for (uint32_t column = 0; column < WIDTH; ++column) {
        double mean = 0;
        for (const double dx : {0.25, 0.75})
          for (const double dy : {0.25, 0.75}) mean += 0.25 * at(column + dx, row + dy);
        weights.push_back(mean * (std::cos(pi * row / HEIGHT) - std::cos(pi * (row + 1) / HEIGHT)));
        total += weights.back();
      }
    for (double& weight : weights) weight /= total;
    return weights;
  }
};

// Directions of light paths, counted by quarters of the map's cells, and what the paths carry: radiance over
// density.
TEST_F(Environment, DirectionsFollowTheMap) {
  const GreyMap map;
  GltfScene square = white_square({0, 1, 0});
  constexpr double ROTATION = 100;
  const PreparedScene scene = prepare(square, map.image(), ROTATION);
  constexpr uint32_t SIDE = 256;
  RenderSettings settings = box_filtered(SIDE, SIDE, 1, 2);
  settings.techniques = TECHNIQUE_SPLAT;
  render::StageRecorder recorder(*device(), scene, plan_recording(scene, settings), SIDE * SIDE);
  const render::Recording recording = recorder.record(render::Pass::Light, 0, 7);

  const std::vector<double> probability = map.cells();
  const double disk = pi * 0.25 *
                      glm::dot(glm::dvec3(scene.scene.bounds_max - scene.scene.bounds_min),
                               glm::dvec3(scene.scene.bounds_max - scene.scene.bounds_min));
  // In a quarter between four dark texels a cell shines nowhere: paths from there are not started.
  std::vector<double> observed(4 * probability.size() + 1), expected(observed.size());
  for (size_t cell = 0; cell < probability.size(); ++cell)
    for (int quarter = 0; quarter < 4; ++quarter) {
      const double x = static_cast<double>(cell % GreyMap::WIDTH) + (quarter % 2 == 0 ? 0.25 : 0.75);
      const double y = static_cast<double>(cell / GreyMap::WIDTH) + (quarter < 2 ? 0.25 : 0.75);
      const size_t counted = map.at(x, y) > 0 ? 4 * cell + static_cast<size_t>(quarter) : observed.size() - 1;
      expected[counted] += 0.25 * probability[cell] * SIDE * SIDE;
    }
  double worst = 0;
  observed.back() = static_cast<double>(SIDE * SIDE - recording.bounces[0].slots.size());
  for (const uint32_t slot : recording.bounces[0].slots) {
    const Path& path = recording.generated[slot];
    const glm::dvec3 w = -glm::dvec3(path.direction);
    const double theta = std::atan2(std::hypot(w.x, w.z), w.y);
    const double turns = std::atan2(w.z, w.x) / (2 * pi) + 0.5 + ROTATION / 360;
    const double x = (turns - std::floor(turns)) * GreyMap::WIDTH, y = theta / pi * GreyMap::HEIGHT;
    const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
    const size_t cell = size_t{row} * GreyMap::WIDTH + column;
    observed[4 * cell + (x - column < 0.5 ? 0 : 1) + (y - row < 0.5 ? 0 : 2)] += 1;
    const double density =
        probability[cell] * GreyMap::WIDTH * GreyMap::HEIGHT / (2 * pi * pi * std::sin(theta));
    const double throughput = map.at(x, y) * disk / density;
    const double margin = std::min({x - column, column + 1 - x, y - row, row + 1 - y});
    if (margin < 1e-4) continue;  // rounding may put the direction into the next cell
    // Shares are raised by 2^-20 of their row, and rows of the map. The rest is rounding: 1e-7 rad of the
    // direction against a texel's slope.
    const double row_share = std::accumulate(&probability[row * GreyMap::WIDTH],
                                             &probability[row * GreyMap::WIDTH] + GreyMap::WIDTH, 0.0);
    const double raised = 0x1p-20 * (row_share / probability[cell] + 1 / row_share);
    const double allowed = throughput * raised + 1e-5 * disk / density * 150;
    if (std::abs(path.throughput.g - throughput) > 2 * allowed)
      std::printf("DBG %g %g allowed %g x %g y %g p %g\n", path.throughput.g, throughput, allowed, x, y,
                  probability[cell]);
    worst = std::max(worst, std::abs(path.throughput.g - throughput) / allowed);
  }
  const ChiSquare result = chi_square_test(observed, expected);
  std::printf("p-value %.3g (alarm below 1e-4); largest difference of a throughput over its bound %.2g\n",
              result.p_value, worst);
  EXPECT_TRUE(result.problem.empty()) << result.problem;
  EXPECT_GT(result.p_value, 1e-4);
  EXPECT_LT(worst, 1);
}

// An environment whose share of the lights' power rounds to 0 is still what rays meet that leave the scene.
TEST_F(Environment, MayBeTooDimToBeChosen) {
  GltfScene scene;
  scene.add({quad({-0.3, 0, 0.3}, {0.6, 0, 0}, {0, 0, -0.6})}, lambert({0.5, 0.5, 0.5}));
  scene.add_point_light({0, 1, 0}, {1e12, 1e12, 1e12});
  scene.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1);
  scene.set_setting("environment", {{"color", {1e-38, 1e-38, 1e-38}}});
  const PreparedScene prepared = prepare(scene);
  ASSERT_TRUE(prepared.scene.environment);
  ASSERT_EQ(prepared.scene.environment->parameters.selection_pdf, 0) << "the test is about nothing";
  RenderSettings settings = point_sampled(12, 12, 2);
  settings.techniques = PT;
  const image::Image image = render(prepared, settings).image;
  const size_t middle = 3 * (6 * size_t{12} + 6);
  // I albedo / (pi d^2), a twelfth of the picture from the point below the lamp.
  EXPECT_NEAR(image.rgb[middle] / (1e12 * 0.5 / pi), 1, 0.02);
  EXPECT_EQ(image.rgb[0], 0) << "less than the film's unit";
}

}  // namespace
}  // namespace regulus::test

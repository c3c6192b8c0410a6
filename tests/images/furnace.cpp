// Closed scenes whose radiance is known (scenes/furnace and scenes/mirrors name theirs in extras).
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using render::RenderSettings;

constexpr int BATCHES = 17;

class Furnace : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

std::filesystem::path furnace(const std::string& name) {
  return own_scenes() / "furnace" / (name + ".gltf");
}

std::array<double, 3> triple(const nlohmann::json& values) {
  return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

// Each further edge multiplies by the albedo, so the series ends with max-depth.
TEST_F(Furnace, LambertBoxIsTheSeriesUpToMaxDepth) {
  const PreparedScene room = prepare(furnace("furnace"));
  const nlohmann::json expected = expected_of(furnace("furnace"));
  const std::array<double, 3> limit = triple(expected["radiance_unlimited_depth"]);
  const std::array<double, 3> albedo = {0.2, 0.5, 0.8};
  for (const uint32_t depth : {1u, 2u, 3u, 12u}) {
    std::array<double, 3> series{};
    for (size_t c = 0; c < 3; ++c) series[c] = limit[c] * (1 - std::pow(albedo[c], depth));
    if (depth == expected["max_depth"]) {
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(series[c], triple(expected["radiance"])[c], 1e-9);
    }
    const auto batches =
        render_batches(room, box_filtered(16, 16, is_slow_device() ? 2 : 16, depth), BATCHES, depth);
    expect_known(("Lambert furnace, max-depth " + std::to_string(depth)).c_str(), batches,
                 uniform_image(16, 16, series));
  }
}

// By hits alone every emission counts in full: the series again, without light connections. (Light
// connections alone have no finite variance in the edges of a room that emits: no test of means applies.)
TEST_F(Furnace, LambertBoxByHitsAlone) {
  const PreparedScene room = prepare(furnace("furnace"));
  constexpr uint32_t DEPTH = 4;
  const std::array<double, 3> emission = {0.5, 1.0, 2.0}, albedo = {0.2, 0.5, 0.8};
  std::array<double, 3> series{};
  for (size_t c = 0; c < 3; ++c) series[c] = emission[c] * (1 - std::pow(albedo[c], DEPTH)) / (1 - albedo[c]);
  RenderSettings settings = box_filtered(16, 16, is_slow_device() ? 4 : 16, DEPTH);
  settings.techniques = interface::TECHNIQUE_HIT;
  expect_known("Lambert furnace by hits", render_batches(room, settings, BATCHES, 20),
               uniform_image(16, 16, series));
}

// Solids that absorb nothing cannot be seen. Every path has weight 1 and ends on the room, so a pixel differs
// by rounding alone: up to 32 vertices with some 10 roundings of 6e-8 each. A path that does not end within
// max-depth is lost; per path less than 1e-6, but one such path costs its pixel a whole sample: at most 1
// pixel in 100.
void expect_invisible_solid(const char* name) {
  const std::filesystem::path file = furnace(name);
  const nlohmann::json expected = expected_of(file);
  const std::array<double, 3> radiance = triple(expected["radiance"]);
  const Rendered rendered = render(
      prepare(file), box_filtered(64, 64, is_slow_device() ? 4 : 16, expected["max_depth"].get<uint32_t>()));
  constexpr double BOUND = 2e-5;
  size_t off = 0;
  double worst = 0;
  for (size_t i = 0; i < rendered.image.rgb.size(); ++i) {
    const double difference = std::abs(rendered.image.rgb[i] / radiance[i % 3] - 1);
    if (difference > BOUND) ++off;
    worst = std::max(worst, difference);
  }
  std::printf("%s: worst relative difference %.3g (bound %.1g), %zu values of %zu beyond it\n", name, worst,
              BOUND, off, rendered.image.rgb.size());
  EXPECT_LE(off, rendered.image.rgb.size() / 100);
  const std::array<double, 3> mean = mean_of(rendered.image);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(mean[c] / radiance[c], 1, BOUND + 1e-5) << "channel " << c;
}

TEST_F(Furnace, GlassCubeCannotBeSeen) {
  expect_invisible_solid("furnace-glass");
}

TEST_F(Furnace, MirrorBallCannotBeSeen) {
  expect_invisible_solid("furnace-mirror");
}

TEST_F(Furnace, RoughMetalBallLosesWhatSingleScatteringLoses) {
  const std::filesystem::path file = furnace("furnace-rough");
  const nlohmann::json expected = expected_of(file);
  const PreparedScene scene = prepare(file);
  const struct {
    const char* name;
    uint32_t shadowing;
  } models[] = {{"smith_correlated", interface::SHADOWING_SMITH},
                {"smith_uncorrelated", interface::SHADOWING_SMITH_UNCORRELATED},
                {"v_cavity", interface::SHADOWING_V_CAVITY}};
  uint32_t stream = 40;
  for (const auto& model : models) {
    RenderSettings settings = box_filtered(32, 32, is_slow_device() ? 4 : 16, 4);
    settings.shadowing = model.shadowing;
    ComparisonOptions options;
    options.tile = 32;  // the known value is the mean over the whole image
    options.relative_tolerance = expected["relative_error_of_quadrature"];
    expect_known((std::string("rough metal ball, ") + model.name).c_str(),
                 render_batches(scene, settings, BATCHES, stream++),
                 uniform_image(32, 32, triple(expected["image_mean"][model.name])), options);
  }
}

TEST_F(Furnace, PointLightInALambertSphere) {
  const std::filesystem::path file = furnace("furnace-point");
  const nlohmann::json expected = expected_of(file);
  ComparisonOptions options;
  options.relative_tolerance =
      expected["relative_spread_over_facets"];  // the known value is the mean over facets
  expect_known(
      "point light in a Lambert sphere",
      render_batches(prepare(file), box_filtered(16, 16, is_slow_device() ? 2 : 16, expected["max_depth"]),
                     BATCHES, 50),
      uniform_image(16, 16, triple(expected["radiance"])), options);
}

TEST_F(Furnace, MirrorsShowTheDirectLightExactly) {
  const std::filesystem::path file = own_scenes() / "mirrors" / "mirrors.gltf";
  const double direct = expected_of(file)["radiance_direct"];
  ComparisonOptions options;
  options.tile = 16;                  // the known value is the mean over the film
  options.relative_tolerance = 2e-5;  // 1e-6 of the scene's midpoint rule and float rounding
  expect_known("point light between mirrors, direct",
               render_batches(prepare(file), box_filtered(16, 16, 16, 12), BATCHES, 60),
               uniform_image(16, 16, {direct, direct, direct}), options);
}

// Scaling in the direction of the camera keeps camera and light paths in agreement, although it is not
// reciprocal.
TEST_F(Furnace, CameraAndLightPathsAgreeUnderEnergyCompensation) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene built;
  built.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, metal({0.9, 0.6, 0.3}, 1));
  built.add({quad({-1, -1, 2}, {0, 2, 0}, {0, 0, -2})}, plastic({0.5, 0.5, 0.5}, 0.8));
  built.add_point_light({0.3, 0.2, 1.2}, {1, 1, 1});
  built.set_perspective(look_at({1.5, 0.5, 3}, {0, 0, 0.5}), 0.8);
  const PreparedScene scene = prepare(built);
  using namespace technique_sets;
  double means[2][3], errors[2][3];
  for (int side = 0; side < 2; ++side) {
    render::RenderSettings settings = box_filtered(24, 24, 256, 4);
    settings.techniques = side == 0 ? PT : LT;
    settings.has_energy_compensation = true;
    settings.aovs = render::AOV_VARIANCE;
    const Rendered rendered = render(scene, settings);
    const image::Image variance = resolve_variance(rendered.film);
    for (size_t c = 0; c < 3; ++c) {
      double sum = 0, squares = 0;
      for (size_t i = c; i < rendered.image.rgb.size(); i += 3) {
        sum += rendered.image.rgb[i];
        squares += variance.rgb[i];
      }
      means[side][c] = sum / (24 * 24);
      errors[side][c] = std::sqrt(squares) / (24 * 24);
    }
  }
  for (int c = 0; c < 3; ++c) {
    std::printf("pt %.5f (%.5f), lt %.5f (%.5f)\n", means[0][c], errors[0][c], means[1][c], errors[1][c]);
    // Splats of one light path share their noise between pixels: twice the error of independent ones, times
    // four.
    EXPECT_NEAR(means[0][c], means[1][c], 4 * std::hypot(errors[0][c], 2 * errors[1][c]));
    EXPECT_LT(errors[0][c] + errors[1][c], 0.01 * means[0][c]);
  }
}

}  // namespace
}  // namespace regulus::test

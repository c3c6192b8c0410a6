// Whole renders by both backends with the same random numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "check/reference_render.hpp"
#include "images/support/copies.hpp"
#include "images/support/render_scene.hpp"
#include "render/aov.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;

// Share of values that differ by more than a thousandth, of themselves or of one.
double share_of_differences(const std::vector<float>& a, const std::vector<float>& b) {
  size_t differ = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const bool is_equal = a[i] == b[i] || std::abs(a[i] - b[i]) <= 1e-3F * (1 + std::abs(b[i]));
    differ += is_equal ? 0 : 1;
  }
  return static_cast<double>(differ) / static_cast<double>(a.size());
}

// The same random numbers give the same picture but for the few paths that rounding turns elsewhere.
TEST(DeviceRenders, CropsClampsAndRouletteAreTheReferences) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const PreparedScene prepared = prepare(own_scenes() / "cornell/cornell.gltf");
  render::RenderSettings asked = box_filtered(32, 24, 2, 12);
  asked.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT;
  asked.crop = {5, 3, 20, 16};
  constexpr float ALL = std::numeric_limits<float>::infinity();
  for (const auto& [largest, roulette] : {std::pair(ALL, 0.0F), {0.05F, 0.0F}, {ALL, 0.5F}}) {
    asked.largest_contribution = largest;
    asked.shadow_roulette = roulette;
    const image::Image found = render(prepared, asked).image;
    const auto wanted = check::render_with_reference(prepared, make_plan(prepared, asked),
                                                     [](uint64_t, uint64_t) { return true; });
    ASSERT_EQ(found.rgb.size(), wanted.image.rgb.size());
    EXPECT_LT(share_of_differences(found.rgb, wanted.image.rgb), 0.02)
        << "clamped to " << largest << ", roulette below " << roulette;
  }
}

// Four squares, each lit by a black and white texture: the first reads it from left to right (set 0), the
// others from bottom to top, from right to left and from top to bottom (sets 1 to 3); their other textures
// read the sets in other orders.
TEST(DeviceRenders, EveryTextureReadsItsOwnSetOfCoordinates) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const PreparedScene prepared =
      prepare(own_scenes().parent_path() / "tests" / "cases" / "uv-sets" / "four-sets.gltf");
  render::RenderSettings asked = box_filtered(16, 16, 1, 2);
  asked.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE;
  const image::Image found = render(prepared, asked).image;
  const image::Image wanted =
      check::render_with_reference(prepared, make_plan(prepared, asked), [](uint64_t, uint64_t) {
        return true;
      }).image;
  constexpr const char* LIT[] = {".###", ".#..", "#...", "#.##"};
  for (uint32_t i = 0; i < 16 * 16; ++i) {
    const uint32_t row = i / 64, column = i % 16 / 4;
    const bool is_lit = LIT[row][column] == '#';
    EXPECT_EQ(found.rgb[3 * i], is_lit ? 1.0F : 0.0F) << i;
    EXPECT_EQ(wanted.rgb[3 * i], is_lit ? 1.0F : 0.0F) << i;
  }
}

// Light beyond the range of a film in units of 2^-40, in a room far from its file's origin.
TEST(DeviceRenders, DimAndBrightRoomsFarAwayAreTheReferences) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const glm::dvec3 place(-3761604, 4105280, 3870316);
  for (const int exponent : {-43, 54}) {
    GltfScene scene;
    scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), lambert({0.7, 0.6, 0.5}));
    scene.add({quad({-0.4, 0.97, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})},
              emitter(glm::dvec3(std::ldexp(1.0, exponent))));
    scene.set_perspective(look_at({0, 0, 0.9}, {0, 0.2, 0}), 1.4);
    scene.set_root({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {place, 1}});
    const PreparedScene prepared = prepare(scene);
    render::RenderSettings asked = box_filtered(12, 12, 4, 4);
    asked.aovs = render::AOV_POSITION;
    const image::Channels positions = surface_channels(prepared, asked);
    image::Image found = render(prepared, asked).image;
    auto wanted = check::render_with_reference(prepared, make_plan(prepared, asked),
                                               [](uint64_t, uint64_t) { return true; });
    double mean = 0;
    for (std::vector<float>* values : {&found.rgb, &wanted.image.rgb})
      for (float& value : *values) {
        value = std::ldexp(value, -exponent);
        mean += value / static_cast<double>(found.rgb.size());
      }
    EXPECT_GT(mean, 0.05);
    EXPECT_LT(share_of_differences(found.rgb, wanted.image.rgb), 0.02) << exponent;
    for (const char* name : {"P.X", "P.Y", "P.Z"})
      EXPECT_EQ(std::get<std::vector<float>>(positions.at(name)),
                std::get<std::vector<float>>(wanted.channels.at(name)))
          << name;
    for (const float x : std::get<std::vector<float>>(wanted.channels.at("P.X")))
      EXPECT_NEAR(x, place.x, 1.25);
  }
}

TEST(DeviceRenders, AovsAreTheReferences) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const PreparedScene prepared = shared_copies(copies_scene());
  render::RenderSettings asked = box_filtered(32, 32, 1, 2);
  asked.aovs = render::SURFACE_AOVS & ~render::CRYPTO_AOVS;  // those stand in images_layers
  const image::Channels found = surface_channels(prepared, asked);
  const image::Channels wanted =
      check::render_with_reference(prepared, make_plan(prepared, asked), [](uint64_t, uint64_t) {
        return true;
      }).channels;
  ASSERT_EQ(found.size(), wanted.size());
  for (const auto& [name, channel] : found) {
    const auto values = [&](const image::Channels& of) {
      if (const auto* floats = std::get_if<std::vector<float>>(&of.at(name))) return *floats;
      const auto& integers = std::get<std::vector<uint32_t>>(of.at(name));
      return std::vector<float>(integers.begin(), integers.end());
    };
    EXPECT_LT(share_of_differences(values(found), values(wanted)), 0.01) << name;
  }
}

}  // namespace
}  // namespace regulus::test

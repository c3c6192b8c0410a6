// Dispersive glass: Snell's law at each wavelength, the colours of a mean over wavelengths, no light made or
// lost, and the same picture by all techniques.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "reference/wavelength.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"
#include "support/standard_observer.hpp"

namespace regulus::test {
namespace {

using glm::dvec3;
using render::RenderSettings;
using namespace interface;

using namespace technique_sets;

class Dispersion : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

/// A wedge of dispersive glass whose front is met at a right angle, before a wall whose brightness says where
/// a ray has met it. Paths of three edges have gone straight through, or see nothing.
struct Prism {
  static constexpr double IOR = 1.5, DISPERSION = 2, ANGLE = 0.5;
  static constexpr double FRONT = 1, THICKNESS = 0.2;  // at x = -1
  static constexpr double WALL = -4, FROM = -2, TO = 6;

  static double back(double x) { return FRONT - THICKNESS - (x + 1) * std::tan(ANGLE); }

  static GltfScene scene(double half_film) {
    GltfScene scene;
    const auto corner = [](double x, double y, bool is_front) {
      return dvec3(x, y, is_front ? FRONT : back(x));
    };
    Polygons faces;
    const auto add = [&](dvec3 a, dvec3 b, dvec3 c, dvec3 d) { faces.push_back({a, b, c, d}); };
    add(corner(-1, -1, true), corner(1, -1, true), corner(1, 1, true), corner(-1, 1, true));
    add(corner(-1, -1, false), corner(-1, 1, false), corner(1, 1, false), corner(1, -1, false));
    add(corner(-1, -1, true), corner(-1, 1, true), corner(-1, 1, false), corner(-1, -1, false));
    add(corner(1, -1, true), corner(1, -1, false), corner(1, 1, false), corner(1, 1, true));
    add(corner(-1, -1, true), corner(-1, -1, false), corner(1, -1, false), corner(1, -1, true));
    add(corner(-1, 1, true), corner(1, 1, true), corner(1, 1, false), corner(-1, 1, false));
    scene.add(faces, dispersive(glass(IOR), DISPERSION));
    nlohmann::json unlit = lambert({1, 1, 1});
    unlit["extensions"] = {{"KHR_materials_unlit", nlohmann::json::object()}};
    Corners colors;
    colors.colors = {{0, 0, 0, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}, {0, 0, 0, 1}};
    scene.add({quad({FROM, -3, WALL}, {TO - FROM, 0, 0}, {0, 6, 0})}, unlit, glm::dmat4(1), colors);
    scene.set_orthographic(look_at({0, 0, 3}, {0, 0, 0}), half_film, half_film);
    return scene;
  }

  static double index_at(double nanometres) {
    return IOR + (IOR - 1) * DISPERSION / 20 * (523655 / (nanometres * nanometres) - 1.5168);
  }

  /// Brightness of the wall where a ray through the wedge at x meets it.
  static double brightness(double x, double index) {
    const double turn = std::asin(index * std::sin(ANGLE)) - ANGLE;
    return (x + (back(x) - WALL) * std::tan(turn) - FROM) / (TO - FROM);
  }

  /// What Fresnel's equations let through both faces.
  static double passed(double index) {
    const double front = std::pow((index - 1) / (index + 1), 2);
    const double inside = ANGLE, outside = std::asin(index * std::sin(ANGLE));
    const double s = std::sin(inside - outside) / std::sin(inside + outside);
    const double p = std::tan(inside - outside) / std::tan(inside + outside);
    return (1 - front) * (1 - (s * s + p * p) / 2);
  }
};

// A picture of one sample has one wavelength, so it shows one angle; its colour is the wavelength's. As the
// three responses sum to 3, the mean of the channels is the wall's brightness.
TEST_F(Dispersion, PrismsBendEachWavelengthBySnellsLaw) {
  const PreparedScene prism = prepare(Prism::scene(0.8));
  RenderSettings settings = point_sampled(8, 8, 3);
  settings.techniques = PT;
  settings.seed = 5;
  double worst = 0, least = 1, most = 0;
  for (uint32_t sample = 0; sample < 24; ++sample) {
    settings.first_sample = sample;
    const image::Image found = render(prism, settings).image;
    const reference::Wavelength wavelength = reference::wavelength_of(settings.seed, sample);
    const double index = Prism::index_at(wavelength.nanometres);
    int seen = 0;
    for (uint32_t i = 0; i < 8 * 8; ++i) {
      const dvec3 pixel(found.rgb[3 * i], found.rgb[3 * i + 1], found.rgb[3 * i + 2]);
      const double mean = (pixel.r + pixel.g + pixel.b) / 3;
      if (mean == 0) continue;  // the path was reflected
      ++seen;
      const double x = 0.8 * ((i % 8 + 0.5) / 4 - 1);
      worst = std::max(worst, std::abs(mean - Prism::brightness(x, index)));
      EXPECT_LT(length(pixel / mean - wavelength.response), 1e-4) << wavelength.nanometres << " nm";
    }
    EXPECT_GT(seen, 32);
    least = std::min(least, Prism::brightness(0, index));
    most = std::max(most, Prism::brightness(0, index));
  }
  std::printf("largest difference %.2g, of a spread of %.3f\n", worst, most - least);
  EXPECT_LT(worst, 5e-6);
  EXPECT_GT(most - least, 0.01);
}

// The mean over wavelengths against a sum over the standard observer's table: blue is bent most.
TEST_F(Dispersion, PrismsSpreadTheColoursThatTheObserverSees) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const PreparedScene prism = prepare(Prism::scene(1e-4));
  RenderSettings settings = point_sampled(16, 16, 3);
  settings.techniques = PT;
  settings.samples = 16384;  // all pixels have their wavelengths in common
  const std::array<double, 3> found = mean_of(render(prism, settings).image);
  dvec3 known(0), whole(0);
  for (size_t i = 0; i < observer().size(); ++i) {
    const dvec3 response = seen(observer()[i]);
    const double index = Prism::index_at(observed(i));
    known += Prism::passed(index) * Prism::brightness(0, index) * response;
    whole += response;
  }
  known /= whole;
  std::printf("seen %.5f %.5f %.5f, known %.5f %.5f %.5f\n", found[0], found[1], found[2], known.r, known.g,
              known.b);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[static_cast<size_t>(c)], known[c], 1e-3);
  EXPECT_NEAR(found[2] - found[0], known.b - known.r, 5e-4);
  EXPECT_NEAR(found[1] - found[0], known.g - known.r, 5e-4);
  EXPECT_GT(known.b - known.r, 0.01);
}

// White in a white room, however much it disperses; with time, because a single wavelength is coloured.
TEST_F(Dispersion, ClearGlassCannotBeSeen) {
  GltfScene scene;
  scene.add(turned(box({-2, -2, -2}, {2, 2, 2})), emitter({0.5, 1, 2}));
  scene.add(box({-0.6, -0.5, -0.4}, {0.4, 0.5, 0.6}), dispersive(glass(1.5), 3));
  scene.set_perspective(look_at({0.3, 0.4, 1.9}, {0, 0, 0}), 0.8);
  RenderSettings settings = box_filtered(16, 16, is_slow_device() ? 4 : 32, 40);
  settings.techniques = PT;
  expect_known("dispersive glass in a furnace", render_batches(prepare(scene), settings, 17, 1),
               uniform_image(16, 16, {0.5, 1, 2}));
}

/// A room with rough, clear and nested dispersive glass.
GltfScene glass_room(double dispersion) {
  const auto of = [dispersion](const nlohmann::json& material) {
    return dispersion > 0 ? dispersive(material, dispersion) : material;
  };
  GltfScene scene = room(WHITE, of(glass(1.5, 0.5, {0.9, 0.6, 0.5})), of(glass(1.4, 0)));
  scene.add(box({0.25, -0.95, -0.15}, {0.45, -0.7, 0.1}), of(glass(1.8, 0.6)));
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  return scene;
}

TEST_F(Dispersion, AllTechniquesShowTheSame) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const PreparedScene prepared = prepare(glass_room(4));
  const auto batches = [&](uint32_t techniques, uint32_t stream) {
    RenderSettings settings = box_filtered(16, 16, 24, 5);
    settings.techniques = techniques;
    if ((techniques & TECHNIQUE_MERGE) != 0) {
      settings.light_paths = 2048;
      settings.merge_radius = 0.02f;
      settings.merge_reduction = 0;
    }
    return render_batches(prepared, settings, 11, stream);
  };
  const auto known = batches(PT, 300);
  expect_equal("dispersive glass, bpt", batches(BPT, 301), known);
  ComparisonOptions merged;
  merged.relative_tolerance = 3e-3;  // as in LightSubpaths
  expect_equal("dispersive glass, vcm", batches(VCM, 302), known, merged);
  expect_equal("dispersive glass, hit, splat, merge",
               batches(TECHNIQUE_HIT | TECHNIQUE_SPLAT | TECHNIQUE_MERGE, 303), known, merged);
}

// What has met no dispersive glass has no wavelength: its colours are those of the room without dispersion.
TEST_F(Dispersion, PathsThatMeetNoGlassAreAsWithoutIt) {
  RenderSettings settings = point_sampled(32, 32, 2);
  settings.techniques = PT;
  const PreparedScene spread = prepare(glass_room(4)), plain = prepare(glass_room(0));
  const image::Image with = render(spread, settings).image, without = render(plain, settings).image;
  settings.aovs = render::AOV_MATERIAL;
  const image::Channels surfaces = surface_channels(spread, settings);
  const auto& materials = std::get<std::vector<uint32_t>>(surfaces.at("material"));
  int bare = 0, coloured = 0;
  for (size_t i = 0; i < materials.size(); ++i) {
    ASSERT_GT(materials[i], 0u);  // 0: nothing, then the first
    const bool is_glass = spread.scene.materials[materials[i] - 1].dispersion > 0;
    for (size_t c = 0; c < 3; ++c) {
      const double a = with.rgb[3 * i + c], b = without.rgb[3 * i + c];
      if (is_glass) {
        coloured += std::abs(a - b) > 0.1 * b ? 1 : 0;
      } else {
        ++bare;
        EXPECT_NEAR(a, b, 1e-6 * b) << i << " of material " << materials[i];
      }
    }
  }
  EXPECT_GT(bare, 1000);
  EXPECT_GT(coloured, 20);
}

// A sample's wavelength is its own: ranges of samples add up, and a crop has the whole's bits.
TEST_F(Dispersion, RangesAndCropsHaveTheBitsOfTheWhole) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const PreparedScene prepared = prepare(glass_room(4));
  RenderSettings settings = box_filtered(24, 20, 5, 5);
  settings.techniques = VCM;
  settings.merge_radius = 0.05f;
  const Rendered whole = render(prepared, settings);
  settings.samples = 2;
  const Rendered front = render(prepared, settings);
  settings.first_sample = 2;
  settings.samples = 3;
  const Rendered back = render(prepared, settings);
  const auto sum_of = [](const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
    std::vector<uint32_t> sum(a.size());
    uint64_t carry = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      if (i % 3 == 0) carry = 0;
      carry += uint64_t{a[i]} + b[i];
      sum[i] = static_cast<uint32_t>(carry);
      carry >>= 32;
    }
    return sum;
  };
  EXPECT_EQ(sum_of(front.film.words, back.film.words), whole.film.words);
  EXPECT_EQ(sum_of(front.film.splat_words, back.film.splat_words), whole.film.splat_words);
  settings.first_sample = 0;
  settings.samples = 5;
  settings.crop = {7, 3, 10, 12};
  const image::Image part = render(prepared, settings).image;
  for (uint32_t i = 0; i < part.rgb.size(); ++i) {
    const uint32_t row = i / 30 + 3, value = i % 30 + 3 * 7;
    EXPECT_EQ(part.rgb[i], whole.image.rgb[row * 72 + value]) << i;
  }
}

}  // namespace
}  // namespace regulus::test

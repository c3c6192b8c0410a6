// Where shading normals and surface disagree (shaders/lib/shading.glsl): no light is lost at poor normals,
// the terminator of a coarse smooth mesh is that of the curved surface, and all techniques see the same.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "check/reference_render.hpp"
#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "interface/wavefront.h"
#include "reference/world.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using glm::dvec3;

using namespace technique_sets;

class Normals : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

image::Image by_reference(const PreparedScene& scene, const render::RenderSettings& settings) {
  return check::render_with_reference(scene, make_plan(scene, settings),
                                      [](uint64_t, uint64_t) { return true; })
      .image;
}

/// A block of 2 x 1 x 2 with a wave of four crests on top, whose normals lean by acos .85 against the facets,
/// to one side and the other.
void add_wave(GltfScene& scene, const nlohmann::json& material, const glm::dmat4& matrix) {
  constexpr int FACETS = 8;
  const double lean = std::acos(0.85);
  Polygons polygons;
  Corners corners;
  const auto add = [&](const Polygon& polygon, double angle) {
    const dvec3 flat = normalize(cross(polygon[1] - polygon[0], polygon[2] - polygon[0]));
    const dvec3 normal(flat.x * std::cos(angle) - flat.y * std::sin(angle),
                       flat.x * std::sin(angle) + flat.y * std::cos(angle), flat.z);
    polygons.push_back(polygon);
    for (size_t i = 0; i < polygon.size(); ++i) corners.normals.push_back(glm::vec3(normal));
  };
  const auto x = [](int i) { return -1 + 2.0 * i / FACETS; };
  const auto top = [](int i) { return i % 2 == 0 ? 0.4 : 0.55; };
  for (int i = 0; i < FACETS; ++i) {
    const double a = x(i), b = x(i + 1), ya = top(i), yb = top(i + 1);
    add({{a, ya, 1}, {b, yb, 1}, {b, yb, -1}, {a, ya, -1}}, i / 2 % 2 == 0 ? lean : -lean);
    add({{a, -0.5, 1}, {b, -0.5, 1}, {b, yb, 1}, {a, ya, 1}}, 0);
    add({{b, -0.5, -1}, {a, -0.5, -1}, {a, ya, -1}, {b, yb, -1}}, 0);
    add({{a, -0.5, -1}, {b, -0.5, -1}, {b, -0.5, 1}, {a, -0.5, 1}}, 0);
  }
  add({{-1, -0.5, -1}, {-1, -0.5, 1}, {-1, top(0), 1}, {-1, top(0), -1}}, 0);
  add({{1, -0.5, 1}, {1, -0.5, -1}, {1, top(FACETS), -1}, {1, top(FACETS), 1}}, 0);
  scene.add(polygons, material, matrix, corners);
}

void add_smooth_ball(GltfScene& scene, const nlohmann::json& material, double radius, int rings,
                     const glm::dmat4& matrix = glm::dmat4(1)) {
  const Polygons ball = sphere({0, 0, 0}, radius, rings);
  Corners corners;
  for (const Polygon& polygon : ball)
    for (const dvec3& corner : polygon) corners.normals.push_back(glm::vec3(normalize(corner)));
  scene.add(ball, material, matrix, corners);
}

// Clear and without absorption a body shows only light of the surroundings, of radiance 1: through its flat
// bottom the wave is seen from inside, where most of it reflects totally, and mirrored at its normals much
// would leave through the facets. 1 but for the few paths that are longer than 32 edges.
TEST_F(Normals, AWaveOfPoorNormalsCannotBeSeenInAFurnace) {
  for (const auto& [name, roughness] : {std::pair("smooth", 0.0)}) {
    GltfScene built;
    add_wave(built, glass(1.33, roughness), glm::dmat4(1));
    built.set_setting("environment", {{"color", {1, 1, 1}}});
    built.set_orthographic(look_at({1.2, -3, 0.9}, {0, 0, 0}), 1.6, 1.6);
    const PreparedScene scene = prepare(built);
    render::RenderSettings settings = box_filtered(24, 24, is_slow_device() ? 1 : 4, 32);
    const image::Image images[] = {render(scene, settings).image, by_reference(scene, settings)};
    for (const image::Image& image : images) {
      size_t off = 0;
      for (const float value : image.rgb) off += std::abs(value - 1) > 2e-5 ? 1 : 0;
      std::printf("%s: %zu values off of %zu\n", name, off, image.rgb.size());
      EXPECT_LE(off, image.rgb.size() / 100);
    }
  }
}

// Seen from inside, a closed coarse ball with smooth normals that glows and reflects holds the series of its
// bounces, although the shading normals lean by up to 11 degrees against the facets. So short that roulette
// ends no path.
TEST_F(Normals, AClosedCoarseBallKeepsItsLight) {
  constexpr double ALBEDO = 0.8;
  constexpr uint32_t DEPTH = 3;
  GltfScene built;
  nlohmann::json wall = lambert({ALBEDO, ALBEDO, ALBEDO});
  wall["emissiveFactor"] = {1, 1, 1};
  const Polygons ball = turned(sphere({0, 0, 0}, 1, 8));
  Corners corners;
  for (const Polygon& polygon : ball)
    for (const dvec3& corner : polygon) corners.normals.push_back(glm::vec3(-normalize(corner)));
  built.add(ball, wall, glm::dmat4(1), corners);
  built.set_perspective(look_at({0.2, 0.1, 0}, {1, 0.3, 0.2}), 1.2);
  const PreparedScene scene = prepare(built);
  render::RenderSettings settings = box_filtered(8, 8, 4, DEPTH);
  settings.techniques = TECHNIQUE_HIT;  // every path has the weight of its albedos: no noise
  const double known = (1 - std::pow(ALBEDO, DEPTH)) / (1 - ALBEDO);
  for (const image::Image& image : {render(scene, settings).image, by_reference(scene, settings)})
    for (const float value : image.rgb) EXPECT_NEAR(value, known, 1e-4);
}

// White, in the light of the sun: I cos / pi with the angle to the shading normal, down to 0 and no more.
TEST_F(Normals, TheTerminatorOfACoarseBallIsSmooth) {
  constexpr double HALF = 1.05;  // of the film's width, m
  GltfScene built;
  add_smooth_ball(built, lambert({1, 1, 1}), 1, 8);
  const dvec3 to_sun = glm::normalize(dvec3(0.9, 0.2, 0.1));
  built.add_directional_light(-to_sun, std::numbers::pi);
  built.set_orthographic(look_at({0, 0, 5}, {0, 0, 0}), HALF, HALF);
  const PreparedScene scene = prepare(built);
  render::RenderSettings settings = point_sampled(64, 64, 2);
  const reference::World world(scene);
  const image::Image images[] = {render(scene, settings).image, by_reference(scene, settings)};
  for (const image::Image& image : images) {
    size_t seen = 0, off = 0, dark = 0;
    for (size_t i = 0; i < 64 * 64; ++i) {
      const double x = static_cast<double>(i % 64) + 0.5, y = static_cast<double>(i / 64) + 0.5;
      const dvec3 origin(HALF * (2 * x / 64 - 1), HALF * (1 - 2 * y / 64), 5);
      const auto hit = world.traversal().closest({origin, {0, 0, -1}});
      if (!hit) continue;
      const dvec3 normal = world.surface_at(hit->triangle, hit->barycentrics).shading_normal;
      ++seen;
      const double known = std::max(dot(normal, to_sun), 0.0);
      off += std::abs(image.rgb[3 * i] - known) > 1e-4 ? 1 : 0;
      dark += known > 0.02 && image.rgb[3 * i] == 0 ? 1 : 0;
    }
    std::printf("%zu pixels, %zu off, %zu of them dark\n", seen, off, dark);
    EXPECT_GT(seen, 2500u);
    EXPECT_LE(off, seen / 200);
  }
}

render::RenderSettings settings_of(uint32_t techniques) {
  render::RenderSettings settings = box_filtered(16, 16, 24, 5);
  settings.techniques = techniques;
  if ((techniques & TECHNIQUE_MERGE) != 0) {
    settings.light_paths = 2048;
    settings.merge_radius = 0.02f;
    settings.merge_reduction = 0;
  }
  return settings;
}

// A wave of rough glass and poor normals: both directions of a pair are seen alike, whichever way it is
// walked. And beside it a coarse ball of plastic, whose light from beyond its facets' horizons no light path
// brings: the weights know.
TEST_F(Normals, TechniquesAgreeOnAWaveAndACoarseBall) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  constexpr int BATCHES = 11;
  for (const bool has_ball : {false, true}) {
    GltfScene built = room(WHITE, WHITE, WHITE);
    built.add({ceiling_light()}, emitter({2, 1.5, 1}));
    const glm::dmat4 wave = {{0.35, 0, 0, 0}, {0, 0.35, 0, 0}, {0, 0, 0.35, 0}, {-0.2, -0.6, 0.25, 1}};
    add_wave(built, glass(1.4, 0.5), wave);
    const glm::dmat4 place = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0.35, -0.4, 0.3, 1}};
    if (has_ball) add_smooth_ball(built, plastic({0.8, 0.8, 0.3}, 0.4), 0.3, 5, place);
    const PreparedScene scene = prepare(built);
    const auto known = render_batches(scene, settings_of(PT), BATCHES, 900);
    // A merge averages over its disk, which matters near edges and corners.
    ComparisonOptions blurred;
    blurred.relative_tolerance = 3e-3;
    if (has_ball)
      expect_equal("wave and ball, vcm", render_batches(scene, settings_of(VCM), BATCHES, 902), known,
                   blurred);
    else
      expect_equal("wave, lt", render_batches(scene, settings_of(TECHNIQUE_SPLAT), BATCHES, 901), known);
  }
}

}  // namespace
}  // namespace regulus::test

// The patterns by which `regulus check` measures how well conditioned a number is: whatever single precision
// moves, they move as far.
#include "reference/rounding.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "images/support/gltf_scene.hpp"
#include "reference/support/reference_images.hpp"
#include "reference/walk.hpp"
#include "scene/placement.hpp"
#include "scene/scene.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using reference::GivenHit;
using reference::World;

// As `check` has them (check/connection_checker.hpp).
constexpr uint32_t PATTERNS = 8;
constexpr double CONDITIONING = 4;

GivenHit hit_at(const World& world, uint32_t triangle, const dvec3& position) {
  const auto p = scene::placed_positions(world.scene(), triangle);
  const dvec3 u = dvec3(p[1]) - dvec3(p[0]), v = dvec3(p[2]) - dvec3(p[0]), to = position - dvec3(p[0]);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), determinant = uu * vv - uv * uv;
  return {
      triangle,
      {(vv * dot(to, u) - uv * dot(to, v)) / determinant, (uu * dot(to, v) - uv * dot(to, u)) / determinant}};
}

reference::CameraSubpath walk(const World& world, reference::Settings settings, uint32_t sample,
                              uint32_t pattern, const std::vector<GivenHit>* given) {
  settings.rounding_pattern = pattern;
  const reference::Camera camera(
      scene::make_camera(world.scene().cameras.at(0), settings.width, settings.height), settings.width,
      settings.height);
  return walk_from_camera(world, camera, settings, 0, sample, given);
}

/// The cosine at which `direction` meets the triangle, all of it but the last product in single precision.
double cosine_in_single_precision(const World& world, const dvec3& direction) {
  const auto p = scene::placed_positions(world.scene(), 0);
  return std::abs(dot(direction, dvec3(normalize(cross(p[1] - p[0], p[2] - p[0])))));
}

TEST(ReferenceRounding, MovesNormalsOfNeedles) {
  Random random(71);
  double largest = 0;
  for (int i = 0; i < 40; ++i) {
    const dvec3 along = random.direction(), aside = normalize(cross(along, random.direction()));
    const dvec3 tip(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double width = std::pow(10, random.uniform(-3, -1));
    GltfScene file;
    file.add({{tip, tip + along, tip + along + width * aside}}, lambert(dvec3(0.5)));
    const dvec3 center = tip + 2.0 / 3 * along + width / 3 * aside;
    const dvec3 grazing = normalize(aside + 0.05 * cross(along, aside));
    file.add_directional_light(-grazing, 1);
    file.set_perspective(look_at(center + 2.0 * grazing, center, along), 0.1);
    const PreparedScene scene = prepare(file);
    const World world(scene);
    const reference::Settings settings = reference_point_sampled(1, 1, 1);
    const std::vector<GivenHit> given{{0, dvec2(1.0 / 3)}};
    const reference::CameraSubpath exact = walk(world, settings, 0, 0, &given);
    ASSERT_EQ(exact.vertices.size(), 1u) << i;
    const double cosine = exact.vertices[0].edge.cos_light_end;
    double spread = 0;
    for (uint32_t pattern = 1; pattern <= PATTERNS; ++pattern) {
      const reference::CameraSubpath moved = walk(world, settings, 0, pattern, &given);
      ASSERT_EQ(moved.vertices.size(), 1u) << i;
      spread = std::max(spread, std::abs(moved.vertices[0].edge.cos_light_end - cosine));
    }
    const double error = std::abs(cosine_in_single_precision(world, -exact.vertices[0].w_back) - cosine);
    largest = std::max(largest, error);
    EXPECT_LE(error, CONDITIONING * spread) << "needle " << i << " of width " << width;
  }
  std::printf("single precision moves cosines by up to %.1e\n", largest);
  EXPECT_GT(largest, 1e-6) << "no needle here needs it";
}

// Where solids touch, the way between surfaces is known exactly for media, but a device's ray starts off its
// surface.
TEST(ReferenceRounding, MovesWhereRaysStartThoughSolidsTouch) {
  GltfScene file;
  file.add({quad({-2, 0, -0.01}, {0, 0, 0.02}, {4, 0, 0})}, lambert(dvec3(0.9)));
  file.add(box({-3, 1, -3}, {3, 2, 3}), glass(1.5));
  file.add(box({-3, 2, -3}, {3, 3, 3}), glass(1.3));
  file.add_directional_light({0, -1, 0}, 1);
  file.set_perspective(look_at({0.3, 0.5, 0}, {0.3, 0, 0}, {1, 0, 0}), 0.01);
  const PreparedScene scene = prepare(file);
  const World world(scene);
  ASSERT_TRUE(world.has_contacts());
  reference::Settings settings = reference_point_sampled(1, 1, 2);
  settings.seed = static_cast<uint32_t>(base_seed());
  for (uint32_t sample = 0; sample < 4; ++sample) {
    std::vector<GivenHit> given;
    const reference::CameraSubpath exact = walk(world, settings, sample, 0, nullptr);
    ASSERT_EQ(exact.vertices.size(), 2u) << "the slab of glass hides the sky from the strip";
    for (const reference::WalkVertex& vertex : exact.vertices)
      given.push_back(hit_at(world, vertex.surface.triangle, vertex.surface.position));
    double most = 0;
    for (uint32_t pattern = 1; pattern <= PATTERNS; ++pattern) {
      const reference::CameraSubpath moved = walk(world, settings, sample, pattern, &given);
      ASSERT_EQ(moved.vertices.size(), 2u);
      most = std::max(most, std::abs(moved.vertices[1].edge.distance - exact.vertices[1].edge.distance));
    }
    const reference::Surface& strip = exact.vertices[0].surface;
    const double shift =
        clearance(world, strip) * std::abs(dot(exact.vertices[1].w_back, strip.geometric_normal));
    // Barycentrics leave the hit on the glass, whose corners are at most 3 m from any axis, by four
    // roundings.
    const double hit = std::sqrt(3.0) * 4 * reference::UNIT_ROUNDOFF * 3;
    EXPECT_GE(CONDITIONING * most, shift) << sample;
    EXPECT_LE(most, shift + hit + 1e-6) << sample;
  }
}

// On a plain of a kilometre barycentrics of single precision lie tens of micrometres beside where the ray has
// met it. The device's weights take the ray's length, those of a walk that is followed the way to the hit.
TEST(ReferenceRounding, MovesTheLengthOfRaysToLargeTriangles) {
  GltfScene file;
  file.add({quad({-500, 0, -500}, {0, 0, 1000}, {1000, 0, 0})}, lambert(dvec3(0.5)));
  file.add_directional_light({0, -1, 0}, 1);
  file.set_perspective(look_at({0.3, 0.6, 1.5}, {0, 0, 0}), 0.4);
  const PreparedScene scene = prepare(file);
  const World world(scene);
  const reference::Settings settings = reference_settings(1, 1, 1, 2);
  double largest = 0;
  for (uint32_t sample = 0; sample < 40; ++sample) {
    const reference::CameraSubpath exact = walk(world, settings, sample, 0, nullptr);
    ASSERT_GE(exact.vertices.size(), 1u);
    const reference::Surface& surface = exact.vertices[0].surface;
    GivenHit hit = hit_at(world, surface.triangle, surface.position);
    hit.barycentrics = dvec2(glm::vec2(hit.barycentrics));
    const std::vector<GivenHit> given{hit};
    const auto length_of = [&](uint32_t pattern) {
      return walk(world, settings, sample, pattern, &given).vertices.at(0).edge.distance;
    };
    const double followed = length_of(0), error = std::abs(followed - exact.vertices[0].edge.distance);
    double spread = 0;
    for (uint32_t pattern = 1; pattern <= PATTERNS; ++pattern)
      spread = std::max(spread, std::abs(length_of(pattern) - followed));
    largest = std::max(largest, error);
    EXPECT_LE(error, CONDITIONING * spread) << sample;
  }
  std::printf("barycentrics move lengths by up to %.1e m\n", largest);
  EXPECT_GT(largest, 1e-5) << "no ray here needs it";
}

}  // namespace
}  // namespace regulus::test

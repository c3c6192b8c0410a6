// Pictures do not depend on the unit of length, nor on where the origin is, as far as float positions allow.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

constexpr int BATCHES = 9;
constexpr uint32_t SIZE = 16;

glm::dmat4 scaling(double scale) {
  return {{scale, 0, 0, 0}, {0, scale, 0, 0}, {0, 0, scale, 0}, {0, 0, 0, 1}};
}

glm::dmat4 translation(const glm::dvec3& by) {
  return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {by, 1}};
}

// An open box with a diffuse, a rough and a glass body, lit from its ceiling.
GltfScene still_life(const glm::dmat4& root) {
  GltfScene scene;
  Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  walls.erase(walls.begin() + 1);  // the front is open
  scene.add(walls, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.7, -1, -0.6}, {-0.1, 0.1, 0}), metal({0.9, 0.7, 0.4}, 0.6));
  scene.add(sphere({0.4, -0.55, 0.1}, 0.4, 12), glass(1.5, 0.5));
  scene.add({quad({-0.5, 0.95, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({2, 1.5, 1}));
  scene.set_perspective(look_at({0, 0, 3.4}, {0, 0, 0}), 0.6);
  scene.set_root(root);
  return scene;
}

class Scale : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

std::vector<image::Image> batches_of(const glm::dmat4& root, uint32_t stream) {
  return render_batches(prepare(still_life(root)), box_filtered(SIZE, SIZE, is_slow_device() ? 4 : 16, 6),
                        BATCHES, stream);
}

TEST_F(Scale, UnitOfLengthDoesNotMatter) {
  const auto metres = batches_of(scaling(1), 1);
  // Other seeds, so that both sides are independent.
  expect_equal("scale 1e-3", batches_of(scaling(1e-3), 2), metres);
  expect_equal("scale 1e4", batches_of(scaling(1e4), 3), metres);
}

// The box is 2 m and 20 km from the origin on each axis: positions are multiples of 1/512 m, ray origins are
// lifted by some 0.06 m (16 roundings of 3 coordinates of 2e4). What is within that of an edge, some 12 % of
// the walls, may leak; light that leaks is lost. So the picture may be darker by that share per edge of its
// paths, of which the first two carry most of the light, and must not be brighter than float noise lets it. A
// surface that shadows itself would lose half or all of its light.
TEST_F(Scale, FarFromTheOriginNothingShadowsItself) {
  const auto near = batches_of(scaling(1), 4), far = batches_of(translation(glm::dvec3(2e4)), 5);
  std::array<double, 3> near_mean{}, far_mean{};
  for (int i = 0; i < BATCHES; ++i)
    for (size_t c = 0; c < 3; ++c) near_mean[c] += mean_of(near[i])[c], far_mean[c] += mean_of(far[i])[c];
  for (size_t c = 0; c < 3; ++c) {
    std::printf("channel %zu: far / near = %.4f (bounds 0.75, 1.05)\n", c, far_mean[c] / near_mean[c]);
    EXPECT_GT(far_mean[c] / near_mean[c], 0.75);
    EXPECT_LT(far_mean[c] / near_mean[c], 1.05);
  }
}

// A tilted plane that nothing shadows, lit by a point: nothing is random, so a single pixel that its own
// triangle shadows is a failure. Coordinates are not representable, and the plane is a grid of many triangles
// whose edges rays meet too.
void expect_no_acne(double scale, const glm::dvec3& shift, double bound) {
  constexpr int GRID = 7;
  constexpr uint32_t FILM = 64;
  const glm::dmat4 tilt = look_at({0.31, 0.83, 0.47}, {0, 0, 0});
  Polygons plane;
  for (int y = 0; y < GRID; ++y)
    for (int x = 0; x < GRID; ++x)
      plane.push_back(
          quad({2.0 * x / GRID - 1, 2.0 * y / GRID - 1, 0}, {2.0 / GRID, 0, 0}, {0, 2.0 / GRID, 0}));
  GltfScene scene;
  scene.add(transformed(tilt, plane), lambert({1, 1, 1}));
  const glm::dvec3 light = glm::dvec3(tilt * glm::dvec4(0.2, 0.1, 0.9, 1));
  scene.add_point_light(light, glm::dvec3(scale * scale));  // so that the irradiance is that of scale 1
  scene.set_orthographic(tilt * translation({0, 0, 0.5}), 0.9 * scale, 0.9 * scale);
  scene.set_root(translation(shift) * scaling(scale));
  const image::Image image = render(prepare(scene), point_sampled(FILM, FILM, 2)).image;

  double worst = 0;
  for (uint32_t y = 0; y < FILM; ++y)
    for (uint32_t x = 0; x < FILM; ++x) {
      const glm::dvec2 p(0.9 * (2 * (x + 0.5) / FILM - 1), 0.9 * (1 - 2 * (y + 0.5) / FILM));
      const double squared = (p.x - 0.2) * (p.x - 0.2) + (p.y - 0.1) * (p.y - 0.1) + 0.81;
      const double known = 0.9 / (squared * std::sqrt(squared)) / std::numbers::pi;
      worst = std::max(worst, std::abs(image.rgb[3 * (y * FILM + x)] / known - 1));
    }
  std::printf("scale %g, shift %g: worst relative difference %.3g (bound %.2g)\n", scale, shift.x, worst,
              bound);
  EXPECT_LE(worst, bound);
}

TEST_F(Scale, LitPlaneHasNoAcneAtAnyScale) {
  for (const double scale : {1e-4, 1e-3, 1.0, 37.0, 1e4, 1e6}) expect_no_acne(scale, glm::dvec3(0), 1e-3);
}

// A plane through the origin, square to an axis: the coordinate along its normal is exactly 0, and so is any
// error bound that is relative to it. Light from 60 to 85 degrees off the normal, so that the ray's longest
// component is not the normal's.
TEST_F(Scale, LitPlaneThroughTheOriginHasNoAcneInGrazingLight) {
  constexpr uint32_t FILM = 32;
  const struct {
    const char* name;
    glm::dvec3 u, v;
  } planes[] = {
      {"x = 0", {0, 1, 0}, {0, 0, 1}}, {"y = 0", {0, 0, 1}, {1, 0, 0}}, {"z = 0", {1, 0, 0}, {0, 1, 0}}};
  for (const auto& plane : planes)
    for (const double degrees : {60.0, 75.0, 85.0}) {
      const glm::dvec3 normal = glm::cross(plane.u, plane.v);
      const double angle = degrees * std::numbers::pi / 180;
      const glm::dvec3 to_light =
          std::cos(angle) * normal + std::sin(angle) * (0.8 * plane.u + 0.6 * plane.v);
      GltfScene scene;
      scene.add({quad(-3.0 * (plane.u + plane.v), 6.0 * plane.u, 6.0 * plane.v)}, lambert({1, 1, 1}));
      scene.add_directional_light(-to_light, 1);
      scene.set_orthographic(look_at(normal, {0, 0, 0}, plane.v), 1, 1);
      const image::Image image = render(prepare(scene), point_sampled(FILM, FILM, 2)).image;
      int dark = 0;
      double worst = 0;
      for (const float value : image.rgb) {
        dark += value == 0;
        worst = std::max(worst, std::abs(value / (std::cos(angle) / std::numbers::pi) - 1));
      }
      std::printf(
          "plane %s, light at %g degrees: worst relative difference %.3g (bound 1e-3), %d values dark\n",
          plane.name, degrees, worst, dark);
      EXPECT_LE(worst, 1e-3) << plane.name;
    }
}

// At distance D times its size positions are off by half a unit in the last place on each axis, D 2^-24; the
// light, 0.9 away, and the point move against each other by twice that, and 1/d^3 amplifies by 3 (by 4 with
// the cosine).
TEST_F(Scale, LitPlaneHasNoAcneFarFromTheOrigin) {
  for (const double distance : {1e2, 1e3, 1e4}) {
    const double bound = 4 * 2 * std::sqrt(3.0) * distance * 0x1p-23 / 0.9 + 1e-4;
    expect_no_acne(1, glm::dvec3(1, -0.7, 0.9) * distance, bound);
  }
}

}  // namespace
}  // namespace regulus::test

// What surfaces may carry beside factors: vertex colours. Against closed forms, on the device and in the
// scalar reference, which reads the same arrays but shares no code with the kernels.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec4;
using nlohmann::json;
using std::numbers::pi;

// As in analytic.cpp: 60 roundings of 2^-24 between the camera and the pixel. Colours and texture coordinates
// are interpolated from a few more.
constexpr double ROUNDING = 1e-5;
constexpr uint32_t SIZE = 32;

// The square [-1, 1]^2 of the plane z = 0 with uv (0, 0) at its upper left corner, as an image lies, and an
// orthographic camera whose film is that square.
const Polygon SQUARE = quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
const std::vector<glm::vec2> SQUARE_UVS = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};

GltfScene above_square() {
  GltfScene scene;
  scene.set_orthographic(look_at({0, 0, 0.5}, {0, 0, 0}), 1, 1);
  return scene;
}

dvec2 film_point(uint32_t x, uint32_t y) {
  return {2 * (x + 0.5) / SIZE - 1, 1 - 2 * (y + 0.5) / SIZE};
}

using Radiance = std::function<dvec3(const dvec2&)>;

/// Every pixel against the radiance of its centre's point.
void expect_image(const char* what, const GltfScene& scene, const Radiance& radiance,
                  double relative = ROUNDING) {
  const image::Image found = render(prepare(scene), point_sampled(SIZE, SIZE, 2)).image;
  double worst = 0;
  for (uint32_t y = 0; y < SIZE; ++y)
    for (uint32_t x = 0; x < SIZE; ++x) {
      const dvec3 known = radiance(film_point(x, y));
      for (int c = 0; c < 3; ++c) {
        const double value = found.rgb[3 * (y * SIZE + x) + static_cast<uint32_t>(c)];
        worst = std::max(worst, std::abs(value - known[c]) / std::max(std::abs(known[c]), 1e-3));
      }
    }
  std::printf("%s: worst relative difference %.3g, bound %.3g\n", what, worst, relative);
  EXPECT_LE(worst, relative) << what;
}

class Surfaces : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

// Red grows to the right, green upwards: what the two triangles of the square interpolate between its
// corners.
TEST_F(Surfaces, VertexColoursScaleTheBaseColour) {
  GltfScene scene = above_square();
  Corners corners;
  corners.colors = {{0, 0, 0.5, 1}, {1, 0, 0.5, 1}, {1, 1, 0.5, 1}, {0, 1, 0.5, 1}};
  scene.add({SQUARE}, lambert({0.5, 0.8, 0.6}), glm::dmat4(1), corners);
  scene.add_directional_light({0, 0.6, -0.8}, 2);
  expect_image("vertex colours", scene, [](const dvec2& p) {
    return dvec3(0.5, 0.8, 0.6) * dvec3(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y, 0.5) * (2 * 0.8 / pi);
  });
}

TEST_F(Surfaces, VertexColoursScaleWhatIsUnlit) {
  GltfScene scene = above_square();
  Corners corners;
  corners.colors = {{0, 0, 0.5, 1}, {1, 0, 0.5, 1}, {1, 1, 0.5, 1}, {0, 1, 0.5, 1}};
  json unlit = lambert({0.5, 0.8, 0.6});
  unlit["extensions"] = {{"KHR_materials_unlit", json::object()}};
  scene.add({SQUARE}, unlit, glm::dmat4(1), corners);
  expect_image("unlit vertex colours", scene, [](const dvec2& p) {
    return dvec3(0.5, 0.8, 0.6) * dvec3(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y, 0.5);
  });
}

}  // namespace
}  // namespace regulus::test

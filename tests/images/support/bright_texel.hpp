// An environment map that is black but for one texel, and the irradiance of a plane under it.
#pragma once

#include <cmath>
#include <numbers>

#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"

namespace regulus::test {

/// The texel `column`, `row` of a map of odd size that is not twice as wide as high.
struct BrightTexel {
  static constexpr uint32_t WIDTH = 65, HEIGHT = 21;
  uint32_t column = WIDTH / 2, row = HEIGHT / 2;  ///< this one's centre lies in direction +x
  glm::dvec3 radiance{40, 80, 20};

  image::Image map() const {
    image::Image image{WIDTH, HEIGHT, std::vector<float>(size_t{3} * WIDTH * HEIGHT)};
    for (int c = 0; c < 3; ++c)
      image.rgb[3 * (row * WIDTH + column) + static_cast<size_t>(c)] = static_cast<float>(radiance[c]);
    return image;
  }

  /// Direction (sin theta cos phi, cos theta, sin theta sin phi) with phi growing from +x to +z, the map then
  /// turned counterclockwise as seen from +y.
  static glm::dvec3 direction(double theta, double phi, double rotation_degrees) {
    const double turn = rotation_degrees * std::numbers::pi / 180;
    const glm::dvec3 w(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    return {std::cos(turn) * w.x + std::sin(turn) * w.z, w.y, -std::sin(turn) * w.x + std::cos(turn) * w.z};
  }

  /// Irradiance per unit radiance of a plane with this normal: the texel as bilinear interpolation spreads
  /// it, by the midpoint rule on 400 x 400 cells (error below 1e-5).
  double irradiance(const glm::dvec3& normal, double rotation_degrees) const {
    constexpr int CELLS = 400;
    const double step_theta = std::numbers::pi / HEIGHT, step_phi = 2 * std::numbers::pi / WIDTH;
    double sum = 0;
    for (int i = 0; i < CELLS; ++i)
      for (int k = 0; k < CELLS; ++k) {
        const double dx = 2 * (i + 0.5) / CELLS - 1,
                     dy = 2 * (k + 0.5) / CELLS - 1;  // texels from its centre
        const double theta = step_theta * (row + 0.5 + dy);
        const double phi = step_phi * (column + 0.5 + dx - 0.5 * WIDTH);
        if (theta < 0 || theta > std::numbers::pi) continue;
        const bool is_towards_pole = dy < 0 ? row == 0 : row == HEIGHT - 1;  // where the map ends
        const double share = (1 - std::abs(dx)) * (is_towards_pole ? 1 : 1 - std::abs(dy));
        sum += share * std::max(0.0, dot(normal, direction(theta, phi, rotation_degrees))) * std::sin(theta);
      }
    return sum * step_theta * step_phi * 4 / (CELLS * double{CELLS});
  }
};

/// A white square facing `normal`, which a camera that looks at it head-on cannot see past.
inline GltfScene white_square(const glm::dvec3& normal) {
  GltfScene scene;
  scene.add({disk({0, 0, 0}, normal, 1, 4)}, lambert({1, 1, 1}));
  scene.set_orthographic(
      look_at(0.5 * normal, {0, 0, 0}, std::abs(normal.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1)),
      0.4, 0.4);
  return scene;
}

}  // namespace regulus::test

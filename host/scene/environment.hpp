// Environment light: a constant radiance or a latitude-longitude map, and how directions of it are drawn
// (interface::Environment says how a map is laid out).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// A scene's environment.
struct Environment {
  interface::Environment parameters {};
  std::vector<glm::vec3> texels;  ///< of the map: row-major from the top row; empty if there is none
  std::vector<float> cdf;         ///< of the map's cells, see interface::Environment
  double integral = 0;            ///< luminance over all directions, W/m^2

  bool is_map() const { return parameters.width > 0; }
};

/// The same radiance (>= 0, finite) from all directions.
Environment uniform_environment(const glm::vec3& radiance);

/// A latitude-longitude map of `width` times `texels.size() / width` texels; becomes a uniform environment if
/// all texels are equal. Texels are finite and >= 0. `rotation` in turns.
///
/// The share of a cell is the luminance of its texel, averaged over it as interpolation spreads it (so that
/// no direction that shines has a density of 0), times its solid angle.
Environment map_environment(std::vector<glm::vec3> texels, uint32_t width, double rotation);

/// Radiance of a scene that has neither a light nor an environment: enough to see it by.
inline constexpr float DIM_RADIANCE = 0.5f;

}  // namespace regulus::scene

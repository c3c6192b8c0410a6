// Small scenes made in code and their pictures, by the device and by the reference.
#pragma once

#include <utility>

#include "prepared/prepared_scene.hpp"
#include "render/renderer.hpp"
#include "scene/environment.hpp"
#include "stability/sweep.hpp"

namespace regulus::stability {

inline constexpr double SIGMAS = 6;  ///< of pixels that are far from normal where geometry terms are large

/// A diffuse surface that emits `radiance`.
interface::Material diffuse(double albedo, double radiance);

/// A scene under construction.
class Stage {
 public:
  /// The parallelogram corner, corner + u, corner + u + v, corner + v, its front towards cross(u, v).
  void add_quad(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v,
                const interface::Material& material);
  void add_point_light(const glm::dvec3& position, double intensity);
  /// A sun that shines down along -z.
  void add_sun(double irradiance);
  void set_environment(scene::Environment environment);
  /// A camera that looks along -z at a square of these half extents.
  PreparedScene seen_from(const glm::dvec3& eye, double half_extent);

 private:
  scene::Scene scene_;
};

render::RenderSettings settings_of(uint32_t techniques, uint32_t size, uint32_t samples, uint32_t depth);

/// Mean of a picture, and its standard error if all pixels have the same expectation.
struct Mean {
  double value = 0, error = 0;
};

Mean by_device(gpu::Device& device, const PreparedScene& prepared, const render::RenderSettings& settings);
Mean by_reference(const PreparedScene& prepared, const render::RenderSettings& settings);

}  // namespace regulus::stability

// Cameras and the pixel filter in double precision. Film coordinates are pixels, as in interface::Camera.
#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <optional>

#include "interface/scene.h"
#include "interface/wavefront.h"

namespace regulus::reference {

/// Density of rays from (or to) an end of a path: per steradian, or, if all rays are parallel, per square
/// metre across them.
struct RayDensity {
  double value = 0;
  bool is_parallel = false;

  /// The same per square metre of a surface that the ray meets at this cosine and distance.
  double on_surface(double cos_surface, double distance) const {
    return is_parallel ? value * cos_surface : value * cos_surface / (distance * distance);
  }
};

/// A camera ray. What it sees lies between two distances from its origin.
struct CameraRay {
  glm::dvec3 origin, direction;
  double nearest = 0, farthest = std::numeric_limits<double>::infinity();  ///< m

  /// Where it starts to see.
  glm::dvec3 start() const { return origin + nearest * direction; }
};

/// A camera with its film.
class Camera {
 public:
  Camera(const interface::Camera& camera, uint32_t width, uint32_t height);

  /// The ray through film point `film`; `u`, uniform in [0, 1)^2, is the place on the lens.
  CameraRay ray(const glm::dvec2& film, const glm::dvec2& u) const;

  /// A ray from the lens, seeing from one clipping plane to the other.
  CameraRay clipped(const glm::dvec3& origin, const glm::dvec3& direction) const;

  /// Density of rays in a direction, given the point on the lens, if film points have density 1 per square
  /// pixel.
  RayDensity density(const glm::dvec3& direction) const;

  /// Where light from `point` reaches the film through the lens point of `u`, and by which ray (from the lens
  /// to the point). Nothing if the point is behind the camera or not between its clipping planes; the film
  /// point may lie beyond the film.
  struct Projection {
    glm::dvec2 film;
    CameraRay ray;
  };
  std::optional<Projection> project(const glm::dvec3& point, const glm::dvec2& u) const;

  /// Depth of a point along the camera's axis, m.
  double depth(const glm::dvec3& point) const { return dot(point - position_, forward_); }

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  bool is_orthographic() const { return is_orthographic_; }
  double lens_radius() const { return lens_radius_; }  ///< m
  /// Area of one pixel: on the plane at distance 1 (perspective), or in space (orthographic).
  double pixel_area() const { return pixel_area_; }

 private:
  glm::dvec3 lens_shift(const glm::dvec2& u) const;
  glm::dvec2 film_of(const glm::dvec2& ndc) const;

  bool is_orthographic_;
  glm::dvec3 position_, forward_, right_, up_;
  double lens_radius_, focus_distance_;
  double near_, far_;  // depths of the clipping planes
  uint32_t width_, height_;
  double pixel_area_;  // of one pixel on the plane at distance 1 (perspective), or in space (orthographic)
};

/// The reconstruction filter h around a pixel's centre; its integral is 1.
struct Filter {
  uint32_t kind = interface::FILTER_BLACKMAN_HARRIS;
  double radius = 1.5;  ///< pixels
  double sigma = 0.5;   ///< pixels, Gaussian only

  /// h at an offset from the pixel's centre, 1 / px^2: a product over x and y of a box, a truncated normal
  /// density, or the four-term Blackman-Harris window (Harris 1978) stretched over [-radius, radius].
  double value(const glm::dvec2& offset) const;

  /// An offset with density h. Ernst, Stamminger and Greiner, Filter Importance Sampling, 2006.
  glm::dvec2 sample(const glm::dvec2& u) const;
};

}  // namespace regulus::reference

#include "reference/footprint.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::reference {

namespace {

// Angular variance of a Lambert lobe, by which angles are measured.
constexpr double LAMBERT_VARIANCE = 0.25;

}  // namespace

Footprint footprint_at_lens(const Camera& camera) {
  const double pixel = camera.pixel_area() / 12;  // the variance of a square along an axis
  if (camera.is_orthographic()) return {pixel, 0, 0};
  return {camera.lens_radius() * camera.lens_radius() / 4, 0, std::min(pixel, LAMBERT_VARIANCE)};
}

Footprint travelled(const Footprint& start, double distance) {
  // x' = x + d a
  return {start.position + 2 * distance * start.covariance + distance * distance * start.angle,
          start.covariance + distance * start.angle, start.angle};
}

Footprint scattered(const Footprint& start, const BsdfSample& event, double curvature, double eta) {
  if (event.is_diffuse) return {start.position, 0, LAMBERT_VARIANCE};
  // a' = p a + q x, and the lobe's own variance.
  double p = 1, q = 0;
  double lobe = 2 * event.alpha.x * event.alpha.y;
  if (event.is_refracted) {
    const double e = 1 / eta;
    p = e;
    q = -(1 - e) * curvature;
    lobe = event.alpha.x * event.alpha.y * (1 - e) * (1 - e) / 2;
  } else if (!event.is_transmitted) {
    q = 2 * curvature;
  }
  const double angle = p * p * start.angle + 2 * p * q * start.covariance + q * q * start.position;
  Footprint result{start.position, p * start.covariance + q * start.position,
                   std::min(std::max(angle, 0.0) + lobe, LAMBERT_VARIANCE)};
  const double most = std::sqrt(result.position * result.angle);  // Cauchy and Schwarz
  result.covariance = std::clamp(result.covariance, -most, most);
  return result;
}

double diffusion(const Footprint& footprint) {
  return std::min(1.0, 2 * std::sqrt(footprint.angle));
}

}  // namespace regulus::reference

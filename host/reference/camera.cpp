#include "reference/camera.hpp"

#include <cmath>
#include <numbers>

#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;

Camera::Camera(const interface::Camera& camera, uint32_t width, uint32_t height)
    : is_orthographic_(camera.kind == interface::CAMERA_ORTHOGRAPHIC),
      position_(camera.position),
      forward_(camera.forward),
      right_(camera.right),
      up_(camera.up),
      lens_radius_(is_orthographic_ ? 0 : camera.lens_radius),
      focus_distance_(camera.focus_distance),
      near_(camera.z_near),
      far_(camera.z_far),
      width_(width),
      height_(height),
      pixel_area_(4 * length(right_) * length(up_) / (static_cast<double>(width) * height)) {}

dvec3 Camera::lens_shift(const dvec2& u) const {
  if (lens_radius_ == 0) return dvec3(0);
  const dvec2 lens = lens_radius_ * sample_disk(u);
  return lens.x * normalize(right_) + lens.y * normalize(up_);
}

CameraRay Camera::clipped(const dvec3& origin, const dvec3& direction) const {
  const double cosine = dot(direction, forward_);
  return {origin, direction, near_ / cosine, far_ / cosine};
}

CameraRay Camera::ray(const dvec2& film, const dvec2& u) const {
  const dvec2 ndc(2 * film.x / width_ - 1, 1 - 2 * film.y / height_);
  const dvec3 across = ndc.x * right_ + ndc.y * up_;
  if (is_orthographic_) return clipped(position_ + across, forward_);
  // All rays of a film point meet in the plane of focus.
  const dvec3 shift = lens_shift(u);
  const dvec3 in_focus = focus_distance_ * (forward_ + across);
  return clipped(position_ + shift,
                 lens_radius_ == 0 ? normalize(forward_ + across) : normalize(in_focus - shift));
}

RayDensity Camera::density(const dvec3& direction) const {
  if (is_orthographic_) return {1 / pixel_area_, true};
  // A pixel covers pixel_area_ of the plane at distance 1, or distance^2 as much of the plane of focus; seen
  // from the lens point, both are pixel_area_ cos^3 steradians.
  const double cosine = dot(direction, forward_);
  return {1 / (pixel_area_ * cosine * cosine * cosine), false};
}

dvec2 Camera::film_of(const dvec2& ndc) const {
  return {0.5 * (ndc.x + 1) * width_, 0.5 * (1 - ndc.y) * height_};
}

std::optional<Camera::Projection> Camera::project(const dvec3& point, const dvec2& u) const {
  const auto across_of = [&](const dvec3& v) {
    return dvec2(dot(v, right_) / dot(right_, right_), dot(v, up_) / dot(up_, up_));
  };
  const dvec3 shift = lens_shift(u);
  const dvec3 to_point = point - position_ - shift;
  const double depth = dot(to_point, forward_);
  if (!(depth > 0 && depth >= near_ && depth <= far_)) return std::nullopt;
  if (is_orthographic_)
    return Projection{film_of(across_of(to_point)), clipped(point - depth * forward_, forward_)};
  const double plane = lens_radius_ == 0 ? 1 : focus_distance_;
  const dvec3 on_plane = shift + to_point * (plane / depth);  // relative to the lens centre
  return Projection{film_of(across_of(on_plane) / plane), clipped(position_ + shift, normalize(to_point))};
}

namespace {

// Four-term minimum Blackman-Harris window, a_0 + a_1 cos(pi t) + a_2 cos(2 pi t) + a_3 cos(3 pi t) for t in
// [-1, 1] (Harris, On the Use of Windows for Harmonic Analysis, 1978, table 1).
constexpr double WINDOW[] = {0.35875, 0.48829, 0.14128, 0.01168};

double window(double t) {
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += WINDOW[k] * std::cos(k * std::numbers::pi * t);
  return sum;
}

/// Integral of the window from 0 to t, over that from 0 to 1.
double window_share(double t) {
  double sum = t;
  for (int k = 1; k < 4; ++k)
    sum += WINDOW[k] / WINDOW[0] * std::sin(k * std::numbers::pi * t) / (k * std::numbers::pi);
  return sum;
}

/// t in [-1, 1] whose signed share is `v`, by bisection.
double invert_window(double v) {
  double low = 0;
  double high = 1;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (window_share(middle) < std::abs(v) ? low : high) = middle;
  }
  return std::copysign(0.5 * (low + high), v);
}

}  // namespace

double Filter::value(const dvec2& offset) const {
  if (std::abs(offset.x) > radius || std::abs(offset.y) > radius) return 0;
  if (kind == interface::FILTER_BOX) return 1 / (4 * radius * radius);
  if (kind == interface::FILTER_BLACKMAN_HARRIS) {
    const double normalization = 2 * WINDOW[0] * radius;
    return window(offset.x / radius) * window(offset.y / radius) / (normalization * normalization);
  }
  const double inside = std::erf(radius / (sigma * std::numbers::sqrt2));
  const double normalization = 1 / (2 * std::numbers::pi * sigma * sigma * inside * inside);
  return normalization * std::exp(-dot(offset, offset) / (2 * sigma * sigma));
}

dvec2 Filter::sample(const dvec2& u) const {
  const dvec2 centred = 2.0 * u - 1.0;
  if (kind == interface::FILTER_BOX) return centred * radius;
  if (kind == interface::FILTER_BLACKMAN_HARRIS)
    return radius * dvec2(invert_window(centred.x), invert_window(centred.y));
  const double scale = sigma * std::numbers::sqrt2;
  const double inside = std::erf(radius / scale);
  return {scale * erf_inverse(centred.x * inside), scale * erf_inverse(centred.y * inside)};
}

}  // namespace regulus::reference

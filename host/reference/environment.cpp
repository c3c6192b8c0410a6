#include "reference/environment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using scene::Environment;
using std::numbers::pi;

namespace {

/// A cumulative distribution.
using Cdf = std::span<const float>;

Cdf row_cdf(const Environment& environment) {
  return Cdf(environment.cdf).first(environment.parameters.height + 1);
}

Cdf column_cdf(const Environment& environment, size_t row) {
  const size_t entries = environment.parameters.width + size_t{1};
  return Cdf(environment.cdf).subspan(environment.parameters.height + 1 + row * entries, entries);
}

double share_of(const Cdf& cdf, size_t cell) {
  return double{cdf[cell + 1]} - double{cdf[cell]};
}

/// Where the distribution reaches u, in cells. The cell is found in single precision like the device's.
double invert(const Cdf& cdf, double u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end(), static_cast<float>(u));
  const auto cell = static_cast<size_t>(above - cdf.begin()) - 1;
  return static_cast<double>(cell) + (u - cdf[cell]) / share_of(cdf, cell);
}

/// Point of the map, in texels.
dvec2 position_of(const Environment& environment, const dvec3& w) {
  const double turns = std::atan2(w.z, w.x) / (2 * pi) + 0.5 + environment.parameters.rotation;
  const double theta = std::atan2(std::hypot(w.x, w.z), w.y);
  return {(turns - std::floor(turns)) * environment.parameters.width,
          theta / pi * environment.parameters.height};
}

dvec3 direction_of(const Environment& environment, const dvec2& position) {
  const double theta = pi * position.y / environment.parameters.height;
  const double phi =
      2 * pi * (position.x / environment.parameters.width - 0.5 - environment.parameters.rotation);
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

/// A texel. Columns beyond one side of the map continue on the other; rows beyond the poles are those at the
/// poles.
dvec3 texel(const Environment& environment, int64_t x, int64_t y) {
  const int64_t width = environment.parameters.width;
  const int64_t height = environment.parameters.height;
  const int64_t index = std::clamp<int64_t>(y, 0, height - 1) * width + (x % width + width) % width;
  return environment.texels[static_cast<size_t>(index)];
}

}  // namespace

dvec3 environment_radiance(const Environment& environment, const dvec3& w) {
  if (!environment.is_map()) return environment.parameters.radiance;
  const dvec2 between = position_of(environment, w) - 0.5;  // centres of texels lie at halves
  const dvec2 corner = floor(between);
  const dvec2 share = between - corner;
  dvec3 radiance(0);
  for (int i = 0; i < 4; ++i) {
    const int right = i % 2;
    const int below = i / 2;
    const double weight = (right == 1 ? share.x : 1 - share.x) * (below == 1 ? share.y : 1 - share.y);
    radiance += weight * texel(environment, static_cast<int64_t>(corner.x) + right,
                               static_cast<int64_t>(corner.y) + below);
  }
  return radiance;
}

dvec3 sample_environment(const Environment& environment, const dvec2& u) {
  if (!environment.is_map()) return sample_sphere(u);
  const double y = invert(row_cdf(environment), u.y);
  const double x = invert(column_cdf(environment, static_cast<size_t>(y)), u.x);
  return direction_of(environment, {x, y});
}

dvec2 environment_numbers(const Environment& environment, const dvec3& w) {
  const dvec2 position = position_of(environment, w);
  const auto row = static_cast<size_t>(std::min(position.y, environment.parameters.height - 1.0));
  const auto column = static_cast<size_t>(std::min(position.x, environment.parameters.width - 1.0));
  const auto reached = [](const Cdf& cdf, size_t cell, double place) {
    return std::min(cdf[cell] + share_of(cdf, cell) * (place - static_cast<double>(cell)), 1 - 0x1p-24);
  };
  return {reached(column_cdf(environment, row), column, position.x),
          reached(row_cdf(environment), row, position.y)};
}

double environment_pdf(const Environment& environment, const dvec3& w) {
  if (!environment.is_map()) return 1 / (4 * pi);
  const double width = environment.parameters.width;
  const double height = environment.parameters.height;
  const dvec2 position = position_of(environment, w);
  const auto row = static_cast<size_t>(std::min(position.y, height - 1));
  const auto column = static_cast<size_t>(std::min(position.x, width - 1));
  const double share = share_of(row_cdf(environment), row) * share_of(column_cdf(environment, row), column);
  // A cell is 2 pi / width by pi / height radians; the area on the sphere shrinks with the sine.
  return share * width * height / (2 * pi * pi * std::hypot(w.x, w.z));
}

}  // namespace regulus::reference

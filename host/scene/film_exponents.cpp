#include "scene/film_exponents.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/components.hpp"
#include "interface/wavefront.h"
#include "scene/light_power.hpp"

namespace regulus::scene {
namespace {

using std::numbers::pi;
// Samples of the brightest that fit into a sum: 2^this. Of what is smaller than 2^-SPECK_BITS of the scene's
// radius squared the fewer the smaller it is, since as few of a pixel's samples meet it; one at least.
constexpr double HEADROOM_BITS = 24, SPECK_BITS = 47;
// Ordinary light keeps the unit that films always had.
constexpr double LEAST_ORDINARY_BRIGHTNESS = 0x1p-20, LEAST_ORDINARY_LEVEL = 0x1p-30;
// A kernel multiplies by 2^-exponent in single precision, with room for what is multiplied; of squares, whose
// range is twice as large, by 2^(2 exponent of radiance - exponent of squares).
constexpr int LEAST_EXPONENT = -100, GREATEST_EXPONENT = 74;

/// The exponent, between two bounds, for sums up to `largest_sum` of values up to `brightest`, most of them
/// about `level`.
int exponent_for(double largest_sum, double brightest, double level, int least, int greatest) {
  if (!(brightest > 0)) return 0;
  const double top = std::ceil(std::log2(largest_sum)) - static_cast<double>(interface::FILM_RANGE_BITS);
  const bool is_dim = brightest < LEAST_ORDINARY_BRIGHTNESS || level < LEAST_ORDINARY_LEVEL;
  if (top <= 0 && !is_dim) return 0;
  const double wanted = top > 0 ? top : std::max(top, std::floor(std::log2(level)));  // log2(0) is -infinite
  return static_cast<int>(std::clamp<double>(wanted, least, greatest));
}

}  // namespace

void FilmRange::add_visible(const glm::dvec3& radiance, double area) {
  const double brightness = largest_component(radiance);
  const double speck_bits = std::max(-std::log2(area / (radius_ * radius_)) - SPECK_BITS, 0.0);
  const double samples = std::exp2(std::max(HEADROOM_BITS - speck_bits, 0.0));
  brightest_ = std::max(brightest_, brightness);
  largest_sum_ = std::max(largest_sum_, brightness * samples);
  largest_sum_of_squares_ = std::max(largest_sum_of_squares_, brightness * brightness * samples);
}

void FilmRange::add_punctual(const interface::Light& light) {
  const double intensity = largest_component(glm::dvec3(light.intensity));
  if (light.kind == interface::LIGHT_DIRECTIONAL) {
    level_ += intensity / pi;
    return;
  }
  const double distance = std::max(glm::length(glm::dvec3(light.position) - center_), radius_);
  level_ += intensity / (pi * distance * distance);
}

void FilmRange::add_power(double power) {
  level_ += power / (4 * pi * pi * radius_ * radius_);
}

void FilmRange::add_environment(const Environment& environment) {
  add_visible(glm::dvec3(environment.parameters.radiance));
  for (const glm::vec3& texel : environment.texels) add_visible(glm::dvec3(texel));
  level_ += environment.integral / (4 * pi);
}

FilmExponents FilmRange::exponents() const {
  const double brightest = std::max(brightest_, level_), most = std::exp2(HEADROOM_BITS);
  return {exponent_for(std::max(largest_sum_, level_ * most), brightest, level_, LEAST_EXPONENT,
                       GREATEST_EXPONENT),
          exponent_for(std::max(largest_sum_of_squares_, level_ * level_ * most), brightest * brightest,
                       level_ * level_, 2 * LEAST_EXPONENT, 2 * GREATEST_EXPONENT + 31)};
}

}  // namespace regulus::scene

#include "scene/wavelengths.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace regulus::scene {

using glm::dvec3;
using interface::Wavelength;
using interface::WAVELENGTH_COUNT;

namespace {

constexpr double STEP = 1.0 / 32;  // nm

// Fraunhofer's lines, nm.
constexpr double D_LINE = 587.56, F_LINE = 486.13, C_LINE = 656.27;

/// 523655 nm^2 / wavelength^2 - 1.5168, as the extension rounds it.
double bend_at(double wavelength) {
  const auto power = [](double x) { return 1 / (x * x); };
  return (power(wavelength) - power(D_LINE)) / (power(F_LINE) - power(C_LINE));
}

/// Integrals of the responses from the shortest wavelength up to each step, and linear between them.
class CumulativeResponse {
 public:
  CumulativeResponse() {
    const auto steps = static_cast<size_t>((LONGEST_WAVELENGTH - SHORTEST_WAVELENGTH) / STEP);
    sums_.reserve(steps + 1);
    sums_.emplace_back(0);
    for (size_t i = 0; i < steps; ++i)
      sums_.push_back(sums_.back() + clipped_color_matching(wavelength_of(static_cast<double>(i) + 0.5)));
    whole_ = sums_.back();
    for (dvec3& sum : sums_) sum /= whole_;
  }

  /// Place, in steps, below which the mean response has this share.
  double place_of(double share) const {
    const auto mean = [](const dvec3& sum) { return (sum.r + sum.g + sum.b) / 3; };
    const auto after = std::ranges::upper_bound(sums_, share, {}, mean);
    if (after == sums_.end()) return static_cast<double>(sums_.size() - 1);
    const auto before = after - 1;
    return static_cast<double>(before - sums_.begin()) +
           (share - mean(*before)) / (mean(*after) - mean(*before));
  }

  dvec3 at(double place) const {
    const size_t step = std::min(static_cast<size_t>(place), sums_.size() - 2);
    return glm::mix(sums_[step], sums_[step + 1], place - static_cast<double>(step));
  }

  static double wavelength_of(double place) { return SHORTEST_WAVELENGTH + STEP * place; }

 private:
  std::vector<dvec3> sums_;
  dvec3 whole_{0};
};

}  // namespace

dvec3 color_matching(double wavelength) {
  const auto lobe = [wavelength](double height, double middle, double below, double above) {
    const double t = (wavelength - middle) * (wavelength < middle ? below : above);
    return height * std::exp(-0.5 * t * t);
  };
  return {lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(0.362, 442.0, 0.0624, 0.0374) -
              lobe(0.065, 501.1, 0.0490, 0.0382),
          lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
          lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)};
}

dvec3 clipped_color_matching(double wavelength) {
  const dvec3 xyz = color_matching(wavelength);
  const dvec3 rgb(dot(dvec3(3.2404542, -1.5371385, -0.4985314), xyz),
                  dot(dvec3(-0.9692660, 1.8760108, 0.0415560), xyz),
                  dot(dvec3(0.0556434, -0.2040259, 1.0572252), xyz));
  return glm::max(rgb, dvec3(0));
}

std::vector<Wavelength> make_wavelengths() {
  const CumulativeResponse response;
  const auto edge = [](uint32_t i) { return static_cast<double>(i) / WAVELENGTH_COUNT; };
  std::vector<Wavelength> table;
  table.reserve(WAVELENGTH_COUNT);
  for (uint32_t i = 0; i < WAVELENGTH_COUNT; ++i) {
    const double middle = response.place_of(0.5 * (edge(i) + edge(i + 1)));
    // Where a channel sees nothing, rounding may leave less than that.
    const dvec3 share = glm::max(
        response.at(response.place_of(edge(i + 1))) - response.at(response.place_of(edge(i))), dvec3(0));
    table.push_back({static_cast<float>(bend_at(CumulativeResponse::wavelength_of(middle))),
                     glm::vec3(double{WAVELENGTH_COUNT} * share)});
  }
  return table;
}

bool is_dispersive(const interface::Material& material) {
  return material.dispersion > 0;
}

std::vector<float> sampled_bends() {
  static const std::array<float, 2> ENDS = [] {
    const std::vector<Wavelength> table = make_wavelengths();
    return std::array{table.back().bend, table.front().bend};
  }();
  constexpr int COUNT = 5;
  std::vector<float> bends;
  bends.reserve(COUNT);
  for (int i = 0; i < COUNT; ++i)
    bends.push_back(std::lerp(ENDS[0], ENDS[1], static_cast<float>(i) / (COUNT - 1)));
  return bends;
}

double dispersed_ior(const interface::Material& material, double bend) {
  constexpr double LARGEST = 1e6;
  const double ior = material.ior;
  return std::clamp(ior + (ior - 1) * material.dispersion / 20 * bend, 1.0, LARGEST);
}

}  // namespace regulus::scene

#include "reference/iridescence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/components.hpp"

namespace regulus::reference {

using glm::dvec3;
using std::numbers::pi;

namespace {

double reflectance_at_normal(double transmitted_ior, double incident_ior) {
  const double amplitude = (transmitted_ior - incident_ior) / (transmitted_ior + incident_ior);
  return amplitude * amplitude;
}

double schlick(double f0, double cosine) {
  return f0 + (1 - f0) * std::pow(std::max(1 - cosine, 0.0), 5);
}

/// evalSensitivity of the appendix. path: nm; shift: of the phases of X, Y and Z.
dvec3 sensitivity(double path, const dvec3& shift) {
  const double phase = 2 * pi * path * 1e-9;
  const auto gaussian = [phase](double value, double position, double variance, double turned) {
    return value * std::sqrt(2 * pi * variance) * std::cos(position * phase + turned) *
           std::exp(-phase * phase * variance);
  };
  const double x =
      gaussian(5.4856e-13, 1.6810e6, 4.3278e9, shift.x) + gaussian(9.7470e-14, 2.2399e6, 4.5282e9, shift.x);
  const double y = gaussian(4.4201e-13, 1.7953e6, 9.3046e9, shift.y);
  const double z = gaussian(5.2481e-13, 2.2084e6, 6.6121e9, shift.z);
  const dvec3 rgb = {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                     -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                     0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
  return rgb / 1.0685e-7;
}

}  // namespace

/// The series of the reflectance: c0 + c1 S_1 + c1 r S_2.
struct ThinFilm::Channel {
  double c0, c1, r;
  double shift;  // of the phase at the two faces
};

ThinFilm::Channel ThinFilm::channel(double base_f0, double cosine) const {
  const double sin2_inside = (1 - cosine * cosine) / (ior * ior);
  const double r12 = schlick(reflectance_at_normal(ior, 1), cosine);
  const double root = std::sqrt(std::min(base_f0 + 0.0001, 0.9999));
  const double base_ior = (1 + root) / (1 - root);
  const double r23 = schlick(reflectance_at_normal(base_ior, ior), std::sqrt(1 - sin2_inside));
  const double passed = 1 - r12;
  const double product = std::clamp(r12 * r23, 1e-5, 0.9999);
  const double further = passed * passed * r23 / (1 - product);
  const double r = std::sqrt(product);
  return {r12 + further, (further - passed) * r, r, pi + (base_ior < ior ? pi : 0)};
}

dvec3 ThinFilm::reflectance(const dvec3& base_f0, double cosine) const {
  std::array<Channel, 3> channels{};
  dvec3 shift;
  for (int i = 0; i < 3; ++i) {
    channels[static_cast<size_t>(i)] = channel(base_f0[i], cosine);
    shift[i] = channels[static_cast<size_t>(i)].shift;
  }
  const double path = 2 * ior * thickness * std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const dvec3 first = 2.0 * sensitivity(path, shift), second = 2.0 * sensitivity(2 * path, 2.0 * shift);
  dvec3 result;
  for (int i = 0; i < 3; ++i) {
    const Channel& c = channels[static_cast<size_t>(i)];
    result[i] = std::clamp(c.c0 + c.c1 * (first[i] + c.r * second[i]), 0.0, 1.0);
  }
  return result;
}

dvec3 ThinFilm::mean_reflectance(const dvec3& base_f0, double cosine) const {
  return {channel(base_f0.r, cosine).c0, channel(base_f0.g, cosine).c0, channel(base_f0.b, cosine).c0};
}

double ThinFilm::passage(const dvec3& base_f0, double cosine, const glm::dvec2& alpha, bool is_inside) const {
  constexpr double SWING = 1.8, SWING_OF_ANY_SHIFTS = 5.3;  // greatest component of sensitivity()
  constexpr double ROUGH_BEGIN = 0.01, ROUGH_FULL = 0.04;
  const double roughest = std::max(alpha.x, alpha.y);
  const double smooth = largest_component(reflectance(base_f0, cosine));
  if (roughest == 0) return 1 - smooth;
  if (is_inside) return 0;
  const std::array channels = {channel(base_f0.r, cosine), channel(base_f0.g, cosine),
                               channel(base_f0.b, cosine)};
  const bool is_one_shift = channels[0].shift == channels[1].shift && channels[1].shift == channels[2].shift;
  double brightest = 0;
  for (const Channel& c : channels)
    brightest = std::max(
        brightest, c.c0 + std::abs(c.c1) * (1 + c.r) * 2 * (is_one_shift ? SWING : SWING_OF_ANY_SHIFTS));
  const double t = std::clamp((roughest - ROUGH_BEGIN) / (ROUGH_FULL - ROUGH_BEGIN), 0.0, 1.0);
  const double rough = std::lerp(smooth, std::min(brightest, 1.0), t * t * (3 - 2 * t));
  return std::max(1 - rough - std::min(0.15 * roughest, 0.035), 0.0);
}

}  // namespace regulus::reference

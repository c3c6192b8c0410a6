// The diffuse lobe in a Bsdf, and what the interface above leaves to it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/bsdf.hpp"
#include "reference/lobes/sides.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

dvec2 Bsdf::cover(double cosine, double eta) const {
  return parameters_.cover->cover(energy_index_, cosine, energy_roughness_, eta < 1) +
         parameters_.cover_error;
}

dvec3 Bsdf::base_reflectance(double cosine, double eta) const {
  const dvec3 smooth = dielectric_.reflectance(cosine, eta);
  const double share = cover_share_[eta < 1];
  if (share == 0) return smooth;
  const double position = cover(cosine, eta).y;
  return glm::mix(smooth, dielectric_.at_position(position), share);
}

/// With energy compensation the facets of a rough interface are met at other angles than the surface: by the
/// tables, from outside.
dvec3 Bsdf::diffuse_transmittance(double cosine, double eta) const {
  if (parameters_.energy != nullptr && eta >= 1) {
    const double further = parameters_.energy->fresnel(energy_index_, cosine, energy_roughness_);
    return 1.0 - dielectric_.remap(
                     fresnel_dielectric(cosine, eta) + further * (1 - fresnel_normal_incidence(eta)), eta);
  }
  dvec3 passed = 1.0 - base_reflectance(cosine, eta);
  if (const double share = cover_share_[eta < 1]; share > 0) {
    const double kept = cover(cosine, eta).x;
    passed += share * (1 - kept) * dielectric_.f0;
  }
  return passed;
}

/// The light that passes an interface is the same from both sides: 1 - F_avg at the back is 1 / n^2 of that
/// at the front.
dvec3 Bsdf::mean_transmittance(bool is_back) const {
  const double eta = is_back ? 1 / parameters_.ior : parameters_.ior;
  const double front = *parameters_.fresnel_average;
  const double average = is_back ? 1 - (1 - front) * eta * eta : front;
  dvec3 passed = 1.0 - dielectric_.remap(average, eta);
  if (parameters_.energy != nullptr && eta >= 1)
    passed -= parameters_.energy->fresnel_mean(energy_index_, energy_roughness_) *
              (dielectric_.f90 - dielectric_.f0);
  if (const double share = cover_share_[eta < 1]; share > 0) {
    const dvec2 mean = parameters_.cover->cover_mean(energy_index_, energy_roughness_, eta < 1);
    const dvec3 rough = 1.0 - mean.x * dielectric_.f0 - mean.y * (dielectric_.f90 - dielectric_.f0);
    passed = glm::mix(passed, rough, share);
  }
  return glm::max(passed, dvec3(1e-6));
}

dvec3 Bsdf::diffuse_value(const dvec3& wo, const dvec3& wi, double eta) const {
  if (is_in_relief_shadow_) return dvec3(0);
  const dvec3 plain = diffuse_scale_[eta != parameters_.ior] * diffuse_transmittance(wi.z, eta) *
                      diffuse_transmittance(wo.z, eta);
  if (parameters_.film_strength == 0) return plain;
  const auto passage = [&](double cosine) {
    return parameters_.film.passage(dielectric_.f0, thin_cosine(cosine, eta), own_alpha_, eta < 1);
  };
  return glm::mix(plain, diffuse_albedo_ / pi * std::min(passage(wo.z), passage(wi.z)),
                  parameters_.film_strength);
}

/// From inside a solid light leaves by a cone alone, but for what f90 and facets leave of the rest.
double Bsdf::cone_share(double eta) const {
  if (eta >= 1) return 0;
  const double in_cone = (dielectric_.f90 - luminance(dielectric_.f0)) * eta * eta;
  return in_cone > 0 ? (1 - cover_share_[false]) * in_cone / (in_cone + (1 - dielectric_.f90)) : 0;
}

double Bsdf::diffuse_pdf(double cosine, double eta, double sheen) const {
  if (sheen > 0) return (1 - sheen) * cosine / pi + sheen / (2 * pi);
  const double share = cone_share(eta);
  const bool is_in_cone = 1 - cosine * cosine < eta * eta;
  return cosine / pi * (1 - share + (is_in_cone ? share / (eta * eta) : 0));
}

dvec3 Bsdf::sample_diffuse(const dvec2& u, double eta, double sheen) const {
  if (u.x < sheen) return sample_cone({u.x / sheen, u.y}, 0);
  if (sheen > 0) return sample_cosine_hemisphere({(u.x - sheen) / (1 - sheen), u.y});
  const double share = cone_share(eta);
  if (u.x >= share) return sample_cosine_hemisphere({(u.x - share) / (1 - share), u.y});
  const dvec3 w = eta * sample_cosine_hemisphere({u.x / share, u.y});
  return {w.x, w.y, std::sqrt(1 - w.x * w.x - w.y * w.y)};
}

}  // namespace regulus::reference

#include "reference/fresnel.hpp"

#include <algorithm>
#include <cmath>

#include "reference/quadrature.hpp"

namespace regulus::reference {

using glm::dvec3;

double fresnel_dielectric(double cos_incident, double eta) {
  if (eta == 1) return 0;
  const double sin2_transmitted = (1 - cos_incident * cos_incident) / (eta * eta);
  if (sin2_transmitted >= 1) return 1;
  const double cos_transmitted = std::sqrt(1 - sin2_transmitted);
  const double perpendicular =
      (cos_incident - eta * cos_transmitted) / (cos_incident + eta * cos_transmitted);
  const double parallel = (eta * cos_incident - cos_transmitted) / (eta * cos_incident + cos_transmitted);
  return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

double fresnel_normal_incidence(double eta) {
  const double amplitude = (eta - 1) / (eta + 1);
  return amplitude * amplitude;
}

double fresnel_dielectric_average(double eta) {
  // Below the critical cosine of the dense side F is 1; above it the square root makes the curve steep at
  // that end, hence the grading towards it. For eta > 1 the same grading resolves the grazing peak.
  const double critical = eta < 1 ? std::sqrt(1 - eta * eta) : 0;
  const double span = 1 - critical;
  const auto integrand = [&](double x) {
    const double mu = critical + span * x;
    return 2 * fresnel_dielectric(mu, eta) * mu * span;
  };
  return critical * critical + integrate_graded(integrand);
}

dvec3 fresnel_metal(const dvec3& base, double cos_incident) {
  return base + (1.0 - base) * std::pow(std::max(1 - cos_incident, 0.0), 5);
}

SpecularDielectric SpecularDielectric::make(double eta, double specular, const dvec3& specular_color) {
  return {glm::min(fresnel_normal_incidence(eta) * specular_color, dvec3(1)) * specular, specular};
}

dvec3 SpecularDielectric::remap(double exact, double eta) const {
  return at_position(position(exact, eta));
}

double SpecularDielectric::lowest_position() const {
  const double darkest = std::min({f0.x, f0.y, f0.z});
  return -darkest / std::max(f90 - darkest, 1e-6);
}

double SpecularDielectric::position(double exact, double eta) const {
  const double normal = fresnel_normal_incidence(eta);
  return std::max((exact - normal) / (1 - normal), lowest_position());
}

dvec3 SpecularDielectric::at_position(double position) const {
  // Above n = 2 + sqrt(3) the exact curve dips below normal incidence near Brewster's angle.
  return glm::mix(f0, dvec3(f90), std::max(position, lowest_position()));
}

dvec3 SpecularDielectric::reflectance(double cos_incident, double eta) const {
  return remap(fresnel_dielectric(cos_incident, eta), eta);
}

}  // namespace regulus::reference

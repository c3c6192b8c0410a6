// Fresnel reflectance in double precision: exact dielectric, its hemispherical average, the glTF specular
// remapping, and Schlick's metal. Angles enter as cosines; eta = n(transmitted side) / n(incident side).
#pragma once

#include <glm/glm.hpp>

namespace regulus::reference {

/// Reflectance of a smooth dielectric interface for unpolarized light. `cos_incident` in [0, 1]. 1 beyond the
/// critical angle; 0 for eta = 1 at every angle. Born and Wolf, Principles of Optics, 1.5.2.
double fresnel_dielectric(double cos_incident, double eta);

/// Reflectance at normal incidence, ((eta - 1) / (eta + 1))^2; equal for eta and 1 / eta.
double fresnel_normal_incidence(double eta);

/// Hemispherical average 2 int_0^1 F(mu) mu dmu, by quadrature (absolute error below 1e-9).
double fresnel_dielectric_average(double eta);

/// Schlick's reflectance of a metal with normal-incidence colour `base`: base + (1 - base) (1 - c)^5.
glm::dvec3 fresnel_metal(const glm::dvec3& base, double cos_incident);

/// The dielectric reflectance of KHR_materials_specular: the exact curve, mapped linearly so that normal
/// incidence gives `f0` and grazing incidence `f90`; where the darkest channel would become negative the
/// curve stays there for all channels.
struct SpecularDielectric {
  glm::dvec3 f0;  ///< min(F0 * specular colour, 1) * specular
  double f90;     ///< specular

  /// The mapping for a relative index `eta` (either side of the interface gives the same).
  static SpecularDielectric make(double eta, double specular, const glm::dvec3& specular_color);

  /// Position at which the darkest channel becomes 0.
  double lowest_position() const;

  /// Position of an exact reflectance for index `eta`, not below the lowest.
  double position(double exact, double eta) const;

  /// Reflectance at a Fresnel position, from 0 at normal incidence to 1 at grazing.
  glm::dvec3 at_position(double position) const;

  /// Maps an exact reflectance (or an average of such) for index `eta`.
  glm::dvec3 remap(double exact, double eta) const;

  /// Reflectance at `cos_incident` for index `eta` seen from the incident side.
  glm::dvec3 reflectance(double cos_incident, double eta) const;
};

}  // namespace regulus::reference

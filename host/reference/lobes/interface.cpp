// The interface of the base in a Bsdf: microfacet reflection, refraction and thin-walled transmission, and
// their delta events.
#include <algorithm>
#include <cmath>

#include "base/components.hpp"
#include "reference/bsdf.hpp"
#include "reference/lobes/sides.hpp"

namespace regulus::reference {

using glm::dvec3;

namespace {

/// Solid angle of h per solid angle of the refracted wi. Walter 2007, eq. 17.
double refraction_jacobian(const dvec3& wo, const dvec3& wi, const dvec3& h, double eta) {
  const double denominator = eta * dot(wi, h) + dot(wo, h);
  return eta * eta * std::abs(dot(wi, h)) / (denominator * denominator);
}

/// The same from both sides: from the thin one it does not cancel near the critical angle.
double fresnel_of_refraction(const dvec3& wo, const dvec3& wi, const dvec3& h, double eta) {
  return eta < 1 ? fresnel_dielectric(-dot(wi, h), 1 / eta) : fresnel_dielectric(dot(wo, h), eta);
}

}  // namespace

dvec3 reflection_half_vector(const dvec3& wo, const dvec3& wi) {
  // Sum and difference of unit vectors are orthogonal. Where they nearly cancel, the sum is so short that
  // what rounding does to their lengths turns it: wo.h = |sum| / 2 would err by 2^-51 / |sum|^2. Directions
  // in single precision are no unit vectors; they keep the sum that they have.
  constexpr double LARGEST_ROUNDING = 1e-15;
  const dvec3 sum = wo + wi;
  const dvec3 apart = wo - wi;
  const double excess = dot(sum, apart);  // of one squared length over the other
  const double across = dot(apart, apart);
  if (across <= dot(sum, sum) || std::abs(excess) > LARGEST_ROUNDING) return normalize(sum);
  return normalize(sum - apart * (excess / across));
}

dvec3 refraction_half_vector(const dvec3& wo, const dvec3& wi, double eta) {
  const dvec3 sum = wo + eta * wi;
  if (sum == dvec3(0)) return sum;  // no bend at all, and no facet that makes one
  const dvec3 h = normalize(sum);
  return h.z < 0 ? -h : h;
}

dvec3 reflect_at(const dvec3& wo, const dvec3& h) {
  return 2 * dot(wo, h) * h - wo;
}

dvec3 refract_at(const dvec3& wo, const dvec3& h, double eta) {
  const double cos_o = dot(wo, h);
  const double sin2_i = (1 - cos_o * cos_o) / (eta * eta);
  if (sin2_i > 1) return dvec3(0);
  return (cos_o / eta - std::sqrt(1 - sin2_i)) * h - wo / eta;
}

double Bsdf::relative_index(const dvec3& w) const {
  return refracts() && w.z < 0 ? 1 / parameters_.ior : parameters_.ior;
}

dvec3 Bsdf::reflectance(double cos_facet, double eta) const {
  const dvec3 plain = parameters_.metallic * fresnel_metal(parameters_.base_color, cos_facet) +
                      (1 - parameters_.metallic) * dielectric_.reflectance(cos_facet, eta);
  return film_over(plain, thin_cosine(cos_facet, eta), dvec3(1), 1);
}

double Bsdf::dielectric_gain(double camera_z) const {
  if (parameters_.energy == nullptr) return 1;
  const double cosine = std::abs(camera_z);
  return 1 / (refracts() ? parameters_.energy->scattered(energy_index_, cosine, energy_roughness_,
                                                         relative_index({0, 0, camera_z}) < 1)
                         : parameters_.energy->reflected(cosine, energy_roughness_));
}

/// Kulla and Conty 2017: later bounces have the metal's mean colour, Schlick's reflectance averaged.
dvec3 Bsdf::metal_gain(double camera_z) const {
  if (parameters_.energy == nullptr) return dvec3(1);
  const double kept = parameters_.energy->reflected(std::abs(camera_z), energy_roughness_);
  const double mean = parameters_.energy->reflected_mean(energy_roughness_);
  const dvec3 fresnel = (20.0 * parameters_.base_color + 1.0) / 21.0;
  return 1.0 + (1 - kept) / kept * mean * fresnel / (1.0 - (1 - mean) * fresnel);
}

dvec3 Bsdf::compensated_reflectance(double cos_facet, double eta, double camera_z) const {
  const dvec3 plain =
      parameters_.metallic * fresnel_metal(parameters_.base_color, cos_facet) * metal_gain(camera_z) +
      (1 - parameters_.metallic) * dielectric_.reflectance(cos_facet, eta) * dielectric_gain(camera_z);
  return film_over(plain, thin_cosine(cos_facet, eta), metal_gain(camera_z), dielectric_gain(camera_z));
}

dvec3 Bsdf::transmittance(double exact, double thin_cosine, double eta) const {
  dvec3 passed = 1.0 - dielectric_.remap(exact, eta);
  if (parameters_.film_strength > 0)
    passed = glm::mix(passed,
                      dvec3(1 - largest_component(parameters_.film.reflectance(dielectric_.f0, thin_cosine))),
                      parameters_.film_strength);
  return (1 - parameters_.metallic) * parameters_.transmission * parameters_.base_color * passed;
}

double Bsdf::reflection_probability(double cos_facet, double eta) const {
  return reflection_probability(cos_facet, fresnel_dielectric(cos_facet, eta), eta);
}

double Bsdf::reflection_probability(double cos_facet, double exact, double eta) const {
  double reflected = luminance(parameters_.metallic * fresnel_metal(parameters_.base_color, cos_facet) +
                               (1 - parameters_.metallic) * dielectric_.remap(exact, eta));
  const dvec3 clear = (1 - parameters_.metallic) * parameters_.transmission * parameters_.base_color;
  double transmitted = luminance(clear * (1.0 - dielectric_.remap(exact, eta)));
  if (parameters_.film_strength > 0) {
    const double position = std::max(dielectric_.position(exact, eta), std::pow(1 - cos_facet, 5));
    reflected = chosen_reflection(cos_facet, position);
    transmitted = chosen_base(clear, position);
  }
  return reflected > 0 ? reflected / (reflected + transmitted) : 0;
}

/// D G2 / (4 cos_i cos_o), both directions above the surface.
dvec3 Bsdf::mirror_lobe_value(const dvec3& wo, const dvec3& wi) const {
  const dvec3 h = reflection_half_vector(wo, wi);
  return dvec3(base_scale_ * distribution(surface_, h) *
               masking_shadowing(surface_, wi, wo, h, Scattering::Reflection) / (4 * wi.z * wo.z));
}

dvec3 Bsdf::refraction_value(const dvec3& wo, const dvec3& wi, double eta, TransportMode mode) const {
  const dvec3 h = refraction_half_vector(wo, wi, eta);
  if (dot(wo, h) <= 0 || dot(wi, h) >= 0) return dvec3(0);
  const double d_g = base_scale_ * distribution(surface_, h) *
                     masking_shadowing(surface_, wi, wo, h, Scattering::Transmission);
  const double importance =
      d_g * dot(wo, h) * refraction_jacobian(wo, wi, h, eta) / (std::abs(wi.z) * std::abs(wo.z));
  const double thin = eta < 1 ? -dot(wi, h) : dot(wo, h);
  return transmittance(fresnel_of_refraction(wo, wi, h, eta), thin, eta) *
         (mode == TransportMode::Radiance ? importance / (eta * eta) : importance);
}

double Bsdf::refraction_pdf(const dvec3& wo, const dvec3& wi, double eta) const {
  const dvec3 h = refraction_half_vector(wo, wi, eta);
  if (dot(wo, h) <= 0 || dot(wi, h) >= 0) return 0;
  return visible_normal_pdf(surface_, wo, h) * refraction_jacobian(wo, wi, h, eta) *
         (1 - reflection_probability(dot(wo, h), fresnel_of_refraction(wo, wi, h, eta), eta));
}

BsdfSample Bsdf::sample_delta(const dvec3& wo, double eta, double p_diffuse, bool reflects,
                              TransportMode mode) const {
  const double p_reflection = reflection_probability(wo.z, eta);
  BsdfSample result;
  result.is_delta = true;
  result.is_transmitted = !reflects;
  result.pdf_forward = (1 - p_diffuse) * (reflects ? p_reflection : 1 - p_reflection);
  const dvec3 normal(0, 0, 1);
  if (reflects) {
    result.wi = reflect_at(wo, normal);
    result.weight = reflectance(wo.z, eta) / result.pdf_forward;
  } else {
    result.wi = parameters_.is_volume ? refract_at(wo, normal, eta) : -wo;
    const double scale = parameters_.is_volume && mode == TransportMode::Radiance ? 1 / (eta * eta) : 1;
    result.weight = transmittance(fresnel_dielectric(wo.z, eta), thin_cosine(wo.z, eta), eta) * scale /
                    result.pdf_forward;
  }
  result.is_valid = result.pdf_forward > 0;
  return result;
}

}  // namespace regulus::reference

// The mixture of a material's lobes: value, pdf and samples. What each lobe is stands in reference/lobes.
#include "reference/bsdf.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/lobes/sides.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

double luminance(const dvec3& color) {
  return dot(color, dvec3(0.2126, 0.7152, 0.0722));
}

Bsdf::Bsdf(const BsdfParameters& parameters)
    : parameters_(parameters),
      surface_{parameters.ndf, parameters.shadowing, parameters.alpha},
      coat_{parameters.ndf, parameters.shadowing, parameters.coat_alpha},
      dielectric_(SpecularDielectric::make(parameters.ior, parameters.specular, parameters.specular_color)) {
  own_alpha_ = parameters.alpha;
  energy_roughness_ = std::sqrt(std::sqrt(parameters.alpha.x * parameters.alpha.y));
  diffuse_albedo_ = (1 - parameters.metallic) * (1 - parameters.transmission) * parameters.base_color;
  for (const EnergyTables* tables : {parameters.energy, parameters.cover, parameters.raised_light})
    if (tables != nullptr) energy_index_ = tables->nearest(std::max(parameters.ior, 1 / parameters.ior));
  if (parameters.cover != nullptr && diffuse_albedo_ != dvec3(0))
    cover_share_ = {cover_share(energy_roughness_), energy_roughness_ > 0 ? 1.0 : 0.0};
  parameters_.fresnel_average =
      parameters.fresnel_average ? *parameters.fresnel_average : fresnel_dielectric_average(parameters.ior);
  for (const bool is_back : {false, true})
    diffuse_scale_[is_back] = diffuse_albedo_ / (pi * mean_transmittance(is_back && refracts()));
}

Bsdf Bsdf::with_alpha(const dvec2& alpha) const {
  Bsdf other = *this;
  other.parameters_.alpha = other.surface_.alpha = alpha;
  return other;
}

Bsdf Bsdf::with_coat_alpha(const dvec2& alpha) const {
  Bsdf other = *this;
  other.parameters_.coat_alpha = other.coat_.alpha = alpha;
  return other;
}

Bsdf Bsdf::with_scaled_lobes(double base, double coat) const {
  Bsdf other = *this;
  other.base_scale_ *= base;
  other.coat_scale_ *= coat;
  return other;
}

Bsdf Bsdf::with_coat_normal(const dvec3& normal) const {
  Bsdf other = *this;
  other.parameters_.coat_normal = normal;
  return other;
}

Bsdf Bsdf::in_relief_shadow() const {
  Bsdf other = *this;
  other.is_in_relief_shadow_ = true;
  return other;
}

Bsdf Bsdf::with_guide(double share, double density) const {
  Bsdf other = *this;
  other.guide_share_ = share;
  other.guide_density_ = density;
  return other;
}

Bsdf Bsdf::with_unit_density() const {
  Bsdf other = *this;
  other.surface_.has_unit_density = other.coat_.has_unit_density = true;
  return other;
}

dvec3 Bsdf::value(const dvec3& wo, const dvec3& wi, TransportMode mode) const {
  dvec3 value = base_value(wo, wi, mode);
  if (parameters_.clearcoat == 0) return value;
  value *= (1 - coat_reflectance(wo)) * (1 - coat_reflectance(wi));
  return value + coat_value(wo, wi, mode);
}

dvec3 Bsdf::base_value(const dvec3& wo, const dvec3& wi, TransportMode mode) const {
  const dvec3 below = interface_value(wo, wi, mode);
  return parameters_.sheen == nullptr ? below : sheen_passage(wo, wi) * below + sheen_value(wo, wi);
}

dvec3 Bsdf::interface_value(const dvec3& wo_material, const dvec3& wi_material, TransportMode mode) const {
  const double eta = relative_index(wo_material);
  const dvec3 wo = wo_material.z < 0 ? mirror_z(wo_material) : wo_material;
  const dvec3 wi = wo_material.z < 0 ? mirror_z(wi_material) : wi_material;
  if (wo.z == 0 || wi.z == 0) return dvec3(0);
  const double camera_z = mode == TransportMode::Importance ? wi_material.z : wo_material.z;
  if (wi.z > 0) {
    const dvec3 diffuse = diffuse_value(wo, wi, eta);
    if (is_delta()) return diffuse;
    return diffuse + compensated_reflectance(dot(wo, reflection_half_vector(wo, wi)), eta, camera_z) *
                         mirror_lobe_value(wo, wi);
  }
  if (is_delta() || parameters_.transmission == 0) return dvec3(0);
  if (parameters_.is_volume) return dielectric_gain(camera_z) * refraction_value(wo, wi, eta, mode);
  const dvec3 wi_mirrored = mirror_z(wi);
  const double cosine = dot(wo, reflection_half_vector(wo, wi_mirrored));
  return dielectric_gain(camera_z) *
         transmittance(fresnel_dielectric(cosine, eta), thin_cosine(cosine, eta), eta) *
         mirror_lobe_value(wo, wi_mirrored);
}

Bsdf::Shares Bsdf::shares(const dvec3& w) const {
  const double cosine = std::abs(w.z);
  const dvec3 reflected = base_reflectance(cosine, relative_index(w));
  const dvec3 clear = (1 - parameters_.metallic) * parameters_.transmission * parameters_.base_color;
  if (parameters_.film_strength > 0) {
    const double eta = relative_index(w), share = cover_share_[eta < 1];
    double position = dielectric_.position(fresnel_dielectric(cosine, eta), eta);
    if (share > 0)
      position = std::lerp(position, std::max(cover(cosine, eta).y, dielectric_.lowest_position()), share);
    position = std::max(position, std::pow(1 - cosine, 5));
    return {chosen_base(diffuse_albedo_, position),
            chosen_reflection(cosine, position) + chosen_base(clear, position)};
  }
  return {luminance(diffuse_albedo_ * (1.0 - reflected)),
          luminance(parameters_.metallic * fresnel_metal(parameters_.base_color, cosine) +
                    (1 - parameters_.metallic) * reflected) +
              luminance(clear * (1.0 - reflected))};
}

double Bsdf::diffuse_probability(const dvec3& wo) const {
  const auto [sheen, diffuse, facets] = layers(wo);
  return facets == 0 ? 1 : (sheen + diffuse) / (sheen + diffuse + facets);
}

double Bsdf::pdf(const dvec3& wo, const dvec3& wi) const {
  const double p_coat = coat_probability(wo);
  const double pdf = (1 - p_coat) * base_pdf(wo, wi);
  return p_coat == 0 ? pdf : pdf + p_coat * coat_pdf(wo, wi);
}

double Bsdf::base_pdf(const dvec3& wo_material, const dvec3& wi_material) const {
  const double eta = relative_index(wo_material);
  const dvec3 wo = wo_material.z < 0 ? mirror_z(wo_material) : wo_material;
  const dvec3 wi = wo_material.z < 0 ? mirror_z(wi_material) : wi_material;
  if (wo.z == 0 || wi.z == 0) return 0;
  const double p_diffuse = diffuse_probability(wo_material);
  double cosine = 0;
  if (wi.z > 0 && !is_in_relief_shadow_)
    cosine =
        p_diffuse * std::lerp(diffuse_pdf(wi.z, eta, sheen_share(wo_material)), guide_density_, guide_share_);
  if (is_delta()) return cosine;
  if (wi.z < 0 && parameters_.transmission == 0) return 0;
  if (wi.z < 0 && parameters_.is_volume) return (1 - p_diffuse) * refraction_pdf(wo, wi, eta);
  const dvec3 h = reflection_half_vector(wo, wi.z > 0 ? wi : mirror_z(wi));
  const double p_reflection = reflection_probability(dot(wo, h), eta);
  const double facet = visible_normal_pdf(surface_, wo, h) / (4 * dot(wo, h));
  return cosine + (1 - p_diffuse) * facet * (wi.z > 0 ? p_reflection : 1 - p_reflection);
}

BsdfSample Bsdf::sample(const dvec3& wo, double u_lobe, const dvec2& u, TransportMode mode) const {
  if (wo.z == 0) return {};
  if (parameters_.clearcoat == 0) return sample_base(wo, u_lobe, u, mode);
  const double p_coat = coat_probability(wo);
  const bool is_coat = u_lobe < p_coat;
  BsdfSample result = is_coat ? sample_coat(wo, u_lobe / p_coat, u)
                              : sample_base(wo, (u_lobe - p_coat) / (1 - p_coat), u, mode);
  if (!result.is_valid) return {};
  if (result.is_delta) return coated_delta(wo, result, mode);
  result.pdf_forward = pdf(wo, result.wi);
  result.pdf_reverse = pdf(result.wi, wo);
  if (!(result.pdf_forward > 0)) return {};
  result.weight = value(wo, result.wi, mode) * std::abs(result.wi.z) / result.pdf_forward;
  return result;
}

BsdfSample Bsdf::sample_facets(const dvec3& wo, double u_choice, const dvec2& u, TransportMode mode) const {
  const double p_facets = 1 - diffuse_probability(wo);
  if (!(p_facets > 0)) return {};
  BsdfSample result = sample_base(wo, 1 - p_facets + u_choice * p_facets, u, mode);
  if (!result.is_valid) return {};
  if (result.is_delta) {
    result.pdf_forward /= p_facets;
    result.weight *= p_facets;
  } else {
    const Bsdf smooth = with_alpha(dvec2(0));
    result.pdf_forward = (base_pdf(wo, result.wi) - smooth.base_pdf(wo, result.wi)) / p_facets;
    result.weight = (base_value(wo, result.wi, mode) - smooth.base_value(wo, result.wi, mode)) *
                    std::abs(result.wi.z) / result.pdf_forward;
  }
  result.weight *= (1 - coat_reflectance(wo)) * (1 - coat_reflectance(result.wi));
  return result;
}

BsdfSample Bsdf::sample_base(const dvec3& wo_material, double u_lobe, const dvec2& u,
                             TransportMode mode) const {
  if (wo_material.z == 0) return {};
  const double eta = relative_index(wo_material);
  const dvec3 wo = wo_material.z < 0 ? mirror_z(wo_material) : wo_material;
  const double p_diffuse = diffuse_probability(wo_material);
  BsdfSample result;
  if (u_lobe < p_diffuse) {
    result.wi = sample_diffuse(u, eta, sheen_share(wo_material));
    result.is_diffuse = true;
  } else {
    double u_choice = (u_lobe - p_diffuse) / (1 - p_diffuse);
    const dvec3 h = is_delta() ? dvec3(0, 0, 1) : sample_visible_normal(surface_, wo, u, u_choice);
    const double cos_facet = dot(wo, h);
    const bool reflects = u_choice < reflection_probability(cos_facet, eta);
    if (is_delta()) {
      result = sample_delta(wo, eta, p_diffuse, reflects, mode);
    } else {
      result.is_transmitted = !reflects;
      result.wi = !reflects && parameters_.is_volume ? refract_at(wo, h, eta) : reflect_at(wo, h);
      if (!reflects && !parameters_.is_volume) result.wi = mirror_z(result.wi);
    }
    result.is_refracted = result.is_transmitted && parameters_.is_volume;
    result.alpha = parameters_.alpha;
  }
  if (result.is_transmitted ? result.wi.z >= 0 : result.wi.z <= 0) return {};
  if (wo_material.z < 0) result.wi = mirror_z(result.wi);
  if (result.is_delta) {
    const double p_back = reflection_probability(std::abs(result.wi.z), relative_index(result.wi));
    result.pdf_reverse = (1 - diffuse_probability(result.wi)) * (result.is_transmitted ? 1 - p_back : p_back);
    result.weight *= sheen_passage(wo_material, result.wi);
    return result;
  }
  result.pdf_forward = base_pdf(wo_material, result.wi);
  result.pdf_reverse = base_pdf(result.wi, wo_material);
  result.is_valid = result.pdf_forward > 0;
  if (!result.is_valid) return {};
  result.weight = base_value(wo_material, result.wi, mode) * std::abs(result.wi.z) / result.pdf_forward;
  return result;
}

}  // namespace regulus::reference

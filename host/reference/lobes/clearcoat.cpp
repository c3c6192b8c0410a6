// The clearcoat in a Bsdf (KHR_materials_clearcoat).
#include <algorithm>
#include <cmath>

#include "reference/bsdf.hpp"
#include "reference/lobes/sides.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;

/// In the frame with z up on that side of the surface.
Basis Bsdf::coat_basis(bool is_back) const {
  const dvec3 normal = parameters_.coat_normal.value_or(dvec3(0, 0, 1));
  return Basis(is_back ? mirror_z(-normal) : normal);
}

dvec3 Bsdf::to_coat(const dvec3& w, bool is_back) const {
  const dvec3 up = is_back ? mirror_z(w) : w;
  return parameters_.coat_normal ? coat_basis(is_back).to_local(up) : up;
}

dvec3 Bsdf::from_coat(const dvec3& w, bool is_back) const {
  const dvec3 up = parameters_.coat_normal ? coat_basis(is_back).to_world(w) : w;
  return is_back ? mirror_z(up) : up;
}

double Bsdf::coat_reflectance(const dvec3& w) const {
  const double cosine = std::abs(to_coat(w, w.z < 0).z);
  return coat_towards(w) * (0.04 + 0.96 * std::pow(std::max(1 - cosine, 0.0), 5));
}

/// D G2 / (4 cos_i cos_o) with the coat's normal, over the base's cosines, times F_c.
double Bsdf::coat_value(const dvec3& wo, const dvec3& wi, TransportMode mode) const {
  if (is_coat_delta() || wo.z * wi.z <= 0) return 0;
  const dvec3 up_o = to_coat(wo, wo.z < 0);
  const dvec3 up_i = to_coat(wi, wo.z < 0);
  if (up_o.z <= 0 || up_i.z <= 0) return 0;
  const dvec3 h = reflection_half_vector(up_o, up_i);
  const double fresnel = coat_towards(wo) * (0.04 + 0.96 * std::pow(std::max(1 - dot(up_o, h), 0.0), 5));
  // What falls on the coat, over what falls on the base.
  const double falls = mode == TransportMode::Radiance ? up_i.z / std::abs(wi.z) : up_o.z / std::abs(wo.z);
  return coat_scale_ * falls * fresnel * distribution(coat_, h) *
         masking_shadowing(coat_, up_i, up_o, h, Scattering::Reflection) / (4 * up_i.z * up_o.z);
}

double Bsdf::coat_pdf(const dvec3& wo, const dvec3& wi) const {
  if (is_coat_delta() || wo.z * wi.z <= 0) return 0;
  const dvec3 up_o = to_coat(wo, wo.z < 0);
  const dvec3 up_i = to_coat(wi, wo.z < 0);
  if (up_i.z <= 0) return 0;
  const dvec3 h = reflection_half_vector(up_o, up_i);
  return visible_normal_pdf(coat_, up_o, h) / (4 * dot(up_o, h));
}

double Bsdf::coat_probability(const dvec3& wo) const {
  const double coat = coat_reflectance(wo);
  if (coat == 0 || to_coat(wo, wo.z < 0).z <= 0) return 0;
  const auto [diffuse, facets] = shares(wo);
  return coat / (coat + (1 - coat) * (diffuse + facets));
}

BsdfSample Bsdf::sample_coat(const dvec3& wo, double u_choice, const dvec2& u) const {
  const dvec3 up = to_coat(wo, wo.z < 0);
  const dvec3 h = is_coat_delta() ? dvec3(0, 0, 1) : sample_visible_normal(coat_, up, u, u_choice);
  const dvec3 wi = reflect_at(up, h);
  BsdfSample result;
  result.wi = from_coat(wi, wo.z < 0);
  result.is_coat = true;
  result.is_delta = is_coat_delta();
  result.alpha = parameters_.coat_alpha;
  result.is_valid = wi.z > 0 && result.wi.z * wo.z > 0;
  return result;
}

/// A delta event of coat or base, whichever was chosen: both reflect to the same side if both are deltas and
/// have the same normal.
BsdfSample Bsdf::coated_delta(const dvec3& wo, BsdfSample sample, TransportMode mode) const {
  const dvec3& wi = sample.wi;
  const double p_coat = coat_probability(wo);
  const double p_coat_back = coat_probability(wi);
  dvec3 factor(0);
  sample.pdf_forward = sample.pdf_reverse = 0;
  const bool is_alone = parameters_.coat_normal.has_value();
  if (is_delta() && !(is_alone && sample.is_coat)) {
    const double eta = relative_index(wo);
    const double p_specular = 1 - diffuse_probability(wo);
    const double p_reflection = reflection_probability(std::abs(wo.z), eta);
    const double p_reflection_back = reflection_probability(std::abs(wi.z), relative_index(wi));
    sample.pdf_forward =
        (1 - p_coat) * p_specular * (sample.is_transmitted ? 1 - p_reflection : p_reflection);
    sample.pdf_reverse = (1 - p_coat_back) * (1 - diffuse_probability(wi)) *
                         (sample.is_transmitted ? 1 - p_reflection_back : p_reflection_back);
    const double scale = sample.is_transmitted && parameters_.is_volume && mode == TransportMode::Radiance
                             ? 1 / (eta * eta)
                             : 1;
    const double cosine = std::abs(wo.z);
    factor = (sample.is_transmitted
                  ? transmittance(fresnel_dielectric(cosine, eta), thin_cosine(cosine, eta), eta) * scale
                  : reflectance(cosine, eta)) *
             sheen_passage(wo, wi) * ((1 - coat_reflectance(wo)) * (1 - coat_reflectance(wi)));
  }
  if (is_coat_delta() && !sample.is_transmitted && (sample.is_coat || !is_alone)) {
    // Radiance is reflected whatever the angle to the base: importance by |cos_i| / |cos_o| of that.
    factor += coat_reflectance(wo) * (mode == TransportMode::Radiance ? 1 : std::abs(wi.z / wo.z));
    sample.pdf_forward += p_coat;
    sample.pdf_reverse += p_coat_back;
  }
  sample.weight = factor / sample.pdf_forward;
  return sample;
}

BsdfSample Bsdf::sample_coat_facets(const dvec3& wo, double u_choice, const dvec2& u,
                                    TransportMode mode) const {
  const dvec3 up_o = to_coat(wo, wo.z < 0);
  if (!(coat_towards(wo) > 0 && up_o.z > 0)) return {};
  BsdfSample result = sample_coat(wo, u_choice, u);
  if (!result.is_valid) return {};
  if (result.is_delta) {
    result.pdf_forward = 1;
    result.weight =
        dvec3(coat_reflectance(wo) * (mode == TransportMode::Radiance ? 1 : std::abs(result.wi.z / wo.z)));
    return result;
  }
  const dvec3 h = reflection_half_vector(up_o, to_coat(result.wi, wo.z < 0));
  result.pdf_forward = visible_normal_pdf(coat_, up_o, h) / (4 * dot(up_o, h));
  const dvec3 coat = value(wo, result.wi, mode) - with_coat_alpha(dvec2(0)).value(wo, result.wi, mode);
  result.weight = coat * std::abs(result.wi.z) / result.pdf_forward;
  return result;
}

}  // namespace regulus::reference

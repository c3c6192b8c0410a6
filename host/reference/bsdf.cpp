#include "reference/bsdf.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/components.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

namespace {

dvec3 mirror_z(const dvec3& w) {
  return {w.x, w.y, -w.z};
}

/// Solid angle of h per solid angle of the refracted wi. Walter 2007, eq. 17.
double refraction_jacobian(const dvec3& wo, const dvec3& wi, const dvec3& h, double eta) {
  const double denominator = eta * dot(wi, h) + dot(wo, h);
  return eta * eta * std::abs(dot(wi, h)) / (denominator * denominator);
}

/// The same from both sides: from the thin one it does not cancel near the critical angle.
double fresnel_of_refraction(const dvec3& wo, const dvec3& wi, const dvec3& h, double eta) {
  return eta < 1 ? fresnel_dielectric(-dot(wi, h), 1 / eta) : fresnel_dielectric(dot(wo, h), eta);
}

/// The cosine on the thin side of an interface; 0 where a direction on the dense one is reflected totally.
double thin_cosine(double cosine, double eta) {
  return eta < 1 ? std::sqrt(std::max(1 - (1 - cosine * cosine) / (eta * eta), 0.0)) : cosine;
}

}  // namespace

double luminance(const dvec3& color) {
  return dot(color, dvec3(0.2126, 0.7152, 0.0722));
}

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

double Bsdf::relative_index(const dvec3& w) const {
  return refracts() && w.z < 0 ? 1 / parameters_.ior : parameters_.ior;
}

dvec3 Bsdf::reflectance(double cos_facet, double eta) const {
  const dvec3 plain = parameters_.metallic * fresnel_metal(parameters_.base_color, cos_facet) +
                      (1 - parameters_.metallic) * dielectric_.reflectance(cos_facet, eta);
  return film_over(plain, thin_cosine(cos_facet, eta), dvec3(1), 1);
}

dvec3 Bsdf::film_over(const dvec3& plain, double thin_cosine, const dvec3& metal_gain,
                      double dielectric_gain) const {
  if (parameters_.film_strength == 0) return plain;
  const ThinFilm& film = parameters_.film;
  const dvec3 covered =
      parameters_.metallic * metal_gain * film.reflectance(parameters_.base_color, thin_cosine) +
      (1 - parameters_.metallic) * dielectric_gain * film.reflectance(dielectric_.f0, thin_cosine);
  return glm::mix(plain, covered, parameters_.film_strength);
}

double Bsdf::chosen_reflection(double cosine, double position) const {
  const BsdfParameters& p = parameters_;
  const double schlick = std::pow(1 - cosine, 5);
  const dvec3 of_metal = p.film.mean_reflectance(p.base_color, 1);
  const dvec3 of_dielectric = p.film.mean_reflectance(dielectric_.f0, 1);
  const dvec3 metal =
      glm::mix(fresnel_metal(p.base_color, cosine), glm::mix(of_metal, dvec3(1), schlick), p.film_strength);
  const dvec3 dielectric = glm::mix(dielectric_.at_position(position),
                                    glm::mix(of_dielectric, dvec3(1), position), p.film_strength);
  return luminance(p.metallic * metal + (1 - p.metallic) * dielectric);
}

double Bsdf::chosen_base(const dvec3& color, double position) const {
  const double covered =
      (1 - largest_component(parameters_.film.mean_reflectance(dielectric_.f0, 1))) * (1 - position);
  return luminance(
      color * glm::mix(1.0 - dielectric_.at_position(position), dvec3(covered), parameters_.film_strength));
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

dvec3 Bsdf::value(const dvec3& wo, const dvec3& wi, TransportMode mode) const {
  dvec3 value = base_value(wo, wi, mode);
  if (parameters_.clearcoat == 0) return value;
  value *= (1 - coat_reflectance(wo)) * (1 - coat_reflectance(wi));
  if (is_coat_delta() || wo.z * wi.z <= 0) return value;
  const dvec3 up_o = to_coat(wo, wo.z < 0);
  const dvec3 up_i = to_coat(wi, wo.z < 0);
  if (up_o.z <= 0 || up_i.z <= 0) return value;
  const dvec3 h = reflection_half_vector(up_o, up_i);
  const double fresnel = coat_towards(wo) * (0.04 + 0.96 * std::pow(std::max(1 - dot(up_o, h), 0.0), 5));
  // What falls on the coat, over what falls on the base.
  const double falls = mode == TransportMode::Radiance ? up_i.z / std::abs(wi.z) : up_o.z / std::abs(wo.z);
  return value + coat_scale_ * falls * fresnel * distribution(coat_, h) *
                     masking_shadowing(coat_, up_i, up_o, h, Scattering::Reflection) / (4 * up_i.z * up_o.z);
}

double Bsdf::largest_sheen(const dvec3& w) const {
  if (parameters_.sheen == nullptr || (refracts() && w.z < 0)) return 0;
  const dvec3& color = parameters_.sheen_color;
  return std::max({color.r, color.g, color.b});
}

double Bsdf::sheen_albedo(const dvec3& w) const {
  return std::min(parameters_.sheen->albedo(std::abs(w.z), parameters_.sheen_roughness), 1.0);
}

double Bsdf::sheen_passage(const dvec3& wo, const dvec3& wi) const {
  if (parameters_.sheen == nullptr) return 1;
  return 1 - std::max(largest_sheen(wo) * sheen_albedo(wo), largest_sheen(wi) * sheen_albedo(wi));
}

/// Where white sheen would reflect more than there is it is scaled down, by the larger of both directions.
dvec3 Bsdf::sheen_value(const dvec3& wo, const dvec3& wi) const {
  if (largest_sheen(wo) == 0 || wo.z * wi.z <= 0 || is_in_relief_shadow_) return dvec3(0);
  const double alpha = parameters_.sheen_roughness * parameters_.sheen_roughness;
  const double most = std::max(parameters_.sheen->albedo(std::abs(wo.z), parameters_.sheen_roughness),
                               parameters_.sheen->albedo(std::abs(wi.z), parameters_.sheen_roughness));
  const double cos_h = std::min(std::abs(reflection_half_vector(wo, wi).z), 1.0);
  return parameters_.sheen_color *
         (sheen_scattering(cos_h, std::abs(wo.z), std::abs(wi.z), alpha) / std::max(most, 1.0));
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

Bsdf::Layers Bsdf::layers(const dvec3& w) const {
  const auto [diffuse, facets] = shares(w);
  if (largest_sheen(w) == 0) return {0, diffuse, facets};
  const double passed = 1 - largest_sheen(w) * sheen_albedo(w);
  return {luminance(parameters_.sheen_color) * sheen_albedo(w), passed * diffuse, passed * facets};
}

double Bsdf::diffuse_probability(const dvec3& wo) const {
  const auto [sheen, diffuse, facets] = layers(wo);
  return facets == 0 ? 1 : (sheen + diffuse) / (sheen + diffuse + facets);
}

/// Of the diffuse lobe's samples.
double Bsdf::sheen_share(const dvec3& w) const {
  const auto [sheen, diffuse, facets] = layers(w);
  return sheen > 0 ? sheen / (sheen + diffuse) : 0;
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

double Bsdf::coat_probability(const dvec3& wo) const {
  const double coat = coat_reflectance(wo);
  if (coat == 0 || to_coat(wo, wo.z < 0).z <= 0) return 0;
  const auto [diffuse, facets] = shares(wo);
  return coat / (coat + (1 - coat) * (diffuse + facets));
}

double Bsdf::pdf(const dvec3& wo, const dvec3& wi) const {
  const double p_coat = coat_probability(wo);
  const double pdf = (1 - p_coat) * base_pdf(wo, wi);
  if (p_coat == 0 || is_coat_delta() || wo.z * wi.z <= 0) return pdf;
  const dvec3 up_o = to_coat(wo, wo.z < 0);
  const dvec3 up_i = to_coat(wi, wo.z < 0);
  if (up_i.z <= 0) return pdf;
  const dvec3 h = reflection_half_vector(up_o, up_i);
  return pdf + p_coat * visible_normal_pdf(coat_, up_o, h) / (4 * dot(up_o, h));
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

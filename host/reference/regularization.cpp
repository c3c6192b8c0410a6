#include "reference/regularization.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;
using namespace interface;

namespace {

constexpr double SHARP_ALPHA = 0.05;  // a surface with a smaller alpha and no diffuse lobe does not diffuse
constexpr double MIN_REGULARIZED_BEND =
    0.02;  // between the indices: with less, no roughness blurs (docs/mathematics.md 2.5)
constexpr double MIN_FACET_COSINE = 1e-4;  // docs/mathematics.md 2.4
constexpr double DELTA_STAND_IN = 1e-6;    // alpha that stands for the limit 0: masking is off by its square

/// x > 0 with f(x) = 0, for f that increases from below 0.
template <typename Function>
double root_of(const Function& f) {
  double low = 0;
  double high = 1;
  while (f(high) < 0) high *= 2;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The alpha at which the lobe's peak for this facet cosine is tau (docs/mathematics.md 2.2;
/// directional: 2.4).
double reflection_alpha(const Regularization& regularization, uint32_t ndf, uint32_t shadowing, double c) {
  const double tau = regularization.tau;
  const bool is_v_cavity = shadowing == SHADOWING_V_CAVITY;
  if (regularization.bound == BOUND_PEAK || (regularization.bound == BOUND_SMITH && is_v_cavity))
    return 1 / std::sqrt(4 * pi * tau);
  if (regularization.bound == BOUND_SMITH)
    return ndf == NDF_GGX ? std::pow(1 / (pi * tau), 0.25) : std::pow(tau, -0.25);
  c = std::max(c, MIN_FACET_COSINE);
  // Peaks, times tau^-1:  1 / (4 pi a^2 c^2),  1 / (4 pi a^2 c sqrt(c^2 + a^2 (1 - c^2))),
  // 1 / (pi a^2 (c + sqrt(c^2 (1 - a^2) + a^2))^2).
  if (is_v_cavity) return 1 / (c * std::sqrt(4 * pi * tau));
  if (shadowing == SHADOWING_SMITH)
    return root_of(
        [=](double a) { return 4 * pi * a * a * c * std::sqrt(c * c + a * a * (1 - c * c)) - 1 / tau; });
  return root_of([=](double a) {
    const double sum = c + std::sqrt(c * c * (1 - a * a) + a * a);
    return pi * a * a * sum * sum - 1 / tau;
  });
}

/// The same of a refraction lobe with relative index eta.
double refraction_alpha(const Regularization& regularization, uint32_t ndf, uint32_t shadowing, double eta) {
  const double larger = std::max(eta, 1.0);
  const double bend = std::abs(eta - 1) / larger;
  if (bend < MIN_REGULARIZED_BEND) return 0;
  const double e = 1 / (bend * bend);
  const double tau = regularization.tau;
  if (regularization.bound == BOUND_SMITH && shadowing != SHADOWING_V_CAVITY)
    return std::pow(4 * e / (ndf == NDF_GGX ? pi * tau : tau), 0.25);
  return std::sqrt(e / (pi * tau));
}

/// Beyond 1 / sqrt(2) Beckmann's maximum leaves the normal (docs/mathematics.md 2.3).
double largest_alpha(uint32_t ndf) {
  return ndf == NDF_BECKMANN ? std::sqrt(0.5) : 1.0;
}

/// The perceptual roughness by which tables are looked up.
double roughness_of(const dvec2& alpha) {
  return std::sqrt(std::sqrt(alpha.x * alpha.y));
}

bool is_refraction(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi) {
  return bsdf.parameters().is_volume && wo.z * wi.z < 0;
}

/// The facet normal of the pair, in the frame where wo is above.
dvec3 facet_normal(const Bsdf& bsdf, dvec3 wo, dvec3 wi) {
  const double eta = bsdf.relative_index(wo);
  const bool is_refracted = is_refraction(bsdf, wo, wi);
  if (wo.z < 0) {
    wo.z = -wo.z;
    wi.z = -wi.z;
  }
  if (is_refracted) return refraction_half_vector(wo, wi, eta);
  return reflection_half_vector(wo, {wi.x, wi.y, std::abs(wi.z)});
}

double luminance_of(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi) {
  return luminance(bsdf.value(wo, wi, TransportMode::Radiance));
}

/// The material without its microfacet lobes: value and pdf are those of the diffuse lobe under the coat.
Bsdf without_facets(const Bsdf& bsdf) {
  return bsdf.with_alpha(dvec2(0)).with_coat_alpha(dvec2(0));
}

/// Luminance of rho^W: the lobe's density D^(h) moves towards its peak D^(n) by beta = 1 - (alpha /
/// alpha^)^2.
double value_in_weights(const Bsdf& bsdf, const Bsdf& wide, const dvec3& wo, const dvec3& wi,
                        const Regularization& regularization) {
  const double diffuse = luminance_of(without_facets(bsdf), wo, wi);
  const auto of_lobe = [&](const Bsdf& alone, const Microsurface& raised, const dvec2& alpha,
                           const dvec3& h) {
    if (raised.alpha == dvec2(0)) return 0.0;
    const double per_density = luminance_of(alone.with_unit_density(), wo, wi) - diffuse;
    if (per_density == 0) return 0.0;
    const double beta =
        regularization.mis == MIS_BLENDED ? 1 - (alpha.x * alpha.y) / (raised.alpha.x * raised.alpha.y) : 0;
    const double here = distribution(raised, h);
    const double peak = distribution(raised, {0, 0, 1});
    return per_density * std::pow(here, 1 - beta) * std::pow(peak, beta);
  };
  const BsdfParameters& p = bsdf.parameters();
  const double base =
      of_lobe(wide.with_coat_alpha(dvec2(0)), wide.microsurface(), p.alpha, facet_normal(bsdf, wo, wi));
  if (p.clearcoat == 0 || wo.z * wi.z < 0) return diffuse + base;
  const dvec3 h = reflection_half_vector(bsdf.to_coat(wo, wo.z < 0), bsdf.to_coat(wi, wo.z < 0));
  return diffuse + base + of_lobe(wide.with_alpha(dvec2(0)), wide.coat_microsurface(), p.coat_alpha, h);
}

/// The alpha of the clearcoat's lobe, which has a bound of its own.
dvec2 raised_coat_alpha(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi,
                        const Regularization& regularization) {
  const BsdfParameters& p = bsdf.parameters();
  const double c = std::abs(dot(dvec3(wo.x, wo.y, std::abs(wo.z)), facet_normal(bsdf, wo, wi)));
  const double alpha = reflection_alpha(regularization, p.ndf, p.shadowing, c) * regularization.alpha_scale;
  return glm::max(p.coat_alpha, dvec2(std::min(alpha, largest_alpha(p.ndf))));
}

/// What a lobe keeps of its light in the direction of the camera where `alpha` is raised to `raised`: the
/// ratio of the energies by single scattering, of a reflection those of a perfect reflector.
double reflection_kept(const Bsdf& bsdf, const dvec2& alpha, const dvec2& raised, double camera_cosine) {
  const EnergyTables* tables = bsdf.parameters().raised_light;
  if (tables == nullptr || alpha == raised) return 1;
  return tables->reflected(camera_cosine, roughness_of(alpha)) /
         tables->reflected(camera_cosine, roughness_of(raised));
}

double refraction_kept(const Bsdf& bsdf, const dvec2& alpha, const dvec2& raised, const dvec3& w_camera) {
  const EnergyTables* tables = bsdf.parameters().raised_light;
  if (tables == nullptr || alpha == raised) return 1;
  const bool is_inside = bsdf.relative_index(w_camera) < 1;
  const auto refracted = [&](const dvec2& a) {
    return tables->refracted(bsdf.energy_index(), std::abs(w_camera.z), roughness_of(a), is_inside);
  };
  const double left = refracted(raised);
  return left > 0 ? refracted(alpha) / left : 0;
}

/// The bsdf with its base's lobe raised, wo towards the camera.
Bsdf with_raised_base(const Bsdf& bsdf, const dvec2& alpha, const dvec3& wo, const dvec3& wi) {
  const dvec2& own = bsdf.parameters().alpha;
  const double kept = is_refraction(bsdf, wo, wi) ? refraction_kept(bsdf, own, alpha, wo)
                                                  : reflection_kept(bsdf, own, alpha, std::abs(wo.z));
  return bsdf.with_alpha(alpha).with_scaled_lobes(kept, 1);
}

/// The bsdf with its clearcoat's lobe raised.
Bsdf with_raised_coat(const Bsdf& bsdf, const dvec2& alpha, const dvec3& wo) {
  const double camera_cosine = std::abs(bsdf.to_coat(wo, wo.z < 0).z);
  return bsdf.with_coat_alpha(alpha).with_scaled_lobes(
      1, reflection_kept(bsdf, bsdf.parameters().coat_alpha, alpha, camera_cosine));
}

}  // namespace

double alpha_at_normal(const Regularization& regularization, uint32_t ndf, uint32_t shadowing) {
  const double alpha_tau = reflection_alpha(regularization, ndf, shadowing, 1);
  return std::min(alpha_tau * regularization.alpha_scale, largest_alpha(ndf));
}

dvec2 raised_alpha(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi, const Regularization& regularization) {
  const BsdfParameters& p = bsdf.parameters();
  const dvec3 h = facet_normal(bsdf, wo, wi);
  const double c = std::abs(dot(dvec3(wo.x, wo.y, std::abs(wo.z)), h));
  const double alpha_tau = is_refraction(bsdf, wo, wi)
                               ? refraction_alpha(regularization, p.ndf, p.shadowing, bsdf.relative_index(wo))
                               : reflection_alpha(regularization, p.ndf, p.shadowing, c);
  return glm::max(p.alpha, dvec2(std::min(alpha_tau * regularization.alpha_scale, largest_alpha(p.ndf))));
}

std::optional<RaisedScattering> raise(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi,
                                      const BsdfSample* delta, const Regularization& regularization) {
  const bool is_delta_event = delta != nullptr;
  const bool has_coat = bsdf.parameters().clearcoat > 0;
  Bsdf wide = with_raised_base(bsdf, raised_alpha(bsdf, wo, wi, regularization), wo, wi);
  if (has_coat) wide = with_raised_coat(wide, raised_coat_alpha(bsdf, wo, wi, regularization), wo);
  if (is_delta_event && (wide.is_delta() || regularization.mis == MIS_UNMODIFIED)) return std::nullopt;
  RaisedScattering raised;
  raised.value = wide.value(wo, wi, TransportMode::Radiance);
  raised.pdf_wi = bsdf.pdf(wo, wi);
  raised.pdf_wo = bsdf.without_guide().pdf(wi, wo);
  const double in_weights = value_in_weights(bsdf, wide, wo, wi, regularization);
  const double plain = luminance_of(bsdf, wo, wi);
  raised.ratio = !is_delta_event && plain > 0 ? in_weights / plain : 0;
  if (regularization.mis == MIS_UNMODIFIED) return raised;

  const Bsdf smooth = without_facets(bsdf);
  const double diffuse = luminance_of(smooth, wo, wi);
  if (!is_delta_event && (diffuse > 0 || (has_coat && plain > 0))) {
    raised.pdf_wi *= raised.ratio;
    raised.pdf_wo *= raised.ratio;
    return raised;
  }
  // The microfacet lobes alone (for a delta event, those that are deltas): the density cancels from p / rho,
  // and with it the infinity of a delta.
  const BsdfParameters& p = bsdf.parameters();
  const bool is_alone = is_delta_event && p.coat_normal;  // the other lobe's delta lies elsewhere
  const auto shared_alpha = [&](const dvec2& alpha, bool is_coat) {
    if (is_alone && delta->is_coat != is_coat) return dvec2(0);
    if (alpha == dvec2(0)) return dvec2(DELTA_STAND_IN);
    return is_delta_event && has_coat ? dvec2(0) : alpha;
  };
  const Bsdf lobe = bsdf.with_alpha(shared_alpha(p.alpha, false))
                        .with_coat_alpha(shared_alpha(p.coat_alpha, true))
                        .with_unit_density();
  const double value = luminance_of(lobe, wo, wi) - diffuse;
  const double scale = value > 0 ? in_weights / value : 0;
  raised.pdf_wi = scale * (lobe.pdf(wo, wi) - smooth.pdf(wo, wi));
  raised.pdf_wo = scale * (lobe.pdf(wi, wo) - smooth.pdf(wi, wo));
  return raised;
}

dvec3 virtual_merge(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi, bool is_coat, TransportMode mode,
                    const Regularization& regularization, const std::vector<dvec3>& tries) {
  const double scale = regularization.alpha_scale;
  const double solid_angle = std::min(scale * scale / regularization.tau, 2 * pi);
  dvec3 sum(0);
  for (const dvec3& u : tries) {
    const BsdfSample sample = is_coat ? bsdf.sample_coat_facets(wo, u.x, {u.y, u.z}, mode)
                                      : bsdf.sample_facets(wo, u.x, {u.y, u.z}, mode);
    if (sample.is_valid && 1 - dot(sample.wi, wi) <= solid_angle / (2 * pi)) sum += sample.weight;
  }
  return sum / (static_cast<double>(tries.size()) * solid_angle * std::abs(wi.z));
}

Bsdf raised_alone(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi, bool is_coat,
                  const Regularization& regularization) {
  const Bsdf raised = is_coat ? with_raised_coat(bsdf, raised_coat_alpha(bsdf, wo, wi, regularization), wo)
                              : with_raised_base(bsdf, raised_alpha(bsdf, wo, wi, regularization), wo, wi);
  return is_coat ? raised.with_alpha(dvec2(0)) : raised.with_coat_alpha(dvec2(0));
}

bool raises_facets(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi, bool is_coat,
                   const Regularization& regularization) {
  if (!regularization.is_on) return false;
  if (!is_coat)
    return glm::any(glm::greaterThan(raised_alpha(bsdf, wo, wi, regularization), bsdf.parameters().alpha));
  return bsdf.coat_towards(wo) > 0 && wo.z * wi.z > 0 &&
         glm::any(
             glm::greaterThan(raised_coat_alpha(bsdf, wo, wi, regularization), bsdf.parameters().coat_alpha));
}

double estimator_bound(const Bsdf& bsdf, const dvec3& wo, const dvec3& wi,
                       const Regularization& regularization) {
  constexpr double LEAST = 1e-10;
  constexpr double MOST = 1e10;
  constexpr double DELTA_ALPHA = 1e-7;  // where nothing is raised a delta takes all, as the limit would
  Regularization full = regularization;
  full.tau = regularization.full_tau;
  const double diffuse = luminance_of(without_facets(bsdf), wo, wi);
  const dvec2 alpha = glm::max(raised_alpha(bsdf, wo, wi, full), dvec2(DELTA_ALPHA));
  const Bsdf wide = with_raised_base(bsdf, alpha, wo, wi).with_coat_alpha(dvec2(0));
  const double facets = luminance_of(wide, wo, wi) - diffuse;
  const auto peak = [](const dvec2& a, double least) { return 1 / (pi * std::max(a.x * a.y, least)); };
  const BsdfParameters& p = bsdf.parameters();
  double scale = 0.25;
  if (is_refraction(bsdf, wo, wi)) {
    const double eta = bsdf.relative_index(wo);
    const double bend = std::max(std::abs(eta * eta - 1), 1e-6) / (eta + 1);
    scale = std::max(eta, 1.0) * std::max(eta, 1.0) / (bend * bend);
  }
  double sum = diffuse + facets;
  double weighted = diffuse * diffuse + facets * scale * peak(p.alpha, 1e-10);
  if (p.clearcoat > 0 && wo.z * wi.z > 0) {
    const Bsdf coated =
        with_raised_coat(bsdf, raised_coat_alpha(bsdf, wo, wi, full), wo).with_alpha(dvec2(0));
    const double coat = luminance_of(coated, wo, wi) - diffuse;
    sum += coat;
    weighted += coat * 0.25 * peak(p.coat_alpha, 1e-28);
  }
  return sum > 0 ? std::clamp(weighted / sum, LEAST, MOST) : LEAST;
}

bool diffuses(const Bsdf& bsdf) {
  if (bsdf.parameters().clearcoat > 0 && bsdf.parameters().coat_alpha.x >= SHARP_ALPHA) return true;
  return bsdf.parameters().alpha.x >= SHARP_ALPHA || without_facets(bsdf).has_finite_lobe({0, 0, 1});
}

}  // namespace regulus::reference

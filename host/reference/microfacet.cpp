#include "reference/microfacet.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/quadrature.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;
using namespace interface;

namespace {

const double SQRT_PI = std::sqrt(pi);

/// (tan theta cos phi / alpha_x)^2 + (tan theta sin phi / alpha_y)^2.
double scaled_tan2(const dvec2& alpha, const dvec3& h) {
  const double x = h.x / (h.z * alpha.x);
  const double y = h.y / (h.z * alpha.y);
  return x * x + y * y;
}

/// alpha(phi) tan(theta), the only thing on which Lambda of a shape-invariant distribution depends.
double alpha_tan(const dvec2& alpha, const dvec3& w) {
  return std::hypot(alpha.x * w.x, alpha.y * w.y) / std::abs(w.z);
}

double lambda_ggx(double a_tan) {
  return 0.5 * (std::sqrt(1 + a_tan * a_tan) - 1);
}

double lambda_beckmann(double a_tan) {
  if (a_tan == 0) return 0;
  const double a = 1 / a_tan;
  return 0.5 * (std::exp(-a * a) / (a * SQRT_PI) - std::erfc(a));
}

/// log(Gamma(x + 1/2) / Gamma(x)). For large x by the asymptotic series (Abramowitz and Stegun 6.1.47), where
/// the difference of two large logarithms would have no digits left; its error is below 1e-14 there.
double log_gamma_ratio_half(double x) {
  if (x < 1e3) return std::lgamma(x + 0.5) - std::lgamma(x);
  return 0.5 * std::log(x) - 1 / (8 * x) + 1 / (192 * x * x * x);
}

/// int_0^theta sin(t)^n f(t) dt of smooth f.
template <typename Function>
double integrate_sine_power(double n, double theta, double log_scale, int levels, const Function& f) {
  // t = theta (1 - y)^2: the mass sits at small y for narrow lobes, and the root t^n at y = 1 is softened.
  const auto integrand = [&](double y) {
    const double t = theta * (1 - y) * (1 - y);
    const double cosine = std::cos(t);
    const double log_sine = t < 0.5 ? std::log(std::sin(t)) : 0.5 * std::log1p(-cosine * cosine);
    return std::exp(log_scale + n * log_sine) * f(y) * 2 * theta * (1 - y);
  };
  return integrate_graded(integrand, levels, 2);
}

/// Slopes of (n + 2) / (2 pi) cos^n have density (n + 2) / (2 pi) (1 + r^2)^(-(n + 4) / 2); integrated over
/// the slope across, the slope s along w has density c (1 + s^2)^(-(n + 3) / 2), c = Gamma((n + 3) / 2) /
/// (sqrt(pi) Gamma(n / 2 + 1)). Then Lambda = (1 / cot) int_cot^inf (s - cot) density(s) ds (Heitz 2014, eq.
/// 67), with s = cot t:  Lambda = c int_0^theta sin(t)^n sin(theta - t) dt / cos(theta).
double lambda_cosine(double alpha, const dvec3& w) {
  const double sin_theta = std::hypot(w.x, w.y);
  if (sin_theta == 0) return 0;
  const double length = std::hypot(sin_theta, w.z);
  const double n = cosine_exponent(alpha);
  const double theta = std::atan2(sin_theta, std::abs(w.z));
  const double log_c = log_gamma_ratio_half(0.5 * n + 1) - std::log(SQRT_PI);
  const int levels = 4 - static_cast<int>(std::floor(std::log2(alpha)));  // down to 1/16 of the lobe's width
  // A fractional power near 0 is no polynomial: with sin(theta - t) expanded and the recurrence of the
  // integrals J of powers of the sine, (m + 1) J(m) = (m + 2) J(m + 2) + cos(theta) sin(theta)^(m + 1), it
  // becomes n + 3. The difference loses a factor of n + 2.
  constexpr double SMALL_EXPONENT = 4;
  if (n < SMALL_EXPONENT) {
    const double sine = sin_theta / length;
    const double cosine = std::abs(w.z) / length;
    const double power = std::exp(log_c + (n + 2) * std::log(sine));
    const double j = integrate_sine_power(n + 3, theta, log_c, levels, [](double) { return 1.0; });
    return (power / (n + 1) - cosine * ((n + 3) * j + cosine * power) / (n + 2)) / cosine;
  }
  return integrate_sine_power(n, theta, log_c, levels,
                              [&](double y) { return std::sin(theta * y * (2 - y)); }) *
         length / std::abs(w.z);
}

double masking_smith(const Microsurface& surface, const dvec3& w) {
  return 1 / (1 + lambda(surface, w));
}

double masking_v_cavity(const dvec3& w, const dvec3& h) {
  return std::min(1.0, 2 * h.z * std::abs(w.z) / std::abs(dot(w, h)));
}

/// Splits a uniform number at `probability`: true below it. What remains is rescaled to [0, 1).
bool choose(double probability, double& u_choice) {
  const bool is_chosen = u_choice < probability;
  u_choice = is_chosen ? u_choice / probability : (u_choice - probability) / (1 - probability);
  return is_chosen;
}

/// The x slope of a visible facet of a Beckmann surface of roughness 1, seen in the xz plane from a direction
/// of cotangent a: density proportional to max(a - x, 0) exp(-x^2) (Heitz and d'Eon 2014, supplemental). The
/// distance r = |x| from 0 has density 2 a exp(-r^2) up to a and (a + r) exp(-r^2) beyond, so it is drawn
/// from three pieces with the integrals below, each divided by a, and then the sign.
double sample_beckmann_slope(double a, double u, double& u_choice) {
  const double inner = SQRT_PI * std::erf(a);
  const double gauss = inner + 0.5 * SQRT_PI * std::erfc(a);
  const double rayleigh = 0.5 * std::exp(-a * a) / a;
  const double target = u * (gauss + rayleigh);
  if (target < inner) {
    const double r = erf_inverse(target / SQRT_PI);
    return choose(0.5 * (1 - r / a), u_choice) ? r : -r;
  }
  if (target < gauss) return -erfc_inverse((gauss - target) * 2 / SQRT_PI);
  return -std::sqrt(a * a - std::log1p(-(target - gauss) / rayleigh));
}

dvec3 sample_visible_beckmann(const dvec2& alpha, const dvec3& wo, const dvec2& u, double& u_choice) {
  const dvec2 stretched = alpha * dvec2(wo);
  const double radius = std::hypot(stretched.x, stretched.y);
  const dvec2 azimuth = radius > 0 ? stretched / radius : dvec2(1, 0);
  const double cotangent = std::clamp(wo.z / std::max(radius, 1e-15), 1e-7, 1e9);
  const double x = sample_beckmann_slope(cotangent, u.x, u_choice);
  const double y = erf_inverse(2 * u.y - 1);
  const dvec2 turned(azimuth.x * x - azimuth.y * y, azimuth.y * x + azimuth.x * y);
  return normalize(dvec3(-alpha * turned, 1));
}

/// Dupuy and Benyoub 2023: the reflected direction is uniform on a spherical cap.
dvec3 sample_visible_ggx(const dvec2& alpha, const dvec3& wo, const dvec2& u) {
  const dvec3 stretched = normalize(dvec3(alpha * dvec2(wo), wo.z));
  const double phi = 2 * pi * u.y;
  const double z = 1 - u.x * (1 + stretched.z);
  const double sin_theta = std::sqrt(std::clamp(1 - z * z, 0.0, 1.0));
  const dvec3 h = dvec3(sin_theta * std::cos(phi), sin_theta * std::sin(phi), z) + stretched;
  return normalize(dvec3(alpha * dvec2(h), std::max(0.0, h.z)));
}

/// A V-cavity shows its two facets, h and its mirror image, in proportion to their projected areas.
dvec3 sample_visible_v_cavity(const Microsurface& surface, const dvec3& wo, const dvec2& u,
                              double& u_choice) {
  const dvec3 h = sample_distribution(surface, u);
  const dvec3 mirrored(-h.x, -h.y, h.z);
  const double seen = std::max(0.0, dot(wo, h));
  const double seen_mirrored = std::max(0.0, dot(wo, mirrored));
  return choose(seen / (seen + seen_mirrored), u_choice) ? h : mirrored;
}

}  // namespace

double cosine_exponent(double alpha) {
  return 2 / (alpha * alpha) - 2;
}

double distribution(const Microsurface& surface, const dvec3& h) {
  if (h.z <= 0) return 0;
  if (surface.has_unit_density) return 1;
  const dvec2 alpha = surface.alpha;
  const double cos2 = h.z * h.z;
  const double cos4 = cos2 * cos2;
  if (surface.ndf == NDF_GGX) {
    const double scale = 1 + scaled_tan2(alpha, h);
    return 1 / (pi * alpha.x * alpha.y * cos4 * scale * scale);
  }
  if (surface.ndf == NDF_BECKMANN) return std::exp(-scaled_tan2(alpha, h)) / (pi * alpha.x * alpha.y * cos4);
  const double n = cosine_exponent(alpha.x);
  const double tan2 = (h.x * h.x + h.y * h.y) / cos2;
  return (n + 2) / (2 * pi) * std::exp(-0.5 * n * std::log1p(tan2));
}

double lambda(const Microsurface& surface, const dvec3& w) {
  if (surface.ndf == NDF_COSINE) return lambda_cosine(surface.alpha.x, w);
  const double a_tan = alpha_tan(surface.alpha, w);
  return surface.ndf == NDF_GGX ? lambda_ggx(a_tan) : lambda_beckmann(a_tan);
}

double lambda_cosine_walter(double alpha, const dvec3& w) {
  return lambda_beckmann(alpha_tan(dvec2(alpha), w));
}

double masking(const Microsurface& surface, const dvec3& w, const dvec3& h) {
  if (dot(w, h) * w.z <= 0) return 0;
  return surface.shadowing == SHADOWING_V_CAVITY ? masking_v_cavity(w, h) : masking_smith(surface, w);
}

double masking_shadowing(const Microsurface& surface, const dvec3& wi, const dvec3& wo, const dvec3& h,
                         Scattering scattering) {
  const double mask = masking(surface, wo, h);
  const double shadow = masking(surface, wi, h);
  if (mask == 0 || shadow == 0) return 0;
  switch (surface.shadowing) {
    case SHADOWING_SMITH:
      return 1 / (1 + lambda(surface, wi) + lambda(surface, wo));
    case SHADOWING_SMITH_UNCORRELATED:
      return mask * shadow;
    default:
      return scattering == Scattering::Reflection ? std::min(mask, shadow) : std::max(0.0, mask + shadow - 1);
  }
}

Microsurface visible_normal_model(const Microsurface& surface) {
  Microsurface model = surface;
  if (surface.ndf == NDF_COSINE) model.shadowing = SHADOWING_V_CAVITY;
  return model;
}

double visible_normal_pdf(const Microsurface& surface, const dvec3& wo, const dvec3& h) {
  const Microsurface model = visible_normal_model(surface);
  return masking(model, wo, h) * distribution(model, h) * std::max(0.0, dot(wo, h)) / wo.z;
}

dvec3 sample_visible_normal(const Microsurface& surface, const dvec3& wo, const dvec2& u, double& u_choice) {
  const Microsurface model = visible_normal_model(surface);
  if (model.shadowing == SHADOWING_V_CAVITY) return sample_visible_v_cavity(model, wo, u, u_choice);
  if (model.ndf == NDF_GGX) return sample_visible_ggx(model.alpha, wo, u);
  return sample_visible_beckmann(model.alpha, wo, u, u_choice);
}

dvec3 sample_distribution(const Microsurface& surface, const dvec2& u) {
  const double phi = 2 * pi * u.y;
  double tan2 = 0;  // of the isotropic distribution with roughness 1 (GGX, Beckmann) or alpha (Cosine)
  dvec2 stretch = surface.alpha;
  switch (surface.ndf) {
    case NDF_GGX:
      tan2 = u.x / (1 - u.x);
      break;
    case NDF_BECKMANN:
      tan2 = -std::log1p(-u.x);
      break;
    default:
      tan2 = std::expm1(-2 / (cosine_exponent(surface.alpha.x) + 2) * std::log1p(-u.x));
      stretch = dvec2(1);
  }
  const double tangent = std::sqrt(tan2);
  return normalize(dvec3(stretch * tangent * dvec2(std::cos(phi), std::sin(phi)), 1));
}

}  // namespace regulus::reference

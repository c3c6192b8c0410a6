#include "stability/exact_bsdf.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "interface/wavefront.h"
#include "stability/quadrature.hpp"

namespace regulus::stability {

using namespace interface;

namespace {

constexpr Exact PI = std::numbers::pi_v<Exact>;

Exact square(Exact x) {
  return x * x;
}

/// (alpha tan theta)^2 of a slope scaled by 1 / alpha, and of a direction scaled by alpha.
Exact squared_slope(const ExactPair& alpha, const ExactVector& h) {
  return square(h.x / (h.z * alpha.x)) + square(h.y / (h.z * alpha.y));
}

/// ln(Gamma(x + 1/2) / Gamma(x)); by its asymptotic series (Abramowitz and Stegun 6.1.47) where logarithms of
/// large numbers would cancel: the first term left out is below 1e-17 from 200 on.
Exact log_gamma_ratio(Exact x) {
  if (x < 200) return std::lgamma(x + 0.5L) - std::lgamma(x);
  const Exact y = 1 / x;
  return 0.5L * std::log(x) - y / 8 + y * y * y / 192 - y * y * y * y * y / 640 +
         17 * std::pow(y, 7.0L) / 14336;
}

/// The Cosine distribution's slopes along one axis have the density c (1 + s^2)^(-(n + 3) / 2); its Lambda is
/// the mean of max(s - cot, 0) over cot, in angles c int_0^theta sin(t)^n sin(theta - t) dt / cos(theta).
Exact cosine_lambda(Exact alpha, const ExactVector& w) {
  const Exact sine = std::hypot(w.x, w.y);
  if (sine == 0) return 0;
  const Exact n = 2 / square(alpha) - 2;
  const Exact theta = std::atan2(sine, std::abs(w.z));
  const Exact log_c = log_gamma_ratio(n / 2 + 1) - std::log(PI) / 2;
  const auto integrand = [&](Exact t, Exact rest) {
    return std::exp(log_c + n * std::log(std::sin(t))) * std::sin(rest);
  };
  return integrate_to_ends(integrand, theta) * std::hypot(sine, w.z) / std::abs(w.z);
}

/// G1 of a direction at facet h; 0 where it sees the facet from behind. `cosine`: with h, positive in front.
Exact masking(uint32_t ndf, uint32_t shadowing, const ExactPair& alpha, const ExactVector& w,
              const ExactVector& h, Exact cosine) {
  if (!(cosine > 0)) return 0;
  if (shadowing == SHADOWING_V_CAVITY) return std::min(Exact{1}, 2 * h.z * std::abs(w.z) / cosine);
  return 1 / (1 + exact_lambda(ndf, alpha, w));
}

/// A facet between two directions.
struct Facet {
  ExactVector h;
  Exact o, i;  // cosines with h, of wi on its own side
  bool is_refracted;
};

Exact masking_shadowing(const ExactLobe& lobe, const ExactPair& alpha, const ExactVector& wo,
                        const ExactVector& wi, const Facet& facet) {
  if (lobe.shadowing == SHADOWING_SMITH)
    return 1 / (1 + exact_lambda(lobe.ndf, alpha, wo) + exact_lambda(lobe.ndf, alpha, wi));
  const Exact o = masking(lobe.ndf, lobe.shadowing, alpha, wo, facet.h, facet.o);
  const Exact i = masking(lobe.ndf, lobe.shadowing, alpha, wi, facet.h, facet.i);
  if (lobe.shadowing == SHADOWING_SMITH_UNCORRELATED) return o * i;
  return facet.is_refracted ? std::max(Exact{0}, o + i - 1) : std::min(o, i);
}

/// Density of visible normals over D |w.h|: G1 / |cos|, of the model that the sampler draws from.
Exact visibility(const ExactLobe& lobe, const ExactVector& w, const Facet& facet, Exact cosine) {
  const uint32_t model = lobe.ndf == NDF_COSINE ? uint32_t{SHADOWING_V_CAVITY} : lobe.shadowing;
  return masking(lobe.ndf, model, lobe.alpha, w, facet.h, cosine) / std::abs(w.z);
}

/// x with f(x) = 0 for increasing f with f(0) < 0.
template <typename Function>
Exact root_of(const Function& f) {
  Exact low = 0;
  Exact high = 1;
  while (f(high) < 0) high *= 2;
  for (int i = 0; i < 200; ++i) {
    const Exact middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return high;
}

/// alpha_tau of docs/mathematics.md 2: the alpha at which the bound on the lobe is tau.
Exact bounding_alpha(const ExactLobe& lobe, const ExactBound& bound, const Facet& facet, Exact eta) {
  const bool is_v_cavity = lobe.shadowing == SHADOWING_V_CAVITY;
  const bool is_smith = bound.bound == BOUND_SMITH && !is_v_cavity;
  const Exact gbar_root = lobe.ndf == NDF_GGX ? PI : Exact{1};  // Smith: 1 / (gbar_root tau) = alpha^4
  if (facet.is_refracted) {
    const Exact larger = std::max(eta, Exact{1});
    const Exact bend = std::abs(eta - 1) / larger;
    if (bend < 0.02L) return 0;
    const Exact e = 1 / square(bend);
    return is_smith ? std::pow(4 * e / (gbar_root * bound.tau), 0.25L) : std::sqrt(e / (PI * bound.tau));
  }
  if (is_smith) return std::pow(1 / (gbar_root * bound.tau), 0.25L);
  if (bound.bound != BOUND_DIRECTIONAL) return 1 / std::sqrt(4 * PI * bound.tau);
  const Exact c = std::max(facet.o, 1e-4L);
  if (is_v_cavity) return 1 / (c * std::sqrt(4 * PI * bound.tau));
  if (lobe.shadowing == SHADOWING_SMITH)
    return root_of(
        [&](Exact a) { return 4 * PI * a * a * c * std::sqrt(c * c + a * a * (1 - c * c)) * bound.tau - 1; });
  return root_of(
      [&](Exact a) { return PI * square(a * (c + std::sqrt(c * c * (1 - a * a) + a * a))) * bound.tau - 1; });
}

/// alpha^ of the pair.
ExactPair raised_alpha(const ExactLobe& lobe, const ExactBound& bound, const Facet& facet, Exact eta) {
  const Exact most = lobe.ndf == NDF_BECKMANN ? std::sqrt(0.5L) : Exact{1};
  const Exact least = std::min(bounding_alpha(lobe, bound, facet, eta), most);
  return {std::max(lobe.alpha.x, least), std::max(lobe.alpha.y, least)};
}

Facet facet_of(const ExactVector& wo, const ExactVector& wi, Exact eta, bool is_refracted) {
  Facet facet{is_refracted ? wo + eta * wi : wo + wi, 0, 0, is_refracted};
  facet.h /= std::sqrt(dot(facet.h, facet.h));
  if (facet.h.z < 0) facet.h = -facet.h;
  facet.o = dot(wo, facet.h);
  facet.i = is_refracted ? -dot(wi, facet.h) : dot(wi, facet.h);
  return facet;
}

}  // namespace

Exact exact_fresnel(Exact c, Exact eta) {
  if (eta == 1) return 0;
  const Exact sine_squared = (1 - c * c) / square(eta);
  if (sine_squared >= 1) return 1;
  const Exact c_other = std::sqrt(1 - sine_squared);
  return (square((c - eta * c_other) / (c + eta * c_other)) +
          square((eta * c - c_other) / (eta * c + c_other))) /
         2;
}

Exact exact_lambda(uint32_t ndf, const ExactPair& alpha, const ExactVector& w) {
  if (ndf == NDF_COSINE) return cosine_lambda(alpha.x, w);
  const Exact slope = std::hypot(alpha.x * w.x, alpha.y * w.y) / std::abs(w.z);
  if (slope == 0) return 0;
  // (sqrt(1 + s^2) - 1) / 2 without its cancellation.
  if (ndf == NDF_GGX) return square(slope) / (2 * (std::sqrt(1 + square(slope)) + 1));
  const Exact a = 1 / slope;
  // Beyond 12 the difference is below 1e-62.
  return a > 12 ? 0 : (std::exp(-a * a) / (a * std::sqrt(PI)) - std::erfc(a)) / 2;
}

Exact exact_density(uint32_t ndf, const ExactPair& alpha, const ExactVector& h) {
  if (!(h.z > 0)) return 0;
  const Exact scale = 1 / (PI * alpha.x * alpha.y * square(square(h.z)));
  if (ndf == NDF_GGX) return scale / square(1 + squared_slope(alpha, h));
  if (ndf == NDF_BECKMANN) return scale * std::exp(-squared_slope(alpha, h));
  const Exact n = 2 / square(alpha.x) - 2;
  return (n + 2) / (2 * PI) * std::exp(-n / 2 * std::log1p((square(h.x) + square(h.y)) / square(h.z)));
}

ExactScattering scatter(const ExactLobe& lobe, const ExactVector& wo, const ExactVector& wi,
                        const ExactBound& bound) {
  const bool is_refracted = wi.z < 0;
  if (!(wo.z > 0) || wi.z == 0 || (is_refracted && lobe.is_metal)) return {};
  const Exact eta = lobe.is_front || lobe.is_metal ? lobe.ior : 1 / lobe.ior;
  const Facet facet = facet_of(wo, wi, eta, is_refracted);
  if (!(facet.o > 0) || !(facet.i > 0)) return {};

  // Value, without D G2: Fresnel, Jacobian of h, and the cosines (Walter et al. 2007, eqs. 20 and 21).
  // Choice: which of the two events the sampler takes. `forward`, `reverse`: Jacobians that go with |wo.h|
  // and |wi.h|.
  const Exact reflected = lobe.is_metal ? Exact{1} : exact_fresnel(facet.o, eta);
  const Exact cosines = wo.z * std::abs(wi.z);
  const Exact spread = square(facet.o - eta * facet.i);
  const Exact choice = is_refracted ? 1 - reflected : reflected;
  const Exact per_value =
      is_refracted ? choice * facet.o * facet.i / (cosines * spread) : choice / (4 * cosines);
  const Exact per_forward = is_refracted ? choice * facet.o * square(eta) * facet.i / spread : choice / 4;
  const Exact per_reverse = is_refracted ? choice * facet.i * facet.o / spread : choice / 4;

  const Exact density = exact_density(lobe.ndf, lobe.alpha, facet.h);
  const Exact shadowing = masking_shadowing(lobe, lobe.alpha, wo, wi, facet);
  ExactScattering result;
  result.value = density * shadowing * per_value;
  result.forward = density * visibility(lobe, wo, facet, facet.o) * per_forward;
  result.reverse = density * visibility(lobe, wi, facet, facet.i) * per_reverse;

  const ExactPair wide = raised_alpha(lobe, bound, facet, eta);
  const Exact wide_density = exact_density(lobe.ndf, wide, facet.h);
  const Exact wide_shadowing = masking_shadowing(lobe, wide, wo, wi, facet);
  result.raised = wide_density * wide_shadowing * per_value;
  const Exact beta = 1 - (lobe.alpha.x * lobe.alpha.y) / (wide.x * wide.y);
  const Exact peak = exact_density(lobe.ndf, wide, {0, 0, 1});
  const Exact blended = std::pow(wide_density, 1 - beta) * std::pow(peak, beta);
  if (shadowing > 0)
    result.raised_forward =
        blended * wide_shadowing / shadowing * visibility(lobe, wo, facet, facet.o) * per_forward;
  return result;
}

}  // namespace regulus::stability

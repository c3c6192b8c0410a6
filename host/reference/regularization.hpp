// Microfacet regularization by its definitions (Jendersie and Grosch 2019; docs/mathematics.md 2 and 3):
// where a path is connected or merged, a microfacet lobe is measured with alpha^ = max(alpha, alpha_tau), so
// wide that its density stays below tau, and weights use pdfs times rho^W / rho.
#pragma once

#include <optional>
#include <vector>

#include "reference/bsdf.hpp"

namespace regulus::reference {

/// How one iteration is regularized.
struct Regularization {
  bool is_on = false;
  bool has_diffusion = true;  ///< only what the camera sees behind a surface that diffuses is regularized
  bool has_bundle = false;    ///< tau is that of a camera path's bundle (path tracing with diffusion)
  double tau = 100;           ///< bound on a lobe's density, 1/sr
  uint32_t bound = interface::BOUND_PEAK;
  uint32_t mis = interface::MIS_BLENDED;
  double alpha_scale = 1;   ///< factor of the schedule on alpha_tau in this iteration
  bool is_virtual = false;  ///< virtual merges: what is measured is what a lobe sends into a cone
  bool has_bounds = false;  ///< estimator_bound() is wanted, for sampler quality
  double full_tau = 100;    ///< tau without path diffusion
};

/// Scattering between two directions as connections and merges see it: what they measure, and the pdfs of
/// docs/mathematics.md 3.1, which are the walk's times rho^W / rho (rho^W: rho^, or with its peak blended
/// in, 3.9). These are finite for delta lobes, whose p and rho share a delta that cancels.
struct RaisedScattering {
  /// rho^(wo, wi), 1/sr, as radiance. A raised lobe is scaled so that wo, towards the camera, gets as much of
  /// even light as before: by the ratio of its energies in single scattering with alpha and with alpha^.
  glm::dvec3 value{0};
  double pdf_wi = 0;  ///< of wi given wo
  double pdf_wo = 0;  ///< of wo given wi
  double ratio = 0;   ///< rho^W / rho; 0 of a delta event
};

/// alpha^ of a mirror at normal incidence.
double alpha_at_normal(const Regularization& regularization, uint32_t ndf, uint32_t shadowing);

/// alpha^ of the lobe that scatters wo to wi: reflection if both lie on the same side, or thin-walled
/// transmission; otherwise refraction.
glm::dvec2 raised_alpha(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi,
                        const Regularization& regularization);

/// Raised scattering of a pair in the bsdf's frame. `delta`: the event, if the pair was found by sampling a
/// delta lobe, which outweighs all others there; else null. Returns nothing if no connection can stand in for
/// that event: the lobe stays a delta, or weights are left unmodified.
std::optional<RaisedScattering> raise(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi,
                                      const BsdfSample* delta, const Regularization& regularization);

/// What a virtual merge measures in place of the value of the base's microfacet lobe, or with `is_coat` of
/// the clearcoat's (Kaplanyan and Dachsbacher 2013; docs/mathematics.md 7): the mean of value |cos_i| over a
/// cone around wi, over |cos_i| at wi, by tries of the lobe's own sampler at wo, each with a number in [0, 1)
/// for its event and two for its direction. The cone has the solid angle 1 / tau, times alpha_scale^2.
glm::dvec3 virtual_merge(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi, bool is_coat,
                         TransportMode mode, const Regularization& regularization,
                         const std::vector<glm::dvec3>& tries);

/// The bsdf with a single microfacet lobe besides the diffuse one: the base's, or with `is_coat` the
/// clearcoat's, with the alpha that regularization raises it to between two directions.
Bsdf raised_alone(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi, bool is_coat,
                  const Regularization& regularization);

/// True if regularization raises the alpha of the base's lobe, or with `is_coat` the clearcoat's, between two
/// directions.
bool raises_facets(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi, bool is_coat,
                   const Regularization& regularization);

/// rho-bar (docs/mathematics.md 2.1 with Gbar = 1, and 2.5): the peak, with the alpha of walks, of the lobe
/// that scatters wo to wi; for a mixture the mean over its lobes by their shares of the fully regularized
/// value at the pair. 1/sr, between 1e-10 and 1e10. Symmetric.
double estimator_bound(const Bsdf& bsdf, const glm::dvec3& wo, const glm::dvec3& wi,
                       const Regularization& regularization);

/// True if what is seen through this surface is blurred: it has a diffuse lobe, or its alpha is not small.
/// Only what lies behind such a surface, as seen from the camera, is regularized.
bool diffuses(const Bsdf& bsdf);

}  // namespace regulus::reference

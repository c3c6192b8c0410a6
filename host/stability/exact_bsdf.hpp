// The microfacet lobes and their regularization in extended precision (64 bits of mantissa on x86-64),
// written from the formulas of docs/mathematics.md 1 and 2 alone: the truth that device and reference are
// held against.
#pragma once

#include <glm/glm.hpp>

#include "stability/sweep.hpp"

namespace regulus::stability {

using ExactVector = glm::vec<3, Exact>;
using ExactPair = glm::vec<2, Exact>;

/// A surface with nothing but a microfacet lobe, seen from wo's side: a perfectly reflecting metal, or a
/// clear white solid that reflects and refracts.
struct ExactLobe {
  uint32_t ndf, shadowing;  ///< NDF_*, SHADOWING_*
  ExactPair alpha;          ///< > 0; equal for the Cosine distribution
  Exact ior;                ///< n(back) / n(front)
  bool is_front;            ///< wo is at the front
  bool is_metal;
};

/// How a pair of directions is regularized.
struct ExactBound {
  uint32_t bound;  ///< BOUND_*
  Exact tau;       ///< 1/sr
};

/// Scattering of a pair, as radiance; pdfs per solid angle.
struct ExactScattering {
  Exact value = 0, forward = 0, reverse = 0;
  Exact raised = 0, raised_forward = 0;  ///< regularized, weights blended
};

/// @param wo, wi z is the normal on wo's side; wo.z > 0
ExactScattering scatter(const ExactLobe& lobe, const ExactVector& wo, const ExactVector& wi,
                        const ExactBound& bound);

/// Exact Fresnel reflectance of a smooth interface for the cosine c > 0 of the incident side; eta = n(other)
/// / n(here).
Exact exact_fresnel(Exact c, Exact eta);

/// Smith's Lambda of the distribution. @param w z > 0 not required: |z| counts
Exact exact_lambda(uint32_t ndf, const ExactPair& alpha, const ExactVector& w);

/// Density of facets, area per projected area and solid angle.
Exact exact_density(uint32_t ndf, const ExactPair& alpha, const ExactVector& h);

}  // namespace regulus::stability

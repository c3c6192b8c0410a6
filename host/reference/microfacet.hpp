// Microfacet theory in double precision: normal distributions D, Smith's Lambda, masking and shadowing, and
// visible normals. Local frame with z = macroscopic normal; all densities per steradian.
//
// Walter et al., Microfacet Models for Refraction through Rough Surfaces (EGSR 2007); Heitz, Understanding
// the Masking-Shadowing Function (JCGT 2014); Heitz and d'Eon, Importance Sampling Microfacet-Based BSDFs
// using the Distribution of Visible Normals (EGSR 2014); Dupuy and Benyoub, Sampling Visible GGX Normals with
// Spherical Caps (HPG 2023); Torrance and Sparrow (1967) for the V-cavity.
#pragma once

#include <glm/glm.hpp>

#include "interface/wavefront.h"

namespace regulus::reference {

/// A rough surface: which model, and its roughness along x and y (alpha = perceptual roughness squared; > 0).
struct Microsurface {
  uint32_t ndf = interface::NDF_GGX;
  uint32_t shadowing = interface::SHADOWING_SMITH;
  glm::dvec2 alpha = glm::dvec2(1);
  /// distribution() is 1: for quotients of value and pdf of a lobe, from which D cancels.
  bool has_unit_density = false;
};

/// Whether two directions lie on the same side of a facet or on different sides.
enum class Scattering { Reflection, Transmission };

/// Exponent n of the Cosine (Blinn-Phong) distribution: 2 / alpha^2 - 2. Isotropic.
double cosine_exponent(double alpha);

/// D(h), area of facets with normal h per unit macroscopic area. 0 for h.z <= 0.
/// Walter 2007 eqs. 25, 30, 33; anisotropic forms from Heitz 2014.
double distribution(const Microsurface& surface, const glm::dvec3& h);

/// Smith's Lambda of a direction (either side; depends on |w.z|) for the surface's own distribution: Heitz
/// 2014 for GGX and Beckmann; Cosine by quadrature over its slopes, isotropic only (it is not
/// shape-invariant).
double lambda(const Microsurface& surface, const glm::dvec3& w);

/// Beckmann's Lambda with the same alpha, which Walter et al. (2007, section 5.2) suggest for Cosine, because
/// sqrt(n/2 + 1) = 1 / alpha. The model does not use it: with alpha near 1 it creates energy.
double lambda_cosine_walter(double alpha, const glm::dvec3& w);

/// Monodirectional masking G1(w, h) of the model that `shadowing` selects: Smith or V-cavity. 0 if w sees the
/// facet and the macrosurface from different sides.
double masking(const Microsurface& surface, const glm::dvec3& w, const glm::dvec3& h);

/// Bidirectional G2(wi, wo, h).
double masking_shadowing(const Microsurface& surface, const glm::dvec3& wi, const glm::dvec3& wo,
                         const glm::dvec3& h, Scattering scattering);

/// The masking model whose visible normals are drawn: the surface's own, except that Cosine with Smith
/// masking draws V-cavity visible normals.
Microsurface visible_normal_model(const Microsurface& surface);

/// Density of the visible-normal sampler, D_v(h; wo) = G1 D max(0, wo.h) / wo.z of visible_normal_model().
/// wo.z > 0.
double visible_normal_pdf(const Microsurface& surface, const glm::dvec3& wo, const glm::dvec3& h);

/// A normal with density visible_normal_pdf(). `u` uniform in [0, 1)^2; `u_choice`, uniform in [0, 1),
/// decides what is discrete, and what remains of it is uniform again (the walk takes its next choice from
/// it).
glm::dvec3 sample_visible_normal(const Microsurface& surface, const glm::dvec3& wo, const glm::dvec2& u,
                                 double& u_choice);

/// A normal with density D(h) h.z.
glm::dvec3 sample_distribution(const Microsurface& surface, const glm::dvec2& u);

}  // namespace regulus::reference

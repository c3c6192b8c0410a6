// Path diffusion in path tracing by its definition (docs/mathematics.md 5): how wide the bundle of camera
// paths around one has become, as a covariance of position and angle that is the same along both axes across
// the ray.
#pragma once

#include "reference/bsdf.hpp"
#include "reference/camera.hpp"

namespace regulus::reference {

/// Second moments of a bundle of rays across its axis.
struct Footprint {
  double position = 0;    ///< variance, m^2
  double covariance = 0;  ///< of position and angle, m rad
  double angle = 0;       ///< variance, rad^2
};

/// The rays of a pixel's camera paths.
Footprint footprint_at_lens(const Camera& camera);

/// After `distance` metres.
Footprint travelled(const Footprint& footprint, double distance);

/// After a sampled event at a surface of mean curvature H (1/m), positive where it is convex towards the ray;
/// `eta`: relative index n(other side) / n(side of the ray).
Footprint scattered(const Footprint& footprint, const BsdfSample& event, double curvature, double eta);

/// sigma~: twice the standard deviation of the angle, at most 1, its value after a Lambert lobe. A vertex
/// where paths arrive with this footprint is regularized with tau / sigma~.
double diffusion(const Footprint& footprint);

}  // namespace regulus::reference

// Every way in which a set of techniques can find a given path: its sample count, density and measured
// function, and the weight that follows from them (docs/mathematics.md 3: w_k = (n_k / I_k) / sum of n / I, I
// = f_k / p_k). This is the definition that the device's recurrences are checked against.
#pragma once

#include <vector>

#include "interface/wavefront.h"
#include "reference/path.hpp"

namespace regulus::reference {

/// Which techniques are on, and with how many samples.
struct TechniqueSet {
  uint32_t bits = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE;  ///< TECHNIQUE_*
  double light_paths = 1;                                               ///< N: samples of `splat` and `merge`
  double connections = 1;                                               ///< samples of `connect` per (s, t)
  double merge_area = 0;                                                ///< eta_0 = pi r^2, m^2
  bool is_both = false;  ///< connections and merges exist twice, with and without regularization
  uint32_t quality = interface::SAMPLER_QUALITY_OFF;  ///< SAMPLER_QUALITY_*
  double enough_quality = 0;  ///< tau^2 of this iteration: below it a path is not regularized
};

/// One way to find a path.
struct Technique {
  uint32_t kind = interface::TECHNIQUE_HIT;  ///< TECHNIQUE_*
  size_t vertex =
      0;  ///< s, the number of vertices from the light; of a merge, the index j of the merged vertex
  Wide density = 0;         ///< n p: expected number of samples per unit of path measure
  Wide weight_density = 0;  ///< n p^, with the pdfs of ConnectedScattering: what weights compare
  bool is_plain = false;    ///< the copy without regularization, see TechniqueSet::is_both
};

/// All techniques of the set that can find the path, in the order hit, nee, connect by s, splat, merge by j.
/// A path of one edge belongs to `hit` alone, or to `splat` where there is no `hit`.
std::vector<Technique> list_techniques(const Path& path, const TechniqueSet& set);

/// q (Jendersie and Grosch 2019; docs/mathematics.md 6): least bound of the estimators of the set's
/// techniques, rho-bar rho-bar / d^2 of a connection and rho-bar / (N pi r^2) of a merge, times the path's
/// squared length.
double sampler_quality(const Path& path, const TechniqueSet& set);

/// How much of the regularized estimate a path gets, by its sampler quality: 1 all, 0 none.
double regularized_share(const Path& path, const TechniqueSet& set);

/// The technique of this kind and vertex, or null if it cannot find the path.
const Technique* find_technique(const std::vector<Technique>& techniques, uint32_t kind, size_t vertex);

/// Weight of one of the techniques: n p^ over the sum of all, which is n p f / f_k over the sum of all,
/// because the product of rho^ / rho over all vertices is common to them (docs/mathematics.md 3.1).
double mis_weight(const std::vector<Technique>& techniques, const Technique& used);

/// What a sample of the technique contributes before the weight: f_k / (n p).
glm::dvec3 unweighted_contribution(const Path& path, const Technique& used);

}  // namespace regulus::reference

// Pairs of directions where microfacet formulas divide by what vanishes, one list of cases a sweep.
#pragma once

#include <vector>

#include "stability/interface.h"
#include "stability/report.hpp"

namespace regulus::stability {

/// One pair at one value of its sweep's parameter.
struct BsdfCase {
  double parameter = 0;
  interface::StabilityBsdfCase inputs {};
  bool is_metal = false;
};

/// Which numbers of a pair a sweep looks at.
enum BsdfQuantities : uint32_t { LOBE = 1, RAISED = 2, WEIGHT = 4 };

struct BsdfSweep {
  const char* name;
  const char* parameter;
  uint32_t quantities;  ///< BsdfQuantities
  bool is_anisotropic;  ///< not for the Cosine distribution
  std::vector<BsdfCase> cases;
};

/// All sweeps of microfacet lobes.
std::vector<BsdfSweep> bsdf_sweeps(Extent extent);

}  // namespace regulus::stability

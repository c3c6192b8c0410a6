// Which techniques suit a scene: `-i auto`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/light_guide_choice.hpp"
#include "render/plan.hpp"

namespace regulus::render {

/// A set of techniques that could render a scene.
struct Candidate {
  uint32_t techniques = 0;
  uint32_t regularization = interface::REGULARIZATION_NONE;
  double error =
      0;  ///< estimated relative squared error of one sample of every pixel; infinite: it never converges
  double cost = 0;  ///< of that sample, in counted work: 1 is about a path of `pt` of four edges

  /// Error at equal time: least for the set that suits best.
  double error_at_equal_time() const { return error * cost; }
};

/// What was chosen and why.
struct TechniqueChoice {
  uint32_t techniques = 0;
  uint32_t regularization = interface::REGULARIZATION_NONE;
  std::string why;                    ///< one sentence
  std::vector<Candidate> candidates;  ///< the best first; empty if there was nothing to choose
  LightGuideChoice light_guide;       ///< what the candidates were judged with
};

/// Chooses techniques and, where the settings leave it open, regularization. A function of the scene, the
/// camera, the film's size and what the settings say of paths and lobes; not of samples, crop, seed or
/// machine, so that parts of one render agree.
TechniqueChoice choose_techniques(const PreparedScene& prepared, const RenderSettings& settings);

}  // namespace regulus::render

// Whether camera walks are guided, and by what: `--guide`.
#pragma once

#include <memory>
#include <string>

#include "prepared/prepared_scene.hpp"
#include "render/settings.hpp"
#include "scene/walk_guide.hpp"

namespace regulus::render {

/// What was chosen and why.
struct WalkGuideChoice {
  std::shared_ptr<const scene::WalkGuide> guide;  ///< null: camera walks go by their bsdfs alone
  std::string why;
};

/// Trains a guide by the reference (probe/walk_guide.hpp); with LIGHT_GUIDE_AUTO it is taken only if it
/// promises enough. A function of the scene, the camera, the film's shape and what the settings say of paths
/// and lobes; not of samples, crop, seed, techniques or machine, so that parts of one render agree.
/// @param regularization REGULARIZATION_* of the plan: what is done, whoever asked for it or chose it
WalkGuideChoice choose_walk_guide(const PreparedScene& prepared, const RenderSettings& settings,
                                  uint32_t regularization);

}  // namespace regulus::render

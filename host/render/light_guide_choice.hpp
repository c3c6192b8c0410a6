// Whether light paths are guided, and by what: `--guide-light`.
#pragma once

#include <memory>
#include <string>

#include "prepared/prepared_scene.hpp"
#include "reference/walk.hpp"
#include "render/settings.hpp"
#include "scene/light_guide.hpp"

namespace regulus::render {

/// What the reference walks before a render to know the scene: about so many pixels of the picture's shape,
/// with its camera, depth and lobes, without regularization.
reference::Settings settings_of_few_pixels(const RenderSettings& settings, double pixels, uint32_t samples);

/// The same to train guides.
reference::Settings training_settings(const RenderSettings& settings);

/// What was chosen and why.
struct LightGuideChoice {
  std::shared_ptr<const scene::LightGuide> guide;  ///< null: light paths start by power
  std::string why;
};

/// Trains a guide by the reference (probe/light_guide.hpp); with LIGHT_GUIDE_AUTO it is taken only if it
/// promises enough. A function of the scene, the camera, the film's shape and what the settings say of paths
/// and lobes; not of samples, crop, seed or machine, so that parts of one render agree.
LightGuideChoice choose_light_guide(const PreparedScene& prepared, const RenderSettings& settings);

}  // namespace regulus::render

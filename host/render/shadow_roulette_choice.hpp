// Which shadow rays play roulette: `--shadow-roulette`.
#pragma once

#include <string>

#include "prepared/prepared_scene.hpp"
#include "render/settings.hpp"

namespace regulus::render {

/// What was chosen and why.
struct ShadowRouletteChoice {
  float least = 0;  ///< W/(m^2 sr): shadow rays that would carry less play roulette; 0: none does
  std::string why;
};

/// What the settings ask for, or a share of how bright what the camera sees typically is, as few paths of the
/// reference tell. A function of the scene, the camera and the film's shape; not of techniques, samples,
/// crop, seed or machine, so that parts of one render agree. Never more than the settings' clamp.
ShadowRouletteChoice choose_shadow_roulette(const PreparedScene& prepared, const RenderSettings& settings);

}  // namespace regulus::render

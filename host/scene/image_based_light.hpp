// EXT_lights_image_based: a scene's cube map as its environment.
#pragma once

#include <optional>

#include "scene/document.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// The environment that the image-based light of a scene makes: the radiance of its sharpest cube map, turned
/// and scaled as the light says and then as the options do. Its blurred maps and coefficients are for
/// renderers that do not integrate light. Nothing if the scene has none, or, with a warning, if it cannot be
/// read.
std::optional<Environment> read_image_based_light(Document& document, size_t scene_index,
                                                  const EnvironmentOptions& options);

}  // namespace regulus::scene

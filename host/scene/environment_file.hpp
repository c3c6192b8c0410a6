// Where a scene's environment comes from: scenes[].extras.regulus.environment, or what a command line says.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "scene/document.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// The environment of a scene: of `extras`, the value of extras.regulus.environment (null: none), an object
/// with either "file" (a URI as those of images) or "color" (radiance as [r, g, b]), and "rotation" and
/// "scale". Texels that are no radiance (negative, not finite) are replaced with a warning.
/// @throws Error (BadFile)
std::optional<Environment> read_environment(Document& document, const nlohmann::json* extras,
                                            const EnvironmentOptions& options);

}  // namespace regulus::scene

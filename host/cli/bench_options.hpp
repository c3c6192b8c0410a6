// Options of `render` as strings, for benchmarks that render.
#pragma once

#include <string>

#include "prepared/prepared_scene.hpp"
#include "render/settings.hpp"

namespace regulus::cli {

struct ResolvedOptions {
  render::RenderSettings settings;
  float exposure_ev;
};

/// What `regulus render SCENE <text> --size <size>` would use, the scene's own settings behind them.
/// @throws Error(BadUsage)
ResolvedOptions resolve_render_options(const std::string& text, const std::string& size,
                                       const PreparedScene& prepared);

/// Checks the options without the scene. @throws Error(BadUsage)
void require_render_options(const std::string& text, const std::string& scene_file);

}  // namespace regulus::cli

// Options of `render` as strings, for benchmarks that render.
#pragma once

#include <string>

#include "bvh/bvh.hpp"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::cli {

struct ResolvedOptions {
  render::RenderSettings settings;
  float exposure_ev;
};

/// What `regulus render SCENE <text> --size <size>` would use, the scene's own settings behind them. The
/// scene must have been prepared by bvh::build_for_scene, whose result is `bvh`.
/// @throws Error(BadUsage)
ResolvedOptions resolve_render_options(const std::string& text, const std::string& size, scene::Scene& scene,
                                       const bvh::Bvh& bvh);

/// Checks the options without the scene. @throws Error(BadUsage)
void require_render_options(const std::string& text, const std::string& scene_file);

}  // namespace regulus::cli

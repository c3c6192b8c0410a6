// The radius of merges that a render of a scene uses, from its options and from what its camera sees.
#pragma once

#include <string>

#include "bvh/bvh.hpp"
#include "reference/merge_radius.hpp"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::cli {

/// What the camera of the settings sees of a scene that bvh::build_for_scene has prepared; `bvh` is its
/// result. On a film of the scene's own shape, whatever size is rendered.
reference::SeenSurfaces seen_by_camera(const scene::Scene& scene, const bvh::Bvh& bvh, uint32_t camera);

/// Turns settings.merge_radius as resolve_settings() leaves it into the one that is used, and names the rule.
/// Returns a warning of one line if that is not the one asked for, otherwise nothing.
std::string choose_merge_radius(const scene::Scene& scene, const bvh::Bvh& bvh,
                                render::RenderSettings& settings);

/// The same where technique merge is enabled; otherwise there is no radius, and nothing is traced.
std::string choose_needed_merge_radius(const scene::Scene& scene, const bvh::Bvh& bvh,
                                       render::RenderSettings& settings);

}  // namespace regulus::cli

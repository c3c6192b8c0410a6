// What is done of what was asked for. This is the only place that decides; device, reference, `inspect`,
// headers and statistics go by the plan.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "prepared/prepared_scene.hpp"
#include "render/layers.hpp"
#include "render/settings.hpp"
#include "scene/light_guide.hpp"
#include "scene/walk_guide.hpp"

namespace regulus::reference {
struct MergeRadius;   // reference/merge_radius.hpp
struct SeenSurfaces;  // likewise
}  // namespace regulus::reference

namespace regulus::render {

/// Something that was asked for and is not done.
struct Dropped {
  std::string what;  ///< such as "technique merge"
  std::string why;
};

/// A render of a scene with every choice made. Made by make_plan() alone.
struct Plan : CommonSettings {
  uint32_t techniques = 0;                                    ///< those that can contribute
  std::string techniques_rule;                                ///< why these, in words
  uint32_t light_sampling = interface::LIGHT_SAMPLING_POWER;  ///< LIGHT_SAMPLING_*, never _AUTO
  /// By which light paths start; null: by power.
  std::shared_ptr<const scene::LightGuide> light_guide;
  std::string light_guide_rule;  ///< why, in words; empty: nobody asked for one
  /// By which camera walks look for light; null: by their bsdfs alone.
  std::shared_ptr<const scene::WalkGuide> walk_guide;
  std::string walk_guide_rule;  ///< likewise
  float shadow_roulette = 0;    ///< W/(m^2 sr): shadow rays that would carry less play roulette; 0: none does
  std::string shadow_roulette_rule;  ///< where it comes from, in words; empty: nobody asked for one
  uint32_t light_paths = 0;          ///< per iteration
  float merge_radius = 0;            ///< metres, of the first iteration; 0: nothing is merged
  std::string merge_radius_rule;     ///< where it comes from, in words
  uint32_t regularization = interface::REGULARIZATION_NONE;
  /// Each wave has its own light vertices, or all light paths of an iteration are walked before its camera
  /// paths (always so for a crop, because all light paths may reach it).
  bool is_per_wave = true;
  uint32_t connections_per_vertex = 0;       ///< light vertices that a camera vertex connects to, at most
  uint32_t state = interface::STATE_ALWAYS;  ///< STATE_*: what is kept beside paths (render/state.hpp)
  Layers layers;                             ///< of the film
  scene::Features features;
  RenderSettings asked;
  std::vector<Dropped> dropped;
  std::vector<std::string> warnings;  ///< what was changed rather than dropped, one line each

  /// Whether one of these STATE_* is kept.
  bool keeps(uint32_t bits) const { return (state & bits) != 0; }

  /// The reason why `what` was dropped; nullptr if it was not.
  const std::string* why_dropped(std::string_view what) const;
};

/// Decides what is done. The same for the device and the reference, whatever the machine.
Plan make_plan(const PreparedScene& prepared, const RenderSettings& settings);

/// The same plan for a part of the film; everything that does not depend on pixels stays.
Plan plan_for_window(Plan plan, const Window& window);

/// What a camera sees of a scene, on a film of the scene's own shape, whatever size is rendered.
reference::SeenSurfaces seen_by_camera(const PreparedScene& prepared, uint32_t camera);

/// The radius of merges under these settings, whether merges are enabled or not. A given radius that does not
/// suit what is seen is changed, with a warning if `warnings` is not null.
reference::MergeRadius choose_merge_radius(const PreparedScene& prepared, const RenderSettings& settings,
                                           std::vector<std::string>* warnings = nullptr);

}  // namespace regulus::render

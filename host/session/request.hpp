// What a render is asked to do before the scene is known, and its settings once it is.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/names.hpp"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::session {

inline constexpr uint32_t MAX_SAMPLES = 1u << 24;

/// Settings as they are given. What needs the scene is text until then.
struct Request {
  std::string sample_range;  ///< FIRST:COUNT; empty: as many as `settings` says, from 0 on
  std::string crop;          ///< x0,y0,x1,y1; empty: the whole film
  std::string aovs;          ///< comma-separated
  std::string size;          ///< WxH; empty: the scene's resolution, else 1280 wide at the camera's aspect
  std::string camera;        ///< index or name; empty: the first
  std::string integrator = "auto";
  std::string techniques;  ///< comma-separated; empty: the integrator's
  std::string
      settings_from;  ///< picture whose techniques and regularization `auto` repeats; empty: it chooses
  std::string connections = "paired";
  std::string shadow_roulette = "off";  ///< off, auto or W/(m^2 sr)
  std::optional<uint32_t>
      regularization;  ///< REGULARIZATION_*; none: roughness, but nothing where vertices are merged
  uint32_t tau_schedule = interface::REGULARIZATION_CONSISTENT;  ///< or 0: fixed
  uint32_t diffusion = interface::REGULARIZATION_DIFFUSION;      ///< or 0: off
  std::string merge_radius;                                      ///< metres or percent; empty: the default
  std::optional<double> time_limit;                              ///< seconds of rendering; none: all samples
  std::optional<double> noise_target;  ///< see render::NoiseEstimate; none: all samples
  std::optional<float> filter_radius;  ///< pixels; none: the filter's own
  uint64_t band_pixels = 0;            ///< rendered at once, at most; 0: what the device's buffers hold
  bool has_no_sample_limit = false;    ///< render until the time or the noise is reached
  bool has_strategy_images = false;
  render::RenderSettings settings;

  /// What is asked for by default: the settings' own, rays by who is fastest, and guided light paths where
  /// that pays.
  Request() {
    settings.rays = interface::RAYS_AUTO;
    settings.light_guide = interface::LIGHT_GUIDE_AUTO;
  }
};

/// What the render is asked to do once the scene is known: size, camera, techniques.
/// @throws regulus::SettingError, regulus::Error (BadFile) for a picture of `settings_from` that says nothing
render::RenderSettings resolve_settings(const Request& request, const scene::Scene& scene);

/// A rectangle x0,y0,x1,y1 of a film of `size` pixels, from the top left, x1 and y1 excluded.
/// @param setting what the error calls it
/// @throws regulus::SettingError if it is anything else, empty or not within the film
render::Window parse_window(const std::string& setting, const std::string& text, const glm::uvec2& size);

/// TECHNIQUE_* bits of an integrator's name, 0 of `auto`, or of a comma-separated list of techniques.
/// @throws regulus::SettingError
uint32_t parse_technique_set(const std::string& text);

/// A setting by name: the long name of an option of `render`, and what scenes[].extras.regulus may say.
struct Setting {
  std::string_view name;
  std::string values;  ///< what it takes, in words
  /// Takes a value, or says what is wrong with it, quoting it.
  std::function<std::optional<std::string>(Request&, const std::string& text)> take;
};

/// All settings, in the order of the command line's help.
std::span<const Setting> known_settings();

/// @throws regulus::SettingError if there is none of that name, with one that is near
const Setting& find_setting(const std::string& name);

/// Values by name, each checked by itself. @throws regulus::SettingError
Request make_request(const std::map<std::string, std::string>& values);

/// What scenes[].extras.regulus says of settings that `values` leaves open is added to them; its number of
/// samples only if neither a time nor a noise is asked for. What is no setting of a scene becomes a warning.
/// @throws regulus::Error (BadFile) for a value that a setting does not take
std::map<std::string, std::string> with_scene_settings(std::map<std::string, std::string> values,
                                                       const scene::Scene& scene,
                                                       std::vector<std::string>& warnings);

}  // namespace regulus::session

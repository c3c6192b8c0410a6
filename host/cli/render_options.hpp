// The options of `regulus render`.
#pragma once

#include <CLI/CLI.hpp>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::cli {

inline constexpr const char* STRICT_HELP =
    "Refuse faults of the scene's files that otherwise are mended with a warning";

/// Most samples of a pixel.
inline constexpr uint32_t MAX_SAMPLES = 1u << 24;

/// What the command line of `render` says, before the scene is known.
struct RenderOptions {
  std::string scene_file;
  std::string output;              ///< picture; empty: the scene's name with .exr in the working folder
  std::string png;                 ///< empty: none
  std::string stats;               ///< empty: none
  std::string strategy_images;     ///< folder; empty: none
  std::string checkpoint;          ///< file to resume from; empty: none
  double checkpoint_seconds = 60;  ///< between two states of it
  bool is_resumed = false;         ///< go on from the checkpoint if it exists
  std::string sample_range;        ///< FIRST:COUNT; empty: --spp samples from 0 on
  std::string crop;                ///< x0,y0,x1,y1; empty: the whole film
  std::string aovs;                ///< comma-separated
  std::string size;    ///< WxH; empty: the scene's resolution, else 1280 wide at the camera's aspect
  std::string camera;  ///< index or name; empty: the first
  std::string integrator = "pt";
  std::string techniques;  ///< comma-separated; empty: the integrator's
  std::string connections = "paired";
  std::optional<uint32_t>
      regularization;  ///< REGULARIZATION_*; none: roughness, but nothing where vertices are merged
  uint32_t tau_schedule = interface::REGULARIZATION_CONSISTENT;  ///< or 0: fixed
  uint32_t diffusion = interface::REGULARIZATION_DIFFUSION;      ///< or 0: off
  std::string merge_radius;                                      ///< metres or percent; empty: the default
  std::string device;
  std::string backend = "vulkan";  ///< or "reference": the scalar reference, which needs no device
  float exposure_ev = 0;
  std::optional<double> time_limit;    ///< seconds of rendering; none: all samples
  std::optional<double> noise_target;  ///< see render::NoiseEstimate; none: all samples
  std::optional<float> filter_radius;  ///< pixels; none: the filter's own
  std::string animation;               ///< name or index; empty: the scene's, or none
  std::optional<double> time;          ///< s, of the animation
  std::string frames;                  ///< FIRST:LAST; empty: one picture
  double frames_per_second = 24;
  std::optional<uint32_t> scene_index;
  std::string variant;      ///< of materials; empty: the scene's
  std::string environment;  ///< file; empty: the scene's
  std::optional<double> environment_rotation, environment_scale;
  uint64_t band_pixels = 0;          ///< rendered at once, at most; 0: what the device's buffers hold
  bool has_no_sample_limit = false;  ///< render until the time or the noise is reached
  bool allow_external = false;
  bool is_strict = false;
  uint64_t memory_bytes = 0;  ///< host and device each; 0: the default
  bool is_quiet = false, is_verbose = false;
  render::RenderSettings settings;
};

/// What the options say of loading the scene.
scene::LoadOptions load_options(const RenderOptions& options);

/// Declares --memory, which is written to `bytes`.
void add_memory_option(CLI::App& command, uint64_t& bytes);

/// Declares the options on the subcommand. `options` must outlive the parse.
void declare_render_options(CLI::App& command, RenderOptions& options);

/// For commands that take the options of `render` and write no files.
/// @param who as the error begins
/// @throws regulus::Error (BadUsage) naming an option that says what to write
void require_no_outputs(const RenderOptions& options, const std::string& who);

/// With --time or --noise and no --spp there is no limit to the samples. Call before the scene's settings are
/// applied: their spp gives way too.
void lift_sample_limit(const CLI::App& command, RenderOptions& options);

/// Takes the settings of scenes[].extras.regulus for every option the command line did not give.
/// Returns a warning for each unknown name and each that makes no sense in a scene.
/// @throws regulus::Error (BadFile) for a value the option does not take
std::vector<std::string> apply_scene_settings(CLI::App& command, const scene::Scene& scene);

/// A rectangle x0,y0,x1,y1 of a film of `size` pixels, from the top left, x1 and y1 excluded.
/// @param option what the error calls it
/// @throws regulus::Error (BadUsage) if it is anything else, empty or not within the film
render::Window parse_window(const char* option, const std::string& text, const glm::uvec2& size);

/// TECHNIQUE_* bits of an integrator's name or of a comma-separated list of techniques. @throws
/// regulus::Error (BadUsage).
uint32_t parse_technique_set(const std::string& text);

/// What the render is asked to do once the scene is known: size, camera, techniques.
/// @throws regulus::Error (BadUsage) naming the option
render::RenderSettings resolve_settings(const RenderOptions& options, const scene::Scene& scene);

}  // namespace regulus::cli

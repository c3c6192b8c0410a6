// The options of `regulus render`.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "cli/denoise_options.hpp"
#include "cli/progress_style.hpp"
#include "image/encoding.hpp"
#include "scene/scene.hpp"
#include "session/request.hpp"

namespace regulus::cli {

inline constexpr const char* STRICT_HELP =
    "Refuse faults of the scene's files that otherwise are mended with a warning";

/// What the command line of `render` says, before the scene is known.
struct RenderOptions : session::Request {
  std::string scene_file;
  std::string output;              ///< picture; empty: the scene's name with .exr in the working folder
  std::string png;                 ///< empty: none
  std::string stats;               ///< empty: none
  std::string strategy_images;     ///< folder; empty: none
  std::string report;              ///< page; empty: none
  std::string display_server;      ///< HOST:PORT; empty: none
  std::string checkpoint;          ///< file to resume from; empty: none
  double checkpoint_seconds = 60;  ///< between two states of it
  bool is_resumed = false;         ///< go on from the checkpoint if it exists
  std::string device;              ///< one, or several with commas between them, or all
  std::string split;  ///< of samples among several devices (session/sample_split.hpp); empty: by speed
  std::string backend = "vulkan";  ///< or "reference": the scalar reference, which needs no device
  float exposure_ev = 0;
  bool is_exposed_automatically = false;
  std::string view = "neutral";  ///< see image::View
  std::string ocio, ocio_display,
      ocio_view;  ///< config of OpenColorIO in place of `view`; empty: its defaults
  std::shared_ptr<const image::ColorTransform> color_transform;  ///< what they come to
  image::ExrStorage storage;
  bool is_denoised = false;
  DenoiseOptions denoise;
  std::string animation;       ///< name or index; empty: the scene's, or none
  std::optional<double> time;  ///< s, of the animation
  std::string frames;          ///< FIRST:LAST; empty: one picture
  double frames_per_second = 24;
  std::optional<uint32_t> scene_index;
  std::vector<std::string> edits;  ///< of the scene, see scene::apply_edits
  std::string variant;             ///< of materials; empty: the scene's
  std::string environment;         ///< file; empty: the scene's
  std::optional<double> environment_rotation, environment_scale;
  bool allow_external = false;
  bool is_strict = false;
  uint64_t memory_bytes = 0;  ///< host and device each; 0: the default
  bool is_quiet = false, is_verbose = false;
  ProgressStyle progress = ProgressStyle::Auto;
};

/// What the options say of loading the scene.
scene::LoadOptions load_options(const RenderOptions& options);

/// How the options say that a picture is written.
image::Encoding encoding(const RenderOptions& options);

/// Declares -D, which adds to `edits`.
void add_edit_option(CLI::App& command, std::vector<std::string>& edits);

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

}  // namespace regulus::cli

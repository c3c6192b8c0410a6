// The files that `render` writes.
#pragma once

#include <filesystem>

#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/render_options.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus::cli {

/// Where the outputs go; what is not asked for is empty.
struct RenderOutputs {
  std::filesystem::path picture, png, stats, report, checkpoint, strategy_images;
  image::Format format = image::Format::Exr;  ///< of the picture
};

/// The picture where no option names one: the scene's name with .exr in the working folder.
std::filesystem::path default_picture(const RenderOptions& options);

/// The outputs that the options name, or the default picture and a preview beside it, before the scene is
/// loaded: none of them is the scene, the environment or another one, their formats are known, and they can
/// be written.
/// @throws regulus::Error (BadUsage) for a format or a clash, (Failed) for a place that cannot be written;
/// both name the option
RenderOutputs resolve_outputs(const RenderOptions& options, OutputGuard& guard);

/// The rest, once the scene and the settings are known: nothing that the scene refers to is replaced, and the
/// picture's format holds what is asked for. @throws regulus::Error (BadUsage)
void check_outputs(const RenderOutputs& outputs, const RenderOptions& options,
                   const render::RenderSettings& settings, OutputGuard& guard);

}  // namespace regulus::cli

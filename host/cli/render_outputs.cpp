#include "cli/render_outputs.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "cli/strategy_images.hpp"

namespace regulus::cli {

namespace fs = std::filesystem;
using image::Format;

namespace {

// Only a picture in OpenEXR holds sums. Other names are no business of ours, but this one would mislead.
void require_checkpoint_name(const fs::path& file) {
  const auto format = image::format_of(file);
  if (format && *format != Format::Exr)
    throw Error(
        ErrorCode::BadUsage,
        fmt::format("--checkpoint {}: is an OpenEXR file; name one that ends in .exr", file.string()));
}

}  // namespace

fs::path default_picture(const RenderOptions& options) {
  return fs::path(options.scene_file).filename().replace_extension(".exr");
}

RenderOutputs resolve_outputs(const RenderOptions& options, OutputGuard& guard) {
  RenderOutputs outputs{options.output, options.png,        options.stats,
                        options.report, options.checkpoint, options.strategy_images};
  if (outputs.picture.empty()) {
    outputs.picture = default_picture(options);
    if (outputs.png.empty()) outputs.png = fs::path(outputs.picture).replace_extension(".png");
  }
  if (!options.strategy_images.empty() && !options.checkpoint.empty())
    throw Error(ErrorCode::BadUsage,
                "--strategy-images: a checkpoint does not hold them; leave out --checkpoint");

  guard.add_input(options.scene_file, "the scene");
  if (!options.environment.empty()) guard.add_input(options.environment, "the environment");
  const std::pair<const char*, const fs::path&> files[] = {{"--output", outputs.picture},
                                                           {"--png", outputs.png},
                                                           {"--stats", outputs.stats},
                                                           {"--report", outputs.report},
                                                           {"--checkpoint", outputs.checkpoint}};
  for (const auto& [option, file] : files)
    if (!file.empty()) guard.add_output(option, file);
  guard.require_places();

  outputs.format = image::require_format("--output", outputs.picture,
                                         {Format::Exr, Format::Png, Format::Jpeg, Format::Hdr});
  if (!outputs.png.empty()) image::require_format("--png", outputs.png, {Format::Png});
  require_checkpoint_name(outputs.checkpoint);
  if (!outputs.strategy_images.empty()) make_strategy_folder(outputs.strategy_images);
  return outputs;
}

void check_outputs(const RenderOutputs& outputs, const RenderOptions& options,
                   const render::RenderSettings& settings, OutputGuard& guard) {
  if (outputs.format != Format::Exr && !options.sample_range.empty())
    throw Error(ErrorCode::BadUsage,
                fmt::format("--samples needs --output FILE.exr; {} holds no sums of samples",
                            outputs.picture.string()));
  if (!options.sample_range.empty() && (options.storage.has_half_floats || options.storage.is_dwaa))
    throw Error(ErrorCode::BadUsage, "--samples: parts keep all their bits; leave out --half and --dwaa");
  if (outputs.format != Format::Exr && settings.aovs != 0)
    throw Error(ErrorCode::BadUsage,
                fmt::format("--aov needs --output FILE.exr; {} holds no channels but colour",
                            outputs.picture.string()));
  if ((settings.aovs & render::CRYPTO_AOVS) != 0 && options.storage.is_dwaa)
    throw Error(ErrorCode::BadUsage, "--aov: DWAA would change the ids of cryptomattes; leave out --dwaa");
  if (!outputs.strategy_images.empty())
    for (const fs::path& file : strategy_files(outputs.strategy_images, settings))
      guard.add_output("--strategy-images", file);
  guard.add_scene(options.scene_file);
}

}  // namespace regulus::cli

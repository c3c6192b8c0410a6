// --strategy-images: the files of Veach's pyramid.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/output_writer.hpp"
#include "render/renderer.hpp"

namespace regulus::cli {

/// What the names in the folder mean, for --help.
extern const char* const STRATEGY_IMAGES_HELP;

/// Makes the folder if it is not there. @throws regulus::Error (Failed)
void make_strategy_folder(const std::filesystem::path& folder);

/// The files that write_strategy_images may write.
std::vector<std::filesystem::path> strategy_files(const std::filesystem::path& folder,
                                                  const render::RenderSettings& settings);

/// Writes two EXR files per strategy of a finished render of paths of up to `max_depth` edges into the
/// folder, and sheet.png: a row per path length, shortest first, from s = 0 on to the right and then the
/// merges; below that the same without weights.
void write_strategy_images(OutputWriter& writer, const std::filesystem::path& folder,
                           const render::Renderer& renderer, uint32_t max_depth,
                           const image::Attributes& attributes, float exposure_ev);

}  // namespace regulus::cli

// The options of denoising, for `render` and `denoise`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "image/image.hpp"

namespace regulus::cli {

struct DenoiseOptions {
  std::string by = "oidn";  ///< or "cross"
  std::string library;      ///< file of Open Image Denoise; empty: see denoise::by_open_image_denoise
};

void add_denoiser_options(CLI::App& command, DenoiseOptions& options);

/// AOV_* bits that the denoiser goes by.
uint32_t aovs_for_denoiser(const DenoiseOptions& options);

/// @throws regulus::Error (Failed) if the denoiser cannot be had
void require_denoiser(const DenoiseOptions& options);

/// Replaces the picture's colors, see denoise::put_denoised. One that was denoised before is denoised anew,
/// from what it was. @throws regulus::Error (Failed), (BadFile) if channels are missing
void denoise_picture(const DenoiseOptions& options, image::Image& image, image::Channels& channels,
                     image::Attributes& attributes);

}  // namespace regulus::cli

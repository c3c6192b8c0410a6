// FLIP's error of each pixel as a picture.
#pragma once

#include <filesystem>

#include "image/image.hpp"

namespace regulus::image {

/// flip_map (image.hpp) on the colours of write_heat_map, evenly from 0 (black) to 1 (pale yellow); PNG or
/// JPEG by the name of the file.
/// @throws regulus::Error (BadFile, Failed).
void write_flip_picture(const std::filesystem::path& path, const Image& image, const Image& reference);

}  // namespace regulus::image

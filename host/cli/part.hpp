// Images that carry the sums of their samples: parts of a render, and checkpoints, which are the same thing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "image/image.hpp"
#include "render/film.hpp"

namespace regulus::cli {

/// Samples [first, first + count) of every pixel.
struct SampleRange {
  uint64_t first = 0, count = 0;
};

/// A file with sums (render/film_file.hpp).
struct Part {
  std::filesystem::path path;
  image::ExrContents contents;  ///< without the sums
  render::Film film;
  std::vector<SampleRange> ranges;  ///< in ascending order; the last may not be complete, see is_complete()

  uint64_t samples() const;  ///< asked for, per pixel
  bool is_complete() const;  ///< every pixel has all of them
};

/// @throws regulus::Error (BadFile) if the file is no part
Part read_part(const std::filesystem::path& path);

/// Writes an image with its film, the sample ranges it holds, and `channels` beside them.
/// @throws regulus::Error (Failed)
void write_part(const std::filesystem::path& path, const render::Film& film,
                const std::vector<SampleRange>& ranges, image::Attributes attributes,
                image::Channels channels, const image::Placement& placement);

/// Checks that two files hold samples of one render: all settings, the scene and the version of Regulus
/// agree, but for the samples. @throws regulus::Error (BadFile) that names a setting in which they differ
void require_same_render(const std::string& name, const image::Attributes& attributes,
                         const std::string& other_name, const image::Attributes& other);

}  // namespace regulus::cli

// Images that carry the sums of their samples: parts of a render, and checkpoints, which are the same thing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "image/image.hpp"
#include "render/film.hpp"

namespace regulus::session {

/// Samples [first, first + count) of every pixel.
struct SampleRange {
  uint64_t first = 0, count = 0;
  bool operator==(const SampleRange&) const = default;
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

/// Whether a file holds sums of samples, as far as its header says; false if it cannot be read.
bool is_part(const std::filesystem::path& path);

/// @throws regulus::Error (BadFile) if the file is no part, or its checksum is another or missing: it is
/// damaged, or was written before there were checksums, and then by a version whose samples this one could
/// not add to anyway
Part read_part(const std::filesystem::path& path);

/// The bytes of an OpenEXR file with an image, its film, the sample ranges it holds, and `channels` beside
/// them; and a checksum (regulus:checksum) over all that a reader trusts: attributes of Regulus, windows,
/// sums and channels but for the colours, which follow from the sums. Errors name `path`.
/// @throws regulus::Error (Failed)
std::string encode_part(const std::filesystem::path& path, const render::Film& film,
                        const std::vector<SampleRange>& ranges, image::Attributes attributes,
                        image::Channels channels, const image::Placement& placement);

/// One line for each kind of the film's sums of which some left its range: more light than the scene's lights
/// let expect, in more samples than there is room for.
std::vector<std::string> saturation_warnings(const render::Film& film);

/// Checks that two files hold samples of one render: all settings, the scene and the version of Regulus
/// agree as they were done, but for the samples. @throws regulus::Error (BadFile) that names a setting in
/// which they differ
void require_same_render(const std::string& name, const image::Attributes& attributes,
                         const std::string& other_name, const image::Attributes& other);

}  // namespace regulus::session

// The film's sums in an OpenEXR file, so that a render can be resumed from it or added to others, bit by bit.
#pragma once

#include <filesystem>

#include "image/image.hpp"
#include "render/film.hpp"

namespace regulus::render {

/// Adds the sums to an image's channels as 32-bit integers (film.sum.R0 is the lowest word of red's) and the
/// numbers of paths to its attributes.
void add_film(const Film& film, image::Channels& channels, image::Attributes& attributes);

/// The film that add_film added; its channels are taken out of `contents`. Errors name `path`.
/// @throws regulus::Error (BadFile) if there is none, or not as add_film writes it
Film take_film(const std::filesystem::path& path, image::ExrContents& contents);

/// Adds the sums of `other`, which holds other samples. Precondition: films of the same size and kind, both
/// complete (the same samples of every pixel).
void add(Film& film, const Film& other);

}  // namespace regulus::render

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

/// Adds the sums of `other`, which holds other samples. Sums that leave the film's range stay saturated.
/// Precondition: films of the same size, kind and exponents, both complete (the same samples of every pixel).
void add(Film& film, const Film& other);

/// A film of another size with the same kinds of sums, all 0, the same number of light paths, and no paths.
Film empty_like(const Film& film, uint32_t width, uint32_t height);

/// Copies the sums of `part` to the pixels from (x, y) on of `whole`, and counts its paths. Precondition: it
/// has the same kinds of sums and lies within.
void place(const Film& part, uint32_t x, uint32_t y, Film& whole);

}  // namespace regulus::render

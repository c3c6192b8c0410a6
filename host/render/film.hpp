// The film on the host: the fixed-point sums of shaders/lib/film.glsl and how many paths they hold.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// A fixed-point sum of three words (interface/wavefront.h) as a number; the least that is too large to be
/// held if it is saturated.
double film_sum(const uint32_t* words, int exponent);

/// The part of the light that is of one kind, or of one group of lights.
struct LightLayer {
  std::string name;                     ///< of the channels: "direct", "light_Lamp"
  std::vector<uint32_t> words{};        ///< as Film::words
  std::vector<uint32_t> splat_words{};  ///< as Film::splat_words
};

/// Sums of whole paths. Paths are counted sample by sample, within a sample pixel by pixel, so `paths` says
/// how many samples each pixel has.
struct Film {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> words;  ///< FILM_WORDS_PER_PIXEL per pixel
  uint64_t paths = 0;

  /// Of technique `splat`: sums of whole light paths over all pixels; empty if it is not enabled.
  std::vector<uint32_t> splat_words;
  uint64_t light_paths = 0;                ///< light paths in splat_words
  uint64_t light_paths_per_iteration = 1;  ///< by which each splat was divided

  /// With AOV_VARIANCE: `words` and `splat_words` together as they were after the last whole sample of every
  /// pixel, and the sums of the squares of whole samples; otherwise empty.
  std::vector<uint32_t> earlier_words{}, square_words{};

  std::vector<LightLayer> layers{};  ///< by name (render/layers.hpp)

  scene::FilmExponents exponents{};  ///< of the units of the sums and of those of squares

  uint64_t pixels() const { return uint64_t{width} * height; }

  /// Complete samples of pixel `pixel` (y * width + x).
  uint64_t samples(uint64_t pixel) const;
};

/// Sums of a film, FILM_WORDS_PER_PIXEL words per pixel, or none.
template <typename Words>
struct NamedSums {
  std::string name;  ///< "sum", "splats", "earlier", "squares"; of layers "direct.sum" and so on
  Words* words;
};
/// All sums that a film may have. Those of two films with the same layers correspond.
std::vector<NamedSums<std::vector<uint32_t>>> sums_of(Film& film);
std::vector<NamedSums<const std::vector<uint32_t>>> sums_of(const Film& film);

/// True if both have the same kinds of sums, in the same units.
bool have_same_sums(const Film& a, const Film& b);

/// A layer as a film of its own.
Film film_of_layer(const Film& film, const LightLayer& layer);

/// Gives saturated sums the same words, whatever the order in which they were added.
void settle_saturated(std::vector<uint32_t>& words);

/// Number of sums (a channel of a pixel) that are saturated.
uint64_t count_saturated(const std::vector<uint32_t>& words);

/// The mean of the samples of each pixel, 0 where a pixel has none, and the mean of the splats.
image::Image resolve(const Film& film);

/// The variance of each value of the image as the mean of the whole samples, estimated from their spread;
/// infinite where there are fewer than two or a sum of squares is saturated. Unbiased for independent samples
/// (--sampler hash), from above for scrambled Sobol points, whose errors compensate for each other.
/// Precondition: film.square_words is not empty.
image::Image resolve_variance(const Film& film);

}  // namespace regulus::render

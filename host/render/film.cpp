#include "render/film.hpp"

#include <cmath>

#include "interface/wavefront.h"

namespace regulus::render {

namespace {

double sum_at(const std::vector<uint32_t>& words, uint64_t pixel, uint64_t channel) {
  const uint32_t* word = &words[pixel * interface::FILM_WORDS_PER_PIXEL + 3 * channel];
  const double units = word[0] + std::ldexp(word[1], 32) + std::ldexp(word[2], 64);
  return std::ldexp(units, -static_cast<int>(interface::FILM_FRACTION_BITS));
}

}  // namespace

uint64_t Film::samples(uint64_t pixel) const {
  const uint64_t pixels = uint64_t{width} * height;
  return paths / pixels + (pixel < paths % pixels ? 1 : 0);
}

image::Image resolve(const Film& film) {
  const uint64_t pixels = uint64_t{film.width} * film.height;
  const double iterations =
      static_cast<double>(film.light_paths) / static_cast<double>(film.light_paths_per_iteration);
  image::Image image{film.width, film.height, std::vector<float>(3 * pixels)};
  for (uint64_t pixel = 0; pixel < pixels; ++pixel) {
    const double samples = static_cast<double>(film.samples(pixel));
    for (uint64_t channel = 0; channel < 3; ++channel) {
      double value = 0;
      if (samples > 0) value += sum_at(film.words, pixel, channel) / samples;
      if (iterations > 0 && !film.splat_words.empty())
        value += sum_at(film.splat_words, pixel, channel) / iterations;
      image.rgb[3 * pixel + channel] = static_cast<float>(value);
    }
  }
  return image;
}

}  // namespace regulus::render

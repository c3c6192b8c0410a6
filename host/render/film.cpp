#include "render/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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
  return paths / pixels() + (pixel < paths % pixels() ? 1 : 0);
}

image::Image resolve(const Film& film) {
  const uint64_t pixels = film.pixels();
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

image::Image resolve_variance(const Film& film) {
  const uint64_t pixels = film.pixels();
  const uint64_t whole_samples = film.paths / pixels;
  const auto samples = static_cast<double>(whole_samples);
  image::Image image{film.width, film.height,
                     std::vector<float>(3 * pixels, std::numeric_limits<float>::infinity())};
  if (samples < 2) return image;
  for (uint64_t i = 0; i < 3 * pixels; ++i) {
    const double sum = sum_at(film.earlier_words, i / 3, i % 3);
    const double squares = sum_at(film.square_words, i / 3, i % 3);
    const double spread = std::max(squares - sum * sum / samples, 0.0);
    image.rgb[i] = static_cast<float>(spread / (samples * (samples - 1)));
  }
  return image;
}

}  // namespace regulus::render

#include "render/film.hpp"

#include <cmath>

#include "interface/wavefront.h"

namespace regulus::render {

uint64_t Film::samples(uint64_t pixel) const {
  const uint64_t pixels = uint64_t{width} * height;
  return paths / pixels + (pixel < paths % pixels ? 1 : 0);
}

image::Image resolve(const Film& film) {
  const uint64_t pixels = uint64_t{film.width} * film.height;
  image::Image image{film.width, film.height, std::vector<float>(3 * pixels)};
  for (uint64_t pixel = 0; pixel < pixels; ++pixel) {
    const double samples = static_cast<double>(film.samples(pixel));
    if (samples == 0) continue;
    for (uint64_t channel = 0; channel < 3; ++channel) {
      const uint32_t* word = &film.words[pixel * interface::FILM_WORDS_PER_PIXEL + 3 * channel];
      const double units = word[0] + std::ldexp(word[1], 32) + std::ldexp(word[2], 64);
      image.rgb[3 * pixel + channel] =
          static_cast<float>(std::ldexp(units, -static_cast<int>(interface::FILM_FRACTION_BITS)) / samples);
    }
  }
  return image;
}

}  // namespace regulus::render

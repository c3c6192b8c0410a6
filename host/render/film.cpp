#include "render/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "interface/wavefront.h"

namespace regulus::render {

namespace {

constexpr size_t WORDS_PER_SUM = 3;

bool is_saturated(const uint32_t* words) {
  return (words[WORDS_PER_SUM - 1] & interface::FILM_SATURATED) != 0;
}

double sum_at(const std::vector<uint32_t>& words, uint64_t pixel, uint64_t channel, int exponent) {
  return film_sum(&words[pixel * interface::FILM_WORDS_PER_PIXEL + WORDS_PER_SUM * channel], exponent);
}

template <typename Words, typename AnyFilm>
std::vector<NamedSums<Words>> named_sums(AnyFilm& film) {
  std::vector<NamedSums<Words>> sums = {{"sum", &film.words},
                                        {"splats", &film.splat_words},
                                        {"earlier", &film.earlier_words},
                                        {"squares", &film.square_words}};
  for (auto& layer : film.layers) {
    sums.push_back({layer.name + ".sum", &layer.words});
    sums.push_back({layer.name + ".splats", &layer.splat_words});
  }
  return sums;
}

}  // namespace

std::vector<NamedSums<std::vector<uint32_t>>> sums_of(Film& film) {
  return named_sums<std::vector<uint32_t>>(film);
}

std::vector<NamedSums<const std::vector<uint32_t>>> sums_of(const Film& film) {
  return named_sums<const std::vector<uint32_t>>(film);
}

bool have_same_sums(const Film& a, const Film& b) {
  const auto of_a = sums_of(a), of_b = sums_of(b);
  return a.exponents == b.exponents &&
         std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), [](const auto& x, const auto& y) {
           return x.name == y.name && x.words->empty() == y.words->empty();
         });
}

Film film_of_layer(const Film& film, const LightLayer& layer) {
  Film own;
  own.width = film.width;
  own.height = film.height;
  own.words = layer.words;
  own.paths = film.paths;
  own.splat_words = layer.splat_words;
  own.light_paths = film.light_paths;
  own.light_paths_per_iteration = film.light_paths_per_iteration;
  own.exponents = film.exponents;
  return own;
}

double film_sum(const uint32_t* words, int exponent) {
  if (is_saturated(words)) return std::ldexp(1.0, int{interface::FILM_RANGE_BITS} + exponent);
  const double units = words[0] + std::ldexp(words[1], 32) + std::ldexp(words[2], 64);
  return std::ldexp(units, exponent - int{interface::FILM_FRACTION_BITS});
}

void settle_saturated(std::vector<uint32_t>& words) {
  for (size_t i = 0; i < words.size(); i += WORDS_PER_SUM)
    if (is_saturated(&words[i])) {
      words[i] = words[i + 1] = 0;
      words[i + 2] = interface::FILM_SATURATED;
    }
}

uint64_t count_saturated(const std::vector<uint32_t>& words) {
  uint64_t count = 0;
  for (size_t i = 0; i < words.size(); i += WORDS_PER_SUM) count += is_saturated(&words[i]) ? 1 : 0;
  return count;
}

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
      if (samples > 0) value += sum_at(film.words, pixel, channel, film.exponents.radiance) / samples;
      if (iterations > 0 && !film.splat_words.empty())
        value += sum_at(film.splat_words, pixel, channel, film.exponents.radiance) / iterations;
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
    if (is_saturated(&film.square_words[WORDS_PER_SUM * i])) continue;
    const double sum = sum_at(film.earlier_words, i / 3, i % 3, film.exponents.radiance);
    const double squares = sum_at(film.square_words, i / 3, i % 3, film.exponents.squares);
    const double spread = std::max(squares - sum * sum / samples, 0.0);
    image.rgb[i] = static_cast<float>(spread / (samples * (samples - 1)));
  }
  return image;
}

}  // namespace regulus::render

#include "render/noise.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::render {

namespace {

// A state is compared with an earlier one once it has at least this part more samples (a quarter): fewer new
// samples would say little.
constexpr uint64_t LEAST_SHARE = 4;

}  // namespace

void NoiseEstimate::observe(const Film& film) {
  const uint64_t pixels = uint64_t{film.width} * film.height;
  if (film.paths < pixels || film.paths <= observed_paths_) return;
  observed_paths_ = film.paths;
  const uint64_t more = film.paths - earlier_paths_;
  const bool can_tell = earlier_paths_ != 0 && more >= std::max(pixels, earlier_paths_ / LEAST_SHARE);
  const bool is_kept = film.paths >= 2 * earlier_paths_;
  if (!can_tell && !is_kept) return;
  const image::Image image = resolve(film);
  if (can_tell) {
    const Film earlier{film.width, film.height, {}, earlier_paths_, {}, 0, 1};
    // Dim light is not black: what is lit is about 1 in the film's units.
    const double epsilon = std::ldexp(image::RELATIVE_EPSILON, 2 * std::min(film.exponents.radiance, 0));
    double sum = 0;
    for (uint64_t pixel = 0; pixel < pixels; ++pixel) {
      const auto m = static_cast<double>(earlier.samples(pixel)),
                 n = static_cast<double>(film.samples(pixel));
      for (uint64_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
        const double difference = double{image.rgb[i]} - earlier_image_.rgb[i];
        const double variance = difference * difference * m / (n - m);
        sum += variance / (double{image.rgb[i]} * image.rgb[i] + epsilon);
      }
    }
    estimate_ = std::sqrt(sum / (3.0 * static_cast<double>(pixels)));
    estimated_paths_ = film.paths;
  }
  if (!is_kept) return;
  earlier_paths_ = film.paths;
  earlier_image_ = image;
}

double NoiseEstimate::relative_error() const {
  return estimate_ * std::sqrt(static_cast<double>(estimated_paths_) / static_cast<double>(observed_paths_));
}

}  // namespace regulus::render

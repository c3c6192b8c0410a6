#include "render/noise.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::render {

void NoiseEstimate::observe(const Film& film) {
  const uint64_t pixels = uint64_t{film.width} * film.height;
  if (film.paths < pixels || film.paths <= earlier_paths_) return;
  const image::Image image = resolve(film);
  if (earlier_paths_ != 0) {
    const Film earlier{film.width, film.height, {}, earlier_paths_, {}, 0, 1};
    // Dim light is not black: what is lit is about 1 in the film's units.
    const double epsilon = std::ldexp(image::RELATIVE_EPSILON, 2 * std::min(film.exponents.radiance, 0));
    double sum = 0;
    uint64_t count = 0;
    for (uint64_t pixel = 0; pixel < pixels; ++pixel) {
      const auto m = static_cast<double>(earlier.samples(pixel)),
                 n = static_cast<double>(film.samples(pixel));
      if (n <= m) continue;  // the last sample of this pixel is still to come
      for (uint64_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
        const double difference = double{image.rgb[i]} - earlier_image_.rgb[i];
        const double variance = difference * difference * m / (n - m);
        sum += variance / (double{image.rgb[i]} * image.rgb[i] + epsilon);
        ++count;
      }
    }
    if (count > 0) relative_error_ = std::sqrt(sum / static_cast<double>(count));
  }
  if (film.paths < 2 * earlier_paths_) return;
  earlier_paths_ = film.paths;
  earlier_image_ = image;
}

}  // namespace regulus::render

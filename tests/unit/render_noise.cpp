// The noise estimate against films whose noise is known, because the samples are drawn here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "interface/wavefront.h"
#include "render/noise.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

/// A film that grows by samples of independent numbers, uniform in [0, 2) times `brightness`.
class NoisyFilm {
 public:
  static constexpr uint32_t WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT;

  NoisyFilm(float brightness, uint64_t stream) : brightness_(brightness), random_(stream) {
    film_.width = WIDTH;
    film_.height = HEIGHT;
    film_.words.resize(size_t{PIXELS} * interface::FILM_WORDS_PER_PIXEL);
  }

  /// One more sample of the first `pixels` pixels that have the fewest.
  const render::Film& grow(uint64_t paths) {
    for (; paths > 0; --paths, ++film_.paths) {
      uint32_t* words = &film_.words[film_.paths % PIXELS * interface::FILM_WORDS_PER_PIXEL];
      for (int channel = 0; channel < 3; ++channel, words += 3) {
        const auto units = static_cast<uint64_t>(
            std::ldexp(2 * brightness_ * random_.uniform(), interface::FILM_FRACTION_BITS));
        const uint64_t sum = (words[0] | uint64_t{words[1]} << 32) + units;
        words[0] = static_cast<uint32_t>(sum);
        words[1] = static_cast<uint32_t>(sum >> 32);
      }
    }
    return film_;
  }

 private:
  double brightness_;
  Random random_;
  render::Film film_;
};

// A sample has variance b^2 / 3. With n samples of mean b, the mean of (T - b)^2 / (T^2 + 0.01) is close to
// b^2 / (3 n (b^2 + 0.01)); the estimate has one degree of freedom per value, so its square errs by sqrt(2 /
// values).
TEST(NoiseEstimate, FindsTheNoiseOfIndependentSamples) {
  constexpr double VALUES = 3.0 * NoisyFilm::PIXELS;
  for (const float brightness : {0.01f, 1.0f, 50.0f}) {
    NoisyFilm film(brightness, 71);
    render::NoiseEstimate noise;
    uint64_t samples = 16;
    noise.observe(film.grow(samples * NoisyFilm::PIXELS));
    EXPECT_TRUE(std::isnan(noise.relative_error())) << "one state says nothing";
    for (const uint64_t more : {8, 16, 24, 64}) {
      noise.observe(film.grow(more * NoisyFilm::PIXELS));
      samples += more;
      const double squared = double{brightness} * brightness;
      const double known = squared / (3 * static_cast<double>(samples) * (squared + 0.01));
      const double estimate = noise.relative_error() * noise.relative_error();
      // Five standard errors, and what the noise in T^2 shifts the quotient by: up to 3 variances of T over
      // b^2.
      const double bound = known * (5 * std::sqrt(2 / VALUES) + 1.0 / static_cast<double>(samples));
      std::printf("brightness %g, %2llu samples: %.4g, known %.4g (bound of the difference %.2g)\n",
                  brightness, static_cast<unsigned long long>(samples), estimate, known, bound);
      EXPECT_NEAR(estimate, known, bound);
    }
  }
}

// A hundred more samples say little of the other pixels: the estimate follows the number of samples alone.
TEST(NoiseEstimate, AFewMoreSamplesAreNoNewEstimate) {
  NoisyFilm film(1, 73);
  render::NoiseEstimate noise;
  noise.observe(film.grow(16 * NoisyFilm::PIXELS));
  noise.observe(film.grow(16 * NoisyFilm::PIXELS));
  const double before = noise.relative_error();
  for (uint64_t paths = 100; paths < 4 * NoisyFilm::PIXELS; paths *= 2) {
    noise.observe(film.grow(paths));
    const double share =
        32.0 * NoisyFilm::PIXELS / (32.0 * NoisyFilm::PIXELS + 2 * static_cast<double>(paths) - 100);
    EXPECT_NEAR(noise.relative_error(), before * std::sqrt(share), 1e-9) << paths;
  }
}

TEST(NoiseEstimate, PartSamplesCountWhereTheyAre) {
  NoisyFilm film(1, 72);
  render::NoiseEstimate noise;
  noise.observe(film.grow(8 * NoisyFilm::PIXELS + 100));
  noise.observe(film.grow(8 * NoisyFilm::PIXELS));  // 16 samples, and 17 of the first hundred pixels
  const double known = 1 / (3 * 16.0 * 1.01);
  const double estimate = noise.relative_error() * noise.relative_error();
  EXPECT_NEAR(estimate, known, known * (5 * std::sqrt(2 / (3.0 * NoisyFilm::PIXELS)) + 1.0 / 16));
}

TEST(NoiseEstimate, IsUnknownBeforeEveryPixelHasTwoSamples) {
  NoisyFilm film(1, 73);
  render::NoiseEstimate noise;
  noise.observe(film.grow(NoisyFilm::PIXELS / 2));
  noise.observe(film.grow(NoisyFilm::PIXELS / 2));
  EXPECT_TRUE(std::isnan(noise.relative_error()));
  noise.observe(film.grow(0));
  EXPECT_TRUE(std::isnan(noise.relative_error())) << "the same state twice";
  noise.observe(film.grow(NoisyFilm::PIXELS));
  EXPECT_GT(noise.relative_error(), 0.0);
}

}  // namespace
}  // namespace regulus::test

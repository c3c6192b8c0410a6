// HDR-FLIP against the program of its authors, and at the edges of what it is defined for.
#include <cmath>
#include <cstdio>
#include <limits>

#include "image_files.hpp"

namespace regulus::test {
namespace {

/// PCG's output permutation of one step (O'Neill 2014), 24 bits: numbers that any language gives alike.
double noise(uint32_t i) {
  i = i * 747796405u + 2891336453u;
  const uint32_t word = ((i >> ((i >> 28) + 4)) ^ i) * 277803737u;
  return ((word >> 22 ^ word) >> 8) * 0x1p-24;
}

struct Pair {
  image::Image image, reference;
};

/// Ramps with edges, every seventh block of 8 x 8 pixels 200 times brighter; the image is the reference times
/// 0.5 to 1.5 and up to 0.1 more.
Pair make_pair(uint32_t width, uint32_t height, double scale) {
  Pair pair{{width, height, {}}, {width, height, {}}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (uint32_t c = 0; c < 3; ++c) {
        const uint32_t i = (y * width + x) * 3 + c;
        const double light = (x / 8 + y / 8) % 7 == 0 ? 200 : 1;
        const double value = (0.02 + (x * (c + 1) + 2 * y) % 64 / 64.0) * light * scale;
        pair.reference.rgb.push_back(static_cast<float>(value));
        pair.image.rgb.push_back(
            static_cast<float>(value * (0.5 + noise(i + 1000003)) + 0.1 * scale * noise(i)));
      }
  return pair;
}

// What flip-evaluator 1.7 of the authors (PyPI; evaluate(reference, image, "HDR", applyMagma=False)) gives
// for these images: the mean, and three pixels of the map. Both programs work in float; a pixel's error is a
// power down to 0.3 of differences of CIELAB coordinates of up to 100, which are right to about 1e-5.
TEST(Flip, AgreesWithTheProgramOfItsAuthors) {
  constexpr double TOLERANCE = 2e-5;
  struct Known {
    uint32_t width, height;
    double scale, mean, first, inner, last;  // first pixel, (13, 7), last pixel
  };
  constexpr Known KNOWN[] = {
      {96, 64, 1, 0.2380150407552719, 0.24304871261119843, 0.17819710075855255, 0.42678365111351013},
      {40, 50, 0.01, 0.24576202034950256, 0.35046809911727905, 0.3171732425689697, 0.3524562418460846},
      {64, 16, 1000, 0.22894372045993805, 0.31928595900535583, 0.257171630859375, 0.24719619750976562}};
  for (const Known& known : KNOWN) {
    const Pair pair = make_pair(known.width, known.height, known.scale);
    const std::vector<float> map = image::flip_map(pair.image, pair.reference);
    const double mean = image::flip(pair.image, pair.reference);
    const double inner = map[7 * known.width + 13];
    std::printf("%u x %u: mean %.7f (off by %.1e), pixels off by %.1e %.1e %.1e, bound %.0e\n", known.width,
                known.height, mean, mean - known.mean, map.front() - known.first, inner - known.inner,
                map.back() - known.last, TOLERANCE);
    EXPECT_NEAR(mean, known.mean, TOLERANCE);
    EXPECT_NEAR(map.front(), known.first, TOLERANCE);
    EXPECT_NEAR(inner, known.inner, TOLERANCE);
    EXPECT_NEAR(map.back(), known.last, TOLERANCE);
  }
}

TEST(Flip, IsZeroForEqualImagesAndOneAtMost) {
  const Pair pair = make_pair(33, 17, 1);
  EXPECT_EQ(image::flip(pair.reference, pair.reference), 0);
  const image::Image green = make_image(16, 16, [](size_t i) { return i % 3 == 1 ? 1000.0f : 0.0f; });
  const image::Image blue = make_image(16, 16, [](size_t i) { return i % 3 == 2 ? 1000.0f : 0.0f; });
  const double largest = image::flip(green, blue);
  // The two colours furthest apart, up to what the tone mapper leaves below 1.
  EXPECT_GT(largest, 0.95);
  EXPECT_LE(largest, 1 + 1e-6);
}

TEST(Flip, IsDefinedForBlackAndForNonFiniteValues) {
  constexpr float INFINITE = std::numeric_limits<float>::infinity();
  const auto of = [](float value) { return make_image(5, 3, [value](size_t) { return value; }); };
  const image::Image mostly_black = make_image(5, 3, [](size_t i) { return i < 6 ? 1.0f : 0.0f; });
  for (const image::Image& reference :
       {of(0), of(-1), of(1e-38f), of(3e38f), of(INFINITE), of(-INFINITE), of(NAN), mostly_black})
    for (const image::Image& image : {of(0), of(1), of(-1), of(3e38f), of(INFINITE), of(NAN), mostly_black}) {
      const double error = image::flip(image, reference);
      EXPECT_TRUE(error >= 0 && error <= 1 + 1e-6) << error;
    }
  EXPECT_EQ(image::flip(of(NAN), of(0)), 0) << "what is not finite is seen as black";
  EXPECT_GT(image::flip(mostly_black, of(0)), 0.1);
}

TEST(Flip, DifferentSizesAreAnError) {
  const auto one = [](size_t) { return 1.0f; };
  expect_error([&] { image::flip(make_image(2, 3, one), make_image(3, 2, one)); }, ErrorCode::BadFile,
               "2 x 3 pixels against a reference of 3 x 2");
}

}  // namespace
}  // namespace regulus::test

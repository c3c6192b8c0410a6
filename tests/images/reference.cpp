// cornell-box of the shared assets against Bitterli's converged Tungsten render.
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using image::Image;

// Both pictures in blocks of 16 pixels of the 1024 x 1024 reference: a box filter over a film of 64 x 64,
// which leaves nothing of the reference's own pixel filter but in blocks at the light's edge.
constexpr uint32_t SIZE = 64, BLOCK = 16;

// Mean over all values of (a - r)(b - r) / (r^2 + 0.01). With a = b the relMSE. With a and b independent
// their noise drops out and what is left is the square of what both have in common: the reference's own
// error, and any bias.
double shared_error(const Image& a, const Image& b, const Image& reference) {
  double sum = 0;
  for (size_t i = 0; i < reference.rgb.size(); ++i) {
    const double r = reference.rgb[i];
    sum += (a.rgb[i] - r) * (b.rgb[i] - r) / (r * r + 0.01);
  }
  return sum / static_cast<double>(reference.rgb.size());
}

double mean_shared_error(const std::vector<Image>& images, const Image& reference) {
  double sum = 0;
  for (size_t i = 0; i < images.size(); ++i)
    for (size_t k = 0; k < i; ++k) sum += shared_error(images[i], images[k], reference);
  return sum / (static_cast<double>(images.size() * (images.size() - 1)) / 2);
}

double mean_relmse(const std::vector<Image>& images, const Image& reference) {
  double sum = 0;
  for (const Image& image : images) sum += shared_error(image, image, reference);
  return sum / static_cast<double>(images.size());
}

class Reference : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    scene_file_ = assets() / "scenes" / "cornell-box.glb";
    reference_file_ = assets() / "reference" / "cornell-box.tungsten.exr";
    if (!std::filesystem::exists(scene_file_) || !std::filesystem::exists(reference_file_))
      GTEST_SKIP() << "the shared assets are absent";
  }
  std::filesystem::path scene_file_, reference_file_;
};

// The reference was rendered without a limit on depth; 64 edges leave less than 1e-4 of the light out (the
// walls reflect 0.73 at most, and roulette ends paths long before).
TEST_F(Reference, CornellBoxErrorFallsAsOneOverSamplesToTheReferencesOwn) {
  const Image reference = downsampled(image::read_exr(reference_file_), BLOCK);
  ASSERT_EQ(reference.width, SIZE);
  ASSERT_EQ(reference.height, SIZE);
  const PreparedScene scene = prepare(scene_file_);
  // Independent renders of 4, 16 and 64 samples.
  const int batches = is_slow_device() ? 2 : 4;
  const auto curve = [&](uint32_t samples, uint32_t stream) {
    return render_batches(scene, box_filtered(SIZE, SIZE, samples, 64), batches, stream);
  };
  const auto at_4 = curve(4, 1), at_16 = curve(16, 2), at_64 = curve(64, 3);
  const double floor = mean_shared_error(at_64, reference);
  const double error[] = {mean_relmse(at_4, reference), mean_relmse(at_16, reference),
                          mean_relmse(at_64, reference)};
  std::printf(
      "relMSE at 4, 16, 64 samples: %.5f %.5f %.5f; common to independent renders (reference, bias): %.6f\n",
      error[0], error[1], error[2], floor);
  const double first = (error[0] - floor) / (error[1] - floor),
               second = (error[1] - floor) / (error[2] - floor);
  std::printf("falls by %.2f and %.2f for four times the samples\n", first, second);
  // Each relMSE averages 12288 values per batch, correlated in threes, of squares whose own relative
  // deviation is a few: 5 % of it at most; twice that for the ratio of two. Tested against a fifth.
  EXPECT_NEAR(first, 4, 0.8);
  EXPECT_NEAR(second, 4, 0.8);
}

// 4.2 million samples, over pixels of the reference's fourth part, so that the jitter over the light's edge
// weighs little: a standard error near 0.1 % of the mean, which the bound exceeds fivefold.
TEST_F(Reference, CornellBoxHasTungstensMean) {
  constexpr uint32_t FILM = 256;
  constexpr double BOUND = 0.005;
  const int batches = is_slow_device() ? 2 : 4;
  const auto images = render_batches(prepare(scene_file_), box_filtered(FILM, FILM, 16, 64), batches, 4);
  const std::array<double, 3> known = mean_of(image::read_exr(reference_file_));
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0, squared_error = 0;
    for (const Image& image : images) mean += mean_of(image)[c] / batches;
    for (const Image& image : images)
      squared_error += std::pow(mean_of(image)[c] - mean, 2) / (batches * (batches - 1));
    std::printf("channel %zu: mean %.5f, Tungsten %.5f, ratio %.4f +- %.4f (bound %g)\n", c, mean, known[c],
                mean / known[c], std::sqrt(squared_error) / known[c], BOUND);
    EXPECT_NEAR(mean / known[c], 1, BOUND);
  }
}

}  // namespace
}  // namespace regulus::test

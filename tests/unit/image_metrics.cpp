// Metrics against values computed by hand, and against OpenImageIO's idiff and oiiotool where they are
// installed.
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <sstream>
#include <tuple>
#include <utility>

#include "image/comparison.hpp"
#include "image_files.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();
constexpr float INFINITE = std::numeric_limits<float>::infinity();
/// Sums of a few exact terms in double.
constexpr double TOLERANCE = 1e-14;

TEST(Metrics, AgreeWithHandComputedValues) {
  const image::Image image{2, 1, {1, 2, 4, 0, 0, 0.5f}};
  const image::Image reference{2, 1, {1, 1, 1, 0, 1, 0.5f}};
  const image::Metrics metrics = image::compare(image, reference);
  // Squared errors 0, 1, 9 and 0, 1, 0; pixel means 1 and 0.5.
  EXPECT_NEAR(metrics.mse, 11.0 / 6, TOLERANCE);
  EXPECT_NEAR(metrics.mae, 5.0 / 6, TOLERANCE);
  EXPECT_NEAR(metrics.relmse, (1 / 1.01 + 9 / 1.01 + 1 / 1.01) / 6, TOLERANCE);
  EXPECT_NEAR(metrics.mrse, (10 / 1.01 + 1 / 0.26) / 6, TOLERANCE);
  EXPECT_NEAR(metrics.psnr, 10 * std::log10(6.0 / 11), TOLERANCE * 10);
  EXPECT_EQ(metrics.mean, (std::array<double, 3>{0.5, 1, 2.25}));
  EXPECT_EQ(metrics.reference_mean, (std::array<double, 3>{0.5, 1, 0.75}));
  EXPECT_EQ(metrics.non_finite, 0u);
  EXPECT_NEAR(metrics.trimmed_relmse, metrics.relmse, TOLERANCE) << "two pixels have no worst thousandth";
}

// Of 2000 pixels the two worst are left out, and not the third one.
TEST(Metrics, TrimmedErrorLeavesOutTheWorstThousandth) {
  const image::Image reference = make_image(50, 40, [](size_t) { return 0.0f; });
  const image::Metrics metrics = image::compare(
      make_image(50, 40, [](size_t i) { return i / 3 % 1000 == 7 ? 1e6f
                                               : i / 3 == 8      ? 1.0f
                                                                 : 0.1f; }),
      reference);
  EXPECT_NEAR(metrics.trimmed_relmse, (100 + 1997 * double{0.1f} * 0.1f / 0.01) / 1998, 1e-5);
}

TEST(Metrics, EqualImagesHaveNoErrorAndInfinitePsnr) {
  const image::Image image = make_image(5, 4, [](size_t i) { return static_cast<float>(i); });
  const image::Metrics metrics = image::compare(image, image);
  EXPECT_EQ(metrics.mse, 0);
  EXPECT_EQ(metrics.mrse, 0);
  EXPECT_EQ(metrics.psnr, std::numeric_limits<double>::infinity());
}

TEST(Metrics, NonFiniteValuesAreCountedAndLeftOut) {
  const image::Image image{2, 1, {NOT_A_NUMBER, 3, 2, INFINITE, 5, 1}};
  const image::Image reference{2, 1, {1, 1, 2, -INFINITE, NOT_A_NUMBER, 1}};
  const image::Metrics metrics = image::compare(image, reference);
  EXPECT_EQ(metrics.non_finite, 4u);
  // Left: (3, 1), (2, 2), (1, 1); the reference's first pixel has mean 4/3, its second has none.
  EXPECT_NEAR(metrics.mse, 4.0 / 3, TOLERANCE);
  EXPECT_NEAR(metrics.mrse, 4 / (16.0 / 9 + 0.01) / 3, TOLERANCE);
  EXPECT_TRUE(std::isnan(metrics.mean[0])) << "no finite value of red";
  EXPECT_NEAR(metrics.mean[1], 3, TOLERANCE);
  EXPECT_NEAR(metrics.mean[2], 1.5, TOLERANCE);
}

TEST(Metrics, DifferentSizesAreAnError) {
  const auto one = [](size_t) { return 1.0f; };
  expect_error([&] { image::compare(make_image(2, 3, one), make_image(3, 2, one)); }, ErrorCode::BadFile,
               "2 x 3 pixels against a reference of 3 x 2");
}

/// Value after `label` in a program's output; NaN if absent.
double value_after(const std::string& text, const std::string& label) {
  const size_t at = text.find(label);
  return at == std::string::npos ? NOT_A_NUMBER : std::strtod(text.c_str() + at + label.size(), nullptr);
}

/// What a command prints.
std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  for (int c; (c = std::fgetc(pipe)) != EOF;) output.push_back(static_cast<char>(c));
  ::pclose(pipe);
  return output;
}

// Quantiles of Student's t from the tables (two-sided 5 %, and 0.1 % for 8 degrees of freedom).
TEST(Comparison, StudentsTHasItsQuantiles) {
  for (const auto& [degrees, t, p] : {std::tuple{1, 12.706205, 0.05},
                                      {2, 4.302653, 0.05},
                                      {3, 3.182446, 0.05},
                                      {8, 2.306004, 0.05},
                                      {8, 5.041305, 0.001},
                                      {15, 2.131450, 0.05},
                                      {16, 2.119905, 0.05}})
    EXPECT_NEAR(image::student_two_sided(t, degrees), p, 1e-6 * p + 1e-8) << degrees;
}

// Two batches, 1 and 3, against 0: a mean of 2 with a standard error of 1, and one degree of freedom, whose
// distribution is Cauchy's: 1 - 2 atan(2) / pi.
TEST(Comparison, BatchesHaveOneDegreeOfFreedomLess) {
  const auto pixel = [](float value) { return image::Image{1, 1, {value, value, value}}; };
  image::ComparisonOptions options;
  options.tile = 1;
  options.relative_tolerance = 0;
  const image::TileTest test = image::test_against({pixel(1), pixel(3)}, pixel(0), options);
  EXPECT_NEAR(test.worst_p, 1 - 2 / std::numbers::pi * std::atan(2.0), 1e-9);
  const image::TileTest equal = image::test_equal({pixel(1), pixel(3)}, {pixel(0), pixel(0)}, options);
  EXPECT_NEAR(equal.worst_p, 1 - 2 / std::numbers::pi * std::atan(2.0), 1e-9);
}

// Of 400 comparisons of equal sets at a false-alarm rate of 5 %, 20 raise one, give or take 4.4; and sets
// that differ by five standard errors of the whole image are told apart.
TEST(Comparison, RaisesFalseAlarmsAtItsRateAndSeesADifference) {
  constexpr int REPETITIONS = 400, BATCHES = 8;
  Random random(6);
  const auto batches = [&](double offset) {
    std::vector<image::Image> images;
    for (int i = 0; i < BATCHES; ++i)
      images.push_back(make_image(6, 4, [&](size_t) {
        double sum = offset;  // nearly normal, variance 1
        for (int k = 0; k < 12; ++k) sum += random.uniform() - 0.5;
        return static_cast<float>(sum + 10);
      }));
    return images;
  };
  image::ComparisonOptions options;
  options.false_alarm_rate = 0.05;
  options.tile = 2;
  int alarms = 0;
  for (int i = 0; i < REPETITIONS; ++i)
    alarms += image::test_equal(batches(0), batches(0), options).is_passed() ? 0 : 1;
  std::printf("%d false alarms of %d (expected at most %g)\n", alarms, REPETITIONS, 0.05 * REPETITIONS);
  // n - 1 degrees of freedom where Welch's formula has nearly 2 (n - 1): fewer alarms than asked for.
  EXPECT_LE(alarms, 0.05 * REPETITIONS + 4 * 4.4);
  options.tile = 6;
  EXPECT_FALSE(image::test_equal(batches(0), batches(0.55), options).is_passed());
}

/// What settles the alarms of two sets of 9 batches of a pixel, drawn with more samples each by `first` and
/// `second`.
template <typename First, typename Second>
image::Settled settled(const image::Alarm& alarm, const First& first, const Second& second,
                       const image::ComparisonOptions& options = {}) {
  const auto batches_of = [](const auto& draw, uint32_t samples) {
    std::vector<image::Image> images;
    for (int i = 0; i < 9; ++i)
      images.push_back(make_image(1, 1, [&](size_t) {
        double sum = 0;
        for (uint32_t k = 0; k < samples; ++k) sum += draw() / samples;
        return static_cast<float>(sum);
      }));
    return images;
  };
  return image::settle(
      {alarm},
      [&](uint32_t times) {
        return std::pair(batches_of(first, 16 * times), batches_of(second, 16 * times));
      },
      options);
}

// Rare bright values: batches without any beside batches with one differ by chance, and look sure of it. A
// bias of the size of the same alarm stays.
TEST(Comparison, MoreSamplesConfirmABiasAndWithdrawAFluke) {
  Random random(7);
  const auto rare = [&] { return random.uniform() < 1.0 / 256 ? 256.0 : random.uniform(); };
  int withdrawn = 0;
  for (int i = 0; i < 20; ++i) {
    const image::Settled fluke = settled({1, 0, 0, 0, 16}, rare, rare);
    EXPECT_TRUE(fluke.confirmed.empty());
    withdrawn += static_cast<int>(fluke.withdrawn.size());
    EXPECT_EQ(settled(
                  {1, 0, 0, 0, 16}, [&] { return rare() + 16; }, rare)
                  .confirmed.size(),
              1);
    // To the other side it is another finding than the one that is to be settled.
    EXPECT_TRUE(settled(
                    {1, 0, 0, 0, -16}, [&] { return rare() + 16; }, rare)
                    .confirmed.empty());
  }
  std::printf("%d of 20 flukes withdrawn\n", withdrawn);
  EXPECT_EQ(withdrawn, 20);
}

// One set meets a light of 10,000 with every tenth sample by a weight of a thousandth, the other as it is,
// once in 100,000 samples: it never does here, and looks sure. That is no difference, unless light can be
// no brighter than 10.
TEST(Comparison, LightThatASetHasNotMetYetConfirmsNothing) {
  Random random(8);
  const auto often = [&] { return random.uniform() < 0.1 ? 1.0 : 0.01 * random.uniform(); };
  const auto hardly = [&] { return 0.01 * random.uniform(); };
  image::ComparisonOptions options;
  options.samples = 9 * 16;
  options.brightest = 1e4;
  const image::Settled fluke = settled({1, 0, 0, 0, 0.1}, often, hardly, options);
  EXPECT_TRUE(fluke.confirmed.empty());
  EXPECT_TRUE(fluke.is_undecided());
  options.brightest = 10;
  EXPECT_EQ(settled({1, 0, 0, 0, 0.1}, often, hardly, options).confirmed.size(), 1);
}

// Of a sun, or of merges, nobody knows how bright a sample can be. Here the second set meets with one of
// 10,000 samples what the first one meets as a tenth of it each time, and never in the first pixel; but in
// others, which says how bright what it lacks there may be.
TEST(Comparison, LightMetElsewhereCanHideInAPixelThatNeverMetIt) {
  constexpr uint32_t PIXELS = 64, SAMPLES = 16;
  Random random(9);
  const auto batches_of = [&](uint32_t samples, double value, double probability, double value_of_the_first) {
    std::vector<image::Image> images;
    for (int i = 0; i < 9; ++i)
      images.push_back(make_image(PIXELS, 1, [&](size_t index) {
        if (index < 3) return static_cast<float>(value_of_the_first + 1e-3 * random.uniform());
        double sum = 0;
        for (uint32_t k = 0; k < samples; ++k) sum += random.uniform() < probability ? value / samples : 0;
        return static_cast<float>(sum);
      }));
    return images;
  };
  const auto settled_against = [&](double value, double probability) {
    image::ComparisonOptions options;
    options.samples = 9 * SAMPLES;
    return image::settle(
        {{1, 0, 0, 0, 0.1}},
        [&](uint32_t times) {
          return std::pair(batches_of(SAMPLES * times, 0.1, 1, 0.1),
                           batches_of(SAMPLES * times, value, probability, 0));
        },
        options);
  };
  EXPECT_TRUE(settled_against(1e3, 1e-4).is_undecided());
  EXPECT_EQ(settled_against(0.2, 0.5).confirmed.size(), 1);
}

// 0.9999 quantiles by the table: of one degree of freedom 1 / tan(pi p / 2), of two sqrt(2 / (p (2 - p)) -
// 2).
TEST(Comparison, FewBatchesRaiseNoAlarm) {
  EXPECT_NEAR(image::standard_errors_of_alarm(2, 1, 1e-4) / (2 / (std::numbers::pi * 1e-4)), 1, 1e-6);
  EXPECT_NEAR(image::standard_errors_of_alarm(3, 1, 1e-4), std::sqrt(2 / (1e-4 * (2 - 1e-4)) - 2), 1e-4);
}

TEST(Metrics, AgreeWithOpenImageIo) {
  if (std::system("command -v idiff oiiotool >/dev/null") != 0)
    GTEST_SKIP() << "openimageio-tools is missing";
  const TemporaryFolder folder;
  Random random(5);
  const auto draw = [&](size_t) { return static_cast<float>(random.uniform()); };
  const image::Image image = make_image(64, 48, draw);
  image::Image reference = make_image(64, 48, draw);
  reference.rgb[17] = 1;  // the peak of idiff's PSNR
  image::write_exr(folder / "a.exr", image);
  image::write_exr(folder / "b.exr", reference);
  const std::string a = (folder / "a.exr").string(), b = (folder / "b.exr").string();
  const std::string output = output_of("idiff -v " + a + " " + b);
  const image::Metrics metrics = image::compare(image, reference);
  // idiff prints six digits, and of the PSNR too.
  EXPECT_NEAR(value_after(output, "Mean error ="), metrics.mae, 1e-5 * metrics.mae) << output;
  EXPECT_NEAR(value_after(output, "RMS error ="), std::sqrt(metrics.mse), 1e-5) << output;
  EXPECT_NEAR(value_after(output, "Peak SNR ="), metrics.psnr, 1e-5 * metrics.psnr) << output;
  // oiiotool: "Stats Avg: r g b (float)", six decimals.
  for (const auto& [file, mean] : {std::pair(a, metrics.mean), std::pair(b, metrics.reference_mean)}) {
    const std::string statistics = output_of("oiiotool --stats " + file);
    const size_t at = statistics.find("Stats Avg:");
    ASSERT_NE(at, std::string::npos) << statistics;
    std::istringstream stream(statistics.substr(at + 10));
    for (size_t c = 0; c < 3; ++c) {
      double value = NOT_A_NUMBER;
      stream >> value;
      EXPECT_NEAR(value, mean[c], 1e-6) << statistics;
    }
  }
}

}  // namespace
}  // namespace regulus::test

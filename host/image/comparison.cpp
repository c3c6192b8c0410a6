#include "image/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace regulus::image {

double tile_mean(const Image& image, uint32_t tile_x, uint32_t tile_y, uint32_t tile, uint32_t channel) {
  double sum = 0;
  int count = 0;
  for (uint32_t y = tile_y * tile; y < std::min((tile_y + 1) * tile, image.height); ++y)
    for (uint32_t x = tile_x * tile; x < std::min((tile_x + 1) * tile, image.width); ++x, ++count)
      sum += image.rgb[3 * (size_t{y} * image.width + x) + channel];
  return sum / count;
}

namespace {

struct Estimate {
  double mean = 0, squared_error = 0;  // of the mean
};

Estimate estimate(const std::vector<Image>& batches, uint32_t x, uint32_t y, uint32_t tile,
                  uint32_t channel) {
  const auto count = static_cast<double>(batches.size());
  std::vector<double> values;
  values.reserve(batches.size());
  Estimate result;
  for (const Image& batch : batches) values.push_back(tile_mean(batch, x, y, tile, channel));
  for (const double value : values) result.mean += value / count;
  for (const double value : values)
    result.squared_error += (value - result.mean) * (value - result.mean) / (count * (count - 1));
  return result;
}

/// Of a difference, less what is tolerated, with this standard error.
double p_value(double excess, double error, int degrees_of_freedom) {
  if (!(excess > 0)) return 1;
  return error == 0 ? 0 : student_two_sided(excess / error, degrees_of_freedom);
}

// Calls difference(x, y, channel) -> {difference, squared error, magnitude} for every tile and keeps the
// worst.
struct Difference {
  double value, squared_error, magnitude;
};

template <typename Function>
TileTest test_tiles(uint32_t width, uint32_t height, int degrees_of_freedom, const ComparisonOptions& options,
                    const Function& difference) {
  TileTest result;
  const auto tiles_over = [&](uint32_t pixels) { return (pixels + options.tile - 1) / options.tile; };
  const auto tests = static_cast<int>(3 * tiles_over(width) * tiles_over(height));
  const double bound = significance_per_test(options.false_alarm_rate, tests);
  for (uint32_t y = 0; y * options.tile < height; ++y)
    for (uint32_t x = 0; x * options.tile < width; ++x)
      for (uint32_t channel = 0; channel < 3; ++channel) {
        const Difference d = difference(x, y, channel);
        const double excess = std::max(0.0, std::abs(d.value) - options.relative_tolerance * d.magnitude);
        const double error = std::sqrt(d.squared_error);
        const double p = p_value(excess, error, degrees_of_freedom);
        ++result.tests;
        if (p < bound) result.alarms.push_back({options.tile, x, y, channel, d.value});
        if (p <= result.worst_p) {
          result.worst_p = p;
          result.worst_difference = d.value;
          result.worst_error = error;
          result.worst_x = x, result.worst_y = y, result.worst_channel = channel;
        }
      }
  result.bound = bound;
  return result;
}

}  // namespace

double significance_per_test(double family_rate, int tests) {
  return -std::expm1(std::log1p(-family_rate) / tests);
}

double student_two_sided(double t, int degrees_of_freedom) {
  const double theta = std::atan(std::abs(t) / std::sqrt(degrees_of_freedom));
  const double cosine_squared = std::cos(theta) * std::cos(theta);
  const bool is_odd = degrees_of_freedom % 2 != 0;
  // A(t|n), the probability of |T| <= |t|: a sum of n / 2 terms, for odd n beside an angle.
  double term = is_odd ? std::cos(theta) : 1;
  double sum = degrees_of_freedom > 1 ? term : 0;
  for (int k = is_odd ? 3 : 2; k < degrees_of_freedom; k += 2) {
    term *= cosine_squared * (k - 1) / k;
    sum += term;
  }
  const double inside = std::sin(theta) * sum;
  return std::max(0.0, 1 - (is_odd ? 2 / std::numbers::pi * (theta + inside) : inside));
}

TileTest test_against(const std::vector<Image>& batches, const Image& known,
                      const ComparisonOptions& options) {
  return test_tiles(known.width, known.height, static_cast<int>(batches.size()) - 1, options,
                    [&](uint32_t x, uint32_t y, uint32_t channel) {
                      const Estimate found = estimate(batches, x, y, options.tile, channel);
                      const double value = tile_mean(known, x, y, options.tile, channel);
                      return Difference{found.mean - value, found.squared_error, std::abs(value)};
                    });
}

TileTest test_equal(const std::vector<Image>& first, const std::vector<Image>& second,
                    const ComparisonOptions& options) {
  return test_tiles(first[0].width, first[0].height, static_cast<int>(first.size()) - 1, options,
                    [&](uint32_t x, uint32_t y, uint32_t channel) {
                      const Estimate a = estimate(first, x, y, options.tile, channel);
                      const Estimate b = estimate(second, x, y, options.tile, channel);
                      return Difference{a.mean - b.mean, a.squared_error + b.squared_error, std::abs(b.mean)};
                    });
}

namespace {

enum class Finding { Confirmed, Withdrawn, Open };

/// A bound of the greatest sample in batches of so many samples a pixel: had all others of its batch been
/// worth the pixel's mean, it would be what the batch has above it.
double brightest_met(const std::vector<Image>& batches, double samples_of_a_batch) {
  double brightest = 0;
  for (size_t i = 0; i < batches[0].rgb.size(); ++i) {
    double sum = 0, largest = 0;
    for (const Image& batch : batches) {
      sum += batch.rgb[i];
      largest = std::max<double>(largest, batch.rgb[i]);
    }
    const double mean = sum / static_cast<double>(batches.size());
    brightest = std::max(brightest, mean + (largest - mean) * samples_of_a_batch);
  }
  return brightest;
}

/// The most that a pixel can hold of light that is at most `brightest`, and that not one of `samples` has met
/// with the probability `level`.
double hidden_light(double brightest, double samples, double level) {
  return brightest * -std::log(level) / samples;
}

Finding finding(const Alarm& alarm, const std::vector<Image>& first, const std::vector<Image>& second,
                double level, double allowed, double relative_tolerance) {
  const Estimate a = estimate(first, alarm.x, alarm.y, alarm.tile, alarm.channel);
  const Estimate b = estimate(second, alarm.x, alarm.y, alarm.tile, alarm.channel);
  const double error = std::sqrt(a.squared_error + b.squared_error);
  const double towards = (a.mean - b.mean) * (alarm.difference < 0 ? -1 : 1);
  const int degrees_of_freedom = static_cast<int>(first.size()) - 1;
  if (p_value(towards - allowed - relative_tolerance * std::abs(b.mean), error, degrees_of_freedom) < level)
    return Finding::Confirmed;
  const double missing = 0.5 * std::abs(alarm.difference) - towards;
  return p_value(missing, error, degrees_of_freedom) < level ? Finding::Withdrawn : Finding::Open;
}

}  // namespace

Settled settle(std::vector<Alarm> alarms, const FreshBatches& fresh, const ComparisonOptions& options) {
  constexpr uint32_t ROUNDS = 3;
  const double level =
      significance_per_test(options.false_alarm_rate, static_cast<int>(ROUNDS * alarms.size()));
  Settled settled;
  settled.open = std::move(alarms);
  for (uint32_t round = 0; round < ROUNDS && !settled.open.empty(); ++round) {
    settled.times *= 4;
    const auto [first, second] = fresh(settled.times);
    const double samples = static_cast<double>(options.samples) * settled.times;
    const double samples_of_a_batch = samples / static_cast<double>(first.size());
    const double brightest = std::max({options.brightest, brightest_met(first, samples_of_a_batch),
                                       brightest_met(second, samples_of_a_batch)});
    for (const Alarm& alarm : std::exchange(settled.open, {})) {
      const double pixels = static_cast<double>(alarm.tile) * alarm.tile;
      const double hidden = options.samples == 0 ? 0 : hidden_light(brightest, samples * pixels, level);
      const Finding found = finding(alarm, first, second, level, hidden, options.relative_tolerance);
      (found == Finding::Confirmed   ? settled.confirmed
       : found == Finding::Withdrawn ? settled.withdrawn
                                     : settled.open)
          .push_back(alarm);
    }
  }
  return settled;
}

double standard_errors_of_alarm(int batches, int tests, double false_alarm_rate) {
  const double bound = significance_per_test(false_alarm_rate, tests);
  double low = 0, high = 1e9;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (student_two_sided(middle, batches - 1) >= bound ? low : high) = middle;
  }
  return high;
}

}  // namespace regulus::image

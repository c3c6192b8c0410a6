// The end of a path: sums of the film against exact ones, and samples that it must refuse.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "interface/wavefront.h"
#include "stability/batch.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using namespace interface;

namespace {

/// What the film holds after all values were added.
struct FilmSum {
  Exact sum;
  uint32_t refused;
  bool is_saturated;
};

FilmSum add_all(gpu::Device& device, int exponent, const std::vector<float>& values) {
  const gpu::Kernel kernel =
      create_kernel(device, "film", {{SPEC_FILM_EXPONENT, static_cast<uint32_t>(exponent)}});
  const gpu::Buffer in = gpu::upload_new(device, values, "samples");
  const gpu::Buffer out = gpu::upload_new(device, std::vector<uint32_t>(4, 0), "sum");
  const StabilityArguments arguments{device_address(in.address()), device_address(out.address()),
                                     static_cast<uint32_t>(values.size())};
  dispatch_and_wait(device, kernel, gpu::bytes_of(arguments), values.size());
  const auto words = gpu::download_all<uint32_t>(device, out, 4);
  const Exact units =
      std::ldexp(static_cast<Exact>(words[2]), 64) + std::ldexp(static_cast<Exact>(words[1]), 32) + words[0];
  return {std::ldexp(units, exponent - int{FILM_FRACTION_BITS}), words[3], (words[2] & FILM_SATURATED) != 0};
}

// Half a unit of the film for each sample.
Exact rounding_of(int exponent, size_t samples) {
  return std::ldexp(static_cast<Exact>(samples), exponent - int{FILM_FRACTION_BITS} - 1);
}

SweepText film_text(std::string name, const char* parameter) {
  SweepText text{"film", std::move(name), parameter, "half a unit of 2^-40 for each sample", 1e-15, 1e-15};
  text.floor = std::numeric_limits<double>::min();
  text.has_reference = false;
  return text;
}

/// A thousand samples of very different brightness, in a film whose units suit their power.
Sweep sums_over_power(gpu::Device& device, Extent extent) {
  Sweep sweep(film_text("sum over power", "radiance of the brightest sample"));
  std::mt19937_64 random(5);
  for (const double power : in_equal_ratios(1e-20, 1e20, extent == Extent::Quick ? 5 : 41)) {
    std::vector<float> values;
    Exact truth = 0;
    for (int i = 0; i < 1000; ++i) {
      values.push_back(
          static_cast<float>(power * std::pow(1e-4, static_cast<double>(random() >> 11) * 0x1p-53)));
      truth += values.back();
    }
    const int exponent = std::ilogb(power);
    const FilmSum found = add_all(device, exponent, values);
    sweep.add({power, static_cast<double>(found.sum), 0, truth, rounding_of(exponent, values.size())},
              [&] { return fmt::format("1000 samples up to {:.3g}, units of 2^{}", power, exponent - 40); });
  }
  return sweep;
}

/// The same sample over and over.
Sweep sums_over_samples(gpu::Device& device, Extent extent) {
  Sweep sweep(film_text("sum over samples of a pixel", "samples"));
  for (const double count :
       in_equal_ratios(1, extent == Extent::Quick ? 1e5 : 1e6, extent == Extent::Quick ? 3 : 7)) {
    const std::vector<float> values(static_cast<size_t>(std::lround(count)), 0.1f);
    const Exact truth = static_cast<Exact>(values.size()) * values[0];
    sweep.add({static_cast<double>(values.size()), static_cast<double>(add_all(device, 0, values).sum), 0,
               truth, rounding_of(0, values.size())},
              [&] { return fmt::format("{} samples of .1", values.size()); });
  }
  return sweep;
}

/// A sum that leaves the film's range: marked, or else right.
Sweep marks_over_sums(gpu::Device& device, Extent extent) {
  SweepText text = film_text("overflow is marked", "sum over the film's range");
  text.bound = "2^55 units of 1: exactly there";
  Sweep sweep(text);
  for (const double share : in_equal_ratios(1e-3, 1e3, extent == Extent::Quick ? 7 : 31)) {
    const float value = static_cast<float>(std::ldexp(share, 55) / 64);
    const Exact sum = 64 * static_cast<Exact>(value);
    const FilmSum found = add_all(device, 0, std::vector<float>(64, value));
    sweep.add({share, found.is_saturated ? 1.0 : 0.0, 0, sum >= std::ldexp(1.0L, 55) ? 1.0L : 0.0L, 0},
              [&] { return fmt::format("64 samples of {:.9g}", value); });
  }
  return sweep;
}

/// NaN, infinities and negative samples among good ones: refused, each of them, and nothing else.
Sweep refused_samples(gpu::Device& device) {
  SweepText text = film_text("samples refused", "bad samples of 7 kinds, copies");
  text.bound = "all that are not finite or negative, and no other";
  Sweep sweep(text);
  const std::array bad = {std::numeric_limits<float>::quiet_NaN(),
                          -std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(),
                          -1.0f,
                          -std::numeric_limits<float>::denorm_min(),
                          -std::numeric_limits<float>::max()};
  const std::array good = {
      0.0f, -0.0f, 1.0f, std::numeric_limits<float>::denorm_min(), 1e-30f, std::numeric_limits<float>::max()};
  for (const int copies : {1, 10, 1000}) {
    std::vector<float> values;
    for (int i = 0; i < copies; ++i) {
      values.insert(values.end(), bad.begin(), bad.end());
      values.insert(values.end(), good.begin(), good.end());
    }
    sweep.add({static_cast<double>(copies), static_cast<double>(add_all(device, 0, values).refused), 0,
               static_cast<Exact>(copies) * bad.size(), 0},
              [&] { return fmt::format("{} copies", copies); });
  }
  return sweep;
}

}  // namespace

std::vector<Sweep> sweep_film(gpu::Device& device, Extent extent) {
  std::vector<Sweep> all;
  all.push_back(sums_over_power(device, extent));
  all.push_back(sums_over_samples(device, extent));
  all.push_back(marks_over_sums(device, extent));
  all.push_back(refused_samples(device));
  return all;
}

}  // namespace regulus::stability

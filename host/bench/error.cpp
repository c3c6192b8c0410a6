#include "bench/error.hpp"

#include <algorithm>
#include <chrono>

#include "base/error.hpp"
#include "base/process_usage.hpp"
#include "render/renderer.hpp"

namespace regulus::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The pixels of a part of the film; of all of it if the part has none.
image::Image part_of(const image::Image& image, const render::Window& part) {
  if (part.pixels() == 0) return image;
  image::Image cut{part.width, part.height, {}};
  cut.rgb.reserve(3 * part.pixels());
  for (uint32_t y = part.y; y < part.y + part.height; ++y) {
    const auto row = image.rgb.begin() + 3 * (ptrdiff_t{y} * image.width + part.x);
    cut.rgb.insert(cut.rgb.end(), row, row + 3 * ptrdiff_t{part.width});
  }
  return cut;
}

// One render: its curve and its last image.
struct Trial {
  std::vector<ErrorPoint> points;
  image::Image image;
};

// Kernels are compiled at their first dispatch on some devices: one sample beforehand keeps that out of the
// times.
void warm_up(gpu::Device& device, const PreparedScene& prepared, render::RenderSettings settings) {
  settings.samples = 1;
  render::Renderer(device, prepared, make_plan(prepared, settings)).render([](uint64_t, uint64_t) {
    return true;
  });
}

// @param reference of the region; null: no curve
Trial run_trial(gpu::Device& device, const PreparedScene& prepared, render::RenderSettings settings,
                const ErrorBudget& budget, const image::Image* reference, const render::Window& region) {
  settings.keeps_doublings = true;
  settings.samples = budget.samples != 0 ? budget.samples : 1u << 24;
  const uint64_t pixels = settings.window().pixels();
  render::Renderer renderer(device, prepared, make_plan(prepared, settings));

  Trial trial;
  const auto start = Clock::now();
  const double cpu_start = process_cpu_seconds();
  double seconds = 0, cpu_seconds = 0, comparing = 0, comparing_cpu = 0;
  uint64_t compared_paths = 0;
  // Comparing costs time that is not the render's.
  const auto compare = [&] {
    const render::Film& film = renderer.film();
    if (film.paths < pixels || film.paths == compared_paths) return;
    const auto before = Clock::now();
    const double cpu_before = process_cpu_seconds();
    compared_paths = film.paths;
    trial.image = part_of(render::resolve(film), region);
    if (reference != nullptr)
      trial.points.push_back({seconds, cpu_seconds,
                              static_cast<double>(film.paths) / static_cast<double>(pixels),
                              image::compare(trial.image, *reference).relmse});
    comparing += seconds_since(before);
    comparing_cpu += process_cpu_seconds() - cpu_before;
  };
  const auto read_clocks = [&] {
    seconds = seconds_since(start) - comparing;
    cpu_seconds = process_cpu_seconds() - cpu_start - comparing_cpu;
  };
  renderer.render([&](uint64_t done, uint64_t) {
    if (budget.is_interrupted && budget.is_interrupted()) throw Error(ErrorCode::Interrupted, "interrupted");
    read_clocks();
    compare();
    const double spent = budget.counts_cpu_time ? cpu_seconds : seconds;
    return budget.samples != 0 || done < pixels || spent < budget.seconds;
  });
  read_clocks();
  compare();
  return trial;
}

// Means over the trials at each state of the film that all of them reached, and at the end.
std::vector<ErrorPoint> mean_curve(const std::vector<Trial>& trials) {
  std::vector<ErrorPoint> curve;
  size_t shortest = trials.front().points.size();
  for (const Trial& trial : trials) shortest = std::min(shortest, trial.points.size());
  const auto add = [&](const auto& point_of) {
    ErrorPoint mean;
    const double share = 1.0 / static_cast<double>(trials.size());
    for (const Trial& trial : trials) {
      const ErrorPoint& point = point_of(trial);
      mean.seconds += share * point.seconds;
      mean.cpu_seconds += share * point.cpu_seconds;
      mean.samples += share * point.samples;
      mean.relmse += share * point.relmse;
    }
    curve.push_back(mean);
  };
  for (size_t i = 0; i + 1 < shortest; ++i)
    add([i](const Trial& trial) -> const ErrorPoint& { return trial.points[i]; });
  add([](const Trial& trial) -> const ErrorPoint& { return trial.points.back(); });
  return curve;
}

// Per value over the trials: the mean, and the mean over values of the variance relative to `scale`.
struct Spread {
  image::Image mean;
  double relative_variance = 0;  // of one trial
};

Spread spread_of(const std::vector<Trial>& trials, const image::Image* scale) {
  Spread spread{trials.front().image, 0};
  const auto count = static_cast<double>(trials.size());
  double sum = 0;
  for (size_t i = 0; i < spread.mean.rgb.size(); ++i) {
    double mean = 0, squares = 0;
    for (const Trial& trial : trials) mean += trial.image.rgb[i] / count;
    for (const Trial& trial : trials) {
      const double difference = trial.image.rgb[i] - mean;
      squares += difference * difference;
    }
    spread.mean.rgb[i] = static_cast<float>(mean);
    const double reference = scale != nullptr ? scale->rgb[i] : mean;
    sum += squares / (count - 1) / (reference * reference + image::RELATIVE_EPSILON);
  }
  spread.relative_variance = sum / static_cast<double>(spread.mean.rgb.size());
  return spread;
}

double mean_of(const image::Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += value;
  return sum / static_cast<double>(image.rgb.size());
}

std::vector<Trial> run_trials(gpu::Device& device, const PreparedScene& prepared,
                              render::RenderSettings settings, const ErrorBudget& budget,
                              const image::Image* reference, const render::Window& region) {
  warm_up(device, prepared, settings);
  std::vector<Trial> trials;
  for (uint32_t i = 0; i < budget.seeds; ++i, ++settings.seed)
    trials.push_back(run_trial(device, prepared, settings, budget, reference, region));
  return trials;
}

}  // namespace

image::Image measured_reference(const ErrorSubject& subject) {
  return part_of(subject.reference, subject.region);
}

ErrorRun measure_error(gpu::Device& device, const ErrorSubject& subject,
                       const render::RenderSettings& settings, const ErrorBudget& budget) {
  const image::Image reference = measured_reference(subject);
  std::vector<Trial> trials =
      run_trials(device, subject.prepared, settings, budget, &reference, subject.region);
  const Spread spread = spread_of(trials, &reference);
  ErrorRun run;
  run.points = mean_curve(trials);
  run.relmse = run.points.back().relmse;
  for (const Trial& trial : trials) {
    const double share = 1.0 / static_cast<double>(trials.size());
    const image::Metrics metrics = image::compare(trial.image, reference);
    run.mse += share * metrics.mse;
    run.trimmed_relmse += share * metrics.trimmed_relmse;
    run.flip += share * image::flip(trial.image, reference);
  }
  run.variance = spread.relative_variance;
  run.squared_bias =
      image::compare(spread.mean, reference).relmse - run.variance / static_cast<double>(budget.seeds);
  run.mean_ratio = mean_of(spread.mean) / mean_of(reference);
  run.image = std::move(trials.front().image);
  return run;
}

Reference make_reference(gpu::Device& device, const PreparedScene& prepared,
                         const render::RenderSettings& settings, const ErrorBudget& budget) {
  const std::vector<Trial> trials = run_trials(device, prepared, settings, budget, nullptr, {});
  Spread spread = spread_of(trials, nullptr);
  return {std::move(spread.mean), spread.relative_variance / static_cast<double>(budget.seeds)};
}

}  // namespace regulus::bench

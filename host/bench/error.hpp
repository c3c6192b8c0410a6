// Error against time: renders of one scene under several configurations, over independent seeds, against a
// reference image.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "image/image.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/settings.hpp"

namespace regulus::bench {

/// The state of a render in progress.
struct ErrorPoint {
  double seconds = 0;      ///< wall time of rendering, kernels already compiled
  double cpu_seconds = 0;  ///< of this process: on a software device what the render cost, whatever else runs
  double samples = 0;      ///< per pixel
  double relmse = 0;       ///< image::Metrics
};

/// One configuration on one scene.
struct ErrorRun {
  std::string name;
  std::string options;  ///< of `regulus render`
  /// At each doubling of the samples and at the end: means over the seeds that got there.
  std::vector<ErrorPoint> points;
  double relmse = 0;                             ///< at the end of the time
  double mse = 0, trimmed_relmse = 0, flip = 0;  ///< likewise: image::Metrics, image::flip()
  double variance = 0;                           ///< share of relmse that seeds do not agree on
  /// relmse of the mean over seeds, less what variance leaves in it: squared bias. Not below 0 but for noise.
  double squared_bias = 0;
  double mean_ratio = 0;  ///< mean of all pixels and channels over the reference's
  image::Image image;     ///< of the first seed, its region
};

/// What error benchmarks need of a scene.
struct ErrorSubject {
  const PreparedScene& prepared;
  const image::Image& reference;  ///< of the whole film
  render::Window region{};        ///< pixels that are measured, of a whole render; without pixels: all
};

struct ErrorBudget {
  double seconds = 10;                             ///< of rendering, for each seed
  bool counts_cpu_time = false;                    ///< `seconds` are CPU seconds of this process
  uint32_t samples = 0;                            ///< per pixel instead of seconds; 0: by time
  uint32_t seeds = 5;                              ///< at least 2
  std::function<bool()> is_interrupted = nullptr;  ///< if it says so, what is being rendered is given up
};

/// The pixels of the subject's reference that are measured. @pre the region lies on the film
image::Image measured_reference(const ErrorSubject& subject);

/// Renders with seeds settings.seed, settings.seed + 1, ... and compares; film size is the reference's.
/// @throws regulus::Error as render::Renderer, and (Interrupted)
ErrorRun measure_error(gpu::Device& device, const ErrorSubject& subject,
                       const render::RenderSettings& settings, const ErrorBudget& budget);

/// An image from independent renders, with its own error.
struct Reference {
  image::Image image;  ///< the mean
  double relmse = 0;   ///< expected, of the mean against the truth as far as the estimator is unbiased
};

/// The mean over `budget.seeds` renders. @throws as measure_error
Reference make_reference(gpu::Device& device, const PreparedScene& prepared,
                         const render::RenderSettings& settings, const ErrorBudget& budget);

}  // namespace regulus::bench

// Whole images by the estimators: iterations one after the other, each over tiles in threads. The image does
// not depend on the number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "reference/walk.hpp"

namespace regulus::reference {

/// Sums over iterations, of the pixels that are rendered (one sample of every pixel plus the splats of the
/// iteration's light walks). Iterations are independent and alike, so the spread of a pixel's values is its
/// variance.
struct Film {
  uint32_t width = 0, height = 0;
  std::vector<glm::dvec3> sum;      ///< of each pixel's values
  std::vector<glm::dvec3> squares;  ///< of their squares
  uint32_t iterations = 0;
  std::vector<std::vector<glm::dvec3>> layers{};  ///< sums of each of Settings::layers

  glm::dvec3 mean(size_t pixel) const;
  /// Variance of mean(); needs two iterations.
  glm::dvec3 variance_of_mean(size_t pixel) const;
};

/// Called after every iteration; false stops the render.
using IterationCallback = std::function<bool(uint32_t done, uint32_t total)>;

/// Renders settings.samples iterations. `threads` 0: one per processor.
Film render(const World& world, const Settings& settings, const IterationCallback& progress = {},
            uint32_t threads = 0);

}  // namespace regulus::reference

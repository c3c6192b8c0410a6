// What `regulus bench talk` compares.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace regulus::cli {

/// Options of `render` under a name.
struct BenchConfig {
  std::string name, options;
  /// Not empty: --clamp is chosen so that the variance becomes that of the configuration of this name before
  /// it.
  std::string clamped_like = {};
};

/// Configurations to compare on a scene.
struct BenchComparison {
  std::string title, text;  ///< what is compared, and what to look for
  std::string scene;        ///< glTF file
  std::vector<BenchConfig> configs;
  uint32_t samples = 0;  ///< per pixel, for all of them; 0: what fits in the time
};

/// The comparisons of the talk that introduced microfacet regularization (Jendersie and Grosch, EGSR 2019),
/// on the scenes in `folder`.
std::vector<BenchComparison> talk_comparisons(const std::string& folder);

}  // namespace regulus::cli

// What `regulus bench talk` compares.
#pragma once

#include <string>
#include <vector>

namespace regulus::cli {

/// Options of `render` under a name.
struct BenchConfig {
  std::string name, options;
};

/// Configurations to compare on a scene.
struct BenchComparison {
  std::string title, text;  ///< what is compared, and what to look for
  std::string scene;        ///< glTF file
  std::vector<BenchConfig> configs;
};

/// The comparisons of the talk that introduced microfacet regularization (Jendersie and Grosch, EGSR 2019),
/// on the scenes in `folder`.
std::vector<BenchComparison> talk_comparisons(const std::string& folder);

}  // namespace regulus::cli

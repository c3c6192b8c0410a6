// What kernels gain by leaving out what a scene lacks: the scene as it is against the scene with one more
// feature on a speck that no ray need ever meet.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::bench {

/// A feature that a scene lacks, present but unused against absent.
struct SkippedFeature {
  std::string name;        ///< see scene::feature_descriptions
  double time_ratio = 0;   ///< CPU time of rendering with it over without: median over repeats
  double least_ratio = 0;  ///< of the repeats
  double greatest_ratio = 0;
  int64_t bytes = 0;  ///< device memory more with it, without nodes: the speck may change the tree either way
  uint64_t bytes_per_path = 0;  ///< state of a path in flight with it
};

struct SkipReport {
  double seconds = 0;           ///< CPU time of rendering the scene as it is, median
  double noise = 0;             ///< median |ratio - 1| of the scene as it is against itself
  uint64_t bytes_per_path = 0;  ///< of the scene as it is
  std::vector<SkippedFeature> features;
};

struct SkipBudget {
  uint32_t repeats = 5;                            ///< of each pair, in turns
  std::function<bool()> is_interrupted = nullptr;  ///< if it says so, measuring is given up
};

/// Gives a scene, loaded and not yet prepared, a feature on a triangle of a millionth
/// of its size at the corner of its bounds, or as a light of next to no power. False if it cannot be added
/// so.
/// @param feature FEATURE_* bit
bool add_unused_feature(scene::Scene& scene, uint32_t feature);

/// Measures all features that the scene lacks. Times are CPU seconds of this process, so the device must be
/// one that computes on the CPU.
/// @param scene loaded and not yet prepared
/// @throws regulus::Error as render::Renderer, and (Interrupted)
SkipReport measure_skipped(gpu::Device& device, const scene::Scene& scene,
                           const render::RenderSettings& settings, const SkipBudget& budget);

}  // namespace regulus::bench

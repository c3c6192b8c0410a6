// Images of single strategies, Veach's pyramid: what each way to make a path adds to the picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.hpp"
#include "interface/wavefront.h"

namespace regulus::render {

/// A technique and the lengths of the subpaths it joins: s vertices from the light, t from the camera, lens
/// included; the two that a merge unites count once each.
struct Strategy {
  uint32_t technique;  ///< TECHNIQUE_*, one of them
  uint32_t s, t;

  bool is_merge() const { return technique == interface::TECHNIQUE_MERGE; }
  uint32_t edges() const { return s + t - (is_merge() ? 2 : 1); }
  /// For instance "connect-s2-t3".
  std::string name() const;
};

/// All strategies of a set of techniques, by path length, then s; of one length merges come last.
std::vector<Strategy> list_strategies(uint32_t techniques, uint32_t max_depth);

/// For kernels: the place in the list of each strategy by 2 (edges (max_depth + 2) + s) + is_merge, or
/// INVALID_INDEX.
std::vector<uint32_t> strategy_layers(const std::vector<Strategy>& strategies, uint32_t max_depth);

/// What a strategy added to the picture, and its estimate, alone, of all light that it can find.
struct StrategyImages {
  Strategy strategy;
  image::Image weighted, unweighted;
};

}  // namespace regulus::render

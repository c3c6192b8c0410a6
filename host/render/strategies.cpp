#include "render/strategies.hpp"

#include <fmt/format.h>

namespace regulus::render {

using namespace interface;

std::string Strategy::name() const {
  const char* const word = technique == TECHNIQUE_HIT       ? "hit"
                           : technique == TECHNIQUE_NEE     ? "nee"
                           : technique == TECHNIQUE_SPLAT   ? "splat"
                           : technique == TECHNIQUE_CONNECT ? "connect"
                                                            : "merge";
  return fmt::format("{}-s{}-t{}", word, s, t);
}

std::vector<Strategy> list_strategies(uint32_t techniques, uint32_t max_depth) {
  std::vector<Strategy> strategies;
  const auto add = [&](uint32_t technique, uint32_t s, uint32_t t) {
    if ((techniques & technique) != 0) strategies.push_back({technique, s, t});
  };
  for (uint32_t edges = 1; edges <= max_depth; ++edges) {
    add(TECHNIQUE_HIT, 0, edges + 1);
    if (edges >= 2) add(TECHNIQUE_NEE, 1, edges);
    for (uint32_t s = 2; s + 1 <= edges; ++s) add(TECHNIQUE_CONNECT, s, edges + 1 - s);
    // An emitter that the camera sees directly is splatted only where no technique hits it.
    if (edges >= 2 || (techniques & TECHNIQUE_HIT) == 0) add(TECHNIQUE_SPLAT, edges, 1);
    for (uint32_t s = 2; s <= edges; ++s) add(TECHNIQUE_MERGE, s, edges + 2 - s);
  }
  return strategies;
}

std::vector<uint32_t> strategy_layers(const std::vector<Strategy>& strategies, uint32_t max_depth) {
  std::vector<uint32_t> layers(2ull * (max_depth + 1) * (max_depth + 2), INVALID_INDEX);
  for (uint32_t i = 0; i < strategies.size(); ++i) {
    const Strategy& strategy = strategies[i];
    layers[2ull * (strategy.edges() * (max_depth + 2) + strategy.s) + (strategy.is_merge() ? 1 : 0)] = i;
  }
  return layers;
}

}  // namespace regulus::render

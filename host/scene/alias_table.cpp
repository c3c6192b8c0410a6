#include "scene/alias_table.hpp"

#include <cstdint>
#include <numeric>

namespace regulus::scene {

std::vector<interface::LightAlias> make_alias_table(const std::vector<double>& weights) {
  const size_t count = weights.size();
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> share(count);  // 1: exactly one bucket
  std::vector<uint32_t> poor, rich;
  for (size_t i = 0; i < count; ++i) {
    share[i] = weights[i] / total * static_cast<double>(count);
    (share[i] < 1 ? poor : rich).push_back(static_cast<uint32_t>(i));
  }
  std::vector<interface::LightAlias> table(count);
  while (!poor.empty() && !rich.empty()) {
    const uint32_t giver = rich.back();
    const uint32_t taker = poor.back();
    poor.pop_back();
    table[taker] = {static_cast<float>(share[taker]), giver};
    share[giver] -= 1 - share[taker];
    if (share[giver] < 1) {
      rich.pop_back();
      poor.push_back(giver);
    }
  }
  // Whatever is left differs from a full bucket by rounding only.
  for (const uint32_t i : rich) table[i] = {1.0f, i};
  for (const uint32_t i : poor) table[i] = {1.0f, i};
  return table;
}

std::vector<double> alias_table_pdf(const std::vector<interface::LightAlias>& table) {
  std::vector<double> pdf(table.size(), 0.0);
  const double bucket = 1.0 / static_cast<double>(table.size());
  for (size_t i = 0; i < table.size(); ++i) {
    const double threshold = table[i].threshold;
    pdf[i] += threshold * bucket;
    pdf[table[i].alias] += (1 - threshold) * bucket;
  }
  return pdf;
}

}  // namespace regulus::scene

// Alias table for drawing an index with given weights in constant time (Walker 1977; Vose, "A linear
// algorithm for generating random numbers with a given distribution", 1991).
#pragma once

#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// @param weights non-negative, finite, not all zero.
std::vector<interface::LightAlias> make_alias_table(const std::vector<double>& weights);

/// The probability with which the table, thresholds rounded as they are, returns each index.
std::vector<double> alias_table_pdf(const std::vector<interface::LightAlias>& table);

}  // namespace regulus::scene

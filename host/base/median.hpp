// The median of a few values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace regulus {

/// The upper median. Precondition: there is a value.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace regulus

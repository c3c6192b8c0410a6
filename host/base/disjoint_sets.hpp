// Sets of numbers that are joined pair by pair (union-find with path halving).
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace regulus {

/// The numbers 0 .. count - 1, each in a set of its own until joined.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  /// The number that stands for the set of x.
  uint32_t root(uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  /// Joins the sets of a and b; that of a goes on to stand for both.
  void join(uint32_t a, uint32_t b) { parent_[root(b)] = root(a); }

 private:
  std::vector<uint32_t> parent_;
};

}  // namespace regulus

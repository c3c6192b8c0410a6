// The solids that hold a point: a set of their numbers, of which the least decides (scene/solids.hpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "interface/scene.h"

namespace regulus::reference {

class Media {
 public:
  Media() = default;
  explicit Media(const interface::MediaSet& set) {
    for (int i = 0; i < 4; ++i) {
      if (set.a[i] != interface::INVALID_INDEX) enter(set.a[i]);
      if (set.b[i] != interface::INVALID_INDEX) enter(set.b[i]);
    }
  }

  bool contain(uint32_t solid) const { return std::binary_search(solids_.begin(), solids_.end(), solid); }

  /// Of more than MEDIA_SET_SIZE those of least number are kept.
  void enter(uint32_t solid) {
    if (contain(solid)) return;
    solids_.insert(std::upper_bound(solids_.begin(), solids_.end(), solid), solid);
    if (solids_.size() > interface::MEDIA_SET_SIZE) solids_.pop_back();
  }
  void leave(uint32_t solid) { std::erase(solids_, solid); }

  Media without(uint32_t solid) const {
    Media rest = *this;
    rest.leave(solid);
    return rest;
  }

  /// The solid that decides; INVALID_INDEX: none.
  uint32_t first() const { return solids_.empty() ? interface::INVALID_INDEX : solids_.front(); }

  bool operator==(const Media& other) const = default;

 private:
  std::vector<uint32_t> solids_;  // ascending
};

}  // namespace regulus::reference

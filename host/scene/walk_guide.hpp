// The guided camera walk: the frozen table of where light comes from, cell by cell (docs/mathematics.md 18).
// Made once, before a render, by host/probe; device and reference read the same.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// The nodes are those of interface::WALK_GUIDE_CELL. Node 0 is the root.
struct WalkGuide {
  std::vector<interface::GuideNode> nodes;
  glm::vec3 corner{0};  ///< of the guide's bounds; what lies beyond them counts as at their faces
  glm::vec3 scale{1};   ///< 1/m: one over their extents
};

/// Tells guides apart: parts of a render that differ in it are not joined.
uint64_t hash_of(const WalkGuide& guide);

}  // namespace regulus::scene

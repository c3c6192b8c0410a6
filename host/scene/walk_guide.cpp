#include "scene/walk_guide.hpp"

#include "scene/word_hash.hpp"

namespace regulus::scene {

uint64_t hash_of(const WalkGuide& guide) {
  WordHash hash;
  for (int axis = 0; axis < 3; ++axis) {
    hash.add(guide.corner[axis]);
    hash.add(guide.scale[axis]);
  }
  for (const interface::GuideNode& node : guide.nodes) {
    hash.add(node.first_share);
    hash.add(node.next);
  }
  return hash.value();
}

}  // namespace regulus::scene

#include "scene/light_guide.hpp"

#include "scene/word_hash.hpp"

namespace regulus::scene {

uint64_t hash_of(const LightGuide& guide) {
  WordHash hash;
  for (const interface::GuidedLight& light : guide.lights) {
    hash.add(light.selection_pdf);
    hash.add(light.root);
  }
  for (const interface::GuideNode& node : guide.nodes) {
    hash.add(node.first_share);
    hash.add(node.next);
  }
  return hash.value();
}

}  // namespace regulus::scene

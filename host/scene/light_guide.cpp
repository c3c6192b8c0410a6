#include "scene/light_guide.hpp"

#include <bit>

namespace regulus::scene {

uint64_t hash_of(const LightGuide& guide) {
  // FNV-1a, by words.
  uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](uint32_t word) { hash = (hash ^ word) * 0x100000001b3u; };
  for (const interface::GuidedLight& light : guide.lights) {
    add(std::bit_cast<uint32_t>(light.selection_pdf));
    add(light.root);
  }
  for (const interface::GuideNode& node : guide.nodes) {
    add(std::bit_cast<uint32_t>(node.first_share));
    add(node.next);
  }
  return hash;
}

}  // namespace regulus::scene

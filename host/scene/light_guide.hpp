// Guided emission: the frozen table by which light paths start (docs/mathematics.md 16). Made once, before a
// render, by host/probe; device and reference read the same.
#pragma once

#include <cstdint>
#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// Node 0 is a leaf, where the trees of lights start that have none.
struct LightGuide {
  std::vector<interface::GuidedLight> lights;  ///< one per light of the scene
  std::vector<interface::LightAlias> aliases;  ///< draws a light with its GuidedLight::selection_pdf
  std::vector<interface::GuideNode> nodes;
};

/// Tells guides apart: parts of a render that differ in it are not joined.
uint64_t hash_of(const LightGuide& guide);

}  // namespace regulus::scene

// Lights as outputs tell them apart.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace regulus::scene {

struct Document;  // scene/document.hpp

/// What the nodes of a document are called: their names, or "node" and the index; and their light groups:
/// extras.regulus.light_group, or what the node is called.
std::vector<SceneNode> read_nodes(const Document& document);

/// Lights by group: those of nodes with one light group, and the environment ("environment").
struct LightGroups {
  std::vector<std::string> names;  ///< of groups that have a light, in the order of their first one
  std::vector<uint32_t> of_light;  ///< index into names, by light
};
/// Of a scene after build_lights.
LightGroups light_groups(const Scene& scene);

}  // namespace regulus::scene

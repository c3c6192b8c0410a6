// The node hierarchy flattened: which nodes the chosen scene shows, and where.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "scene/document.hpp"

namespace regulus::scene {

struct PlacedNode {
  size_t node;  ///< index into model.nodes
  glm::dmat4 to_world;
};

/// Index of the scene to show: the wanted one, else the file's default, else the first; empty if the file has
/// no scenes.
/// @throws Error if the wanted scene does not exist.
std::optional<size_t> choose_scene(const Document& document, std::optional<uint32_t> wanted);

/// All nodes of the scene (of all roots if there are no scenes) in depth-first order.
/// @throws Error on cycles, nodes with two parents, and transforms that are not finite.
std::vector<PlacedNode> place_nodes(const Document& document, std::optional<size_t> scene);

}  // namespace regulus::scene

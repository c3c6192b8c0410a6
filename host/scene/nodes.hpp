// The node hierarchy flattened: which nodes the chosen scene shows, and where.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "scene/document.hpp"
#include "scene/pose.hpp"

namespace regulus::scene {

struct PlacedNode {
  size_t node;  ///< index into model.nodes
  glm::dmat4 to_world;
  std::shared_ptr<const MeshPose> pose{};  ///< null: its mesh stands as it is stored; see pose_meshes()
  /// KHR_node_visibility: of the node and of all above it. Cameras need not be visible.
  bool is_visible = true;
};

/// Index of the scene to show: the wanted one, else the file's default, else the first; empty if the file has
/// no scenes.
/// @throws Error if the wanted scene does not exist.
std::optional<size_t> choose_scene(const Document& document, std::optional<uint32_t> wanted);

/// All nodes of the scene (of all roots if there are no scenes) in depth-first order.
/// Matrices whose last row is 0 0 0 1 but for rounding, and rotations by a quaternion of length 0, are
/// mended.
/// @throws Error on cycles, nodes with two parents, projective matrices, and transforms that are not finite.
std::vector<PlacedNode> place_nodes(Document& document, std::optional<size_t> scene);

/// By node of the file: its transform to the world, as it is placed or, if the scene does not show it, as its
/// parents would place it. Joints may be such nodes. Call after place_nodes, which finds cycles.
std::vector<glm::dmat4> node_transforms(Document& document, const std::vector<PlacedNode>& placed);

}  // namespace regulus::scene

// How meshes stand at their places: by the weights of morph targets and by joints.
#pragma once

#include <memory>
#include <vector>

#include "scene/document.hpp"
#include "scene/skin.hpp"

namespace regulus::scene {

struct PlacedNode;

struct MeshPose {
  std::vector<double> weights;                  ///< of morph targets, see morph_weights()
  std::shared_ptr<const JointMatrices> joints;  ///< null: the node's own transform places the mesh
};

/// Poses meshes at their places (PlacedNode::pose); equal poses of a mesh are one object. `nodes` are all
/// that the scene shows.
/// @throws Error on broken skins and weights
void pose_meshes(Document& document, const std::vector<PlacedNode>& nodes, std::vector<PlacedNode>& places);

}  // namespace regulus::scene

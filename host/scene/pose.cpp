#include "scene/pose.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "scene/morph.hpp"
#include "scene/nodes.hpp"

namespace regulus::scene {
namespace {

bool has_targets(const tinygltf::Mesh& mesh) {
  return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                     [](const tinygltf::Primitive& primitive) { return !primitive.targets.empty(); });
}

/// Null, with a warning, if the skin is broken.
std::shared_ptr<const JointMatrices> joints_of(Document& document, size_t skin,
                                               const std::vector<glm::dmat4>& transforms) {
  try {
    return std::make_shared<const JointMatrices>(joint_matrices(document, skin, transforms));
  } catch (const Error& error) {
    document.mend(error, "its meshes stand where their nodes are");
    return nullptr;
  }
}

}  // namespace

void pose_meshes(Document& document, const std::vector<PlacedNode>& nodes, std::vector<PlacedNode>& places) {
  const auto has_skin = [&](const PlacedNode& place) { return document.model.nodes[place.node].skin >= 0; };
  std::vector<glm::dmat4> transforms;
  if (std::any_of(places.begin(), places.end(), has_skin)) transforms = node_transforms(document, nodes);
  std::map<int, std::shared_ptr<const JointMatrices>> skins;
  std::map<std::tuple<int, int, std::vector<double>>, std::shared_ptr<const MeshPose>> poses;
  for (PlacedNode& place : places) {
    const tinygltf::Node& node = document.model.nodes[place.node];
    std::vector<double> weights;
    if (has_targets(document.model.meshes[static_cast<size_t>(node.mesh)]))
      weights = morph_weights(document, place.node);
    if (node.skin < 0 && std::ranges::all_of(weights, [](double weight) { return weight == 0; })) continue;
    if (node.skin >= 0 && node.extensions.count("EXT_mesh_gpu_instancing") != 0)
      document.warn(element_name("node", place.node, node.name) +
                    ": instances of a skinned mesh have no meaning; it is shown once");
    auto& joints = skins[node.skin];
    if (node.skin >= 0 && !joints) joints = joints_of(document, static_cast<size_t>(node.skin), transforms);
    auto& pose = poses[{node.mesh, node.skin, weights}];
    if (!pose) pose = std::make_shared<const MeshPose>(MeshPose{weights, joints});
    place.pose = pose;
  }
}

}  // namespace regulus::scene

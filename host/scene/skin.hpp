// Skins: what joints do to the vertices that are bound to them (glTF 2.0, 3.7.3).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/document.hpp"

namespace regulus::scene {

/// By joint of a skin: from the space of the mesh it is bound to into the world.
using JointMatrices = std::vector<glm::dmat4>;

/// The world transform of each joint times its inverse bind matrix (the identity where the skin has none).
/// @param transforms of all nodes to the world
/// @throws Error if the skin has no joints, too few matrices, or one that is not finite
JointMatrices joint_matrices(Document& document, size_t skin, const std::vector<glm::dmat4>& transforms);

/// What was seen of vertices' joints and weights.
struct SkinTally {
  uint64_t foreign_joints = 0;  ///< weights of joints that the skin does not have, left out
  uint64_t unbound = 0;         ///< vertices without any weight: their first joint moves them
  uint64_t unnormalized = 0;    ///< vertices whose weights are far from a sum of 1: divided by it
};

/// Warns of everything that was seen.
void warn_of(const SkinTally& tally, Document& document);

/// Whether a primitive can be skinned: it has joints and weights.
bool has_joints(const tinygltf::Primitive& primitive);

/// By vertex of a primitive: its transform to the world, the mean of its joints' matrices by its weights, of
/// all its sets.
/// @param vertices their number
/// @param element names the primitive in errors
/// Precondition: has_joints(primitive).
/// @throws Error if joints and weights are not one each per vertex
std::vector<glm::dmat4> skin_vertices(const Document& document, const tinygltf::Primitive& primitive,
                                      const JointMatrices& joints, uint64_t vertices,
                                      const std::string& element, SkinTally& tally);

}  // namespace regulus::scene

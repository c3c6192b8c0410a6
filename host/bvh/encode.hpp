// Wide nodes to the device's node layout (shaders/interface/bvh.h).
#pragma once

#include <span>

#include "bvh/bvh.hpp"
#include "bvh/collapse.hpp"

namespace regulus::bvh {

/// Encodes nodes and triangles in leaf order. Primitives of the tree behind the triangles are instances.
Bvh encode(const BinaryTree& binary, const WideTree& wide, std::span<const InputTriangle> triangles);

/// A node without children, as an empty scene has it.
interface::BvhNode empty_node();

}  // namespace regulus::bvh

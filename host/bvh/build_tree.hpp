// One tree over triangles and instances: what both levels of the structure are made with.
#pragma once

#include <span>

#include "bvh/binary_tree.hpp"
#include "bvh/bvh.hpp"

namespace regulus::bvh {

/// The tree over these primitives, in the device's layout.
/// @throws regulus::Error (Failed) if it is too large or cannot be built of `max_depth` levels.
Bvh build_tree(const Primitives& primitives, uint32_t max_depth);

/// @throws regulus::Error (Failed) if references cannot tell so many apart.
void require_encodable(size_t triangles, size_t nodes, size_t instances);

}  // namespace regulus::bvh

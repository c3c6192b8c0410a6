// Where the scene's own frame stands in the world of its file. Positions are stored in single precision,
// which has no room for a house at geocentric coordinates: what lies far from the world's origin is moved
// near it, in double precision, before anything is rounded.
#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "scene/document.hpp"
#include "scene/nodes.hpp"

namespace regulus::scene {

/// An axis-aligned box in double precision.
struct Box {
  glm::dvec3 lower{std::numeric_limits<double>::infinity()};
  glm::dvec3 upper{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& point);
  void add(const Box& box);
  bool is_empty() const { return !(lower.x <= upper.x); }
  glm::dvec3 center() const { return 0.5 * (lower + upper); }
  /// Largest side; 0 if it is empty.
  double extent() const;
  /// Largest absolute coordinate; 0 if it is empty.
  double reach() const;
  /// A box around this one as `transform` places it.
  Box placed(const glm::dmat4& transform) const;
};

/// Distance of a box's centre from the origin, in extents of the box, beyond which the origin is moved. Up to
/// here single precision holds a box to a millionth of its extent.
inline constexpr double FAR_IN_EXTENTS = 16;

/// Boxes around meshes, in their own spaces and where they stand in their poses.
class PlacedBoxes {
 public:
  /// @throws Error if accessors are broken
  PlacedBoxes(const Document& document, const std::vector<PlacedNode>& places);

  /// By mesh of the file: around its finite vertices in its own space, in all poses that it takes without
  /// joints; empty for meshes without a place.
  const std::vector<Box>& meshes() const { return meshes_; }
  /// Around the mesh at a place.
  Box at(size_t place) const;
  /// Around all of them.
  Box all() const;

 private:
  Box around(const PlacedNode& place, const glm::dmat4& to_world, const MeshPose* pose) const;
  size_t mesh_of(const PlacedNode& place) const;

  const Document& document_;
  const std::vector<PlacedNode>& places_;
  std::vector<Box> meshes_;
  std::map<std::pair<size_t, const MeshPose*>, Box> posed_;  // without joints, in the mesh's space
  std::map<size_t, Box> skinned_;                            // by place
};

/// The point to take off what lies in `box`: 0 if the box is near the origin; otherwise the point of the
/// lattice of its extent, rounded up to a power of two, that is nearest to its centre. Floats of the file on
/// that lattice's scale are moved without rounding.
glm::dvec3 choose_origin(const Box& box);

/// Takes the origin off the places of nodes and of the joints that pose their meshes.
void take_off(const glm::dvec3& origin, std::vector<PlacedNode>& nodes);

/// @throws Error if the box is too large for single precision
void require_fitting_extent(const Document& document, const Box& box);

/// Warns of meshes that lose more than a thousandth of their extent to rounding: in the file's own floats,
/// far from their node's origin, or in the scene's, far from its own.
void warn_of_rounding(Document& document, const std::vector<PlacedNode>& places, const PlacedBoxes& boxes,
                      const glm::dvec3& origin);

}  // namespace regulus::scene

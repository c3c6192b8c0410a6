// Makes the frozen table of guided camera walks out of where camera walks have been, and where light arrived.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/walk_guide.hpp"

namespace regulus::probe {

/// Of CellKey::sides.
inline constexpr uint32_t SIDE_BITS = 6;

/// A vertex, as cells tell vertices apart.
struct CellKey {
  std::array<uint16_t, 3> place{};  ///< in units of 2^-GUIDE_HALVINGS of the guide's bounds
  uint8_t sides = 0;  ///< bit k: the normal is in the upper half along axis WALK_GUIDE_NORMALS + k
};

/// The key of a point in a guide of these bounds. normal: unit, geometric, on the side of the camera.
CellKey cell_key(const scene::WalkGuide& bounds, const glm::dvec3& position, const glm::dvec3& normal);

/// Light that arrived at a vertex.
struct Arrival {
  CellKey key;
  std::array<uint16_t, 2> direction{};  ///< sphere_numbers() of where it came from, as the place
  float cosine = 0;                     ///< with the normal, absolute
  uint64_t weight = 0;                  ///< flux, in whole units
  bool is_second = false;               ///< the half that judges what the other half has trained
};

/// A guide and what it is worth.
struct MadeWalkGuide {
  scene::WalkGuide guide;
  /// By how much the diffuse lobe's samples have a larger second moment than guided ones, of light that
  /// arrives at where camera walks go: the geometric mean over their vertices.
  double gain = 1;
};

/// The guide with these bounds (its nodes do not matter) whose cells follow `visits`, the vertices of camera
/// walks, and whose directions follow `arrivals`.
MadeWalkGuide make_walk_guide(const scene::WalkGuide& bounds, std::vector<CellKey> visits,
                              std::vector<Arrival> arrivals);

}  // namespace regulus::probe

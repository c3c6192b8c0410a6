// The solids that refracting materials with a volume bound: which triangles bound which, what overlaps what,
// and what holds a camera or a light.
//
// A solid is a connected, closed surface of one place of a mesh, whatever its materials; the surfaces of
// cavities, whose fronts face inwards, belong to the smallest solid around them. What is not closed counts as
// one open solid for each place: its faces alone tell inside from outside.
// Closed surfaces whose fronts face inwards are cavities of what is around them, of the same material; others
// are turned: someone forgot to.
//
// Where solids overlap, the one of higher priority (materials[].extras.regulus.priority, 0 by default)
// decides; of equal priority the one of smaller volume, for what lies inside is always smaller; then the one
// whose node comes first. That is a function of the place, not of how a path came there.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

struct Scene;

struct RankedSolid {
  uint32_t material = 0;  ///< of the largest part of its surface
  uint32_t place = 0;     ///< interface::Triangle::instance
  bool is_closed = false;
  double priority = 0;
  double volume = 0;              ///< m^3; of an open one that of its box
  double area = 0;                ///< m^2
  glm::dvec3 lower{0}, upper{0};  ///< its box
};

struct Solids {
  std::vector<RankedSolid> ranked;  ///< a solid's number is its rank: lower numbers decide
  std::vector<uint32_t>
      of_triangle;  ///< number of the solid that a stored triangle bounds, INVALID_INDEX: none
  std::vector<interface::Solid> records;  ///< the same as kernels read them
  // What follows is filled by find_contacts.
  bool has_contacts = false;                    ///< the scene needs FEATURE_CONTACTS
  std::vector<interface::MediaSet> media_sets;  ///< sets that hold something; the first is empty
  std::vector<uint32_t> of_camera;              ///< by camera: index into media_sets, or MEDIA_VARY
  std::vector<uint32_t> of_light;               ///< by light, likewise
  std::vector<uint32_t> of_lens;  ///< by camera: what holds the middle of its lens, index into media_sets
};

/// A set that holds nothing.
interface::MediaSet empty_media_set();

/// Material of the medium that holds the middle of a camera's lens; INVALID_INDEX: none.
uint32_t medium_of_lens(const Scene& scene, size_t camera);

/// Fills Scene::solids up to `records`. Call when all triangles are stored; reorder_triangles keeps it valid.
void find_solids(Scene& scene);

/// Fills the rest. Call when the lights are built.
void find_contacts(Scene& scene);

}  // namespace regulus::scene

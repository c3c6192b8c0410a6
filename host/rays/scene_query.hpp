// What rays meet in a scene, asked on the host: Embree finds the triangle, the kernels' own test says where
// on it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

#include "interface/bvh.h"
#include "prepared/prepared_scene.hpp"

namespace regulus::rays {

/// The queries of shaders/lib/traversal.glsl with the same answers, but for ties: a ray through an edge may
/// meet the triangle on its other side, and of surfaces whose distances differ by rounding another may come
/// first. Thread-safe.
class SceneQuery {
 public:
  /// Why a scene with these features cannot be asked; nullptr if it can.
  static const char* why_not(const scene::Features& features);

  /// Builds Embree's own acceleration structures, on all cores. Precondition: why_not() has nothing against
  /// it. `prepared` must outlive the object. @throws regulus::Error (Failed) if memory runs out.
  explicit SceneQuery(const PreparedScene& prepared);
  ~SceneQuery();

  /// The first hit with t in (0, t_max], and the tag of its triangle; without one its number is
  /// INVALID_INDEX. t is in lengths of the direction. A ray that is not finite or has no direction meets
  /// nothing.
  interface::Hit closest(const glm::vec3& origin, const glm::vec3& direction, float t_max,
                         uint32_t& tag) const;

  /// Whether nothing is met with t in (0, t_max].
  bool is_open(const glm::vec3& origin, const glm::vec3& direction, float t_max) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::rays

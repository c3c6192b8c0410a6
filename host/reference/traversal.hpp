// Rays against triangles in double precision. The tree is the device's own, walked one ray at a time; the
// boxes only cull, so the answer is that of testing every triangle.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <optional>

#include "bvh/bvh.hpp"
#include "reference/media.hpp"
#include "scene/scene.hpp"

namespace regulus::reference {

/// State of a ray among surfaces that touch (FEATURE_CONTACTS). The rules are those of
/// shaders/lib/contacts.glsl, with the same tolerances, so that decisions agree.
struct Contact {
  Media around;                                          ///< the solids there
  double from = 0;                                       ///< surfaces before this t have been met
  double end = std::numeric_limits<double>::infinity();  ///< of the ray
  uint32_t crossed = interface::INVALID_INDEX;           ///< the solid whose boundary lies at `from`
  uint32_t left = interface::INVALID_INDEX;              ///< the solid whose boundary the ray starts on
  uint32_t triangle = interface::INVALID_INDEX;          ///< the triangle that it starts on
  bool is_blind =
      false;  ///< meets closed solids only, to find what holds its origin: `around` is what it has entered
  Media holding{};  ///< if blind: what it has left without having entered it
};

/// origin + t * direction for t in (t_min, t_max). Two triangles can be passed over: those on which a segment
/// starts and ends.
struct Ray {
  glm::dvec3 origin, direction;
  double t_min = 0;
  double t_max = std::numeric_limits<double>::infinity();
  uint32_t skip_first = interface::INVALID_INDEX;
  uint32_t skip_last = interface::INVALID_INDEX;
  /// The bits of origin and direction by which a blended surface decides whether the ray meets it: the
  /// device's, or if empty those of the members above.
  std::optional<std::array<glm::vec3, 2>> decision = std::nullopt;
  const Contact* contact =
      nullptr;  ///< null: surfaces are met by distance alone; otherwise t_min and t_max do not count
};

/// Share of the surface that is there at barycentrics of a triangle: 1, or by the alpha of its material.
double coverage_at(const scene::Scene& scene, uint32_t triangle, const glm::dvec2& barycentrics);

/// Whether a ray meets a surface there: by a hash of the ray's bits, as on the device.
bool is_covered(const scene::Scene& scene, uint32_t triangle, const glm::dvec2& barycentrics,
                const glm::vec3& origin, const glm::vec3& direction);

/// Where a ray meets a triangle; p = (1 - u - v) p0 + u p1 + v p2.
struct Intersection {
  double t;
  glm::dvec2 barycentrics;  ///< (u, v)
  uint32_t triangle;
  bool is_front = false;  ///< only with Ray::contact
};

/// Ray against one triangle, both faces, edges included: Woop, Benthin and Wald, Watertight Ray/Triangle
/// Intersection, JCGT 2013, in double.
std::optional<Intersection> intersect(const Ray& ray, const glm::dvec3 (&vertices)[3]);

/// The scene's triangles under a tree.
class Traversal {
 public:
  /// Both must outlive the object. Without a scene all surfaces are whole.
  explicit Traversal(const bvh::Bvh& tree, const scene::Scene* scene = nullptr)
      : tree_(tree), scene_(scene) {}

  /// The nearest intersection of the ray, if there is one.
  std::optional<Intersection> closest(const Ray& ray) const;

  /// Whether the ray meets anything.
  bool is_occluded(const Ray& ray) const;

 private:
  /// A reference to visit, in the world or in the space of a copy's mesh.
  struct Visit {
    uint32_t reference;
    const interface::Instance* copy;
  };

  std::optional<Intersection> run(const Ray& ray, bool any_hit) const;
  /// What a ray has found so far.
  struct Search {
    Ray ray;
    std::optional<Intersection> nearest{};
    double key = std::numeric_limits<double>::infinity();  ///< with contacts: of the nearest, as is
    uint32_t order = interface::INVALID_INDEX;
  };

  void intersect_leaf(const Visit& visit, Search& search) const;
  void take_contact(uint32_t tag, Intersection hit, const glm::dvec3& normal, Search& search) const;

  bool is_covered(const Ray& ray, const Intersection& hit) const;

  const bvh::Bvh& tree_;
  const scene::Scene* scene_;
};

}  // namespace regulus::reference

#include "scene/coincidence.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

#include "scene/coplanar.hpp"
#include "scene/placement.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using interface::INVALID_INDEX;

// Area of the least triangles that are looked at whatever they are, in squares of the scene's extent.
constexpr double LEAST_AREA = 1e-5;

class Coincidences {
 public:
  explicit Coincidences(const Scene& scene) : scene_(scene), distance_(distance_of_coincidence(scene)) {}

  bool any() const {
    bool found = false;
    const bool is_sure = visit_coplanar_pairs(faces(), distance_, [&](const Face& a, const Face& b) {
      found = matter(a, b);
      return found;
    });
    return found || !is_sure;
  }

 private:
  bool emits(uint32_t triangle) const { return scene_.triangles[triangle].light != INVALID_INDEX; }
  uint32_t solid_of(uint32_t triangle) const {
    return scene_.solids.of_triangle.empty() ? INVALID_INDEX : scene_.solids.of_triangle[triangle];
  }

  std::vector<Face> faces() const {
    const double extent = length(dvec3(scene_.bounds_max) - dvec3(scene_.bounds_min));
    const double least_area = LEAST_AREA * extent * extent;
    std::vector<Face> faces;
    for (size_t i = first_placed_triangle(scene_); i < scene_.triangles.size(); ++i) {
      const auto index = static_cast<uint32_t>(i);
      const std::optional<Face> face = face_of(scene_, index);
      if (face && (face->area >= least_area || emits(index) || solid_of(index) != INVALID_INDEX))
        faces.push_back(*face);
    }
    return faces;
  }

  static auto bytes_of(const interface::Material& material) {
    return std::bit_cast<std::array<std::byte, sizeof(material)>>(material);
  }

  bool matter(const Face& a, const Face& b) const {
    const uint32_t solid_a = solid_of(a.triangle), solid_b = solid_of(b.triangle);
    const bool is_plain = solid_a == INVALID_INDEX && solid_b == INVALID_INDEX;
    const bool is_same_solid = !is_plain && solid_a == solid_b;
    const bool one_emits = emits(a.triangle) || emits(b.triangle);
    const interface::Material& material_a = scene_.materials[scene_.triangles[a.triangle].material];
    const interface::Material& material_b = scene_.materials[scene_.triangles[b.triangle].material];
    const bool differ = bytes_of(material_a) != bytes_of(material_b);
    if (is_same_solid || (is_plain && !one_emits && !differ)) return false;
    // The bottom of a box on a floor: nothing is seen of either. The two faces of a leaf have common corners.
    if (is_plain && !one_emits && dot(a.normal, b.normal) < 0 && common_corners(a, b) < 2) return false;
    return overlap_in_plane(a, b, distance_);
  }

  int64_t common_corners(const Face& a, const Face& b) const {
    return std::count_if(a.corners.begin(), a.corners.end(), [&](const dvec3& corner) {
      return std::any_of(b.corners.begin(), b.corners.end(),
                         [&](const dvec3& other) { return glm::distance(corner, other) <= distance_; });
    });
  }

  const Scene& scene_;
  double distance_;
};

}  // namespace

bool has_coincident_surfaces(const Scene& scene) {
  return Coincidences(scene).any();
}

}  // namespace regulus::scene

#include "scene/clipping.hpp"

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "scene/placement.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using glm::dvec4;

// Films up to this much wider than the camera's frame, or higher, are looked at, filters' radii included.
constexpr double WIDEST_FILM = 4;
// Cameras times triangles; beyond, planes are kept without looking.
constexpr uint64_t MAX_TESTS = uint64_t{1} << 31;

/// Half the extent of what a camera sees at depth z is at_lens + z * growth.
struct HalfExtents {
  double at_lens, growth;
};

HalfExtents half_extents(const SceneCamera& camera) {
  const double half_height = glm::length(dvec3(make_camera(camera, 1, 1).up));
  const double half = WIDEST_FILM * half_height * std::max(1.0, double{camera.aspect_ratio});
  if (camera.is_orthographic) return {half, 0};
  const double lens = camera.lens_radius;
  return {lens, half + lens / camera.focus_distance};
}

/// What a camera sees between two depths: where these functions of (x, y, depth, 1) in its frame are >= 0.
class Region {
 public:
  Region(const SceneCamera& camera, double nearest, double farthest) : view_(make_camera(camera, 1, 1)) {
    const auto [at_lens, growth] = half_extents(camera);
    planes_ = {dvec4(1, 0, growth, at_lens), dvec4(-1, 0, growth, at_lens), dvec4(0, 1, growth, at_lens),
               dvec4(0, -1, growth, at_lens), dvec4(0, 0, 1, -nearest)};
    if (farthest < std::numeric_limits<double>::infinity()) planes_.emplace_back(0, 0, -1, farthest);
    right_ = glm::normalize(dvec3(view_.right));
    up_ = glm::normalize(dvec3(view_.up));
  }

  dvec3 in_view(const dvec3& point) const {
    const dvec3 offset = point - dvec3(view_.position);
    return {dot(offset, right_), dot(offset, up_), dot(offset, dvec3(view_.forward))};
  }

  /// False only if the convex hull of the points (in the view) has nothing in the region.
  bool may_meet(std::span<const dvec3> points) const {
    return std::none_of(planes_.begin(), planes_.end(), [&](const dvec4& plane) {
      return std::all_of(points.begin(), points.end(),
                         [&](const dvec3& point) { return dot(plane, dvec4(point, 1)) < 0; });
    });
  }

  /// Whether a convex polygon has a part in the region (Sutherland and Hodgman 1974).
  bool meets(std::vector<dvec3> polygon) const {
    std::vector<dvec3> cut;
    for (const dvec4& plane : planes_) {
      cut.clear();
      for (size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = dot(plane, dvec4(a, 1)), at_b = dot(plane, dvec4(b, 1));
        if (at_a >= 0) cut.push_back(a);
        if ((at_a < 0) != (at_b < 0)) cut.push_back(mix(a, b, at_a / (at_a - at_b)));
      }
      std::swap(polygon, cut);
    }
    return !polygon.empty();
  }

  bool meets_triangle(const Scene& scene, uint32_t number) const {
    std::array<dvec3, 3> corners{};
    const std::array<glm::vec3, 3> positions = placed_positions(scene, number);
    std::transform(positions.begin(), positions.end(), corners.begin(),
                   [&](const glm::vec3& p) { return in_view(p); });
    return may_meet(corners) && meets({corners.begin(), corners.end()});
  }

 private:
  interface::Camera view_;
  dvec3 right_, up_;
  std::vector<dvec4> planes_;
};

bool may_meet_box(const Region& region, const std::pair<glm::vec3, glm::vec3>& box) {
  std::array<dvec3, 8> corners{};
  for (size_t i = 0; i < corners.size(); ++i)
    corners[i] =
        region.in_view({(i & 1) != 0 ? box.second.x : box.first.x, (i & 2) != 0 ? box.second.y : box.first.y,
                        (i & 4) != 0 ? box.second.z : box.first.z});
  return region.may_meet(corners);
}

bool has_surfaces(const Scene& scene, const Region& region) {
  if (!may_meet_box(region, {scene.bounds_min, scene.bounds_max})) return false;
  for (size_t i = first_placed_triangle(scene); i < scene.triangles.size(); ++i)
    if (region.meets_triangle(scene, static_cast<uint32_t>(i))) return true;
  const auto boxes = instance_bounds(scene);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    if (!may_meet_box(region, boxes[i])) continue;
    const interface::Instance& copy = scene.instances[i];
    const uint32_t count = scene.shared_meshes[mesh_index_of(scene, copy)].triangle_count;
    for (uint32_t k = 0; k < count; ++k)
      if (region.meets_triangle(scene, copy.first_number + k)) return true;
  }
  return false;
}

}  // namespace

double half_extent_at_near_plane(const SceneCamera& camera) {
  const auto [at_lens, growth] = half_extents(camera);
  return at_lens + camera.z_near * growth;
}

void drop_idle_planes(Scene& scene) {
  if (scene.cameras.size() * placed_triangle_count(scene) > MAX_TESTS) return;
  for (SceneCamera& camera : scene.cameras) {
    if (camera.z_near > 0 && !has_surfaces(scene, Region(camera, 0, camera.z_near))) camera.z_near = 0;
    if (camera.z_far < NO_FAR_PLANE &&
        !has_surfaces(scene, Region(camera, camera.z_far, std::numeric_limits<double>::infinity())))
      camera.z_far = NO_FAR_PLANE;
  }
}

}  // namespace regulus::scene

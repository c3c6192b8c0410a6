#include "scene/coincidence.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "scene/placement.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

using glm::dvec2;
using glm::dvec3;
using interface::INVALID_INDEX;

// Surfaces closer than this share of the scene's coordinates count as one: what rays cannot tell apart.
constexpr double ONE_PLANE = 1e-6;
// Area of the least triangles that are looked at whatever they are, in squares of the scene's extent.
constexpr double LEAST_AREA = 1e-5;
// Of two normals that count as parallel.
constexpr double PARALLEL_COSINE = 1 - 1e-7;
// Triangles overlap if they do so by more than this share of their size: neighbours share an edge.
constexpr double OVERLAP = 1e-4;
// Pairs that are compared; beyond this, the cautious answer is taken.
constexpr uint64_t MAX_PAIRS = 5'000'000;

struct Face {
  std::array<dvec3, 3> corners;
  dvec3 normal;
  uint32_t triangle;
};

/// Planes with the same key may be one.
struct Keyed {
  uint64_t key;
  uint32_t face;
  bool operator<(const Keyed& other) const { return std::pair(key, face) < std::pair(other.key, other.face); }
};

class Coincidences {
 public:
  explicit Coincidences(const Scene& scene) : scene_(scene) {
    const dvec3 far = glm::max(glm::abs(dvec3(scene.bounds_min)), glm::abs(dvec3(scene.bounds_max)));
    distance_ = ONE_PLANE * std::max({far.x, far.y, far.z});
    const double extent = glm::length(dvec3(scene.bounds_max) - dvec3(scene.bounds_min));
    for (size_t i = first_placed_triangle(scene); i < scene.triangles.size(); ++i)
      add(static_cast<uint32_t>(i), LEAST_AREA * extent * extent);
  }

  bool any() {
    std::vector<Keyed> keyed;
    for (uint32_t i = 0; i < faces_.size(); ++i) {
      const auto [first, second] = keys(faces_[i]);
      keyed.push_back({first, i});
      keyed.push_back({second, i});
    }
    std::sort(keyed.begin(), keyed.end());
    for (auto first = keyed.begin(); first != keyed.end();) {
      const auto last =
          std::find_if(first, keyed.end(), [&](const Keyed& other) { return other.key != first->key; });
      std::vector<uint32_t> plane;
      for (auto i = first; i != last; ++i) plane.push_back(i->face);
      if (any_in_plane(plane)) return true;
      first = last;
    }
    return false;
  }

 private:
  struct Extent {
    double low, high;
    uint32_t face;
  };

  /// Compares faces along the longer side of their plane.
  bool any_in_plane(const std::vector<uint32_t>& plane) {
    if (plane.size() < 2) return false;
    dvec3 lower(INFINITY), upper(-INFINITY);
    for (const uint32_t face : plane)
      for (const dvec3& corner : faces_[face].corners) {
        lower = glm::min(lower, corner);
        upper = glm::max(upper, corner);
      }
    const dvec3 size = upper - lower;
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    std::vector<Extent> extents;
    for (const uint32_t face : plane) {
      const auto& c = faces_[face].corners;
      const auto [low, high] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
      extents.push_back({low, high, face});
    }
    std::sort(extents.begin(), extents.end(), [](const Extent& a, const Extent& b) { return a.low < b.low; });
    for (size_t i = 0; i < extents.size(); ++i)
      for (size_t j = i + 1; j < extents.size() && extents[j].low < extents[i].high; ++j)
        if (++compared_ > MAX_PAIRS || matter(faces_[extents[i].face], faces_[extents[j].face])) return true;
    return false;
  }

  bool emits(uint32_t triangle) const { return scene_.triangles[triangle].light != INVALID_INDEX; }
  uint32_t solid_of(uint32_t triangle) const {
    return scene_.solids.of_triangle.empty() ? INVALID_INDEX : scene_.solids.of_triangle[triangle];
  }

  void add(uint32_t index, double least_area) {
    const interface::Triangle& t = scene_.triangles[index];
    Face face{{dvec3(scene_.vertices[t.v0].position), dvec3(scene_.vertices[t.v1].position),
               dvec3(scene_.vertices[t.v2].position)},
              dvec3(0),
              index};
    const dvec3 doubled = cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0]);
    const double length_of_normal = length(doubled);
    if (0.5 * length_of_normal < least_area && !emits(index) && solid_of(index) == INVALID_INDEX) return;
    if (!(length_of_normal > 0)) return;
    face.normal = doubled / length_of_normal;
    faces_.push_back(face);
  }

  /// Of the plane whichever way it faces; two, so that planes that are close share one.
  std::pair<uint64_t, uint64_t> keys(const Face& face) const {
    dvec3 normal = face.normal;
    const int axis = std::abs(normal.x) > 0.5 ? 0 : std::abs(normal.y) > 0.5 ? 1 : 2;
    if (normal[axis] < 0) normal = -normal;
    constexpr double STEPS = 128;
    uint64_t key = 0;
    for (int i = 0; i < 3; ++i) key = key << 10 | static_cast<uint64_t>(std::lround(STEPS * normal[i]) + 512);
    const double place =
        dot(normal, (face.corners[0] + face.corners[1] + face.corners[2]) / 3.0) / (8 * distance_);
    const auto mixed = [&](double offset, uint64_t which) {
      const auto cell = static_cast<uint64_t>(static_cast<int64_t>(std::floor(place + offset)));
      return (key * 0x9E3779B97F4A7C15) ^ (2 * cell + which) * 0xBF58476D1CE4E5B9;
    };
    return {mixed(0, 0), mixed(0.5, 1)};
  }

  static auto bytes_of(const interface::Material& material) {
    return std::bit_cast<std::array<std::byte, sizeof(material)>>(material);
  }

  bool matter(const Face& a, const Face& b) const {
    const double facing = dot(a.normal, b.normal);
    if (std::abs(facing) < PARALLEL_COSINE) return false;
    const uint32_t solid_a = solid_of(a.triangle), solid_b = solid_of(b.triangle);
    const bool is_plain = solid_a == INVALID_INDEX && solid_b == INVALID_INDEX;
    const bool is_same_solid = !is_plain && solid_a == solid_b;
    const bool one_emits = emits(a.triangle) || emits(b.triangle);
    const interface::Material& material_a = scene_.materials[scene_.triangles[a.triangle].material];
    const interface::Material& material_b = scene_.materials[scene_.triangles[b.triangle].material];
    const bool differ = bytes_of(material_a) != bytes_of(material_b);
    if (is_same_solid || (is_plain && !one_emits && !differ)) return false;
    // The bottom of a box on a floor: nothing is seen of either. The two faces of a leaf have common corners.
    if (is_plain && !one_emits && facing < 0 && common_corners(a, b) < 2) return false;
    for (const dvec3& corner : b.corners)
      if (std::abs(dot(a.normal, corner - a.corners[0])) > distance_) return false;
    return overlap(a, b);
  }

  int64_t common_corners(const Face& a, const Face& b) const {
    return std::count_if(a.corners.begin(), a.corners.end(), [&](const dvec3& corner) {
      return std::any_of(b.corners.begin(), b.corners.end(),
                         [&](const dvec3& other) { return glm::distance(corner, other) <= distance_; });
    });
  }

  /// In the plane of a, by separating axes.
  static bool overlap(const Face& a, const Face& b) {
    const dvec3 x = normalize(a.corners[1] - a.corners[0]), y = cross(a.normal, x);
    const auto flat = [&](const Face& face) {
      std::array<dvec2, 3> points;
      for (size_t i = 0; i < 3; ++i)
        points[i] = {dot(face.corners[i] - a.corners[0], x), dot(face.corners[i] - a.corners[0], y)};
      return points;
    };
    const std::array<dvec2, 3> p = flat(a), q = flat(b);
    for (const auto* triangle : {&p, &q})
      for (size_t i = 0; i < 3; ++i) {
        const dvec2 edge = (*triangle)[(i + 1) % 3] - (*triangle)[i];
        const dvec2 axis = dvec2(-edge.y, edge.x) / length(edge);
        const auto [low_p, high_p] = range(p, axis);
        const auto [low_q, high_q] = range(q, axis);
        const double least = OVERLAP * std::min(high_p - low_p, high_q - low_q);
        if (std::min(high_p, high_q) - std::max(low_p, low_q) <= least) return false;
      }
    return true;
  }

  static std::pair<double, double> range(const std::array<dvec2, 3>& points, const dvec2& axis) {
    const auto [low, high] = std::minmax({dot(points[0], axis), dot(points[1], axis), dot(points[2], axis)});
    return {low, high};
  }

  const Scene& scene_;
  double distance_ = 0;
  std::vector<Face> faces_;
  uint64_t compared_ = 0;
};

}  // namespace

bool has_coincident_surfaces(const Scene& scene) {
  return Coincidences(scene).any();
}

}  // namespace regulus::scene

#include "scene/coplanar.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

using glm::dvec2;
using glm::dvec3;

// Surfaces closer than this share of the scene's coordinates count as one.
constexpr double ONE_PLANE = 1e-6;
// Of two normals that count as parallel.
constexpr double PARALLEL_COSINE = 1 - 1e-7;
// Triangles overlap if they do so by more than this share of their size: neighbours share an edge.
constexpr double OVERLAP = 1e-4;
// Pairs that are visited at most.
constexpr uint64_t MAX_VISITED_PAIRS = 5'000'000;

/// Planes with the same key may be one.
struct Keyed {
  uint64_t key;
  uint32_t face;
  bool operator<(const Keyed& other) const { return std::pair(key, face) < std::pair(other.key, other.face); }
};

/// Of the plane whichever way it faces; two, so that planes that are close share one.
std::pair<uint64_t, uint64_t> keys(const Face& face, double distance) {
  dvec3 normal = face.normal;
  const int axis = std::abs(normal.x) > 0.5 ? 0 : std::abs(normal.y) > 0.5 ? 1 : 2;
  if (normal[axis] < 0) normal = -normal;
  constexpr double STEPS = 128;
  uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = key << 10 | static_cast<uint64_t>(std::lround(STEPS * normal[i]) + 512);
  const double place =
      dot(normal, (face.corners[0] + face.corners[1] + face.corners[2]) / 3.0) / (8 * distance);
  const auto mixed = [&](double offset, uint64_t which) {
    const auto cell = static_cast<uint64_t>(static_cast<int64_t>(std::floor(place + offset)));
    return (key * 0x9E3779B97F4A7C15) ^ (2 * cell + which) * 0xBF58476D1CE4E5B9;
  };
  return {mixed(0, 0), mixed(0.5, 1)};
}

std::pair<double, double> range(const std::array<dvec2, 3>& points, const dvec2& axis) {
  const auto [low, high] = std::minmax({dot(points[0], axis), dot(points[1], axis), dot(points[2], axis)});
  return {low, high};
}

/// Visits the pairs of some faces along the longer side of their plane.
class PlanePairs {
 public:
  PlanePairs(const std::vector<Face>& faces, const std::function<bool(const Face&, const Face&)>& visit)
      : faces_(faces), visit_(visit) {}

  /// False once there is no more to be done.
  bool visit(const std::vector<uint32_t>& plane) {
    if (plane.size() < 2) return true;
    const int axis = longest_axis(plane);
    std::vector<Extent> extents;
    for (const uint32_t face : plane) {
      const auto& c = faces_[face].corners;
      const auto [low, high] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
      extents.push_back({low, high, face});
    }
    std::sort(extents.begin(), extents.end(), [](const Extent& a, const Extent& b) { return a.low < b.low; });
    for (size_t i = 0; i < extents.size(); ++i)
      for (size_t j = i + 1; j < extents.size() && extents[j].low < extents[i].high; ++j) {
        if (++visited_ > MAX_VISITED_PAIRS) return false;
        if (visit_(faces_[extents[i].face], faces_[extents[j].face])) return false;
      }
    return true;
  }

  bool is_too_much() const { return visited_ > MAX_VISITED_PAIRS; }

 private:
  struct Extent {
    double low, high;
    uint32_t face;
  };

  int longest_axis(const std::vector<uint32_t>& plane) const {
    dvec3 lower(INFINITY), upper(-INFINITY);
    for (const uint32_t face : plane)
      for (const dvec3& corner : faces_[face].corners) {
        lower = glm::min(lower, corner);
        upper = glm::max(upper, corner);
      }
    const dvec3 size = upper - lower;
    return size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
  }

  const std::vector<Face>& faces_;
  const std::function<bool(const Face&, const Face&)>& visit_;
  uint64_t visited_ = 0;
};

}  // namespace

std::optional<Face> face_of(const Scene& scene, uint32_t triangle) {
  const interface::Triangle& t = scene.triangles[triangle];
  Face face{{dvec3(scene.vertices[t.v0].position), dvec3(scene.vertices[t.v1].position),
             dvec3(scene.vertices[t.v2].position)},
            dvec3(0),
            0,
            triangle};
  const dvec3 doubled = cross(face.corners[1] - face.corners[0], face.corners[2] - face.corners[0]);
  face.area = 0.5 * length(doubled);
  if (!(face.area > 0)) return std::nullopt;
  face.normal = doubled / (2 * face.area);
  return face;
}

double distance_of_coincidence(const Scene& scene) {
  const dvec3 far = glm::max(glm::abs(dvec3(scene.bounds_min)), glm::abs(dvec3(scene.bounds_max)));
  return ONE_PLANE * std::max({far.x, far.y, far.z});
}

bool overlap_in_plane(const Face& a, const Face& b, double distance) {
  if (std::abs(dot(a.normal, b.normal)) < PARALLEL_COSINE) return false;
  for (const dvec3& corner : b.corners)
    if (std::abs(dot(a.normal, corner - a.corners[0])) > distance) return false;
  // In the plane of a, by separating axes.
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

bool visit_coplanar_pairs(const std::vector<Face>& faces, double distance,
                          const std::function<bool(const Face&, const Face&)>& visit) {
  std::vector<Keyed> keyed;
  for (uint32_t i = 0; i < faces.size(); ++i) {
    const auto [first, second] = keys(faces[i], distance);
    keyed.push_back({first, i});
    keyed.push_back({second, i});
  }
  std::sort(keyed.begin(), keyed.end());
  PlanePairs pairs(faces, visit);
  for (auto first = keyed.begin(); first != keyed.end();) {
    const auto last =
        std::find_if(first, keyed.end(), [&](const Keyed& other) { return other.key != first->key; });
    std::vector<uint32_t> plane;
    for (auto i = first; i != last; ++i) plane.push_back(i->face);
    if (!pairs.visit(plane)) break;
    first = last;
  }
  return !pairs.is_too_much();
}

}  // namespace regulus::scene

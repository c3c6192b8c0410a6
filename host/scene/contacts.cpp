// find_contacts: whether solids nest, touch or hold a camera or a light, and what holds those.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "interface/wavefront.h"
#include "scene/clipping.hpp"
#include "scene/coincidence.hpp"
#include "scene/scene.hpp"
#include "scene/solids.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using interface::INVALID_INDEX;
using interface::MEDIA_VARY;

// Boxes that come closer than this share of their coordinates count as touching.
constexpr double TOUCHING = 1e-5;
// Solids thinner than this share of their coordinates: the offsets of rays' origins, some 1e-6 of them, would
// matter to what they absorb, or (the second) to whether they are met.
constexpr double THIN = 1e-3, HARDLY_THERE = 3e-5;
// Pairs of triangles or of triangles and points that are looked at; beyond this, the cautious answer is
// taken.
constexpr uint64_t MAX_PAIRS = 200'000'000;

struct Box {
  dvec3 lower{INFINITY}, upper{-INFINITY};

  void extend(const dvec3& point) {
    lower = glm::min(lower, point);
    upper = glm::max(upper, point);
  }
  double scale() const {
    const dvec3 size = glm::max(glm::abs(lower), glm::abs(upper));
    return std::max({size.x, size.y, size.z});
  }
};

bool touch(const Box& a, const Box& b) {
  const dvec3 margin(TOUCHING * std::max(a.scale(), b.scale()));
  return glm::all(glm::lessThanEqual(a.lower - margin, b.upper)) &&
         glm::all(glm::lessThanEqual(b.lower - margin, a.upper));
}

/// Solid angle of a triangle seen from the origin, signed. Van Oosterom and Strackee 1983.
double solid_angle(const std::array<dvec3, 3>& p) {
  const double a = length(p[0]), b = length(p[1]), c = length(p[2]);
  const double numerator = dot(p[0], cross(p[1], p[2]));
  const double denominator = a * b * c + dot(p[0], p[1]) * c + dot(p[1], p[2]) * a + dot(p[2], p[0]) * b;
  return 2 * std::atan2(numerator, denominator);
}

/// The scene's solids with their triangles.
class SolidGeometry {
 public:
  explicit SolidGeometry(const Scene& scene) : scene_(scene), triangles_(scene.solids.ranked.size()) {
    for (uint32_t i = 0; i < scene.solids.of_triangle.size(); ++i)
      if (scene.solids.of_triangle[i] != INVALID_INDEX) triangles_[scene.solids.of_triangle[i]].push_back(i);
    for (const RankedSolid& solid : scene.solids.ranked) boxes_.push_back({solid.lower, solid.upper});
  }

  size_t count() const { return boxes_.size(); }
  const Box& box(size_t solid) const { return boxes_[solid]; }
  const RankedSolid& solid(size_t i) const { return scene_.solids.ranked[i]; }

  Box box_of_triangle(uint32_t triangle) const {
    Box box;
    for (const dvec3& corner : corners(triangle)) box.extend(corner);
    return box;
  }

  std::array<dvec3, 3> corners(uint32_t index) const {
    const interface::Triangle& t = scene_.triangles[index];
    return {dvec3(scene_.vertices[t.v0].position), dvec3(scene_.vertices[t.v1].position),
            dvec3(scene_.vertices[t.v2].position)};
  }

  /// True if the point lies inside a closed solid: by the solid angle of its surface.
  bool holds(size_t solid, const dvec3& point) {
    if (!this->solid(solid).is_closed || !touch(boxes_[solid], Box{point, point})) return false;
    double sum = 0;
    for (const uint32_t triangle : triangles_[solid]) {
      std::array<dvec3, 3> p = corners(triangle);
      for (dvec3& corner : p) corner -= point;
      sum += solid_angle(p);
    }
    pairs_ += triangles_[solid].size();
    return sum > 2 * std::numbers::pi;
  }

  /// True if some part of the solid's surface may touch a box.
  bool surface_touches(size_t solid, const Box& box) {
    if (!touch(boxes_[solid], box)) return false;
    pairs_ += triangles_[solid].size();
    return std::any_of(triangles_[solid].begin(), triangles_[solid].end(),
                       [&](uint32_t triangle) { return touch(box_of_triangle(triangle), box); });
  }

  /// True if the surfaces of two solids may touch, or one lies in the other.
  bool in_contact(size_t a, size_t b) {
    if (!touch(boxes_[a], boxes_[b])) return false;
    std::vector<Box> near;
    for (const uint32_t triangle : triangles_[a]) {
      const Box box = box_of_triangle(triangle);
      if (touch(box, boxes_[b])) near.push_back(box);
    }
    pairs_ += triangles_[a].size() + near.size() * triangles_[b].size();
    if (is_too_much()) return true;
    for (const uint32_t triangle : triangles_[b]) {
      const Box box = box_of_triangle(triangle);
      if (std::any_of(near.begin(), near.end(), [&](const Box& other) { return touch(box, other); }))
        return true;
    }
    return holds(a, corners(triangles_[b].front())[0]) || holds(b, corners(triangles_[a].front())[0]);
  }

  /// More has been looked at than is worth the time.
  bool is_too_much() const { return pairs_ > MAX_PAIRS; }

 private:
  const Scene& scene_;
  std::vector<std::vector<uint32_t>> triangles_;  // by solid
  std::vector<Box> boxes_;
  uint64_t pairs_ = 0;
};

bool solids_are_in_contact(SolidGeometry& geometry) {
  std::vector<size_t> order(geometry.count());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return geometry.box(a).lower.x < geometry.box(b).lower.x; });
  uint64_t compared = 0;
  for (size_t i = 0; i < order.size(); ++i)
    for (size_t j = i + 1; j < order.size(); ++j) {
      const Box &a = geometry.box(order[i]), &b = geometry.box(order[j]);
      if (b.lower.x > a.upper.x + TOUCHING * std::max(a.scale(), b.scale())) break;
      if (++compared > MAX_PAIRS || geometry.in_contact(order[i], order[j])) return true;
    }
  return false;
}

/// A solid so thin for its distance from the origin that rays must be followed with more care.
bool has_thin_solid(const Scene& scene) {
  return std::any_of(scene.solids.ranked.begin(), scene.solids.ranked.end(), [&](const RankedSolid& solid) {
    const bool absorbs = scene.materials[solid.material].absorption != glm::vec3(0);
    const double thickness = 2 * solid.volume / solid.area;
    const Box box{solid.lower, solid.upper};
    return solid.is_closed && thickness < (absorbs ? THIN : HARDLY_THERE) * box.scale();
  });
}

/// Where paths start: a box of points, and one of them.
struct Start {
  Box box;
  dvec3 point{0};
};

/// Numbers of media sets.
class StartFinder {
 public:
  StartFinder(SolidGeometry& geometry, std::vector<interface::MediaSet>& sets)
      : geometry_(geometry), sets_(sets) {}

  /// Index of the set, or MEDIA_VARY if it may not be the same for all points or would take too long to find.
  uint32_t find(const Start& start) {
    interface::MediaSet set = empty_media_set();
    int count = 0;
    const bool is_point = start.box.lower == start.box.upper;
    for (uint32_t i = 0; i < geometry_.count(); ++i) {
      if (geometry_.is_too_much()) return MEDIA_VARY;
      if (!geometry_.solid(i).is_closed || !touch(geometry_.box(i), start.box)) continue;
      if (!is_point && geometry_.surface_touches(i, start.box)) return MEDIA_VARY;
      if (count == int{interface::MEDIA_SET_SIZE} || !geometry_.holds(i, start.point)) continue;
      (count < 4 ? set.a[count] : set.b[count - 4]) = i;
      ++count;
    }
    const auto found = std::find_if(sets_.begin(), sets_.end(), [&](const interface::MediaSet& other) {
      return other.a == set.a && other.b == set.b;
    });
    const auto index = static_cast<uint32_t>(found - sets_.begin());
    if (index == sets_.size()) sets_.push_back(set);
    return index;
  }

 private:
  SolidGeometry& geometry_;
  std::vector<interface::MediaSet>& sets_;
};

Start start_of_camera(const SceneCamera& camera, const Box& bounds) {
  const dvec3 position(camera.camera_to_world[3]);
  Start start{{position, position}, position};
  const bool is_clipped = camera.z_near > 0;  // rays then start at that plane
  if (is_clipped) {
    const dvec3 on_plane = position - double{camera.z_near} * normalize(dvec3(camera.camera_to_world[2]));
    start = {{on_plane, on_plane}, on_plane};
  }
  if (!camera.is_orthographic && camera.lens_radius == 0 && !is_clipped) return start;
  // How wide the film is, is known with its size only: as far as there is anything.
  const double reach = camera.is_orthographic ? length(bounds.upper - bounds.lower)
                       : is_clipped           ? half_extent_at_near_plane(camera)
                                              : double{camera.lens_radius};
  for (const int column : {0, 1}) {
    const dvec3 axis = normalize(dvec3(camera.camera_to_world[column]));
    start.box.lower -= reach * glm::abs(axis);
    start.box.upper += reach * glm::abs(axis);
  }
  return start;
}

std::optional<Start> start_of_light(const SolidGeometry& geometry, const interface::Light& light) {
  if (light.kind == interface::LIGHT_TRIANGLE) {
    const std::array<dvec3, 3> p = geometry.corners(light.triangle);
    return Start{geometry.box_of_triangle(light.triangle), (p[0] + p[1] + p[2]) / 3.0};
  }
  if (light.kind != interface::LIGHT_POINT && light.kind != interface::LIGHT_SPOT) return std::nullopt;
  const dvec3 position(light.position);
  return Start{{position, position}, position};
}

}  // namespace

uint32_t medium_of_lens(const Scene& scene, size_t camera) {
  const Solids& solids = scene.solids;
  if (camera >= solids.of_lens.size()) return INVALID_INDEX;
  const interface::MediaSet& set = solids.media_sets[solids.of_lens[camera]];
  const glm::uvec4 least = glm::min(set.a, set.b);
  const uint32_t first = std::min({least.x, least.y, least.z, least.w});
  return first == INVALID_INDEX ? INVALID_INDEX : solids.records[first].material;
}

void find_contacts(Scene& scene) {
  Solids& solids = scene.solids;
  solids.media_sets = {empty_media_set()};
  solids.of_camera.assign(scene.cameras.size(), 0);
  solids.of_lens.assign(scene.cameras.size(), 0);
  solids.of_light.assign(scene.lights.size(), 0);
  solids.has_contacts = false;
  if (!solids.ranked.empty()) {
    SolidGeometry geometry(scene);
    solids.has_contacts = has_thin_solid(scene) || solids_are_in_contact(geometry);
    StartFinder finder(geometry, solids.media_sets);
    const Box bounds{dvec3(scene.bounds_min), dvec3(scene.bounds_max)};
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
      solids.of_camera[i] = finder.find(start_of_camera(scene.cameras[i], bounds));
      const dvec3 position(scene.cameras[i].camera_to_world[3]);
      // Where that takes too long to find: in air.
      const uint32_t set = finder.find({{position, position}, position});
      if (set != MEDIA_VARY) solids.of_lens[i] = set;
    }
    for (size_t i = 0; i < scene.lights.size(); ++i)
      if (const auto start = start_of_light(geometry, scene.lights[i]))
        solids.of_light[i] = finder.find(*start);
  }
  const auto is_inside = [](uint32_t set) { return set != 0; };
  solids.has_contacts = solids.has_contacts || std::ranges::any_of(solids.of_camera, is_inside) ||
                        std::ranges::any_of(solids.of_lens, is_inside) ||
                        std::ranges::any_of(solids.of_light, is_inside) || has_coincident_surfaces(scene);
}

}  // namespace regulus::scene

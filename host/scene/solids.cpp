// find_solids: connected parts of surfaces, whether they are closed, and their ranks.
#include "scene/solids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/disjoint_sets.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using interface::INVALID_INDEX;
using interface::Triangle;

// Share of the length of all edges that may lack a partner: cracks that dropped triangles without area leave.
constexpr double OPEN_SHARE = 1e-3;
// Moments of a border that cancels, in the part's radius per length of the border.
constexpr double CANCELLED = 1e-5;
// Vertices at borders that are no further apart are one, as a share of their coordinates.
constexpr double WELDING = 1e-6;
// Beyond this many a triangle's tag cannot tell them apart.
constexpr size_t MAX_SOLIDS = interface::TRIANGLE_TAG_SOLID_MASK - 1;

bool bounds_solid(const interface::Material& material) {
  constexpr uint32_t ALPHA = interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND;
  // Through the holes of a surface paths enter and leave unnoticed.
  return material.material_class == interface::MATERIAL_CLASS_TRANSMISSIVE &&
         (material.flags & interface::MATERIAL_VOLUME) != 0 && (material.flags & ALPHA) == 0;
}

std::array<dvec3, 3> corners_of(const Scene& scene, uint32_t index) {
  const Triangle& t = scene.triangles[index];
  return {dvec3(scene.vertices[t.v0].position), dvec3(scene.vertices[t.v1].position),
          dvec3(scene.vertices[t.v2].position)};
}

/// Vertices at the same position have the same number: seams of normals and coordinates are no holes.
class Welder {
 public:
  uint32_t number(const glm::vec3& position) {
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x == 0 ? 0.0F : x); };
    const Key key{bits(position.x), bits(position.y), bits(position.z)};
    return numbers_.try_emplace(key, static_cast<uint32_t>(numbers_.size())).first->second;
  }
  size_t count() const { return numbers_.size(); }

 private:
  using Key = std::array<uint32_t, 3>;
  struct Hash {
    size_t operator()(const Key& key) const {
      uint64_t h = 0;
      for (const uint32_t word : key) h = (h ^ word) * 0x9E3779B97F4A7C15 ^ (h >> 29);
      return static_cast<size_t>(h);
    }
  };
  std::unordered_map<Key, uint32_t, Hash> numbers_;
};

/// A connected part of a surface.
struct Part {
  RankedSolid solid;
  std::vector<uint32_t> triangles;
  std::map<uint32_t, double> area_of_material;
};

bool contains_box(const RankedSolid& outer, const RankedSolid& inner) {
  return glm::all(glm::lessThanEqual(outer.lower, inner.lower)) &&
         glm::all(glm::greaterThanEqual(outer.upper, inner.upper));
}

/// A side of a triangle between two welded vertices: from the one of lower number to the other, or back.
struct Side {
  uint32_t member;  // which triangle of the place
  bool is_forward;
};
using Edges = std::unordered_map<uint64_t, std::vector<Side>>;

/// Takes the triangles of one place apart.
class PlaceParts {
 public:
  PlaceParts(const Scene& scene, const std::vector<uint32_t>& triangles)
      : scene_(scene), triangles_(triangles) {
    weld();
    edges_ = find_edges();
    if (weld_borders()) edges_ = find_edges();
    DisjointSets sets(triangles.size());
    for (const auto& [key, sides] : edges_) join_sides(key, sides, sets);
    join_borders(sets);
    std::unordered_map<uint32_t, size_t> part_of_root;
    for (uint32_t i = 0; i < triangles.size(); ++i) {
      const size_t part = part_of_root.try_emplace(sets.root(i), parts_.size()).first->second;
      if (part == parts_.size()) parts_.emplace_back();
      part_of_member_.push_back(part);
      parts_[part].triangles.push_back(triangles[i]);
    }
    for (Part& part : parts_) measure(part);
    find_closed();
  }

  std::vector<Part> take() && { return std::move(parts_); }

 private:
  using Corners = std::array<uint32_t, 3>;

  void weld() {
    Welder welder;
    for (const uint32_t index : triangles_) {
      const Triangle& t = scene_.triangles[index];
      Corners corners{};
      size_t i = 0;
      for (const uint32_t v : {t.v0, t.v1, t.v2}) {
        const glm::vec3& position = scene_.vertices[v].position;
        corners[i++] = welder.number(position);
        if (welder.count() > positions_.size()) positions_.emplace_back(position);
      }
      corners_.push_back(corners);
    }
  }

  Edges find_edges() const {
    Edges edges;
    for (uint32_t member = 0; member < corners_.size(); ++member)
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = corners_[member][i], b = corners_[member][(i + 1) % 3];
        if (a != b) edges[uint64_t{std::min(a, b)} << 32 | std::max(a, b)].push_back({member, a < b});
      }
    return edges;
  }

  static int balance(const std::vector<Side>& sides) {
    int sum = 0;
    for (const Side& side : sides) sum += side.is_forward ? 1 : -1;
    return sum;
  }

  /// Vertices at borders that are a few roundings apart become one: poles and seams of what was computed.
  bool weld_borders() {
    std::map<uint32_t, uint32_t> becomes;
    double scale = 0;
    for (const auto& [key, sides] : edges_) {
      if (balance(sides) == 0) continue;
      for (const uint32_t vertex : {static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key)}) {
        becomes[vertex] = vertex;
        const dvec3 size = glm::abs(positions_[vertex]);
        scale = std::max({scale, size.x, size.y, size.z});
      }
    }
    const double apart = WELDING * scale;
    if (becomes.empty() || !(apart > 0)) return false;
    std::map<std::array<int64_t, 3>, std::vector<uint32_t>> cells;
    bool has_changed = false;
    for (auto& [vertex, other] : becomes) {
      const dvec3& position = positions_[vertex];
      std::array<int64_t, 3> cell{};
      for (int axis = 0; axis < 3; ++axis)
        cell[static_cast<size_t>(axis)] = static_cast<int64_t>(std::floor(position[axis] / (2 * apart)));
      for (int64_t i = 0; i < 27 && other == vertex; ++i) {
        const auto near = cells.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
        if (near == cells.end()) continue;
        for (const uint32_t candidate : near->second)
          if (glm::distance(positions_[candidate], position) <= apart) other = candidate;
      }
      has_changed = has_changed || other != vertex;
      if (other == vertex) cells[cell].push_back(vertex);
    }
    for (Corners& corners : corners_)
      for (uint32_t& corner : corners)
        if (const auto found = becomes.find(corner); found != becomes.end()) corner = found->second;
    return has_changed;
  }

  /// Direction in which a triangle lies beside an edge, in the plane across the edge.
  dvec3 beside(const Side& side, const dvec3& from, const dvec3& along) const {
    dvec3 middle(0);
    for (const uint32_t corner : corners_[side.member]) middle += positions_[corner] / 3.0;
    const dvec3 out = middle - from;
    return out - dot(out, along) * along;
  }

  /// Connects triangles across an edge. Where more than two meet, as where two blocks touch, each is
  /// connected to the next one through the inside.
  void join_sides(uint64_t key, const std::vector<Side>& sides, DisjointSets& sets) const {
    if (sides.size() == 2) {
      sets.join(sides[1].member, sides[0].member);
      return;
    }
    const dvec3 from = positions_[key >> 32];
    const dvec3 along = glm::normalize(positions_[static_cast<uint32_t>(key)] - from);
    for (const Side& side : sides) {
      if (!side.is_forward) continue;
      // Its front is on the left of the edge, seen with the triangle ahead: the inside is turned the other
      // way.
      const dvec3 ahead = beside(side, from, along), inwards = cross(ahead, along);
      const Side* next = nullptr;
      double least = INFINITY;
      for (const Side& other : sides) {
        if (other.is_forward) continue;
        const dvec3 direction = beside(other, from, along);
        double angle = std::atan2(dot(direction, inwards), dot(direction, ahead));
        if (angle < 1e-6) angle += 2 * std::numbers::pi;
        if (angle < least) next = &other;
        least = std::min(least, angle);
      }
      if (next != nullptr) sets.join(next->member, side.member);
    }
  }

  /// Where edges have no partners, as where two sides of a box are cut differently, common vertices connect.
  void join_borders(DisjointSets& sets) const {
    std::unordered_map<uint32_t, uint32_t> member_at;
    for (const auto& [key, sides] : edges_) {
      if (balance(sides) == 0) continue;
      for (const Side& side : sides)
        for (const uint32_t vertex : {static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key)})
          sets.join(member_at.try_emplace(vertex, side.member).first->second, side.member);
    }
  }

  void measure(Part& part) const {
    RankedSolid& solid = part.solid;
    solid.place = scene_.triangles[part.triangles.front()].instance;
    solid.lower = dvec3(INFINITY);
    solid.upper = -solid.lower;
    // Volumes from the part's own place: far from the origin they would cancel.
    const dvec3 origin = corners_of(scene_, part.triangles.front())[0];
    for (const uint32_t index : part.triangles) {
      const std::array<dvec3, 3> p = corners_of(scene_, index);
      for (const dvec3& v : p) {
        solid.lower = glm::min(solid.lower, v);
        solid.upper = glm::max(solid.upper, v);
      }
      const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double area = 0.5 * glm::length(normal);
      solid.area += area;
      solid.volume += glm::dot(p[0] - origin, normal) / 6;
      part.area_of_material[scene_.triangles[index].material] += area;
    }
    const auto largest = std::max_element(part.area_of_material.begin(), part.area_of_material.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    solid.material = largest->first;
  }

  /// What is left of a part's edges when those in opposite directions are taken away.
  struct Border {
    double whole = 0, open = 0;  // length of all edges and of those without partners
    std::array<double, 30>
        moments{};  // sums of 1, x and x x (components, from the part's box) times the edges' vectors

    void add(const dvec3& from, const dvec3& to, int times) {
      const dvec3 edge = double(times) * (to - from), middle = 0.5 * (from + to);
      open += glm::length(edge);
      size_t next = 0;
      const auto add_scaled = [&](double scale) {
        for (int i = 0; i < 3; ++i) moments[next++] += scale * edge[i];
      };
      add_scaled(1);
      for (int i = 0; i < 3; ++i) add_scaled(middle[i]);
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j)  // the mean of the product along the edge, by Simpson's rule
          add_scaled((from[i] * from[j] + 4 * middle[i] * middle[j] + to[i] * to[j]) / 6);
    }

    /// Edges that are cut differently on both sides cancel all the same; a hole has an area.
    bool is_closed() const {
      if (open <= OPEN_SHARE * whole) return true;
      return std::all_of(moments.begin(), moments.end(),
                         [&](double moment) { return std::abs(moment) <= CANCELLED * open; });
    }
  };

  void find_closed() {
    std::vector<Border> borders(parts_.size());
    for (const auto& [key, sides] : edges_) {
      const dvec3 &from = positions_[key >> 32], &to = positions_[static_cast<uint32_t>(key)];
      std::map<size_t, int> balances;
      for (const Side& side : sides) balances[part_of_member_[side.member]] += side.is_forward ? 1 : -1;
      for (const auto& [part, sum] : balances) {
        const RankedSolid& solid = parts_[part].solid;
        const dvec3 center = 0.5 * (solid.lower + solid.upper);
        const double radius = 0.5 * glm::distance(solid.lower, solid.upper);
        borders[part].whole += glm::distance(from, to) / radius;
        if (sum == 0) continue;
        borders[part].add((from - center) / radius, (to - center) / radius, sum);
      }
    }
    for (size_t part = 0; part < parts_.size(); ++part)
      parts_[part].solid.is_closed = borders[part].is_closed();
  }

  const Scene& scene_;
  const std::vector<uint32_t>& triangles_;
  std::vector<Corners> corners_;  // by triangle of the place: welded vertices
  std::vector<dvec3> positions_;  // of welded vertices
  Edges edges_;
  std::vector<Part> parts_;
  std::vector<size_t> part_of_member_;
};

void absorb(Part& part, Part&& other) {
  part.triangles.insert(part.triangles.end(), other.triangles.begin(), other.triangles.end());
  part.solid.volume += other.solid.volume;
  part.solid.area += other.solid.area;
  part.solid.lower = glm::min(part.solid.lower, other.solid.lower);
  part.solid.upper = glm::max(part.solid.upper, other.solid.upper);
}

/// The smallest solid around a part, by boxes; null: none.
Part* smallest_around(std::vector<Part>& solids, const Part& part) {
  Part* smallest = nullptr;
  for (Part& solid : solids)
    if (contains_box(solid.solid, part.solid) &&
        (smallest == nullptr || solid.solid.volume < smallest->solid.volume))
      smallest = &solid;
  return smallest;
}

/// Gives cavities to the solids around them, and makes what is open one solid. Closed surfaces whose fronts
/// face inwards and that lie in no solid go to `inverted`.
std::vector<Part> join_parts(std::vector<Part> parts, std::vector<Part>& inverted) {
  std::vector<Part> solids, rest;
  Part open;
  for (Part& part : parts)
    (part.solid.is_closed && part.solid.volume > 0 ? solids : rest).push_back(std::move(part));
  std::vector<Part*> around;  // before cavities take from their volumes
  around.reserve(rest.size());
  for (const Part& part : rest)
    around.push_back(part.solid.is_closed ? smallest_around(solids, part) : nullptr);
  for (size_t i = 0; i < rest.size(); ++i) {
    if (around[i] != nullptr) {
      absorb(*around[i], std::move(rest[i]));
    } else if (rest[i].solid.is_closed && rest[i].solid.volume < 0) {
      inverted.push_back(std::move(rest[i]));
    } else if (open.triangles.empty()) {
      open = std::move(rest[i]);
      open.solid.is_closed = false;
    } else {
      absorb(open, std::move(rest[i]));
    }
  }
  if (!open.triangles.empty()) {
    const dvec3 size = open.solid.upper - open.solid.lower;
    open.solid.volume = size.x * size.y * size.z;
    solids.push_back(std::move(open));
  }
  return solids;
}

/// Turns a part inside out: its fronts become its backs, and its normals follow unless they do already.
void turn(Scene& scene, Part& part) {
  std::set<uint32_t> vertices;
  double agreement = 0;
  for (const uint32_t index : part.triangles) {
    Triangle& t = scene.triangles[index];
    std::swap(t.v1, t.v2);
    const std::array<dvec3, 3> p = corners_of(scene, index);
    const dvec3 normal = cross(p[1] - p[0], p[2] - p[0]);
    for (const uint32_t vertex : {t.v0, t.v1, t.v2}) {
      agreement += dot(normal, dvec3(scene.vertices[vertex].normal));
      vertices.insert(vertex);
    }
  }
  part.solid.volume = -part.solid.volume;
  if (agreement >= 0) return;
  for (const uint32_t vertex : vertices) {
    scene.vertices[vertex].normal = -scene.vertices[vertex].normal;
    if (!scene.vertex_tangents.empty()) scene.vertex_tangents[vertex].w *= -1;
  }
}

/// True if a material's surface does nothing to light but for the index of refraction.
bool is_clear(const interface::Material& m) {
  for (const uint32_t texture : {m.base_color_texture, m.metallic_roughness_texture, m.specular_texture,
                                 m.specular_color_texture, m.transmission_texture, m.normal_texture})
    if (texture != INVALID_INDEX) return false;
  return m.base_color == glm::vec3(1) && m.metallic == 0 && m.transmission == 1 && m.clearcoat == 0 &&
         m.sheen_color == glm::vec3(0) && m.iridescence == 0 && (m.flags & interface::MATERIAL_EMISSIVE) == 0;
}

/// Materials between whose solids light passes as if there was nothing: the same one, or clear ones of the
/// same index, dispersion and absorption.
std::vector<uint32_t> substances(const Scene& scene) {
  std::map<std::tuple<float, float, float, float, float>, uint32_t> clear;
  std::vector<uint32_t> result;
  for (uint32_t i = 0; i < scene.materials.size(); ++i) {
    const interface::Material& m = scene.materials[i];
    result.push_back(i);
    if (!scene.vertex_colors.empty() || !is_clear(m)) continue;
    const std::tuple key(m.ior, m.dispersion, m.absorption.x, m.absorption.y, m.absorption.z);
    result.back() = clear.try_emplace(key, i).first->second;
  }
  return result;
}

/// Closed surfaces whose fronts face inwards: cavities of a solid of the same substance around them, in
/// whichever mesh that is, or else solids that were modelled inside out, with what their meshes meant as
/// their cavities.
void join_inverted(Scene& scene, const std::vector<uint32_t>& substance, std::vector<Part> inverted,
                   std::vector<Part>& parts) {
  std::vector<Part> turned;
  for (Part& part : inverted) {
    Part* around = nullptr;
    for (Part& solid : parts)
      if (solid.solid.is_closed && substance[solid.solid.material] == substance[part.solid.material] &&
          contains_box(solid.solid, part.solid) &&
          (around == nullptr || solid.solid.volume < around->solid.volume))
        around = &solid;
    if (around != nullptr) {
      absorb(*around, std::move(part));
      continue;
    }
    turn(scene, part);
    turned.push_back(std::move(part));
  }
  if (turned.empty()) return;
  scene.warnings.push_back(fmt::format(
      "{} closed surfaces of refracting materials have their fronts inwards and are turned", turned.size()));
  std::vector<Part> rest;
  for (Part& part : parts) {
    Part* around = part.solid.is_closed ? smallest_around(turned, part) : nullptr;
    if (around == nullptr || around->solid.place != part.solid.place ||
        around->solid.material != part.solid.material) {
      rest.push_back(std::move(part));
      continue;
    }
    turn(scene, part);
    absorb(*around, std::move(part));
  }
  for (Part& part : turned) rest.push_back(std::move(part));
  parts = std::move(rest);
}

double priority_of(const Scene& scene, uint32_t material) {
  return material < scene.material_priorities.size() ? double{scene.material_priorities[material]} : 0.0;
}

}  // namespace

interface::MediaSet empty_media_set() {
  return {glm::uvec4(INVALID_INDEX), glm::uvec4(INVALID_INDEX)};
}

void find_solids(Scene& scene) {
  Solids& solids = scene.solids;
  solids = {};
  std::map<uint32_t, std::vector<uint32_t>> of_place;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i)
    if (scene.triangles[i].instance != INVALID_INDEX &&
        bounds_solid(scene.materials[scene.triangles[i].material]))
      of_place[scene.triangles[i].instance].push_back(i);
  std::vector<Part> parts, inverted;
  for (const auto& [place, triangles] : of_place)
    for (Part& part : join_parts(PlaceParts(scene, triangles).take(), inverted))
      parts.push_back(std::move(part));
  const std::vector<uint32_t> substance = substances(scene);
  join_inverted(scene, substance, std::move(inverted), parts);
  for (Part& part : parts) part.solid.priority = priority_of(scene, part.solid.material);
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return std::tuple(-a.solid.priority, a.solid.volume, a.solid.place) <
           std::tuple(-b.solid.priority, b.solid.volume, b.solid.place);
  });
  if (parts.size() > MAX_SOLIDS) parts.resize(MAX_SOLIDS);
  if (parts.empty()) return;
  solids.of_triangle.assign(scene.triangles.size(), INVALID_INDEX);
  for (const Part& part : parts) {
    for (const uint32_t triangle : part.triangles)
      solids.of_triangle[triangle] = static_cast<uint32_t>(solids.ranked.size());
    solids.ranked.push_back(part.solid);
    solids.records.push_back({part.solid.material, substance[part.solid.material]});
  }
}

}  // namespace regulus::scene

// The triangles of a loaded scene in double precision, and what is expected of surfaces made of them.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace regulus::test {

using glm::dvec3;

/// File of a scene of ours, by folder and name.
inline std::string scene_path(const std::string& stem) {
  return REGULUS_SOURCE_DIR "/scenes/" + stem + ".gltf";
}

/// A triangle in double precision with the name of its material.
struct Facet {
  dvec3 p0, p1, p2;
  std::string material;
  dvec3 emission;

  dvec3 area_vector() const { return 0.5 * glm::cross(p1 - p0, p2 - p0); }
  dvec3 normal() const { return glm::normalize(area_vector()); }
  dvec3 center() const { return (p0 + p1 + p2) / 3.0; }
  double area() const { return glm::length(area_vector()); }
};

/// All facets of the materials whose names begin with `material`.
inline std::vector<Facet> facets(const scene::Scene& scene, const std::string& material = "") {
  std::vector<Facet> result;
  for (const interface::Triangle& triangle : scene.triangles) {
    const std::string& name = scene.material_names[triangle.material];
    if (!material.empty() && name.rfind(material, 0) != 0) continue;
    const auto position = [&](uint32_t i) { return dvec3(scene.vertices[i].position); };
    result.push_back({position(triangle.v0), position(triangle.v1), position(triangle.v2), name,
                      dvec3(scene.materials[triangle.material].emission)});
  }
  EXPECT_FALSE(result.empty()) << material;
  return result;
}

/// Expects every facet to face `point`, or all of them to face away from it.
inline void expect_facing(const std::vector<Facet>& surface, const dvec3& point, bool towards) {
  size_t wrong = 0;
  for (const Facet& facet : surface)
    wrong += (glm::dot(facet.normal(), point - facet.center()) > 0) != towards;
  EXPECT_EQ(wrong, 0u);
}

/// Expects a surface without holes: by Gauss' theorem its area vectors cancel.
inline void expect_closed(const std::vector<Facet>& surface) {
  dvec3 sum(0);
  double area = 0;
  for (const Facet& facet : surface) {
    sum += facet.area_vector();
    area += facet.area();
  }
  // Every facet's vector is off by a few float roundings of its vertices at most.
  EXPECT_LT(glm::length(sum), 1e-6 * area);
}

/// Expects that every edge is shared by two facets in opposite directions: no holes, and fronts on one side.
inline void expect_watertight(const std::vector<Facet>& surface) {
  using Point = std::array<long long, 3>;
  // Corners of pieces that meet were computed in different ways: equal up to 1e-7 m.
  const auto rounded = [](const dvec3& p) {
    return Point{std::llround(p.x * 1e7), std::llround(p.y * 1e7), std::llround(p.z * 1e7)};
  };
  std::map<std::pair<Point, Point>, int> excess;
  for (const Facet& facet : surface) {
    const std::array<Point, 3> corners = {rounded(facet.p0), rounded(facet.p1), rounded(facet.p2)};
    for (size_t i = 0; i < 3; ++i) {
      const Point &from = corners[i], &to = corners[(i + 1) % 3];
      excess[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  size_t open = 0;
  for (const auto& [edge, count] : excess) open += count != 0;
  EXPECT_EQ(open, 0u) << "edges that belong to one facet only, of " << excess.size();
}

/// Volume inside of a closed surface; negative if its fronts face inwards.
inline double volume_of(const std::vector<Facet>& surface) {
  double volume = 0;
  for (const Facet& facet : surface) volume += glm::dot(facet.p0, glm::cross(facet.p1, facet.p2)) / 6;
  return volume;
}

}  // namespace regulus::test

#include "scene/tangents.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/disjoint_sets.hpp"
#include "scene/texture.hpp"

namespace regulus::scene {
namespace {

using glm::dvec2;
using glm::dvec3;

/// Which way the image lies on a triangle.
enum class Orientation { Unknown, Upright, Mirrored };

/// What mikktspace.c calls STriInfo.
struct Facet {
  std::array<uint32_t, 3> vertices;  // in Scene::vertices
  std::array<uint32_t, 3> welded;    // numbers of distinct (position, normal, uv)
  dvec3 tangent{0};  // of the mesh: unit direction of growing u; 0 if the image has no area here
  Orientation orientation = Orientation::Unknown;
};

/// Back to the mesh that vertices in world space are of.
struct MeshSpace {
  glm::dmat3 to_world{1.0}, from_world{1.0};

  explicit MeshSpace(const glm::dmat3& matrix) {
    const glm::dmat3 inverse = glm::inverse(matrix);
    for (int column = 0; column < 3; ++column)
      if (glm::any(glm::isnan(inverse[column])) || glm::any(glm::isinf(inverse[column]))) return;
    to_world = matrix;
    from_world = inverse;
  }
  dvec3 difference(const glm::vec3& a, const glm::vec3& b) const {
    return from_world * (dvec3(a) - dvec3(b));
  }
  dvec3 normal(const glm::vec3& n) const { return glm::normalize(glm::transpose(to_world) * dvec3(n)); }
};

// In these steps a vertex's uv are the coordinates of the image.
struct VertexHash {
  size_t operator()(const interface::Vertex& v) const {
    size_t hash = 0;
    for (const float value :
         {v.position.x, v.position.y, v.position.z, v.normal.x, v.normal.y, v.normal.z, v.uv.x, v.uv.y})
      hash = (hash ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0x9E3779B97F4A7C15u;
    return hash;
  }
};

struct VertexEqual {
  bool operator()(const interface::Vertex& a, const interface::Vertex& b) const {
    return a.position == b.position && a.normal == b.normal && a.uv == b.uv;
  }
};

/// Two triangles at an edge that they run through in opposite directions; corner k starts edge k.
struct SharedEdge {
  size_t facets[2];
  uint32_t edges[2];
};

void set_image_direction(const std::array<interface::Vertex, 3>& corners, const MeshSpace& space,
                         Facet& facet) {
  const auto& [a, b, c] = corners;
  // Up in the image is -v.
  const dvec2 ab = (dvec2(b.uv) - dvec2(a.uv)) * dvec2(1, -1);
  const dvec2 ac = (dvec2(c.uv) - dvec2(a.uv)) * dvec2(1, -1);
  const double area = ab.x * ac.y - ab.y * ac.x;
  if (!(std::abs(area) > FLT_MIN)) return;
  const dvec3 u =
      ac.y * space.difference(b.position, a.position) - ab.y * space.difference(c.position, a.position);
  const double length = glm::length(u);
  if (!(length > 0) || !std::isfinite(length)) return;
  facet.orientation = area > 0 ? Orientation::Upright : Orientation::Mirrored;
  facet.tangent = (area > 0 ? u : -u) / length;
}

/// A vertex of the scene with the coordinates of the image.
interface::Vertex placed_vertex(const Scene& scene, uint32_t index, const interface::Texture& placement) {
  interface::Vertex vertex = scene.vertices[index];
  vertex.uv = image_coordinates(scene, placement, {glm::dvec2(vertex.uv), glm::uvec3(index), {1, 0, 0}});
  return vertex;
}

std::vector<Facet> make_facets(const Scene& scene, size_t first_triangle, const interface::Texture& placement,
                               const MeshSpace& space) {
  std::unordered_map<interface::Vertex, uint32_t, VertexHash, VertexEqual> numbers;
  std::vector<Facet> facets;
  for (size_t t = first_triangle; t < scene.triangles.size(); ++t) {
    const interface::Triangle& triangle = scene.triangles[t];
    Facet facet{{triangle.v0, triangle.v1, triangle.v2}, {}};
    std::array<interface::Vertex, 3> corners{};
    for (size_t i = 0; i < 3; ++i) {
      corners[i] = placed_vertex(scene, facet.vertices[i], placement);
      facet.welded[i] = numbers.try_emplace(corners[i], static_cast<uint32_t>(numbers.size())).first->second;
    }
    set_image_direction(corners, space, facet);
    facets.push_back(facet);
  }
  return facets;
}

/// Each edge belongs to at most one pair.
std::vector<SharedEdge> find_shared_edges(const std::vector<Facet>& facets) {
  std::map<std::pair<uint32_t, uint32_t>, std::vector<std::pair<size_t, uint32_t>>> open;
  std::vector<SharedEdge> shared;
  for (size_t f = 0; f < facets.size(); ++f)
    for (uint32_t e = 0; e < 3; ++e) {
      const uint32_t from = facets[f].welded[e], to = facets[f].welded[(e + 1) % 3];
      const auto opposite = open.find({to, from});
      if (opposite != open.end() && !opposite->second.empty()) {
        const auto [g, edge] = opposite->second.back();
        opposite->second.pop_back();
        shared.push_back({{g, f}, {edge, e}});
      } else {
        open[{from, to}].emplace_back(f, e);
      }
    }
  return shared;
}

/// Triangles on which the image has no area go with a neighbour.
void adopt_orientations(std::vector<Facet>& facets, const std::vector<SharedEdge>& shared) {
  for (const SharedEdge& edge : shared)
    for (int side = 0; side < 2; ++side) {
      Facet& facet = facets[edge.facets[side]];
      if (facet.orientation == Orientation::Unknown)
        facet.orientation = facets[edge.facets[1 - side]].orientation;
    }
}

DisjointSets join_corners(const std::vector<Facet>& facets, const std::vector<SharedEdge>& shared) {
  DisjointSets sets(3 * facets.size());
  const auto corner = [](size_t facet, uint32_t i) { return static_cast<uint32_t>(3 * facet) + i % 3; };
  for (const SharedEdge& edge : shared) {
    const auto [f, g] = edge.facets;
    if (facets[f].orientation != facets[g].orientation) continue;
    sets.join(corner(f, edge.edges[0]), corner(g, edge.edges[1] + 1));
    sets.join(corner(f, edge.edges[0] + 1), corner(g, edge.edges[1]));
  }
  return sets;
}

/// v without its part along n, unit length, or zero.
dvec3 projected(const dvec3& v, const dvec3& n) {
  const dvec3 in_plane = v - glm::dot(v, n) * n;
  const double length = glm::length(in_plane);
  return length > FLT_MIN ? in_plane / length : dvec3(0);
}

/// The share of one corner in its set's tangent: weighted by the angle there, seen along the normal.
dvec3 weighted_tangent(const Scene& scene, const Facet& facet, size_t i, const MeshSpace& space) {
  const interface::Vertex& here = scene.vertices[facet.vertices[i]];
  const dvec3 normal = space.normal(here.normal);
  const auto along_edge = [&](size_t corner) {
    const glm::vec3& there = scene.vertices[facet.vertices[corner % 3]].position;
    return projected(space.difference(there, here.position), normal);
  };
  const dvec3 next = along_edge(i + 1), last = along_edge(i + 2);
  return std::acos(std::clamp(glm::dot(next, last), -1.0, 1.0)) * projected(facet.tangent, normal);
}

/// Gives each vertex the tangent of its corners; a copy of it takes each further one.
class TangentWriter {
 public:
  TangentWriter(Scene& scene, size_t first_vertex)
      : scene_(scene),
        first_vertex_(first_vertex),
        is_written_(scene.vertices.size() - first_vertex, false) {}

  /// The vertex that a corner at `vertex` with that tangent uses.
  uint32_t vertex_with(uint32_t vertex, const glm::vec4& tangent) {
    const size_t local = vertex - first_vertex_;
    if (!is_written_[local] || scene_.vertex_tangents[vertex] == tangent) {
      is_written_[local] = true;
      scene_.vertex_tangents[vertex] = tangent;
      return vertex;
    }
    auto& copies = copies_[vertex];
    for (const uint32_t copy : copies)
      if (scene_.vertex_tangents[copy] == tangent) return copy;
    const auto copy = static_cast<uint32_t>(scene_.vertices.size());
    scene_.vertices.emplace_back(interface::Vertex(scene_.vertices[vertex]));
    scene_.vertex_tangents.push_back(tangent);
    if (scene_.vertex_colors.size() > vertex) {
      scene_.vertex_colors.resize(copy, glm::vec4(1));
      scene_.vertex_colors.emplace_back(glm::vec4(scene_.vertex_colors[vertex]));
    }
    const size_t sets = scene_.vertex_uv_sets;
    if (scene_.vertex_uvs.size() > sets * vertex) {
      scene_.vertex_uvs.resize(sets * (size_t{copy} + 1), glm::vec2(0));
      std::copy_n(scene_.vertex_uvs.begin() + static_cast<ptrdiff_t>(sets * vertex), sets,
                  scene_.vertex_uvs.end() - static_cast<ptrdiff_t>(sets));
    }
    copies.push_back(copy);
    return copy;
  }

 private:
  Scene& scene_;
  size_t first_vertex_;
  std::vector<bool> is_written_;
  std::unordered_map<uint32_t, std::vector<uint32_t>> copies_;
};

}  // namespace

glm::vec4 any_tangent(const glm::vec3& normal) {
  const glm::vec3 axis = std::abs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  return {glm::normalize(axis - glm::dot(axis, normal) * normal), 1};
}

void add_tangents(Scene& scene, size_t first_vertex, size_t first_triangle,
                  const interface::Texture& placement, const glm::dmat3& to_world) {
  const MeshSpace space(to_world);
  scene.vertex_tangents.resize(scene.vertices.size(), glm::vec4(1, 0, 0, 1));
  std::vector<Facet> facets = make_facets(scene, first_triangle, placement, space);
  const std::vector<SharedEdge> shared = find_shared_edges(facets);
  adopt_orientations(facets, shared);
  DisjointSets sets = join_corners(facets, shared);
  std::vector<dvec3> sums(3 * facets.size(), dvec3(0));
  for (uint32_t corner = 0; corner < sums.size(); ++corner)
    sums[sets.root(corner)] += weighted_tangent(scene, facets[corner / 3], corner % 3, space);

  TangentWriter writer(scene, first_vertex);
  for (size_t f = 0; f < facets.size(); ++f) {
    std::array<uint32_t, 3> vertices{};
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t vertex = facets[f].vertices[i];
      const dvec3 sum = space.to_world * sums[sets.root(static_cast<uint32_t>(3 * f) + i)];
      const double length = glm::length(sum);
      glm::vec4 tangent = length > FLT_MIN ? glm::vec4(glm::vec3(sum / length), 1.0f)
                                           : any_tangent(scene.vertices[vertex].normal);
      if (facets[f].orientation == Orientation::Mirrored) tangent.w = -1;
      vertices[i] = writer.vertex_with(vertex, tangent);
    }
    interface::Triangle& triangle = scene.triangles[first_triangle + f];
    triangle.v0 = vertices[0];
    triangle.v1 = vertices[1];
    triangle.v2 = vertices[2];
  }
}

}  // namespace regulus::scene

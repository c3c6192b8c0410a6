// Triangles by their numbers (interface::Instance): where the triangles of a scene stand, whether they are
// stored there or are copies. Everything on the host that meets a triangle by its number looks it up here.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "scene/scene.hpp"

namespace regulus::scene {

/// Beyond this, products of edge lengths overflow in the kernels' single precision. m
inline constexpr float MAX_COORDINATE = 1e9F;

/// A triangle where it stands.
struct PlacedTriangle {
  interface::Triangle triangle;               ///< corners in the order that has the front in front
  const interface::Instance* copy = nullptr;  ///< null: its vertices are stored in world space

  std::array<uint32_t, 3> corners() const { return {triangle.v0, triangle.v1, triangle.v2}; }
};

/// Index of a copy's mesh in Scene::shared_meshes.
size_t mesh_index_of(const Scene& scene, const interface::Instance& copy);

/// Index of the first stored triangle that stands for itself: those before it belong to shared meshes.
size_t first_placed_triangle(const Scene& scene);

/// Triangles that rays can meet, those of copies included.
uint64_t placed_triangle_count(const Scene& scene);

/// @throws std::out_of_range if there is no such triangle.
PlacedTriangle placed_triangle(const Scene& scene, uint32_t number);

/// A corner of a placed triangle (index into Scene::vertices) in world space, to the bit as kernels see its
/// position.
interface::Vertex placed_vertex(const Scene& scene, const PlacedTriangle& placed, uint32_t vertex);

/// Its tangent in world space; w: sign of the bitangent. Precondition: the scene has tangents.
glm::vec4 placed_tangent(const Scene& scene, const PlacedTriangle& placed, uint32_t vertex);

/// World-space positions of a placed triangle's corners.
std::array<glm::vec3, 3> placed_positions(const Scene& scene, uint32_t number);

/// World-space position of a point of a copy's mesh.
glm::vec3 placed_position(const interface::Instance& copy, const glm::vec3& v);

/// A box around the mesh of a copy becomes one around the copy; covers rounding.
std::pair<glm::vec3, glm::vec3> placed_box(const interface::Instance& copy, const glm::vec3& lower,
                                           const glm::vec3& upper);

/// A box around each copy: that of the mesh's box.
std::vector<std::pair<glm::vec3, glm::vec3>> instance_bounds(const Scene& scene);

/// What decides whether a shared mesh can be placed by a transform.
struct MeshExtent {
  glm::vec3 lower{0}, upper{0};
  double least_height = 0;  ///< of the flattest triangle, m
};
MeshExtent extent_of(const Scene& scene, const SharedMesh& mesh);

/// The copy of a mesh that `to_world` places. Nothing if single precision would not do: the transform is
/// (nearly) singular, or a triangle might lose its area in rounding, so far from the origin or so small it
/// would be.
/// @param place see interface::Triangle
std::optional<interface::Instance> place_mesh(const SharedMesh& mesh, const MeshExtent& extent,
                                              const glm::dmat4& to_world, uint32_t place);

/// Gives the copies' triangles their numbers. Call when all triangles are stored.
/// @returns false if there are more than 2^32.
bool number_instances(Scene& scene);

}  // namespace regulus::scene

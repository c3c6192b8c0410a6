#include "scene/placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/components.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using glm::vec3;
using interface::Instance;

constexpr double ROUNDOFF = 5.9604644775390625e-8;  // 2^-24
// A copy's vertex errs by five roundings of its reach.
constexpr double PLACING_ERROR = 8 * ROUNDOFF;
// Boxes are met by rays in the mesh's space, where an ill-conditioned transform makes their errors large.
constexpr double MAX_CONDITION = 1e3;
constexpr double MAX_SCALE = 1e9;
// Heights of triangles above this have an area that kernels can compute: its square is a normal number.
constexpr double MIN_HEIGHT = 1e-9;
// A vertex moves by this in rounding, relative to the translation and to what is added to it: at most 6
// roundings of the latter. Along any line that is sqrt(3) times as much, and a triangle's height changes by
// up to twice that.
constexpr double ROUNDINGS_OF_OFFSET = 6;
constexpr double HEIGHT_OVER_ERROR = 4;

const SharedMesh& mesh_of(const Scene& scene, const Instance& copy) {
  return scene.shared_meshes[mesh_index_of(scene, copy)];
}

/// The copies' blocks of 2^shift numbers.
uint64_t count_blocks(const Scene& scene, uint32_t shift) {
  uint64_t blocks = 0;
  for (const Instance& copy : scene.instances)
    blocks += ((uint64_t{mesh_of(scene, copy).triangle_count} - 1) >> shift) + 1;
  return blocks;
}

vec3 rounded_up(const dvec3& v) {
  vec3 result(v);
  for (int axis = 0; axis < 3; ++axis)
    if (double{result[axis]} < v[axis])
      result[axis] = std::nextafter(result[axis], std::numeric_limits<float>::infinity());
  return result;
}

double frobenius(const glm::dmat3& m) {
  return std::sqrt(dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2]));
}

}  // namespace

size_t mesh_index_of(const Scene& scene, const Instance& copy) {
  const auto& meshes = scene.shared_meshes;
  const auto found =
      std::lower_bound(meshes.begin(), meshes.end(), copy.first_triangle,
                       [](const SharedMesh& mesh, uint32_t first) { return mesh.first_triangle < first; });
  return static_cast<size_t>(found - meshes.begin());
}

size_t first_placed_triangle(const Scene& scene) {
  if (scene.shared_meshes.empty()) return 0;
  const SharedMesh& last = scene.shared_meshes.back();
  return size_t{last.first_triangle} + last.triangle_count;
}

uint64_t placed_triangle_count(const Scene& scene) {
  uint64_t count = scene.triangles.size() - first_placed_triangle(scene);
  for (const Instance& copy : scene.instances) count += mesh_of(scene, copy).triangle_count;
  return count;
}

PlacedTriangle placed_triangle(const Scene& scene, uint32_t number) {
  if (number < scene.triangles.size()) return {scene.triangles[number]};
  const size_t block = (number - scene.triangles.size()) >> scene.instance_block_shift;
  const Instance& copy = scene.instances.at(scene.instance_blocks.at(block));
  PlacedTriangle placed{scene.triangles.at(number - copy.first_number + copy.first_triangle), &copy};
  placed.triangle.instance = copy.place;
  if (copy.is_mirrored != 0) std::swap(placed.triangle.v1, placed.triangle.v2);
  return placed;
}

vec3 placed_position(const Instance& copy, const vec3& v) {
  return copy.x_axis * v.x + copy.y_axis * v.y + copy.z_axis * v.z + copy.translation;
}

interface::Vertex placed_vertex(const Scene& scene, const PlacedTriangle& placed, uint32_t vertex) {
  interface::Vertex result = scene.vertices[vertex];
  if (placed.copy == nullptr) return result;
  const Instance& copy = *placed.copy;
  result.position = placed_position(copy, result.position);
  const dvec3 n(result.normal);
  result.normal = vec3(
      normalize(dvec3(copy.inverse_x) * n.x + dvec3(copy.inverse_y) * n.y + dvec3(copy.inverse_z) * n.z));
  return result;
}

glm::vec4 placed_tangent(const Scene& scene, const PlacedTriangle& placed, uint32_t vertex) {
  const glm::vec4 tangent = scene.vertex_tangents[vertex];
  if (placed.copy == nullptr) return tangent;
  const Instance& copy = *placed.copy;
  const dvec3 t(tangent);
  const dvec3 world = dvec3(copy.x_axis) * t.x + dvec3(copy.y_axis) * t.y + dvec3(copy.z_axis) * t.z;
  return {vec3(normalize(world)), copy.is_mirrored != 0 ? -tangent.w : tangent.w};
}

std::array<vec3, 3> placed_positions(const Scene& scene, uint32_t number) {
  const PlacedTriangle placed = placed_triangle(scene, number);
  std::array<vec3, 3> positions{};
  for (size_t i = 0; i < 3; ++i) positions[i] = placed_vertex(scene, placed, placed.corners()[i]).position;
  return positions;
}

std::pair<vec3, vec3> placed_box(const Instance& copy, const vec3& lower, const vec3& upper) {
  const dvec3 center = 0.5 * (dvec3(lower) + dvec3(upper)), half = dvec3(upper) - center;
  const dvec3 x(copy.x_axis), y(copy.y_axis), z(copy.z_axis);
  const dvec3 world = x * center.x + y * center.y + z * center.z + dvec3(copy.translation);
  const dvec3 extent =
      abs(x) * half.x + abs(y) * half.y + abs(z) * half.z + PLACING_ERROR * dvec3(copy.reach);
  return {-rounded_up(extent - world), rounded_up(world + extent)};
}

std::vector<std::pair<vec3, vec3>> instance_bounds(const Scene& scene) {
  std::vector<MeshExtent> extents;
  for (const SharedMesh& mesh : scene.shared_meshes) extents.push_back(extent_of(scene, mesh));
  std::vector<std::pair<vec3, vec3>> boxes;
  for (const Instance& copy : scene.instances) {
    const MeshExtent& extent = extents[mesh_index_of(scene, copy)];
    boxes.push_back(placed_box(copy, extent.lower, extent.upper));
  }
  return boxes;
}

MeshExtent extent_of(const Scene& scene, const SharedMesh& mesh) {
  MeshExtent extent;
  extent.lower = vec3(std::numeric_limits<float>::infinity());
  extent.upper = -extent.lower;
  extent.least_height = std::numeric_limits<double>::infinity();
  for (uint32_t i = mesh.first_triangle; i < mesh.first_triangle + mesh.triangle_count; ++i) {
    const interface::Triangle& triangle = scene.triangles[i];
    const vec3 p[3] = {scene.vertices[triangle.v0].position, scene.vertices[triangle.v1].position,
                       scene.vertices[triangle.v2].position};
    for (const vec3& v : p) {
      extent.lower = min(extent.lower, v);
      extent.upper = max(extent.upper, v);
    }
    const dvec3 a(p[0]), b(p[1]), c(p[2]);
    const double longest = std::max({length(b - a), length(c - b), length(a - c)});
    extent.least_height = std::min(extent.least_height, length(cross(b - a, c - a)) / longest);
  }
  return extent;
}

std::optional<Instance> place_mesh(const SharedMesh& mesh, const MeshExtent& extent,
                                   const glm::dmat4& to_world, uint32_t place) {
  Instance copy{};
  copy.x_axis = vec3(to_world[0]);
  copy.y_axis = vec3(to_world[1]);
  copy.z_axis = vec3(to_world[2]);
  copy.translation = vec3(to_world[3]);
  const glm::dmat3 axes(dvec3(copy.x_axis), dvec3(copy.y_axis), dvec3(copy.z_axis));
  const double determinant = glm::determinant(axes);
  if (!std::isfinite(determinant) || determinant == 0) return std::nullopt;
  const glm::dmat3 inverse = glm::inverse(axes);
  const double scale = frobenius(axes), inverse_scale = frobenius(inverse);
  if (!(scale < MAX_SCALE && inverse_scale < MAX_SCALE && scale * inverse_scale < MAX_CONDITION))
    return std::nullopt;

  const dvec3 farthest = max(abs(dvec3(extent.lower)), abs(dvec3(extent.upper)));
  const dvec3 offset = abs(axes[0]) * farthest.x + abs(axes[1]) * farthest.y + abs(axes[2]) * farthest.z;
  const dvec3 translation = abs(dvec3(copy.translation)), reach = offset + translation;
  const double error =
      ROUNDOFF * (largest_component(translation) + ROUNDINGS_OF_OFFSET * largest_component(offset));
  // The least singular value is at least 1 / |inverse|; no height shrinks by more.
  const double height = extent.least_height / inverse_scale;
  if (!(largest_component(reach) < double{MAX_COORDINATE} && height > MIN_HEIGHT &&
        height > HEIGHT_OVER_ERROR * error))
    return std::nullopt;

  const glm::dmat3 rows = transpose(inverse);
  copy.inverse_x = vec3(rows[0]);
  copy.inverse_y = vec3(rows[1]);
  copy.inverse_z = vec3(rows[2]);
  copy.reach = rounded_up(reach);
  copy.first_triangle = mesh.first_triangle;
  copy.place = place;
  copy.is_mirrored = determinant < 0 ? 1 : 0;
  return copy;
}

bool number_instances(Scene& scene) {
  if (scene.instances.empty()) return true;
  // The smallest blocks of which there are no more than two for each copy.
  uint32_t shift = 0;
  while (count_blocks(scene, shift) > 2 * scene.instances.size()) ++shift;
  scene.instance_block_shift = shift;
  scene.instance_blocks.clear();
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const uint64_t first = scene.triangles.size() + (uint64_t{scene.instance_blocks.size()} << shift);
    const uint32_t blocks = ((mesh_of(scene, scene.instances[i]).triangle_count - 1) >> shift) + 1;
    if (first + (uint64_t{blocks} << shift) >= interface::INVALID_INDEX) return false;
    scene.instances[i].first_number = static_cast<uint32_t>(first);
    scene.instance_blocks.insert(scene.instance_blocks.end(), blocks, i);
  }
  return true;
}

}  // namespace regulus::scene

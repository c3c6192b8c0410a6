#include "render/scene_structure.hpp"

#include <fmt/format.h>

#include <array>
#include <numeric>

#include "base/error.hpp"
#include "scene/placement.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint32_t MOST_COPIES = (1u << 24) - HARDWARE_FIRST_COPY;  // ids have 24 bits

/// Corners of stored triangles, one after the other.
class Corners {
 public:
  explicit Corners(const scene::Scene& scene) : scene_(scene) {}
  void add(uint32_t triangle) {
    const Triangle& t = scene_.triangles[triangle];
    all_.insert(all_.end(), {t.v0, t.v1, t.v2});
  }
  std::span<const uint32_t> all() const { return all_; }

 private:
  const scene::Scene& scene_;
  std::vector<uint32_t> all_;
};

constexpr std::array<float, 12> IN_PLACE = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

std::array<float, 12> matrix_of(const Instance& copy) {
  std::array<float, 12> rows{};
  const std::array<glm::vec3, 4> columns = {copy.x_axis, copy.y_axis, copy.z_axis, copy.translation};
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 4; ++column)
      rows[4 * row + column] = columns[column][static_cast<int>(row)];
  return rows;
}

}  // namespace

SceneStructure::SceneStructure(gpu::Device& device, const PreparedScene& prepared,
                               const gpu::Buffer& vertices) {
  const scene::Scene& scene = prepared.scene;
  if (scene.instances.size() > MOST_COPIES)
    throw Error(
        ErrorCode::Failed,
        fmt::format("{}: of its {} copies of meshes hardware rays can tell {} apart; use --rays software",
                    scene.path.string(), scene.instances.size(), MOST_COPIES));
  build_meshes(device, scene, vertices);
  build_placed(device, prepared, vertices);
  std::vector<gpu::StructureCopy> copies;
  if (placed_.address() != 0) copies.push_back({placed_, IN_PLACE, HARDWARE_PLACED, true});
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& copy = scene.instances[i];
    // Met in the space of their mesh, where a ray's origin is rounded anew: the kernel confirms each hit.
    copies.push_back(
        {meshes_[scene::mesh_index_of(scene, copy)], matrix_of(copy), HARDWARE_FIRST_COPY + i, false});
  }
  all_ = device.build_structure(copies);
}

void SceneStructure::build_meshes(gpu::Device& device, const scene::Scene& scene,
                                  const gpu::Buffer& vertices) {
  for (const scene::SharedMesh& mesh : scene.shared_meshes) {
    Corners corners(scene);
    for (uint32_t i = 0; i < mesh.triangle_count; ++i) corners.add(mesh.first_triangle + i);
    const gpu::StructureTriangles triangles{vertices, sizeof(Vertex), corners.all(), false};
    meshes_.push_back(device.build_structure(std::span(&triangles, 1)));
  }
}

void SceneStructure::build_placed(gpu::Device& device, const PreparedScene& prepared,
                                  const gpu::Buffer& vertices) {
  const scene::Scene& scene = prepared.scene;
  first_ = static_cast<uint32_t>(scene::first_placed_triangle(scene));
  std::vector<uint32_t> whole, partly;
  Corners whole_corners(scene), partly_corners(scene);
  for (auto i = first_; i < scene.triangles.size(); ++i) {
    const bool is_whole = (prepared.bvh.triangles[i].tag & TRIANGLE_TAG_ALPHA) == 0;
    (is_whole ? whole : partly).push_back(i);
    (is_whole ? whole_corners : partly_corners).add(i);
  }
  if (whole.empty() && partly.empty()) return;
  whole_ = static_cast<uint32_t>(whole.size());
  std::vector<gpu::StructureTriangles> geometries;
  if (!whole.empty()) geometries.push_back({vertices, sizeof(Vertex), whole_corners.all(), true});
  if (!partly.empty()) geometries.push_back({vertices, sizeof(Vertex), partly_corners.all(), false});
  placed_ = device.build_structure(geometries);
  if ((prepared.features.bits & FEATURE_ALPHA) == 0) return;
  whole.insert(whole.end(), partly.begin(), partly.end());
  placed_triangles_ = gpu::upload_new(device, whole, "triangles of hardware rays");
}

void SceneStructure::fill(Frame& frame) const {
  frame.bvh_nodes = device_address(all_.address());
  frame.placed_triangles = device_address(placed_triangles_.address());
  frame.whole_placed_triangles = whole_;
  frame.first_placed_triangle = first_;
}

TriangleStructure::TriangleStructure(gpu::Device& device, const std::vector<BvhTriangle>& triangles) {
  std::vector<glm::vec3> points;
  points.reserve(3 * triangles.size());
  for (const BvhTriangle& triangle : triangles)
    points.insert(points.end(), {triangle.v0, triangle.v1, triangle.v2});
  std::vector<uint32_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0u);
  const gpu::Buffer vertices = gpu::upload_new(device, points, "corners of hardware rays");
  const gpu::StructureTriangles geometry{vertices, sizeof(glm::vec3), corners, true};
  triangles_ = device.build_structure(std::span(&geometry, 1));
  const gpu::StructureCopy copy{triangles_, IN_PLACE, HARDWARE_PLACED, true};
  all_ = device.build_structure(std::span(&copy, 1));
}

}  // namespace regulus::render

// One primitive of a glTF mesh to triangles.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/document.hpp"
#include "scene/origin.hpp"
#include "scene/pose.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// A primitive to store, in world space or (then the transform only moves it near its origin) in that of its
/// mesh.
struct PrimitiveToStore {
  size_t mesh;
  size_t primitive;
  glm::dmat4 to_world;
  uint32_t place;                  ///< of its mesh, see interface::Triangle
  const MeshPose* pose = nullptr;  ///< null: as its accessors have it. With joints they place the vertices
};

/// What was seen while flattening, reported in one warning each.
struct Tally {
  uint64_t triangles = 0;
  uint64_t without_area = 0;
  uint64_t bad_normals = 0;
  uint64_t bad_uvs = 0;
  uint64_t bad_colors = 0;
  uint64_t bad_tangents = 0;
  SkinTally skin;
};

/// Drops, with a warning, what is broken of a primitive: an attribute that it can do without, or else all of
/// its attributes, so that it is not drawn.
void drop_unreadable(Document& document, size_t mesh, size_t index);

/// True for primitives that have triangles.
bool is_drawn(const tinygltf::Primitive& primitive);

/// A box around the finite vertices of a primitive where it is placed; empty if it is not drawn.
/// @throws Error if its accessors are broken
Box primitive_box(const Document& document, const PrimitiveToStore& primitive);

/// What primitives take on the host, by their accessors' headers.
struct Size {
  uint64_t triangles = 0, vertices = 0;
  uint64_t lights = 0;  ///< triangles that may emit
  bool has_colors = false, has_tangents = false;
  size_t uv_sets = 0;  ///< beside the first

  uint64_t bytes() const {
    return triangles * sizeof(interface::Triangle) +
           vertices * (sizeof(interface::Vertex) + (has_colors ? sizeof(glm::vec4) : 0) +
                       (has_tangents ? sizeof(glm::vec4) : 0) + uv_sets * sizeof(glm::vec2));
  }
  /// With the acceleration structure and the lights, and what building them takes for a time.
  uint64_t bytes_to_prepare() const { return bytes() + triangles * BYTES_OF_TREE + lights * BYTES_OF_LIGHT; }

 private:
  // For each triangle, measured as the peak of `inspect` on grids of 500,000: 344 to 348 and 328.
  static constexpr uint64_t BYTES_OF_TREE = 350, BYTES_OF_LIGHT = 330;
};

/// Adds what a primitive takes.
/// @throws Error if its accessors are broken.
void add_size(const Document& document, const PrimitiveToStore& primitive, Size& size);

/// Whether primitives can be stored in their mesh's space: not with coordinates that only their places make
/// fit, nor with millions of vertices that no triangle uses.
bool fits_as_shared(const Document& document, const std::vector<PrimitiveToStore>& primitives);

/// Appends the primitive's triangles to the scene.
/// @throws Error as add_geometry()
void store_primitive(Document& document, const PrimitiveToStore& primitive, Scene& scene, Tally& tally);

/// Warns of everything that was seen.
void warn_of(const Tally& tally, Document& document);

}  // namespace regulus::scene

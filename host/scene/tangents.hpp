// Tangent frames where a mesh brings none: those of MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces
// Revisited", 2008, and the reference implementation mikktspace.c), for which normal maps are baked.
#pragma once

#include <cstddef>

#include "scene/scene.hpp"

namespace regulus::scene {

/// Fills Scene::vertex_tangents for the triangles from `first_triangle` on, which must be the last of the
/// scene and use no vertex before `first_vertex`. Corners that share position, normal and texture coordinates
/// share a tangent with those they are connected to by edges, unless the image is mirrored between them; a
/// vertex whose corners then differ is split. The frame is that of glTF: bitangent = w cross(normal, tangent)
/// points up in the image, against v. As the specification demands the tangents are those of the mesh, then
/// transformed: `to_world` is what has been applied to its vertices (one without an inverse counts as none).
/// The image is that of a texture placed so (see MaterialUvs).
void add_tangents(Scene& scene, size_t first_vertex, size_t first_triangle,
                  const interface::Texture& placement, const glm::dmat3& to_world);

/// Some unit vector orthogonal to a unit normal, with w = 1: the frame where texture coordinates give none.
glm::vec4 any_tangent(const glm::vec3& normal);

}  // namespace regulus::scene

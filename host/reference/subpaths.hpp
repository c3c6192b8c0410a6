// Makes finished paths out of subpaths: by hitting an emitter, by connecting two vertices or a vertex and an
// end, by merging. Directions and cosines of a merged path come from the walk to which each edge belongs.
#pragma once

#include <optional>

#include "reference/walk.hpp"

namespace regulus::reference {

/// A path with the technique that found it and how.
struct SampledPath {
  Path path;
  uint32_t technique = 0;  ///< TECHNIQUE_*
  size_t vertex = 0;       ///< Technique::vertex
  double survival = 1;     ///< probability that roulette let its walks come so far
  glm::dvec2 film{0};      ///< splats: where the path meets the film
};

/// The camera walk's vertex after `edges` edges as the path's light. Nothing if it does not emit.
std::optional<SampledPath> hit_light(const World& world, const CameraSubpath& camera, size_t edges);

/// The camera walk's last ray, if it left the scene, with the environment as the path's light. Nothing if
/// there is none.
std::optional<SampledPath> hit_environment(const World& world, const CameraSubpath& camera);

/// The camera walk's vertex after `edges` edges connected to a light point. Like the others, nothing if the
/// path carries no light; visibility is tested last.
std::optional<SampledPath> connect_to_light(const World& world, const LightPoint& point,
                                            const CameraSubpath& camera, size_t edges);

/// The vertex of a light walk after `light_edges` >= 1 edges connected to that of a camera walk after
/// `camera_edges` >= 1.
std::optional<SampledPath> connect_vertices(const World& world, const LightSubpath& light, size_t light_edges,
                                            const CameraSubpath& camera, size_t camera_edges);

/// The vertex of a light walk after `edges` edges connected to the lens point of `u_lens`; 0: the light
/// itself, if it is a surface. lens_medium: material of the medium before the near plane.
std::optional<SampledPath> connect_to_lens(const World& world, const Camera& lens, uint32_t lens_medium,
                                           const LightSubpath& light, size_t edges, const glm::dvec2& u_lens);

/// Two vertices taken as one, which scatters as the camera walk's does.
std::optional<SampledPath> merge_vertices(const LightSubpath& light, size_t light_edges,
                                          const CameraSubpath& camera, size_t camera_edges);

}  // namespace regulus::reference

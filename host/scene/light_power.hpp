// Emitted power of lights, by which they are selected.
#pragma once

#include "scene/scene.hpp"

namespace regulus::scene {

/// Radiant flux of a punctual light, as luminance: W for radiometric units. Directional lights: the flux
/// through the scene's bounding sphere.
double punctual_power(const interface::Light& light, double scene_radius);

/// Flux of an emissive triangle. With a texture its average over the triangle by samples, but never 0 unless
/// every texel that the triangle can show is black.
double triangle_power(const Scene& scene, const interface::Triangle& triangle, double area);

/// Area of a triangle.
double triangle_area(const Scene& scene, const interface::Triangle& triangle);

}  // namespace regulus::scene

// Renders a scene file with the device of the tests, whole or as independent batches.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bvh/bvh.hpp"
#include "image/image.hpp"
#include "images/support/prepared_scene.hpp"
#include "render/renderer.hpp"
#include "scene/scene.hpp"

namespace regulus::test {

struct Rendered {
  render::Film film;
  image::Image image;
  render::RenderStatistics statistics;
};

/// Renders all samples. Fails the calling test if a sample was not finite or a ray overran its step bound.
Rendered render(const PreparedScene& prepared, const render::RenderSettings& settings);

/// A film of square pixels with a box filter over the pixel; merges have the radius that a test gives.
render::RenderSettings box_filtered(uint32_t width, uint32_t height, uint32_t samples, uint32_t max_depth);

/// One ray through the very centre of each pixel (a box filter of radius 0): where the light transport has no
/// random choice either, the image is an exact function of position.
render::RenderSettings point_sampled(uint32_t width, uint32_t height, uint32_t max_depth);

/// All AOVs of what camera rays meet first.
image::Channels surface_channels(const PreparedScene& prepared, render::RenderSettings settings);

/// Bound on a lobe's density, 1/sr, that raises mirrors to this alpha (docs/mathematics.md 2.2, BOUND_PEAK).
float tau_of_mirrors(double alpha);

/// Images of `count` renders that differ in their seed alone: base_seed() + 1000 stream + 0, 1, ...
std::vector<image::Image> render_batches(const PreparedScene& prepared, render::RenderSettings settings,
                                         int count, uint32_t stream);

}  // namespace regulus::test

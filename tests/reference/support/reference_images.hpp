// Images by the scalar reference, as independent batches for the statistics of images/support/comparison.hpp.
#pragma once

#include <vector>

#include "image/image.hpp"
#include "images/support/prepared_scene.hpp"
#include "reference/renderer.hpp"
#include "render/technique_sets.hpp"

namespace regulus::test {

/// A film of square pixels with a box filter over the pixel, all on one core: what the test machine shares.
reference::Settings reference_settings(uint32_t width, uint32_t height, uint32_t samples, uint32_t max_depth);

/// One ray through the very centre of each pixel.
reference::Settings reference_point_sampled(uint32_t width, uint32_t height, uint32_t max_depth);

/// The mean image of a render by the reference. Fails the calling test if a value is not finite or negative.
image::Image render_reference(const PreparedScene& prepared, const reference::Settings& settings);

/// Images of `count` renders that differ in their seed alone: base_seed() + 1000 stream + 0, 1, ... But in a
/// full run (is_full_run()) each has a quarter of the samples: errors found are twice as large, at the same
/// rate of false alarms.
std::vector<image::Image> reference_batches(const PreparedScene& prepared, reference::Settings settings,
                                            int count, uint32_t stream);

/// Technique sets by the names of the command line.
struct NamedTechniques {
  const char* name;
  uint32_t bits;
};
using namespace technique_sets;

}  // namespace regulus::test

#include "reference/support/reference_images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/random.hpp"
#include "support/run_length.hpp"

namespace regulus::test {

reference::Settings reference_settings(uint32_t width, uint32_t height, uint32_t samples,
                                       uint32_t max_depth) {
  reference::Settings settings;
  settings.width = width;
  settings.height = height;
  settings.samples = samples;
  settings.max_depth = max_depth;
  settings.filter = {interface::FILTER_BOX, 0.5, 0.5};
  return settings;
}

reference::Settings reference_point_sampled(uint32_t width, uint32_t height, uint32_t max_depth) {
  reference::Settings settings = reference_settings(width, height, 1, max_depth);
  settings.filter.radius = 0;
  return settings;
}

image::Image render_reference(const PreparedScene& prepared, const reference::Settings& settings) {
  const reference::World world(prepared, settings.ndf, settings.shadowing);
  const reference::Film film = reference::render(world, settings);
  image::Image image{settings.width, settings.height, {}};
  for (size_t i = 0; i < film.sum.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double value = film.mean(i)[c];
      EXPECT_TRUE(std::isfinite(value) && value >= 0) << "pixel " << i << ": " << value;
      image.rgb.push_back(static_cast<float>(value));
    }
  return image;
}

std::vector<image::Image> reference_batches(const PreparedScene& prepared, reference::Settings settings,
                                            int count, uint32_t stream) {
  if (!is_full_run()) settings.samples = std::max(settings.samples / 4, 1U);
  std::vector<image::Image> images;
  const auto first = static_cast<uint32_t>(base_seed()) + 1000 * stream;
  for (int i = 0; i < count; ++i) {
    settings.seed = first + static_cast<uint32_t>(i);
    images.push_back(render_reference(prepared, settings));
  }
  return images;
}

}  // namespace regulus::test

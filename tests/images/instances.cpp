// Meshes that are stored once for several copies, against the same scenes with every copy stored in world
// space.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "images/support/copies.hpp"
#include "images/support/render_scene.hpp"
#include "scene/placement.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class Instances : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

/// Share of pixels in which the channels differ by more than the bound.
double differing(const std::vector<float>& a, const std::vector<float>& b, float bound) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += !(std::abs(a[i] - b[i]) <= bound) && a[i] != b[i] ? 1 : 0;
  return static_cast<double>(count) / static_cast<double>(a.size());
}

// Vertices of both differ by roundings. A ray that passes an edge that closely (one in some thousand) may see
// something else; all others see the same within roundings, which a curved mirror enlarges.
TEST_F(Instances, LookLikeStoredCopies) {
  const GltfScene scene = copies_scene();
  const PreparedScene shared = shared_copies(scene), stored = stored_copies(scene);
  ASSERT_EQ(shared.scene.instances.size(), 5u);  // not the two of glass: each is a solid of its own
  ASSERT_TRUE(stored.scene.instances.empty());
  EXPECT_EQ(placed_triangle_count(shared.scene), stored.scene.triangles.size());

  const render::RenderSettings settings = box_filtered(48, 48, is_slow_device() ? 1 : 8, 6);
  const image::Channels a = surface_channels(shared, settings), b = surface_channels(stored, settings);
  for (const auto& [name, values] : a) {
    if (const auto* numbers = std::get_if<std::vector<uint32_t>>(&values)) {
      const auto& others = std::get<std::vector<uint32_t>>(b.at(name));
      size_t count = 0;
      for (size_t i = 0; i < numbers->size(); ++i) count += (*numbers)[i] != others[i] ? 1 : 0;
      std::printf("%-14s %zu of %zu pixels differ\n", name.c_str(), count, numbers->size());
      EXPECT_LE(count, numbers->size() / 500) << name;
    } else {
      const double share =
          differing(std::get<std::vector<float>>(values), std::get<std::vector<float>>(b.at(name)), 1e-4f);
      std::printf("%-14s %.4f of the pixels differ\n", name.c_str(), share);
      EXPECT_LE(share, 0.002) << name;
    }
  }
  const image::Image first = render(shared, settings).image, second = render(stored, settings).image;
  const double share = differing(first.rgb, second.rgb, 1e-3f);
  std::printf("radiance       %.4f of the values differ\n", share);
  EXPECT_LE(share, 0.02);
  EXPECT_GT(*std::max_element(first.rgb.begin(), first.rgb.end()), 0.1f);
}

}  // namespace
}  // namespace regulus::test

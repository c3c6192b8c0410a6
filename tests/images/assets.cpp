// Every scene of the shared assets renders: no sample is lost, no ray gives up, and something is seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class Asset : public testing::TestWithParam<const char*> {};

// On a slow device only one scene each of diffuse, glossy and glass surfaces.
bool is_for_slow_devices(const std::string& name) {
  return name == "cornell-box" || name == "veach-mis" || name == "lux-juice";
}

TEST_P(Asset, RendersWithoutALostSample) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::string name = GetParam();
  const std::filesystem::path file = assets() / "scenes" / (name + ".glb");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  if (is_slow_device() && !is_for_slow_devices(name)) GTEST_SKIP() << "left out on a slow device";
  const PreparedScene prepared = prepare(file);
  render::RenderSettings settings;
  const glm::dvec2 resolution = prepared.scene.resolution.value();
  settings.width = 64;
  settings.height = static_cast<uint32_t>(std::lround(64 * resolution.y / resolution.x));
  settings.samples = 4;
  const Rendered rendered = render(prepared, settings);  // checks the counters
  const std::array<double, 3> mean = mean_of(rendered.image);
  std::printf(
      "%s: %zu triangles, mean %.4f %.4f %.4f, %.2f closest and %.2f visibility rays per sample\n",
      name.c_str(), prepared.scene.triangles.size(), mean[0], mean[1], mean[2],
      static_cast<double>(rendered.statistics.closest_rays()) / static_cast<double>(rendered.film.paths),
      static_cast<double>(rendered.statistics.visibility_rays()) / static_cast<double>(rendered.film.paths));
  for (const double value : mean) EXPECT_GT(value, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Asset,
                         testing::Values("bathroom", "cornell-box", "cornell-dragon100k", "etx-sds",
                                         "living-room", "lumen-occluded", "lux-causticcube", "lux-juice",
                                         "lux-kitchen", "staircase", "veach-mis"),
                         [](const testing::TestParamInfo<const char*>& asset) {
                           std::string name = asset.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace regulus::test

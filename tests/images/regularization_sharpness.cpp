// Where regularization must not blur or darken: lamps that are seen in mirrors and highlights (path
// diffusion), a caustic that bidirectional path tracing finds by itself (sampler quality), and the energy of
// a glass caustic.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;

using namespace technique_sets;
/// Finds caustics that the camera sees directly, with fewer kernels to compile.
constexpr uint32_t SPLATS = PT | TECHNIQUE_SPLAT;

class Sharpness : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (is_slow_device()) GTEST_SKIP() << "slow device";
  }
};

/// Every mirror that is raised at all is raised to alpha, in every iteration.
RenderSettings raised_to(RenderSettings settings, double alpha, uint32_t flags = 0) {
  settings.regularization = REGULARIZATION_ROUGHNESS | flags;
  settings.tau = tau_of_mirrors(alpha);
  return settings;
}

/// Green, summed over the columns from `first` to `last`, by row.
std::vector<double> profile(const image::Image& image, uint32_t first, uint32_t last) {
  std::vector<double> sums(image.height);
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = first; x < last; ++x) sums[y] += image.rgb[3 * (size_t{y} * image.width + x) + 1];
  return sums;
}

/// Where a sequence, linear between entries, first rises to `level`.
double crossing(const std::vector<double>& values, double level) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] < level) continue;
    const double before = i > 0 ? values[i - 1] : 0;
    return static_cast<double>(i) - (values[i] - level) / (values[i] - before);
  }
  return static_cast<double>(values.size());
}

/// Distance, in entries, between 10 and 90 % of the plateau that the last eighth is.
double edge_width(const std::vector<double>& rising) {
  const auto count = static_cast<std::ptrdiff_t>(rising.size() / 8);
  const double plateau =
      std::accumulate(rising.end() - count, rising.end(), 0.0) / static_cast<double>(count);
  return crossing(rising, 0.9 * plateau) - crossing(rising, 0.1 * plateau);
}

// A strip of light seen in a floor of metal: what its cumulated profile, which is that of an edge, takes to
// rise. The floor's left half is a mirror; in the right one's lobe of alpha 0.01 the highlight has a width of
// its own.
TEST_F(Sharpness, PathDiffusionLeavesLampsInMirrorsAndHighlightsAlone) {
  GltfScene scene;
  scene.add({quad({-40, 0, 40}, {40, 0, 0}, {0, 0, -80})}, metal({1, 1, 1}, 0));
  scene.add({quad({0, 0, 40}, {40, 0, 0}, {0, 0, -80})}, metal({1, 1, 1}, 0.1));
  scene.add({quad({-1, 0.95, -3}, {2, 0, 0}, {0, 0.1, 0})}, emitter({1, 1, 1}));
  scene.set_perspective(look_at({0, 1, 2}, {0, -1, -3}), 0.4);
  const PreparedScene prepared = prepare(scene);
  constexpr uint32_t HALF = 8;
  const RenderSettings plain = box_filtered(2 * HALF, 96, 32, 2);
  struct Widths {
    double mirror, highlight;
  };
  const auto widths = [&](const char* what, RenderSettings settings, uint32_t techniques) {
    settings.techniques = techniques;
    const image::Image image = render(prepared, settings).image;
    const auto width = [&](uint32_t first) {
      std::vector<double> rows = profile(image, first, first + HALF);
      std::partial_sum(rows.begin(), rows.end(), rows.begin());
      return edge_width(rows);
    };
    const Widths result{width(0), width(HALF)};
    std::printf("%s: 10-90 %% of a mirror image in %.2f pixels, of a highlight in %.2f\n", what,
                result.mirror, result.highlight);
    return result;
  };
  const RenderSettings raised = raised_to(plain, 0.1);
  const RenderSettings diffused = raised_to(plain, 0.1, REGULARIZATION_DIFFUSION);
  const Widths none = widths("pt without regularization", plain, PT);
  for (const Widths& on : {widths("pt", diffused, PT), widths("bpt", diffused, BPT)}) {
    EXPECT_NEAR(on.mirror / none.mirror, 1, 0.05);
    EXPECT_NEAR(on.highlight / none.highlight, 1, 0.05);
  }
  const Widths off = widths("pt without path diffusion", raised, PT);
  EXPECT_GT(off.mirror / none.mirror, 2);
  EXPECT_GT(off.highlight / none.highlight, 2);
}

// The edge of the patch of floor that a small lamp lights over a mirror; it faces away from that floor. Light
// subpaths reach the floor and are connected to the camera: a good sampler.
TEST_F(Sharpness, SamplerQualityLeavesCausticsOfLightSubpathsAlone) {
  GltfScene scene;
  scene.add({quad({1.2, 0, 1}, {1.3, 0, 0}, {0, 0, -2})}, WHITE);
  scene.add({quad({0, 0.2, 0}, {0, 0, -1}, {0, 1.6, 0})}, metal({1, 1, 1}, 0));
  scene.add({quad({1, 1.99, -0.01}, {0, 0, 0.02}, {0, 0.02, 0})}, emitter({1000, 1000, 1000}));
  scene.set_perspective(look_at({1.8, 5, 0}, {1.8, 0, 0}, {0, 0, -1}), 0.2);
  const PreparedScene prepared = prepare(scene);
  const auto width = [&](RenderSettings settings, uint32_t techniques, uint32_t quality) {
    settings.techniques = techniques;
    settings.sampler_quality = quality;
    std::vector<double> rows = profile(render(prepared, settings).image, 0, settings.width);
    if (rows.front() > rows.back()) std::ranges::reverse(rows);
    return edge_width(rows);
  };
  const RenderSettings plain = box_filtered(16, 64, 256, 3);
  const RenderSettings raised = raised_to(plain, 0.05, REGULARIZATION_DIFFUSION);
  const double none = width(plain, SPLATS, SAMPLER_QUALITY_OFF), on = width(raised, BPT, SAMPLER_QUALITY_ON),
               off = width(raised, SPLATS, SAMPLER_QUALITY_OFF);
  std::printf("10-90 %% in %.2f pixels; regularized with sampler quality %.2f, without %.2f\n", none, on,
              off);
  EXPECT_NEAR(on / none, 1, 0.1);
  EXPECT_GT(off / none, 1.5);
}

// A glass ball in a room under a small lamp. Renderers that raise roughness in walks and weights alike lose a
// third of such a caustic (32.5 % by pbrt-v4's bdpt with "regularize"). The caustic is the brightest pixels
// of one render without regularization; of their mean, by another one, what the default leaves. Measured with
// four seeds: 0.975 with tau 5, 0.993 with 10, 1.001 with 20, the seeds' deviation being 0.018.
TEST_F(Sharpness, AGlassCausticKeepsItsEnergy) {
  GltfScene scene;
  const Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  for (const Polygon& wall : walls) scene.add({wall}, WHITE);
  const glm::dvec3 centre(0, -0.5, 0);
  const Polygons ball = sphere(centre, 0.35, 32);
  Corners corners;
  for (const Polygon& polygon : ball)
    for (const glm::dvec3& corner : polygon)
      corners.normals.push_back(glm::vec3(glm::normalize(corner - centre)));
  scene.add(ball, glass(1.5), glm::dmat4(1), corners);
  scene.add({quad({-0.55, 0.99, -0.15}, {0.3, 0, 0}, {0, 0, 0.3})}, emitter({20, 20, 20}));
  scene.set_perspective(look_at({0, 0, 0.95}, {0.2, -1, 0.1}), 1.2);
  const PreparedScene prepared = prepare(scene);
  const auto image_of = [&](uint32_t techniques, uint32_t regularization, uint32_t samples, uint32_t seed) {
    RenderSettings settings = box_filtered(24, 24, samples, 8);
    settings.techniques = techniques;
    settings.regularization = regularization;
    settings.seed = seed;
    return render(prepared, settings).image;
  };
  const image::Image first = image_of(SPLATS, REGULARIZATION_NONE, 256, 1);
  std::vector<size_t> brightest(first.rgb.size() / 3);
  std::iota(brightest.begin(), brightest.end(), size_t{0});
  std::ranges::sort(brightest, std::greater<>{}, [&](size_t pixel) { return first.rgb[3 * pixel + 1]; });
  brightest.resize(brightest.size() / 20);
  const auto mean = [&](const image::Image& image) {
    double sum = 0;
    for (const size_t pixel : brightest) sum += image.rgb[3 * pixel + 1];
    return sum / static_cast<double>(brightest.size());
  };
  const double truth = mean(image_of(SPLATS, REGULARIZATION_NONE, 512, 2));
  constexpr uint32_t DEFAULT =
      REGULARIZATION_ROUGHNESS | REGULARIZATION_DIFFUSION | REGULARIZATION_CONSISTENT;
  const double share =
      0.5 * (mean(image_of(BPT, DEFAULT, 128, 3)) + mean(image_of(BPT, DEFAULT, 128, 4))) / truth;
  std::printf("%.3f of the caustic's light\n", share);
  EXPECT_NEAR(share, 1, 0.05);
}

}  // namespace
}  // namespace regulus::test

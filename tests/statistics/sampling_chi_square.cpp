// The sampling functions of the shaders: uniformity by chi-square, and the same points as the reference where
// the map is fixed by its source.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "kernels/bsdf_cases.hpp"
#include "reference/sampling.hpp"
#include "support/chi_square.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec2;
using namespace interface;
using std::numbers::pi;

constexpr uint32_t SAMPLES = 1u << 18;
constexpr double FALSE_ALARM = 1e-4;
constexpr int TESTS = 5;

std::vector<vec2> random_pairs(uint64_t stream) {
  Random random(stream);
  std::vector<vec2> pairs(SAMPLES);
  for (vec2& pair : pairs) pair = {random.index(1u << 24) * 0x1p-24, random.index(1u << 24) * 0x1p-24};
  return pairs;
}

std::vector<DrawnDirection> draw(uint32_t function, const std::vector<vec2>& pairs) {
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "sampling_draw", {});
  return map_on_device<DrawnDirection>(kernel, pairs, 1, function);
}

void expect_uniform(const char* name, const ChiSquare& result) {
  const double significance = significance_per_test(FALSE_ALARM, TESTS);
  std::printf("%s: p-value %.3g, alarm below %.1e\n", name, result.p_value, significance);
  EXPECT_TRUE(result.problem.empty()) << result.problem;
  EXPECT_GT(result.p_value, significance);
}

void test_directions(const char* name, uint32_t function, uint64_t stream,
                     const std::function<double(double)>& pdf_of_z) {
  SphereHistogram histogram(40, 32);
  for (const DrawnDirection& sample : draw(function, random_pairs(stream))) {
    ASSERT_NEAR(length(dvec3(sample.direction)), 1, 4e-7) << "4 ulp";
    histogram.add(sample.direction);
  }
  expect_uniform(name, histogram.test([&](const dvec3& w) { return pdf_of_z(w.z); }));
}

TEST(SamplingChiSquare, CosineHemisphere) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  test_directions("cosine hemisphere", SAMPLING_COSINE_HEMISPHERE, 51,
                  [](double z) { return z > 0 ? z / pi : 0; });
}

TEST(SamplingChiSquare, Sphere) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  test_directions("sphere", SAMPLING_SPHERE, 52, [](double) { return 1 / (4 * pi); });
}

TEST(SamplingChiSquare, Cone) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  // The cone's edge at z = 0.7 is an edge between cells (40 cells of 0.05).
  const double height = 0.1 * SAMPLING_CONE_HEIGHT_TENTHS;
  test_directions("cone", SAMPLING_CONE, 53,
                  [&](double z) { return z > 1 - height ? 1 / (2 * pi * height) : 0; });
}

TEST(SamplingChiSquare, DiskIsUniformAndConcentric) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::vector<vec2> pairs = random_pairs(54);
  const auto points = draw(SAMPLING_DISK, pairs);
  constexpr int RINGS = 20, SECTORS = 30;
  std::vector<double> observed(RINGS * SECTORS),
      expected(RINGS * SECTORS, double{SAMPLES} / (RINGS * SECTORS));
  double worst = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const dvec2 point(points[i].direction);
    ASSERT_LE(length(point), 1 + 2e-7);
    worst = std::max(worst, length(point - reference::sample_disk(dvec2(pairs[i]))));
    const int ring = std::min(RINGS - 1, static_cast<int>(dot(point, point) * RINGS));
    const double turn = std::atan2(point.y, point.x) / (2 * pi);
    observed[ring * SECTORS +
             std::min(SECTORS - 1, static_cast<int>((turn < 0 ? turn + 1 : turn) * SECTORS))] += 1;
  }
  std::printf("largest distance to Shirley and Chiu's map %.1e (bound 5e-7: 4 ulp of 1)\n", worst);
  EXPECT_LT(worst, 5e-7);
  expect_uniform("disk", chi_square_test(observed, expected));
}

TEST(SamplingChiSquare, TriangleIsUniform) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::vector<vec2> pairs = random_pairs(55);
  const auto points = draw(SAMPLING_TRIANGLE, pairs);
  // Equal-area cells: (1 - third barycentric) squared and the ratio of the others are uniform and
  // independent.
  constexpr int ROWS = 24, COLUMNS = 24;
  std::vector<double> observed(ROWS * COLUMNS), expected(ROWS * COLUMNS, double{SAMPLES} / (ROWS * COLUMNS));
  double worst = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const dvec2 b(points[i].direction);
    ASSERT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1 + 1e-7);
    worst = std::max(worst, length(b - reference::sample_triangle(dvec2(pairs[i]))));
    const double sum = b.x + b.y;
    const int row = std::min(ROWS - 1, static_cast<int>(sum * sum * ROWS));
    const int column = std::min(COLUMNS - 1, static_cast<int>(sum > 0 ? b.x / sum * COLUMNS : 0));
    observed[row * COLUMNS + column] += 1;
  }
  std::printf("largest distance to Heitz's map %.1e (bound 2e-7)\n", worst);
  EXPECT_LT(worst, 2e-7);
  expect_uniform("triangle", chi_square_test(observed, expected));
}

}  // namespace
}  // namespace regulus::test

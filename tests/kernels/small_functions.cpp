// Small functions of shaders/lib on the device against their definitions in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "reference/fresnel.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using glm::dvec3;
using glm::vec3;

/// Largest error of fresnel_mean_position over indices evenly spread in x = (ior - 1) / (ior + 1).
double worst_mean_error(double first_ior, double last_ior) {
  constexpr int COUNT = 4096;
  const auto x_of = [](double ior) { return (ior - 1) / (ior + 1); };
  std::vector<float> inputs(COUNT);
  for (int i = 0; i < COUNT; ++i)
    inputs[i] = static_cast<float>(std::lerp(x_of(first_ior), x_of(last_ior), (i + 0.5) / COUNT));
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "fresnel_mean", {});
  const auto measured = map_on_device<float>(kernel, inputs);

  double worst = 0, worst_ior = 0;
  for (int i = 0; i < COUNT; ++i) {
    const double x = inputs[i], ior = (1 + x) / (1 - x), normal = reference::fresnel_normal_incidence(ior);
    const double expected = (reference::fresnel_dielectric_average(ior) - normal) / (1 - normal);
    const double error = std::abs(measured[i] - expected);
    if (!(error <= worst)) worst = error, worst_ior = ior;
  }
  std::printf("index %g to %g: largest error of the mean reflectance's position %.2e, at %.4g\n", first_ior,
              last_ior, worst, worst_ior);
  return worst;
}

// The bounds that fresnel.glsl states. The hemispherical mean itself is integrated by the reference.
TEST(Fresnel, MeanMatchesQuadrature) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  EXPECT_LT(worst_mean_error(1, 1.1), 1e-5);
  EXPECT_LT(worst_mean_error(1.1, 10), 1e-5);
  EXPECT_LT(worst_mean_error(10, 1e4), 2e-3);
}

struct Tangents {
  vec3 tangent, bitangent;
};

std::vector<vec3> normals_to_test() {
  std::vector<vec3> normals;
  for (const float zero : {0.0f, -0.0f})
    for (const float one : {1.0f, -1.0f})
      for (int axis = 0; axis < 3; ++axis)
        for (const float other_zero : {0.0f, -0.0f}) {
          vec3 normal(zero);
          normal[axis] = one;
          normal[(axis + 1) % 3] = other_zero;
          normals.push_back(normal);
        }
  Random random(61);
  for (int i = 0; i < 20000; ++i) normals.emplace_back(random.direction());
  // Close to the poles, where 1 + z of the classical formula cancels, and close to the equator.
  for (int i = 0; i < 20000; ++i) {
    const dvec3 w = random.direction();
    const double small = random.log_uniform(1e-30, 1);
    normals.emplace_back(normalize(dvec3(small * w.x, small * w.y, w.z)));
    normals.emplace_back(normalize(dvec3(w.x, w.y, small * w.z)));
  }
  return normals;
}

// With u = 2^-24: the normals are unit within |n|^2 - 1 = 2u, which by the formula (Duff et al. 2017) passes
// to the tangents at most once, and each component is the result of at most five roundings of numbers not
// above 1, where the third component is exact: an error of at most sqrt(5^2 + 4^2) u in each vector. Products
// of two vectors err by at most twice that and 2u, below 16u = 2^-20.
TEST(OrthonormalBasis, IsOrthonormalAndRightHanded) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr double BOUND = 0x1p-20;
  const std::vector<vec3> normals = normals_to_test();
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "basis", {});
  const auto bases = map_on_device<Tangents>(kernel, normals);
  double worst = 0, least_handedness = 1;
  for (size_t i = 0; i < normals.size(); ++i) {
    const dvec3 n(normals[i]), t(bases[i].tangent), b(bases[i].bitangent);
    for (const double defect : {dot(t, t) - 1, dot(b, b) - 1, dot(t, b), dot(t, n), dot(b, n)}) {
      EXPECT_LE(std::abs(defect), BOUND) << "normal " << n.x << " " << n.y << " " << n.z;
      worst = std::max(worst, std::abs(defect));
    }
    const double handedness = dot(cross(t, b), n);
    EXPECT_GT(handedness, 0.5) << "normal " << n.x << " " << n.y << " " << n.z;
    least_handedness = std::min(least_handedness, handedness);
  }
  std::printf("%zu normals: largest defect %.2e (bound %.2e), least triple product %.7f\n", normals.size(),
              worst, BOUND, least_handedness);
}

}  // namespace
}  // namespace regulus::test

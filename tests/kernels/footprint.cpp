// Path diffusion's covariance tracing against rays that are traced exactly through a circle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "interface/scene.h"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

struct Encounters {
  vec3 footprint;
  float distance, curvature, e;
};

/// A ray of the bundle: offset from its axis (m) and angle to it (rad).
struct BundleRay {
  double x, angle;
};

/// Follows a ray along +y for `distance` metres on the axis to a circle of signed radius 1 / curvature
/// (positive: its centre lies behind the surface) and through it by the laws of reflection (e = 0) and
/// refraction. The axis of what leaves is -y or +y.
BundleRay traced(BundleRay start, const Encounters& encounters) {
  const double radius = 1.0 / encounters.curvature, distance = encounters.distance;
  const dvec2 centre(0, distance + radius), d(std::sin(start.angle), std::cos(start.angle));
  const dvec2 from = dvec2(start.x, 0) - centre;
  const double half = dot(from, d), root = std::sqrt(half * half - dot(from, from) + radius * radius);
  const double t = radius > 0 ? -half - root : -half + root;
  const dvec2 hit = from + t * d;
  const dvec2 normal = (radius > 0 ? 1.0 : -1.0) * normalize(hit);
  const double cosine = -dot(d, normal);
  if (encounters.e == 0) {
    const dvec2 out = d + 2 * cosine * normal;
    return {hit.x, std::atan2(out.x, -out.y)};
  }
  const double e = encounters.e;
  const double cosine_t = std::sqrt(1 - e * e * (1 - cosine * cosine));
  const dvec2 out = e * d + (e * cosine - cosine_t) * normal;
  return {hit.x, std::atan2(out.x, out.y)};
}

/// Covariance of what leaves, by the exact map's derivatives at the axis.
dvec3 expected_footprint(const Encounters& encounters) {
  // Central differences err by the step squared.
  constexpr double STEP = 1e-5;
  const auto derivative = [&](BundleRay step) {
    const BundleRay a = traced(step, encounters), b = traced({-step.x, -step.angle}, encounters);
    return BundleRay{(a.x - b.x) / (2 * STEP), (a.angle - b.angle) / (2 * STEP)};
  };
  const BundleRay of_x = derivative({STEP, 0}), of_angle = derivative({0, STEP});
  const dvec3 start(encounters.footprint);
  const auto moment = [&](double x0, double a0, double x1, double a1) {
    return x0 * x1 * start.x + (x0 * a1 + a0 * x1) * start.y + a0 * a1 * start.z;
  };
  return {moment(of_x.x, of_angle.x, of_x.x, of_angle.x),
          moment(of_x.x, of_angle.x, of_x.angle, of_angle.angle),
          moment(of_x.angle, of_angle.angle, of_x.angle, of_angle.angle)};
}

// Float error: every term is the result of at most six roundings of terms not larger than the sum of their
// magnitudes, which is what a bundle without correlation and with |curvature| would have.
TEST(Footprint, IsThatOfRaysThroughACircle) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(71);
  std::vector<Encounters> inputs;
  for (int i = 0; i < 3000; ++i) {
    Encounters next{};
    const double x = random.log_uniform(1e-4, 0.1), angle = random.log_uniform(1e-4, 0.1);
    next.footprint = vec3(x * x, x * angle * (2 * random.uniform() - 1), angle * angle);
    next.distance = static_cast<float>(random.log_uniform(0.1, 3));
    next.curvature = static_cast<float>((i % 2 == 0 ? 1 : -1) * random.log_uniform(0.1, 3));
    next.e = i % 3 == 0 ? 0.0F : static_cast<float>(random.log_uniform(0.6, 1.6));
    inputs.push_back(next);
  }
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "footprint", {});
  const auto outputs = map_on_device<vec3>(kernel, inputs);
  double worst = 0;
  for (size_t i = 0; i < inputs.size(); ++i) {
    const Encounters& in = inputs[i];
    const dvec3 expected = expected_footprint(in), measured(outputs[i]);
    const double d = in.distance, h = std::abs(in.curvature),
                 bend = in.e == 0 ? 2 * h : std::abs(1 - in.e) * h;
    const double gain = in.e == 0 ? 1 : in.e;
    const double x = std::sqrt(in.footprint.x) + d * std::sqrt(in.footprint.z);
    const double angle = gain * std::sqrt(in.footprint.z) + bend * x;
    const dvec3 scale(x * x, x * angle, angle * angle);
    for (int k = 0; k < 3; ++k) {
      const double error = std::abs(measured[k] - expected[k]) / scale[k];
      worst = std::max(worst, error);
      EXPECT_LT(error, 2e-6) << "case " << i << " moment " << k;
    }
  }
  std::printf("%zu encounters: largest error %.2e of the moments' scale (bound 2e-6)\n", inputs.size(),
              worst);
}

struct Corners {
  interface::Vertex vertices[3];
};

// Interpolated normals of a sphere are exactly linear in the position: the curvature is 1 / radius whatever
// the triangle. On a cylinder the mean of 1 / radius and 0 is approached as the triangles shrink.
TEST(Footprint, MeanCurvatureOfSpheresAndCylinders) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(72);
  std::vector<Corners> inputs;
  std::vector<double> expected, bound;
  for (int i = 0; i < 3000; ++i) {
    const double radius = random.log_uniform(0.01, 100), side = i % 2 == 0 ? 1 : -1;
    const bool is_cylinder = i % 3 == 0;
    const dvec3 towards = random.direction();
    const double turn = std::atan2(towards.y, towards.x);
    Corners corners{};
    for (interface::Vertex& vertex : corners.vertices) {
      dvec3 normal = normalize(towards + 0.05 * random.direction());
      dvec3 position = radius * normal;
      if (is_cylinder) {
        const double angle = turn + 0.05 * (random.uniform() - 0.5);
        normal = {std::cos(angle), std::sin(angle), 0};
        position = radius * dvec3(normal.x, normal.y, 0.05 * random.uniform());
      }
      vertex.position = position;
      vertex.normal = side * normal;
    }
    const dvec3 a(corners.vertices[0].position), b(corners.vertices[1].position),
        c(corners.vertices[2].position);
    const double area = length(cross(b - a, c - a));
    const double longest = std::max({length(b - a), length(c - b), length(a - c)});
    if (area < 0.2 * longest * longest) continue;  // not a sliver: its normals tell little across it
    // Normals that agree with the winding make the front convex; turned round, both normals and front are.
    const bool is_outward = side * dot(cross(b - a, c - a), dvec3(corners.vertices[0].normal)) > 0;
    inputs.push_back(corners);
    expected.push_back((is_outward ? 1 : -1) / radius * (is_cylinder ? 0.5 : 1));
    // Rounding of normals and positions over a 0.01 rad triangle; on cylinders the chord's shortening as
    // well.
    bound.push_back((is_cylinder ? 1e-3 : 1e-4) / radius);
  }
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "curvature", {});
  const auto measured = map_on_device<float>(kernel, inputs);
  double worst = 0;
  for (size_t i = 0; i < inputs.size(); ++i) {
    worst = std::max(worst, std::abs(measured[i] - expected[i]) / bound[i]);
    EXPECT_NEAR(measured[i], expected[i], bound[i]) << "case " << i;
  }
  std::printf("%zu triangles: largest error %.2f of the bound\n", inputs.size(), worst);
}

}  // namespace
}  // namespace regulus::test

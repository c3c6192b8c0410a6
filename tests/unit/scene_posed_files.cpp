// Skinned, morphed and animated files of the shared assets: triangles stand where three.js puts them
// (poses/expected_positions.json, written by poses/expected_positions.mjs).
#include <gtest/gtest.h>

#include <cmath>

#include "scene/placement.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

using glm::dvec3;

// three.js keeps the weights of joints and morph targets and what it interpolates in single precision, as we
// keep positions: roundings of 2^-24 in up to four weights and in the rotations of a chain of about ten
// joints reach a share of 2^-20 of the extent.
constexpr double SHARE_OF_EXTENT = 0x1p-19;

json expected_poses() {
  std::ifstream stream(REGULUS_SOURCE_DIR "/tests/unit/poses/expected_positions.json");
  return json::parse(stream);
}

dvec3 vector_of(const json& numbers, size_t first = 0) {
  return {numbers[first].get<double>(), numbers[first + 1].get<double>(), numbers[first + 2].get<double>()};
}

struct Moments {
  dvec3 mean{0}, mean_square{0};
};

/// Of all corners of the triangles.
Moments moments(const Scene& scene) {
  Moments sum;
  for (uint32_t t = 0; t < scene.triangles.size(); ++t)
    for (const glm::vec3& corner : placed_positions(scene, t)) {
      sum.mean += dvec3(corner);
      sum.mean_square += dvec3(corner) * dvec3(corner);
    }
  const double corners = 3.0 * static_cast<double>(scene.triangles.size());
  return {sum.mean / corners, sum.mean_square / corners};
}

/// Largest distance of sampled corners from where they should be.
double largest_error(const Scene& scene, const json& sampled) {
  double largest = 0;
  for (const json& triangle : sampled) {
    const auto corners = placed_positions(scene, triangle[0].get<uint32_t>());
    for (size_t i = 0; i < 3; ++i)
      largest = std::max(largest, glm::length(dvec3(corners[i]) - vector_of(triangle, 1 + 3 * i)));
  }
  return largest;
}

TEST(ScenePosedFiles, StandWhereAnIndependentImplementationPutsThem) {
  const std::filesystem::path folder = std::filesystem::path(REGULUS_ASSETS_DIR) / "gltf";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  for (const json& expected : expected_poses()) {
    LoadOptions options;
    if (!expected["animation"].is_null()) {
      options.animation = expected["animation"].get<std::string>();
      options.time = expected["time"].get<double>();
    }
    const Scene scene = load(folder / expected["file"].get<std::string>(), options);
    ASSERT_EQ(scene.triangles.size(), expected["triangles"].get<size_t>()) << expected["file"];
    const double extent = glm::length(dvec3(scene.bounds_max) - dvec3(scene.bounds_min));
    const double tolerance = SHARE_OF_EXTENT * extent;
    const double error = largest_error(scene, expected["sampled"]);
    const Moments found = moments(scene);
    const double of_mean = glm::length(found.mean - vector_of(expected["mean"]));
    const double of_square = glm::length(found.mean_square - vector_of(expected["meanSquare"]));
    std::printf("%s %s %g: %.2g of the extent, mean %.2g\n", expected["file"].get<std::string>().c_str(),
                expected["animation"].dump().c_str(), expected["time"].get<double>(), error / extent,
                of_mean / extent);
    EXPECT_LE(error, tolerance);
    EXPECT_LE(of_mean, tolerance);
    // |d(x^2)| <= 2 |x| |dx|, and no |x| is beyond the bounds.
    EXPECT_LE(of_square, 2 * tolerance * (extent + glm::length(dvec3(scene.bounds_max))));
  }
}

}  // namespace
}  // namespace regulus::scene::test

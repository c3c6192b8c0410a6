// Rays that run along the faces of boxes, meet triangles exactly in a corner or an edge, come from far away,
// or have components that are zero, minus zero or tiny.
#include <gtest/gtest.h>

#include <cmath>

#include "bvh_queries.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

constexpr uint32_t MISS = interface::INVALID_INDEX;

/// Axes with `z` as the normal: the permutations that keep a right-handed frame.
glm::dvec3 permuted(const glm::dvec3& v, int axis) {
  return axis == 0 ? glm::dvec3(v.z, v.x, v.y) : axis == 1 ? glm::dvec3(v.y, v.z, v.x) : v;
}

/// A flat square of size x size cells in the plane z = height of the permuted axes, from (low, low) on.
Triangles make_sheet(int size, double cell, double low, double height, int axis) {
  const auto corner = [&](int x, int y) {
    return glm::vec3(permuted({low + cell * x, low + cell * y, height}, axis));
  };
  Triangles triangles;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      triangles.push_back({{corner(x, y), corner(x + 1, y), corner(x + 1, y + 1)}});
      triangles.push_back({{corner(x, y), corner(x + 1, y + 1), corner(x, y + 1)}});
    }
  return triangles;
}

/// How many rays miss, by either query.
uint32_t count_misses(RayQueries& queries, const Rays& rays) {
  const std::vector<interface::Hit> hits = queries.closest(rays);
  const std::vector<bool> any = queries.any(rays);
  uint32_t misses = 0;
  for (size_t i = 0; i < rays.size(); ++i) misses += hits[i].triangle == MISS || !any[i];
  EXPECT_EQ(queries.overruns(), 0u);
  return misses;
}

}  // namespace

// The boxes of a flat sheet share faces, and its triangles edges: a ray through an inner corner or edge must
// be caught by one of them, however far it comes from. There the distances to two planes of a box agree up to
// their rounding, which is far larger than the box.
TEST(BvhEdges, ASheetCatchesRaysFromFarAway) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr int SIZE = 48;
  constexpr double CELL = 0.37;
  Random random(71);
  for (const double distance : {1e1, 1e3, 1e4, 1e5, 1e6})
    for (int axis = 0; axis < 3; ++axis) {
      const Triangles triangles = make_sheet(SIZE, CELL, -8.6, 0.3, axis);
      Rays rays;
      const auto aim = [&](double x, double y) {
        const glm::dvec3 target = permuted({-8.6 + CELL * x, -8.6 + CELL * y, 0.3}, axis);
        // From steep to nearly along the sheet: then it is seen as a line, and what is known of the target's
        // corners is less than its cells, so that only rays to its middle must meet it.
        const double rise = random.log_uniform(0.05, 1);
        glm::dvec3 from = random.direction();
        from.z = random.uniform() < 0.5 ? rise : -rise;
        rays.push_back(make_ray(target + distance * permuted(normalize(from), axis), -permuted(from, axis)));
        // Straight towards it, with two components of zero.
        rays.push_back(make_ray(target + distance * permuted({0, 0, 1}, axis), permuted({0, 0, -1}, axis)));
      };
      for (int i = 0; i < 4000; ++i) {
        // The middle half, whose distance from the border is above the error of the farthest origins, 1e6
        // 2^-23 / 0.05.
        const double x = SIZE / 4 + random.index(SIZE / 2), y = SIZE / 4 + random.index(SIZE / 2);
        aim(x, y);
        aim(x + random.uniform(), y);
        aim(x, y + random.uniform());
      }
      RayQueries queries(triangles);
      const uint32_t misses = count_misses(queries, rays);
      std::printf("sheet across axis %d from %g m: %zu rays, %u missed it (bound 0)\n", axis, distance,
                  rays.size(), misses);
      EXPECT_EQ(misses, 0u);
    }
}

// Coordinates are multiples of 1/8, directions along an axis: everything is exact, and edges and corners
// belong to a triangle. Zero components of both signs: the ray lies in the faces of boxes.
TEST(BvhEdges, CornersAndEdgesAreHitWithZeroComponents) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr int SIZE = 8;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0})
      for (const float zero_u : {0.0f, -0.0f})
        for (const float zero_v : {0.0f, -0.0f}) {
          Rays rays;
          for (int y = 0; y <= 2 * SIZE; ++y)
            for (int x = 0; x <= 2 * SIZE; ++x) {  // the border included
              const glm::vec3 origin(permuted({0.125 * x - 1, 0.125 * y - 1, 0.5 + 2 * side}, axis));
              const glm::vec3 direction(permuted({zero_u, zero_v, -side}, axis));
              rays.push_back({origin, 2, direction, 0});  // ends on the sheet
            }
          RayQueries queries(make_sheet(SIZE, 0.25, -1, 0.5, axis));
          EXPECT_EQ(count_misses(queries, rays), 0u)
              << "axis " << axis << ", from " << side << ", zeros " << zero_u << " " << zero_v;
          for (interface::BenchRay& ray : rays) ray.t_max = std::nextafter(2.0f, 0.0f);
          EXPECT_EQ(count_misses(queries, rays), rays.size()) << "they end short of it";
        }
}

// A ray in the very plane of a triangle sees none of it; one in the plane of a face of its box does.
TEST(BvhEdges, EdgeOnTrianglesAreMissedAndWhatIsBehindIsNot) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (int axis = 0; axis < 3; ++axis) {
    Triangles triangles = make_sheet(4, 0.5, -1, 0, axis);
    const auto sheet = static_cast<uint32_t>(triangles.size());
    // A wall across the sheet's plane, behind it.
    const auto wall = [&](double y, double z) { return glm::vec3(permuted({2, y, z}, axis)); };
    triangles.push_back({{wall(-2, -2), wall(2, -2), wall(2, 2)}});
    triangles.push_back({{wall(-2, -2), wall(2, 2), wall(-2, 2)}});
    Rays rays;
    for (int i = 0; i <= 16; ++i)
      for (const float zero : {0.0f, -0.0f}) {
        const glm::dvec3 origin = permuted({-3, 0.125 * i - 1, 0}, axis);
        rays.push_back({glm::vec3(origin), UNBOUNDED, glm::vec3(permuted({1, zero, zero}, axis)), 0});
      }
    RayQueries queries(triangles);
    for (const interface::Hit& hit : queries.closest(rays)) {
      ASSERT_NE(hit.triangle, MISS);
      EXPECT_GE(hit.triangle, sheet);
      EXPECT_EQ(hit.t, 5);
    }
  }
}

// Directions need not be unit vectors. Below 1e-18 (traversal.glsl) they count as none: boxes could not be
// told from each other, although the triangles themselves, which are large enough to be met by any guess,
// could still be hit.
TEST(BvhEdges, LengthOfTheDirectionScalesDistancesDownToNothing) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Rays rays, without_direction;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const glm::dvec3 origin = permuted({0.1, 0.2, -sign}, axis), direction = permuted({0, 0, sign}, axis);
      for (const int exponent : {0, 20, 40, -20, -40, -56})
        rays.push_back({glm::vec3(origin), UNBOUNDED, glm::vec3(std::ldexp(1.0, exponent) * direction), 0});
      for (const int exponent : {-61, -80, -120})
        without_direction.push_back(
            {glm::vec3(origin), UNBOUNDED, glm::vec3(std::ldexp(1.0, exponent) * direction), 0});
    }
  Triangles triangles;
  for (int axis = 0; axis < 3; ++axis) {
    const Triangles sheet = make_sheet(4, 5, -10, 0, axis);
    triangles.insert(triangles.end(), sheet.begin(), sheet.end());
  }
  RayQueries queries(triangles);
  const std::vector<interface::Hit> hits = queries.closest(rays);
  for (size_t i = 0; i < rays.size(); ++i)
    EXPECT_EQ(hits[i].t * glm::length(glm::dvec3(rays[i].direction)), 1) << "ray " << i;
  EXPECT_EQ(count_misses(queries, rays), 0u);
  EXPECT_EQ(count_misses(queries, without_direction), without_direction.size());
}

}  // namespace regulus::test

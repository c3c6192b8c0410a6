// The closest-hit and any-hit kernels find what exact geometry and Embree find.
#include <fmt/format.h>
#include <gtest/gtest.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "bvh_queries.hpp"
#include "scene/scene.hpp"
#include "support/device.hpp"

namespace regulus::test {

namespace {

constexpr uint32_t MISS = interface::INVALID_INDEX;

std::vector<uint32_t> all_of(const Triangles& triangles) {
  std::vector<uint32_t> indices(triangles.size());
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

/// Holds every hit against all triangles, and the any-hit query against the closest-hit query.
void expect_exact(const Triangles& triangles, const Rays& rays) {
  RayQueries queries(triangles);
  const std::vector<interface::Hit> hits = queries.closest(rays);
  const std::vector<bool> any = queries.any(rays);
  const std::vector<uint32_t> candidates = all_of(triangles);
  uint32_t found = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const std::string problem = check_hit(triangles, candidates, rays[i], hits[i]);
    ASSERT_EQ(problem, "") << "ray " << i;
    const bool is_hit = hits[i].triangle != MISS;
    ASSERT_EQ(any[i], is_hit) << "ray " << i;
    found += is_hit;
  }
  EXPECT_EQ(queries.overruns(), 0u);
  std::printf("%zu rays, %u hits, all within rounding of exact geometry\n", rays.size(), found);
  EXPECT_GT(found, rays.size() / 10) << "the test must hit something";
}

struct Placement {
  double scale;
  glm::dvec3 shift;
};

class BvhPlacement : public testing::TestWithParam<Placement> {};

/// What Embree finds in robust mode: for each ray the triangle and t.
std::vector<interface::Hit> embree_closest(const Triangles& triangles, const Rays& rays) {
  RTCDevice embree = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(embree);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), 3 * triangles.size()));
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles.size()));
  std::iota(indices, indices + 3 * triangles.size(), 0u);
  for (size_t i = 0; i < triangles.size(); ++i)
    std::copy_n(triangles[i].vertices.begin(), 3, vertices + 3 * i);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  std::vector<interface::Hit> hits;
  for (const interface::BenchRay& ray : rays) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = ray.origin.x;
    query.ray.org_y = ray.origin.y;
    query.ray.org_z = ray.origin.z;
    query.ray.dir_x = ray.direction.x;
    query.ray.dir_y = ray.direction.y;
    query.ray.dir_z = ray.direction.z;
    query.ray.tfar = ray.t_max;
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &query);
    const bool is_hit = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hits.push_back({query.ray.tfar, query.hit.u, query.hit.v, is_hit ? query.hit.primID : MISS});
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(embree);
  return hits;
}

/// Both find the same triangle; or each of the two is right about what the other found.
void expect_as_embree(const Triangles& triangles, const Rays& rays) {
  RayQueries queries(triangles);
  const std::vector<interface::Hit> hits = queries.closest(rays);
  const std::vector<interface::Hit> expected = embree_closest(triangles, rays);
  uint32_t found = 0;
  uint32_t other_triangle = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    std::vector<uint32_t> candidates;
    if (expected[i].triangle != MISS) candidates.push_back(expected[i].triangle);
    ASSERT_EQ(check_hit(triangles, candidates, rays[i], hits[i]), "") << "ray " << i;
    found += hits[i].triangle != MISS;
    other_triangle += hits[i].triangle != expected[i].triangle;
  }
  EXPECT_EQ(queries.overruns(), 0u);
  std::printf(
      "%zu rays, %u hits, %u times another triangle than Embree, each within rounding of an edge or a tie\n",
      rays.size(), found, other_triangle);
  EXPECT_GT(found, rays.size() / 10) << "the test must hit something";
}

/// Rays between random points of the bounds.
Rays rays_across(Random& random, const Triangles& triangles, uint32_t count) {
  glm::vec3 lower(std::numeric_limits<float>::max());
  glm::vec3 upper = -lower;
  for (const bvh::InputTriangle& triangle : triangles)
    for (const glm::vec3& vertex : triangle.vertices) {
      lower = glm::min(lower, vertex);
      upper = glm::max(upper, vertex);
    }
  const glm::dvec3 extent = glm::dvec3(upper) - glm::dvec3(lower);
  Rays rays;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::dvec3 from = glm::dvec3(lower) + random.cube() * extent;
    rays.push_back(make_ray(from, glm::dvec3(lower) + random.cube() * extent - from));
  }
  return rays;
}

}  // namespace

TEST_P(BvhPlacement, HitsAreExactUpToRounding) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(1);
  Triangles triangles = make_soup(random, 500);
  Rays rays = make_rays(random, 2000);
  transform(triangles, rays, GetParam().scale, GetParam().shift);
  expect_exact(triangles, rays);
}

INSTANTIATE_TEST_SUITE_P(Placements, BvhPlacement,
                         testing::Values(Placement{1, glm::dvec3(0)}, Placement{1e-4, glm::dvec3(0)},
                                         Placement{1e6, glm::dvec3(0)},
                                         Placement{1, glm::dvec3(1e4, -2e4, 5e3)},
                                         Placement{1e-4, glm::dvec3(1, 1, -1)},
                                         Placement{100, glm::dvec3(-1e6, 1e6, 1e6)}));

TEST(BvhHits, CoplanarDuplicatesAndStackedCopiesTie) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(2);
  const Triangles distinct = make_soup(random, 60);
  Triangles triangles;
  for (int copy = 0; copy < 9; ++copy) triangles.insert(triangles.end(), distinct.begin(), distinct.end());
  expect_exact(triangles, make_rays(random, 1000));
}

TEST(BvhHits, AgreeWithEmbreeOnALargeSoup) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(3);
  const Triangles triangles = make_soup(random, 30000);
  expect_as_embree(triangles, make_rays(random, 5000));
}

TEST(BvhHits, AgreeWithEmbreeOnScenes) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(4);
  for (const char* name : {"cornell-dragon100k", "lux-kitchen"}) {
    const std::filesystem::path path =
        std::filesystem::path(REGULUS_ASSETS_DIR) / "scenes" / (std::string(name) + ".glb");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    const scene::Scene scene = scene::load(path);
    Triangles triangles;
    for (const interface::Triangle& triangle : scene.triangles)
      triangles.push_back({{scene.vertices[triangle.v0].position, scene.vertices[triangle.v1].position,
                            scene.vertices[triangle.v2].position}});
    std::printf("%s: ", name);
    expect_as_embree(triangles, rays_across(random, triangles, 10000));
  }
}

TEST(BvhHits, AnyHitKeepsWithinItsLength) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(5);
  const Triangles triangles = make_soup(random, 2000);
  RayQueries queries(triangles);
  Rays rays = make_rays(random, 2000);
  for (interface::BenchRay& ray : rays) ray.t_max = UNBOUNDED;
  const std::vector<interface::Hit> hits = queries.closest(rays);
  // Up to the hit it is found, short of it not; both queries compute the same t.
  Rays reaching, short_of;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle == MISS) continue;
    reaching.push_back(rays[i]);
    reaching.back().t_max = hits[i].t;
    short_of.push_back(rays[i]);
    short_of.back().t_max = std::nextafter(hits[i].t, 0.0f);
  }
  ASSERT_GT(reaching.size(), 200u);
  const std::vector<bool> reached = queries.any(reaching);
  const std::vector<bool> passed = queries.any(short_of);
  for (size_t i = 0; i < reaching.size(); ++i) {
    EXPECT_TRUE(reached[i]) << "ray " << i;
    EXPECT_FALSE(passed[i]) << "ray " << i;
  }
}

TEST(BvhHits, TrianglesWithoutAreaAreNeverHit) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(6);
  Triangles triangles;
  Rays rays;
  for (uint32_t i = 0; i < 500; ++i) {
    // Multiples of 2^-10 along a direction of small integers are exactly collinear in floats.
    const glm::vec3 step = glm::vec3(glm::ivec3(random.cube() * 15.0)) / 1024.0f;
    const glm::vec3 start = glm::vec3(glm::ivec3(random.cube() * 1000.0)) / 1024.0f;
    const std::array<glm::vec3, 3> vertices = {start, start + 3.0f * step, start + 7.0f * step};
    triangles.push_back({vertices});
    const glm::dvec3 from = 3.0 * random.direction();
    const glm::dvec3 target = glm::mix(glm::dvec3(vertices[0]), glm::dvec3(vertices[2]), random.uniform());
    rays.push_back(make_ray(from, target - from));
    rays.push_back(make_ray(from, glm::dvec3(vertices[1]) - from));
  }
  RayQueries queries(triangles);
  const std::vector<interface::Hit> hits = queries.closest(rays);
  const std::vector<bool> any = queries.any(rays);
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i].triangle, MISS) << "ray " << i;
    EXPECT_FALSE(any[i]) << "ray " << i;
  }
}

TEST(BvhHits, RaysThatAreNoRaysMiss) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(7);
  RayQueries queries(make_soup(random, 2000));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  Rays rays;
  for (float bad : {nan, infinity, -infinity}) {
    for (int axis = 0; axis < 3; ++axis) {
      rays.push_back(make_ray({0, 0, 0}, {1, 1, 1}));
      rays.back().origin[axis] = bad;
      rays.push_back(make_ray({0, 0, 0}, {1, 1, 1}));
      rays.back().direction[axis] = bad;
    }
  }
  rays.push_back({{0, 0, 0}, UNBOUNDED, {0, 0, 0}, 0});
  for (float bad : {nan, 0.0f, -1.0f}) rays.push_back(make_ray({0, 0, 0}, {1, 1, 1}, bad));
  const std::vector<interface::Hit> hits = queries.closest(rays);
  const std::vector<bool> any = queries.any(rays);
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(hits[i].triangle, MISS) << "ray " << i;
    EXPECT_FALSE(any[i]) << "ray " << i;
  }
  EXPECT_EQ(queries.overruns(), 0u);
}

TEST(BvhHits, EndlessWorkIsCutShortAndCounted) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  // More copies of one triangle than a ray may test (TRAVERSAL_MAX_STEPS), beside a triangle that stands
  // alone.
  Triangles triangles(20000, {{glm::vec3(0, 0, 1), glm::vec3(1, 0, 1), glm::vec3(0, 1, 1)}});
  triangles.push_back({{glm::vec3(5, 0, 2), glm::vec3(6, 0, 2), glm::vec3(5, 1, 2)}});
  RayQueries queries(triangles);
  const Rays rays = {make_ray({0.2, 0.2, 0}, {0, 0, 1}), make_ray({5.2, 0.2, 0}, {0, 0, 1})};
  const std::vector<interface::Hit> hits = queries.closest(rays);
  EXPECT_EQ(queries.overruns(), 1u);
  EXPECT_EQ(hits[0].t, 1);
  EXPECT_EQ(hits[1].t, 2);
}

TEST(BvhHits, AnEmptySceneIsMissed) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(8);
  RayQueries queries({});
  const Rays rays = make_rays(random, 100);
  for (const interface::Hit& hit : queries.closest(rays)) EXPECT_EQ(hit.triangle, MISS);
  for (bool is_hit : queries.any(rays)) EXPECT_FALSE(is_hit);
}

}  // namespace regulus::test

// The reference's traversal: against testing every triangle, and against Embree in robust mode, which shares
// neither code nor precision with it.
#include "reference/traversal.hpp"

#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "images/support/copies.hpp"
#include "reference/support/reference_images.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec3;
using interface::INVALID_INDEX;

bvh::Bvh soup(test::Random& random, int count) {
  std::vector<bvh::InputTriangle> triangles;
  for (int i = 0; i < count; ++i) {
    const dvec3 center = random.cube();
    const double size = random.log_uniform(1e-3, 0.3);
    bvh::InputTriangle triangle;
    for (glm::vec3& vertex : triangle.vertices) vertex = glm::vec3(center + size * (random.cube() - 0.5));
    triangles.push_back(triangle);
  }
  return bvh::build(triangles);
}

Ray random_ray(test::Random& random) {
  const dvec3 origin = 2.0 * random.cube() - 0.5;
  return {origin, normalize(random.cube() - origin + 1e-9)};
}

TEST(ReferenceTraversal, FindsWhatTestingEveryTriangleFinds) {
  test::Random random(61);
  const bvh::Bvh tree = soup(random, 2000);
  const Traversal traversal(tree);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    Ray ray = random_ray(random);
    if (i % 3 == 0) ray.t_max = random.uniform(0.1, 1);
    if (i % 5 == 0) ray.direction[i % 3] = 0;
    std::optional<Intersection> expected;
    for (uint32_t k = 0; k < tree.triangles.size(); ++k) {
      const interface::BvhTriangle& t = tree.triangles[k];
      auto hit = intersect(ray, {dvec3(t.v0), dvec3(t.v1), dvec3(t.v2)});
      if (!hit || (expected && hit->t >= expected->t)) continue;
      hit->triangle = k;
      expected = hit;
    }
    const auto found = traversal.closest(ray);
    ASSERT_EQ(found.has_value(), expected.has_value()) << i;
    EXPECT_EQ(traversal.is_occluded(ray), expected.has_value());
    if (!found) continue;
    ++hits;
    EXPECT_EQ(found->triangle, expected->triangle);
    EXPECT_EQ(found->t, expected->t);
    const interface::BvhTriangle& t = tree.triangles[found->triangle];
    const double u = found->barycentrics.x;
    const double v = found->barycentrics.y;
    const dvec3 on_triangle = (1 - u - v) * dvec3(t.v0) + u * dvec3(t.v1) + v * dvec3(t.v2);
    EXPECT_LT(length(on_triangle - (ray.origin + found->t * ray.direction)), 1e-11);
  }
  EXPECT_GT(hits, 1000);
}

using Corners = std::array<glm::vec3, 3>;

/// The triangles of a tree without instances, and of a scene with them by their places.
std::vector<Corners> corners_of(const bvh::Bvh& tree) {
  std::vector<Corners> corners;
  for (const interface::BvhTriangle& t : tree.triangles) corners.push_back({t.v0, t.v1, t.v2});
  return corners;
}

class EmbreeScene {
 public:
  explicit EmbreeScene(const std::vector<Corners>& triangles)
      : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t count = triangles.size();
    auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), 3 * count));
    auto* indices = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), count));
    for (uint32_t i = 0; i < count; ++i) {
      for (uint32_t k = 0; k < 3; ++k) vertices[3 * i + k] = triangles[i][k];
      indices[i] = {3 * i, 3 * i + 1, 3 * i + 2};
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  std::optional<Intersection> closest(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(ray.origin.x);
    query.ray.org_y = static_cast<float>(ray.origin.y);
    query.ray.org_z = static_cast<float>(ray.origin.z);
    query.ray.dir_x = static_cast<float>(ray.direction.x);
    query.ray.dir_y = static_cast<float>(ray.direction.y);
    query.ray.dir_z = static_cast<float>(ray.direction.z);
    query.ray.tfar = std::numeric_limits<float>::infinity();
    query.ray.mask = 0xFFFFFFFFu;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return Intersection{query.ray.tfar, {query.hit.u, query.hit.v}, query.hit.primID};
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

// Both work on the same single-precision rays. They may differ where a ray passes within single precision of
// an edge: then one sees what lies behind it. Such rays are few, and each must pass an edge that closely.
// number_of: the number that Embree's triangle has in the scene.
void expect_agreement(const std::string& name, const PreparedScene& prepared,
                      const std::vector<Corners>& triangles, const std::vector<uint32_t>& number_of) {
  const EmbreeScene embree(triangles);
  const Traversal traversal(prepared.bvh, &prepared.scene);
  test::Random random(62);
  const dvec3 low(prepared.scene.bounds_min);
  const dvec3 size = dvec3(prepared.scene.bounds_max) - low;
  constexpr int RAYS = 50000;
  int differ = 0;
  double worst = 0;
  for (int i = 0; i < RAYS; ++i) {
    Ray ray{dvec3(glm::vec3(low + size * random.cube())), dvec3(glm::vec3(random.direction()))};
    const auto found = traversal.closest(ray);
    const auto expected = embree.closest(ray);
    const bool is_same = found.has_value() == expected.has_value() &&
                         (!found || found->triangle == number_of[expected->triangle]);
    EXPECT_EQ(traversal.is_occluded(ray), found.has_value());
    if (is_same && found) {
      // t errs by the rounding of the vertices relative to the origin, over the cosine of the plane.
      const Corners& t = triangles[expected->triangle];
      const dvec3 normal = normalize(cross(dvec3(t[1]) - dvec3(t[0]), dvec3(t[2]) - dvec3(t[0])));
      const double allowed = 16 * 6e-8 * length(size) / std::abs(dot(normal, ray.direction));
      worst = std::max(worst, std::abs(found->t - expected->t) / allowed);
    }
    if (is_same) continue;
    ++differ;
    const double least_found = found ? std::min({found->barycentrics.x, found->barycentrics.y,
                                                 1 - found->barycentrics.x - found->barycentrics.y})
                                     : 1;
    const double least_expected = expected
                                      ? std::min({expected->barycentrics.x, expected->barycentrics.y,
                                                  1 - expected->barycentrics.x - expected->barycentrics.y})
                                      : 1;
    const bool is_tie = found && expected && std::abs(found->t - expected->t) < 1e-5 * length(size);
    EXPECT_TRUE(is_tie || std::min(least_found, least_expected) < 1e-3) << name << " ray " << i;
  }
  std::printf("%s: %d rays, %d see another triangle, t off by at most %.2g of its bound\n", name.c_str(),
              RAYS, differ, worst);
  EXPECT_LT(differ, RAYS / 1000);
  EXPECT_LT(worst, 1);
}

TEST(ReferenceTraversal, AgreesWithEmbreeAwayFromEdges) {
  for (const char* name : {"cornell/cornell.gltf", "plates/plates.gltf"}) {
    const PreparedScene prepared = test::prepare(test::own_scenes() / name);
    std::vector<uint32_t> numbers(prepared.scene.triangles.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    expect_agreement(name, prepared, corners_of(prepared.bvh), numbers);
  }
}

// Two hundred copies of a ball, of sizes from 2 mm to 2 m, turned, stretched up to fourfold, every other one
// mirrored. Embree gets every copy's triangles, which the test moves to their places itself.
TEST(ReferenceTraversal, FindsCopiesWhereEmbreeFindsTheirTriangles) {
  test::Random random(63);
  const test::Polygons ball = test::sphere({0.3, 0, 0.1}, 1, 8);
  test::GltfScene scene;
  scene.add({test::quad({-9, -5, 9}, {18, 0, 0}, {0, 0, -18})}, test::lambert({0.5, 0.5, 0.5}));
  std::vector<glm::dmat4> places;
  for (int i = 0; i < 200; ++i) {
    const double scale = random.log_uniform(1e-3, 1);
    places.push_back(
        test::placed(10.0 * random.cube() - 5.0, random.uniform(0, 360), random.direction(),
                     scale * dvec3(i % 2 == 0 ? 1 : -1, random.uniform(0.5, 2), random.uniform(0.5, 2))));
    if (i == 0) scene.add(ball, test::lambert({0.5, 0.5, 0.5}), places[0]);
    if (i > 0) scene.add_copy(places.back());
  }
  scene.add_point_light({0, 4, 0}, {1, 1, 1});
  const PreparedScene prepared = test::shared_copies(scene);
  ASSERT_EQ(prepared.scene.instances.size(), places.size());

  std::vector<Corners> triangles;
  std::vector<uint32_t> numbers;
  for (uint32_t i = prepared.scene.shared_meshes[0].triangle_count; i < prepared.scene.triangles.size();
       ++i) {
    triangles.push_back(
        {prepared.bvh.triangles[i].v0, prepared.bvh.triangles[i].v1, prepared.bvh.triangles[i].v2});
    numbers.push_back(i);
  }
  for (size_t k = 0; k < places.size(); ++k)
    for (uint32_t i = 0; i < prepared.scene.shared_meshes[0].triangle_count; ++i) {
      const interface::BvhTriangle& t = prepared.bvh.triangles[i];
      const auto to_world = [&](const glm::vec3& v) { return glm::vec3(places[k] * glm::dvec4(v, 1)); };
      const bool is_mirrored = k % 2 != 0;
      triangles.push_back(
          {to_world(t.v0), to_world(is_mirrored ? t.v2 : t.v1), to_world(is_mirrored ? t.v1 : t.v2)});
      numbers.push_back(prepared.scene.instances[k].first_number + i);
    }
  expect_agreement("copies", prepared, triangles, numbers);
}

}  // namespace
}  // namespace regulus::reference

// The pieces of the reference's estimators, each against what defines it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reference/estimator.hpp"
#include "reference/quadrature.hpp"
#include "reference/support/reference_images.hpp"
#include "scene/scene.hpp"
#include "support/chi_square.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

constexpr uint32_t WIDTH = 64, HEIGHT = 48;

interface::Camera device_camera(uint32_t kind, float lens_radius) {
  interface::Camera camera {};
  camera.kind = kind;
  camera.position = {1, 2, 3};
  camera.forward = glm::normalize(glm::vec3(0.3f, -0.2f, -1));
  const glm::vec3 right = glm::normalize(glm::cross(camera.forward, glm::vec3(0, 1, 0)));
  camera.right = 0.8f * right;
  camera.up = 0.6f * glm::cross(right, camera.forward);
  camera.lens_radius = lens_radius;
  camera.focus_distance = 2.5f;
  camera.z_far = scene::NO_FAR_PLANE;
  return camera;
}

std::vector<Camera> cameras() {
  std::vector<Camera> all;
  all.emplace_back(device_camera(interface::CAMERA_PERSPECTIVE, 0), WIDTH, HEIGHT);
  all.emplace_back(device_camera(interface::CAMERA_PERSPECTIVE, 0.1f), WIDTH, HEIGHT);
  all.emplace_back(device_camera(interface::CAMERA_ORTHOGRAPHIC, 0), WIDTH, HEIGHT);
  return all;
}

// Forward and up are unit and orthogonal to single precision only, which 1e-6 pixels of 64 allow for.
TEST(ReferenceCamera, ProjectionInvertsRays) {
  test::Random random(31);
  double worst = 0;
  for (const Camera& camera : cameras())
    for (int i = 0; i < 1000; ++i) {
      const dvec2 film(random.uniform(-2, WIDTH + 2), random.uniform(-2, HEIGHT + 2));
      const dvec2 u = random.square();
      const CameraRay ray = camera.ray(film, u);
      const auto projection = camera.project(ray.origin + random.uniform(0.1, 20) * ray.direction, u);
      ASSERT_TRUE(projection);
      worst = std::max({worst, length(projection->film - film), length(projection->ray.origin - ray.origin),
                        length(projection->ray.direction - ray.direction)});
    }
  std::printf("largest difference %.2g pixels or metres (bound 1e-5)\n", worst);
  EXPECT_LT(worst, 1e-5);
}

// One pixel's worth of rays by central differences, against the density.
TEST(ReferenceCamera, DensityIsThatOfFilmPoints) {
  test::Random random(32);
  constexpr double STEP = 1e-3;
  for (const Camera& camera : cameras())
    for (int i = 0; i < 200; ++i) {
      const dvec2 film(random.uniform(0, WIDTH), random.uniform(0, HEIGHT));
      const dvec2 u = random.square();
      const CameraRay ray = camera.ray(film, u);
      const RayDensity density = camera.density(ray.direction);
      const auto quantity = [&](const dvec2& at) {
        const CameraRay moved = camera.ray(at, u);
        return density.is_parallel ? moved.origin : moved.direction;
      };
      const dvec3 dx = (quantity(film + dvec2(STEP, 0)) - quantity(film - dvec2(STEP, 0))) / (2 * STEP);
      const dvec3 dy = (quantity(film + dvec2(0, STEP)) - quantity(film - dvec2(0, STEP))) / (2 * STEP);
      EXPECT_NEAR(density.value * length(cross(dx, dy)), 1, 1e-6);
    }
}

TEST(ReferenceFilter, SamplesHaveTheDensityWhoseIntegralIsOne) {
  for (const Filter& filter :
       {Filter{interface::FILTER_BOX, 0.5, 0}, Filter{interface::FILTER_GAUSSIAN, 1.5, 0.5},
        Filter{interface::FILTER_BLACKMAN_HARRIS, 1.5, 0}}) {
    const double r = filter.radius;
    const auto value = [&](double x, double y) { return filter.value({x, y}); };
    EXPECT_NEAR(integrate_2d(value, -r, r, 8, -r, r, 8), 1, 1e-9) << filter.kind;
    // The share of the filter to the left of a sample is the number it was made of.
    for (const double u : {0.001, 0.2, 0.5, 0.77, 0.999}) {
      const double x = filter.sample({u, 0.5}).x;
      EXPECT_NEAR(integrate_2d(value, -r, x, 8, -r, r, 8), u, 1e-9) << filter.kind;
      EXPECT_NEAR(filter.sample({0.5, u}).y, x, 1e-12);
    }
  }
}

class ReferenceLights : public testing::Test {
 protected:
  // One light of every kind, and a floor.
  static test::GltfScene scene_with_lights() {
    test::GltfScene scene;
    scene.add({test::quad({-1, 0, -1}, {0, 0, 2}, {2, 0, 0})}, test::lambert({0.5, 0.5, 0.5}));
    scene.add({{{0, 1, 0}, {0.2, 1, 0}, {0, 1.3, 0.2}}}, test::emitter({1, 2, 3}));
    scene.add({{{0, 2, 0}, {0.2, 2, 0.1}, {0, 2.3, 0.2}}}, test::emitter({1, 2, 3}, true));
    scene.add_point_light({0, 1, 1}, {1, 1, 1});
    scene.add_spot_light({0, 1, -1}, {0.2, -1, 0.1}, 3, 0.3, 0.9);
    scene.add_directional_light({0.1, -1, 0}, 2);
    scene.set_perspective(test::look_at({0, 3, 5}, {0, 0, 0}), 0.8);
    return scene;
  }
  ReferenceLights() : prepared_(test::prepare(scene_with_lights())), world_(prepared_) {}

  PreparedScene prepared_;
  World world_;
};

TEST_F(ReferenceLights, DirectionsHaveTheirDensity) {
  int tested = 0;
  for (uint32_t light = 0; light < prepared_.scene.lights.size(); ++light) {
    if (prepared_.scene.lights[light].kind == interface::LIGHT_DIRECTIONAL) continue;
    test::Random random(40 + light);
    const LightPoint point = sample_light_point(world_, light, {0.3, 0.6});
    test::SphereHistogram histogram(24, 48);
    for (int i = 0; i < 200000; ++i)
      histogram.add(sample_emission(world_, point, random.square(), random.square()).direction);
    const test::ChiSquare result =
        histogram.test([&](const dvec3& w) { return emission_density(world_, point, w).value; }, 4);
    EXPECT_TRUE(result.problem.empty()) << result.problem;
    EXPECT_GT(result.p_value, test::significance_per_test(1e-4, 4)) << "light " << light;
    ++tested;
  }
  EXPECT_EQ(tested, 4);
}

TEST_F(ReferenceLights, DirectionalLightCoversTheScenesDiskEvenly) {
  for (uint32_t light = 0; light < prepared_.scene.lights.size(); ++light) {
    if (prepared_.scene.lights[light].kind != interface::LIGHT_DIRECTIONAL) continue;
    const LightPoint point = sample_light_point(world_, light, {0, 0});
    const RayDensity density = emission_density(world_, point, prepared_.scene.lights[light].direction);
    ASSERT_TRUE(density.is_parallel);
    EXPECT_NEAR(density.value * pi * world_.radius() * world_.radius(), 1, 1e-12);
    test::Random random(50);
    int inside = 0;
    constexpr int COUNT = 100000;
    for (int i = 0; i < COUNT; ++i) {
      const dvec3 from_center =
          sample_emission(world_, point, random.square(), {0, 0}).origin - world_.center();
      const double along = dot(from_center, dvec3(prepared_.scene.lights[light].direction));
      EXPECT_NEAR(along, -world_.radius(), 1e-5 * world_.radius());
      const double across = std::sqrt(dot(from_center, from_center) - along * along);
      ASSERT_LE(across, world_.radius() * (1 + 1e-6));
      inside += across < 0.5 * world_.radius();
    }
    // A quarter of the area; 5 standard deviations of the binomial.
    EXPECT_NEAR(inside, 0.25 * COUNT, 5 * std::sqrt(COUNT * 0.25 * 0.75));
  }
}

// f / p of whole paths is what the walks carry: products of bsdf cos / pdf, kept apart from the path's terms.
TEST(ReferencePaths, FullContributionIsTheWalksThroughput) {
  test::GltfScene scene;
  scene.add(test::turned(test::box({-1, -1, -1}, {1, 1, 1})), test::plastic({0.7, 0.5, 0.3}, 0.4));
  scene.add({test::quad({-0.4, 0.98, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})}, test::emitter({8, 8, 8}));
  scene.add(test::box({-0.6, -0.9, -0.6}, {-0.1, -0.2, 0}), test::glass(1.5, 0, {0.3, 0.6, 0.9}));
  scene.add(test::box({0.1, -0.9, -0.6}, {0.6, -0.2, 0}), test::glass(1.5, 0.5));
  scene.set_perspective(test::look_at({0, 0.1, 0.95}, {0, -0.3, -1}), 1.2);
  const PreparedScene prepared = test::prepare(scene);
  const World world(prepared);
  Settings settings = test::reference_settings(32, 32, 1, 12);
  settings.techniques = interface::TECHNIQUE_HIT;
  const Camera camera(scene::make_camera(prepared.scene.cameras[0], 32, 32), 32, 32);
  const Estimator estimator(world, camera, settings);
  double worst = 0;
  int paths = 0;
  int with_delta = 0;
  for (uint32_t pixel = 0; pixel < 1024; ++pixel)
    for (uint32_t sample = 0; sample < 16; ++sample) {
      const CameraSubpath walk = walk_from_camera(world, camera, settings, pixel, sample);
      estimator.camera_sample(pixel, sample, nullptr, [&](const Contribution& found) {
        const Path& path = found.sampled.path;
        const dvec3 carried = walk.vertices[path.length() - 1].throughput * path.light.emitted;
        worst = std::max(worst, length(found.unweighted - carried) / length(carried));
        ++paths;
        for (const VertexScattering& vertex : path.vertices) with_delta += vertex.is_delta;
      });
    }
  std::printf("%d paths, %d delta events, largest relative difference %.2g (bound 1e-9)\n", paths, with_delta,
              worst);
  EXPECT_GT(paths, 500);
  EXPECT_GT(with_delta, 100);
  EXPECT_LT(worst, 1e-9);
}

// Points of one plane are connected along it: the cosines of the correction for shading normals are 0 / 0
// there.
TEST(ReferencePaths, NothingArrivesAlongASurface) {
  Surface surface;
  surface.geometric_normal = surface.shading_normal = {0, 0, 1};
  BsdfParameters white;
  white.base_color = dvec3(1);
  const VertexScattering along = scattering_between(surface, Bsdf(white), {1, 0, 0}, {0, 0, 1}, {}, {});
  EXPECT_EQ(along.value, dvec3(0));
}

// The technique list is a function of the path: a path that a light walk finds by a splat lists the same
// densities as the same vertices found by connecting one edge earlier.
TEST(ReferencePaths, TechniquesDoNotDependOnHowThePathWasFound) {
  const std::filesystem::path file = test::own_scenes() / "cornell" / "cornell.gltf";
  const PreparedScene prepared = test::prepare(file);
  const World world(prepared);
  Settings settings = test::reference_settings(32, 32, 1, 8);
  settings.merge_radius = 0.01;
  const Camera camera(scene::make_camera(prepared.scene.cameras[0], 32, 32), 32, 32);
  const TechniqueSet set{test::VCM, 1000, 1, 1e-4};
  int compared = 0;
  double worst = 0;
  for (uint32_t index = 0; index < 4000; ++index) {
    const LightSubpath light = walk_from_light(world, settings, index, 0);
    if (light.vertices.size() < 3) continue;
    // The camera walk that leaves the lens towards the last vertex.
    const auto splat = connect_to_lens(world, camera, interface::INVALID_INDEX, light, 3, {0.5, 0.5});
    if (!splat || splat->path.vertices[3].is_delta || splat->path.vertices[2].is_delta) continue;
    if (splat->path.vertices[2].value == dvec3(0)) continue;  // a walk may pass a black lamp
    CameraSubpath walk;
    walk.density = splat->path.camera;
    WalkVertex first = light.vertices[2];
    first.edge = splat->path.edges[3];
    const auto projection = camera.project(first.surface.position, {0.5, 0.5});
    first.w_back = -projection->ray.direction;
    first.medium = light.vertices[2].medium;
    walk.vertices.push_back(first);
    const auto connected = connect_vertices(world, light, 2, walk, 1);
    ASSERT_TRUE(connected);
    const std::vector<Technique> a = list_techniques(splat->path, set);
    const std::vector<Technique> b = list_techniques(connected->path, set);
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].kind, b[i].kind);
      EXPECT_EQ(a[i].vertex, b[i].vertex);
      worst = std::max(worst, static_cast<double>(std::abs(a[i].density / b[i].density - 1)));
    }
    ++compared;
  }
  std::printf("%d paths, largest relative difference of a density %.2g (bound 1e-9)\n", compared, worst);
  EXPECT_GT(compared, 100);
  EXPECT_LT(worst, 1e-9);
}

}  // namespace
}  // namespace regulus::reference

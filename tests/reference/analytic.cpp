// The reference alone against closed forms: when device and reference disagree, these decide.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "images/support/comparison.hpp"
#include "reference/support/reference_images.hpp"
#include "support/sanitizers.hpp"

namespace regulus::test {
namespace {

using interface::TECHNIQUE_HIT;
using interface::TECHNIQUE_MERGE;
using interface::TECHNIQUE_NEE;
using interface::TECHNIQUE_SPLAT;
using reference::Settings;
using std::numbers::pi;

constexpr int BATCHES = 17;
const glm::dvec3 ALBEDO(0.2, 0.5, 0.8);

// The plane z = 0, seen from just above by an orthographic camera whose film is the square [-1, 1]^2 of it.
GltfScene lit_plane() {
  GltfScene scene;
  scene.add({quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})}, lambert(ALBEDO));
  scene.set_orthographic(look_at({0, 0, 0.05}, {0, 0, 0}), 1, 1);
  return scene;
}

using Irradiance = std::function<double(const glm::dvec3&)>;

// Radiance of the plane, each pixel's mean by the midpoint rule on `cells`^2 cells (1: at the centre).
image::Image plane_image(uint32_t size, const Irradiance& irradiance, int cells) {
  image::Image image{size, size, {}};
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      double sum = 0;
      for (int i = 0; i < cells * cells; ++i) {
        const double u = (i % cells + 0.5) / cells;
        const double v = (i / cells + 0.5) / cells;
        sum += irradiance({2 * (x + u) / size - 1, 1 - 2 * (y + v) / size, 0});
      }
      for (int c = 0; c < 3; ++c)
        image.rgb.push_back(static_cast<float>(ALBEDO[c] / pi * sum / (cells * cells)));
    }
  return image;
}

// Punctual lights with fixed film points: nothing is random. What is left is the single precision of the
// scene's numbers and of the image: a few 2^-24.
void expect_exact(const char* what, const PreparedScene& scene, const Irradiance& irradiance) {
  constexpr uint32_t SIZE = 16;
  constexpr double BOUND = 1e-6;
  const image::Image found = render_reference(scene, reference_point_sampled(SIZE, SIZE, 2));
  const image::Image known = plane_image(SIZE, irradiance, 1);
  double largest = 0;
  double worst = 0;
  for (const float value : known.rgb) largest = std::max(largest, double{value});
  for (size_t i = 0; i < known.rgb.size(); ++i)
    worst = std::max(worst, std::abs(double{found.rgb[i]} - known.rgb[i]) / largest);
  std::printf("%s by nee: largest difference %.2g of the brightest pixel (bound %.1g)\n", what, worst, BOUND);
  EXPECT_LT(worst, BOUND) << what;
}

// The same light by light tracing, which has to find the same without a single common step.
void expect_by_splats(const char* what, const PreparedScene& scene, const Irradiance& irradiance,
                      uint32_t stream) {
  constexpr uint32_t SIZE = 8;
  Settings settings = reference_settings(SIZE, SIZE, 16, 2);
  settings.techniques = TECHNIQUE_SPLAT;
  settings.light_paths = 2000;
  ComparisonOptions options;
  options.tile = 2;
  options.relative_tolerance = 1e-3;  // of the midpoint rule, which steps over the edges of shadows
  expect_known((std::string(what) + " by splats").c_str(),
               reference_batches(scene, settings, BATCHES, stream), plane_image(SIZE, irradiance, 32),
               options);
}

TEST(ReferenceAnalytic, PointLight) {
  const glm::dvec3 light(0.3, -0.2, 1.5);
  GltfScene scene = lit_plane();
  scene.add_point_light(light, glm::dvec3(4));
  const Irradiance irradiance = [&](const glm::dvec3& p) {
    return 4 * light.z / std::pow(glm::length(light - p), 3);
  };
  const PreparedScene prepared = prepare(scene);
  expect_exact("point light", prepared, irradiance);
  expect_by_splats("point light", prepared, irradiance, 1);
}

TEST(ReferenceAnalytic, DirectionalLight) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.4, -0.3, -0.9));
  GltfScene scene = lit_plane();
  scene.add_directional_light(direction, 3);
  const Irradiance irradiance = [&](const glm::dvec3&) { return -3 * direction.z; };
  const PreparedScene prepared = prepare(scene);
  expect_exact("directional light", prepared, irradiance);
  expect_by_splats("directional light", prepared, irradiance, 2);
}

TEST(ReferenceAnalytic, SpotLight) {
  const glm::dvec3 light(0.1, 0.2, 1.2);
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.1, -0.15, -1));
  constexpr double INNER = 0.2;
  constexpr double OUTER = 0.6;
  GltfScene scene = lit_plane();
  scene.add_spot_light(light, direction, 5, INNER, OUTER);
  const Irradiance irradiance = [&](const glm::dvec3& p) {
    const double distance = glm::length(p - light);
    const double cos_angle = glm::dot((p - light) / distance, direction);
    const double linear =
        std::clamp((cos_angle - std::cos(OUTER)) / (std::cos(INNER) - std::cos(OUTER)), 0.0, 1.0);
    return 5 * linear * linear * light.z / std::pow(distance, 3);
  };
  const PreparedScene prepared = prepare(scene);
  expect_exact("spot light", prepared, irradiance);
  expect_by_splats("spot light", prepared, irradiance, 3);
}

TEST(ReferenceAnalytic, OccluderCastsAHardShadow) {
  GltfScene scene = lit_plane();
  scene.add_point_light({0, 0, 2}, {1, 1, 1});
  // At half the height: its shadow is the square [-0.4, 0.4]^2, with edges between pixel centres.
  scene.add({quad({-0.2, -0.2, 1}, {0.4, 0, 0}, {0, 0.4, 0})}, lambert({1, 1, 1}));
  expect_exact("hard shadow", prepare(scene), [&](const glm::dvec3& p) {
    const bool is_shadowed = std::abs(p.x) < 0.4 && std::abs(p.y) < 0.4;
    return is_shadowed ? 0 : 2 / std::pow(glm::length(glm::dvec3(0, 0, 2) - p), 3);
  });
}

// Irradiance at p, normal +z, of the front-facing polygons of a convex body above the horizon (Lambert 1760).
double irradiance_of(const glm::dvec3& p, const Polygons& body) {
  double sum = 0;
  for (const Polygon& polygon : body) {
    const glm::dvec3 facing = glm::cross(polygon[1] - polygon[0], polygon[2] - polygon[0]);
    if (glm::dot(facing, p - polygon[0]) <= 0) continue;
    double turn = 0;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const glm::dvec3 a = glm::normalize(polygon[i] - p);
      const glm::dvec3 b = glm::normalize(polygon[(i + 1) % polygon.size()] - p);
      const glm::dvec3 normal = glm::cross(a, b);
      turn += std::atan2(glm::length(normal), glm::dot(a, b)) * glm::normalize(normal).z;
    }
    sum += std::abs(turn) / 2;
  }
  return sum;
}

TEST(ReferenceAnalytic, SphereLightByEveryTechnique) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  constexpr uint32_t SIZE = 8;
  const Polygons light = sphere({0.2, 0.1, 1}, 0.35, 16);
  GltfScene scene = lit_plane();
  scene.add(light, emitter({1, 1, 1}));
  const PreparedScene prepared = prepare(scene);
  const image::Image known = plane_image(
      SIZE, [&](const glm::dvec3& p) { return irradiance_of(p, light); }, 4);
  uint32_t stream = 10;
  for (const NamedTechniques techniques : {NamedTechniques{"hit", TECHNIQUE_HIT},
                                           {"nee", TECHNIQUE_NEE},
                                           {"splat", TECHNIQUE_SPLAT},
                                           {"hit,nee,splat", PT | TECHNIQUE_SPLAT}}) {
    Settings settings = reference_settings(SIZE, SIZE, 32, 2);
    settings.techniques = techniques.bits;
    settings.light_paths = 1000;
    ComparisonOptions options;
    options.tile = 2;
    options.relative_tolerance = 3e-4;  // of the midpoint rule within a pixel
    expect_known((std::string("sphere light by ") + techniques.name).c_str(),
                 reference_batches(prepared, settings, BATCHES, stream++), known, options);
  }
}

// Merging alone is biased by its kernel, which vanishes for constant irradiance away from edges.
TEST(ReferenceAnalytic, DirectionalLightByMerges) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  constexpr uint32_t SIZE = 8;
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.4, -0.3, -0.9));
  GltfScene scene = lit_plane();
  scene.add_directional_light(direction, 3);
  Settings settings = reference_settings(SIZE, SIZE, 16, 2);
  settings.techniques = TECHNIQUE_MERGE;
  settings.light_paths = 4000;
  settings.merge_radius = 0.2;
  ComparisonOptions options;
  options.tile = 2;
  expect_known("directional light by merges", reference_batches(prepare(scene), settings, BATCHES, 15),
               plane_image(
                   SIZE, [&](const glm::dvec3&) { return -3 * direction.z; }, 1),
               options);
}

double fresnel(double cos_i, double eta) {
  const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return (s * s + p * p) / 2;
}

// Between two emissive panels: red passes the slab, green comes back from it, half the blue from either.
TEST(ReferenceAnalytic, GlassSlabPassesAndReflectsWithAllInterReflections) {
  constexpr double IOR = 1.5;
  constexpr double THICKNESS = 0.1;
  constexpr double TILT = 0.5;
  uint32_t stream = 20;
  for (const glm::dvec3 attenuation : {glm::dvec3(1), glm::dvec3(0.01, 0.001, 1)}) {
    GltfScene scene;
    scene.add({quad({-40, -40, -3}, {80, 0, 0}, {0, 80, 0})}, emitter({1, 0, 0.5}));
    scene.add({quad({-40, -40, 3}, {0, 80, 0}, {80, 0, 0})}, emitter({0, 1, 0.5}));
    const double c = std::cos(TILT);
    const double s = std::sin(TILT);
    scene.add(box({-4, -4, -THICKNESS / 2}, {4, 4, THICKNESS / 2}), glass(IOR, 0, attenuation),
              {{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, {0, 0, 0, 1}});
    scene.set_orthographic(look_at({0, 0, 2.5}, {0, 0, 0}), 0.2, 0.2);
    const double length = THICKNESS / std::sqrt(1 - std::pow(s / IOR, 2));
    const double f = fresnel(c, IOR);
    const auto passed = [&](double a) { return (1 - f) * (1 - f) * a / (1 - f * f * a * a); };
    const double red = std::pow(attenuation.r, length);
    const double green = std::pow(attenuation.g, length);
    ComparisonOptions options;
    options.tile = 2;
    expect_known("glass slab",
                 reference_batches(prepare(scene), reference_settings(8, 8, 128, 16), BATCHES, stream++),
                 uniform_image(8, 8, {passed(red), f + passed(green) * f * green, 0.5}), options);
  }
}

std::array<double, 3> triple(const nlohmann::json& values) {
  return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

TEST(ReferenceAnalytic, FurnaceByEverySetOfTechniques) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  const std::filesystem::path file = own_scenes() / "furnace" / "furnace.gltf";
  const PreparedScene room = prepare(file);
  const nlohmann::json expected = expected_of(file);
  const auto depth = expected["max_depth"].get<uint32_t>();
  uint32_t stream = 30;
  for (const NamedTechniques techniques :
       {NamedTechniques{"pt", PT}, {"bpt", BPT}, {"bpm", BPM}, {"vcm", VCM}}) {
    Settings settings = reference_settings(8, 8, 8, depth);
    settings.techniques = techniques.bits;
    settings.merge_radius = 0.02;  // constant radiance: merging is biased by edges alone, see tolerance
    ComparisonOptions options;
    // A merge disk that an edge of the room cuts lacks at most half its area, on a share of the room's
    // surface of radius / side; only the part of the light that merges carry is concerned.
    if ((techniques.bits & TECHNIQUE_MERGE) != 0) options.relative_tolerance = 2e-3;
    expect_known((std::string("furnace by ") + techniques.name).c_str(),
                 reference_batches(room, settings, BATCHES, stream++),
                 uniform_image(8, 8, triple(expected["radiance"])), options);
  }
}

TEST(ReferenceAnalytic, GlassCubeInAFurnaceCannotBeSeen) {
  const std::filesystem::path file = own_scenes() / "furnace" / "furnace-glass.gltf";
  const nlohmann::json expected = expected_of(file);
  const std::array<double, 3> radiance = triple(expected["radiance"]);
  const image::Image image =
      render_reference(prepare(file), reference_settings(16, 16, 16, expected["max_depth"].get<uint32_t>()));
  for (size_t i = 0; i < image.rgb.size(); ++i) EXPECT_NEAR(image.rgb[i] / radiance[i % 3], 1, 1e-6) << i;
}

// Two perfect mirrors x = -1.5 and x = 1.5 beside the plane: light by way of one of them is a straight line
// from an image of the light. No camera walk and no light sample finds one; light walks do, and merges.
TEST(ReferenceAnalytic, LightWalksFindTheChainsOfImageSources) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  constexpr uint32_t SIZE = 8;
  constexpr double HALF = 1.5;
  const glm::dvec3 light(0.3, -0.2, 1.5);
  GltfScene scene = lit_plane();
  scene.add_point_light(light, glm::dvec3(4));
  scene.add(
      {quad({-HALF, -60, -0.5}, {0, 120, 0}, {0, 0, 120}), quad({HALF, -60, -0.5}, {0, 0, 120}, {0, 120, 0})},
      metal({1, 1, 1}, 0));
  const PreparedScene prepared = prepare(scene);
  // The light itself and its two images behind one mirror: all paths of up to three edges, because light that
  // the plane has scattered needs a fourth to come back to it.
  const Irradiance irradiance = [&](const glm::dvec3& p) {
    double sum = 0;
    for (const double x : {light.x, -2 * HALF - light.x, 2 * HALF - light.x})
      sum += 4 * light.z / std::pow(glm::length(glm::dvec3(x, light.y, light.z) - p), 3);
    return sum;
  };
  uint32_t stream = 40;
  for (const NamedTechniques techniques :
       {NamedTechniques{"splat", TECHNIQUE_SPLAT}, {"bpt", BPT}, {"vcm", VCM}}) {
    Settings settings = reference_settings(SIZE, SIZE, 16, 3);
    settings.techniques = techniques.bits;
    settings.light_paths = 2000;
    settings.merge_radius = 0.05;
    ComparisonOptions options;
    options.tile = 2;
    options.relative_tolerance = 1e-3;  // of the midpoint rule and, for merges, of the kernel
    expect_known((std::string("one-mirror chains by ") + techniques.name).c_str(),
                 reference_batches(prepared, settings, BATCHES, stream++), plane_image(SIZE, irradiance, 4),
                 options);
  }
}

}  // namespace
}  // namespace regulus::test

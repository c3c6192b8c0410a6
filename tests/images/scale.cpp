// Pictures do not depend on the unit of length, nor on where the origin is, as far as float positions allow.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

constexpr int BATCHES = 9;
constexpr uint32_t SIZE = 16;

glm::dmat4 scaling(double scale) {
  return {{scale, 0, 0, 0}, {0, scale, 0, 0}, {0, 0, scale, 0}, {0, 0, 0, 1}};
}

glm::dmat4 translation(const glm::dvec3& by) {
  return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {by, 1}};
}

// An open box with a diffuse, a rough and a glass body, lit from its ceiling.
GltfScene still_life(const glm::dmat4& root) {
  GltfScene scene;
  Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  walls.erase(walls.begin() + 1);  // the front is open
  scene.add(walls, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.7, -1, -0.6}, {-0.1, 0.1, 0}), metal({0.9, 0.7, 0.4}, 0.6));
  scene.add(sphere({0.4, -0.55, 0.1}, 0.4, 12), glass(1.5, 0.5));
  scene.add({quad({-0.5, 0.95, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({2, 1.5, 1}));
  scene.set_perspective(look_at({0, 0, 3.4}, {0, 0, 0}), 0.6);
  scene.set_root(root);
  return scene;
}

class Scale : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

std::vector<image::Image> batches_of(const glm::dmat4& root, uint32_t stream) {
  return render_batches(prepare(still_life(root)), box_filtered(SIZE, SIZE, is_slow_device() ? 4 : 16, 6),
                        BATCHES, stream);
}

TEST_F(Scale, UnitOfLengthDoesNotMatter) {
  const auto metres = batches_of(scaling(1), 1);
  // Other seeds, so that both sides are independent.
  expect_equal("scale 1e-3", batches_of(scaling(1e-3), 2), metres);
  expect_equal("scale 1e4", batches_of(scaling(1e4), 3), metres);
}

// At geocentric coordinates, or a billion times as large as they are there, a scene is rendered as at the
// origin, to the bit where its place is a multiple of its extent's power of two: its frame is the same.
TEST_F(Scale, GeocentricCoordinatesRenderAsAtTheOrigin) {
  render::RenderSettings settings = box_filtered(SIZE, SIZE, 2, 6);
  settings.techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT |
                        interface::TECHNIQUE_CONNECT | interface::TECHNIQUE_MERGE;
  settings.merge_radius = 0.05f;
  const PreparedScene near = prepare(still_life(scaling(1)));
  const Rendered wanted = render(near, settings);
  for (const glm::dvec3& place : {glm::dvec3(-3761604, 4105280, 3870316), glm::dvec3(4e9, 0, -4e9)}) {
    const PreparedScene far = prepare(still_life(translation(place)));
    EXPECT_EQ(far.scene.origin, place);
    const Rendered found = render(far, settings);
    EXPECT_EQ(found.film.words, wanted.film.words) << place.x;
    EXPECT_EQ(found.film.splat_words, wanted.film.splat_words) << place.x;
  }
}

// What the AOV of position shows is the place in the file's world, on the device as in the reference.
TEST_F(Scale, PositionsAreShownInTheWorldOfTheFile) {
  const glm::dvec3 place(1e6, -2e6, 3e6);
  const render::RenderSettings settings = box_filtered(8, 8, 1, 2);
  const auto positions = [&](const glm::dmat4& root) {
    return surface_channels(prepare(still_life(root)), settings);
  };
  const image::Channels near = positions(scaling(1)), far = positions(translation(place));
  for (int i = 0; i < 3; ++i) {
    const std::string name = std::string("P.") + "XYZ"[i];
    const auto &own = std::get<std::vector<float>>(far.at(name)),
               &known = std::get<std::vector<float>>(near.at(name));
    for (size_t pixel = 0; pixel < own.size(); ++pixel)
      EXPECT_EQ(own[pixel], static_cast<float>(known[pixel] + place[i])) << name << pixel;
  }
}

/// Keeps the world's origin in the scene, so that the loader does not move it: a speck there that nothing
/// sees. What is so far from it loses enough to be warned of, perhaps.
PreparedScene prepare_beside_origin(GltfScene scene, const glm::dvec3& root) {
  scene.add({quad({0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0})}, lambert({0, 0, 0}), translation(-root));
  const TemporaryFolder folder;
  scene.write(folder / "scene.gltf");
  PreparedScene prepared = prepare(folder / "scene.gltf");
  EXPECT_EQ(prepared.scene.origin, glm::dvec3(0));
  for (const std::string& warning : prepared.scene.warnings)
    EXPECT_NE(warning.find("from the scene's centre"), std::string::npos) << warning;
  return prepared;
}

constexpr double FAR =
    2e4;  // of the origin, on each axis, in scenes of metres: floats there are multiples of 1/512

// How far a computed point may be from the exact one, per axis, and how far ray origins are lifted: the
// stated error of the position, 8 * 2^-24 of its coordinates (shaders/lib/geometry.glsl). A point is a sum of
// three rounded products of coordinates FAR + 1 at most, whose weights add up to 1: 5 roundings at most.
constexpr double POSITION_ERROR = 8 * 0x1p-24 * (FAR + 1);

// A closed room that emits 1 and reflects half, with a white and a mirror body in it, which change nothing:
// the radiance is 2 everywhere. All corners are multiples of 1/8 and therefore exact. What a surface shadows
// of its own light, or of its neighbours', is missing. What may be missing: a point within its error of an
// edge of the room may end up outside. Walls are 2 m wide with four edges, so a share s = 2 * error of their
// points, by which a path may be lost, and as much of the light it connects to. Of the series of the bounces
// 0.5 / (1 - 0.5 (1 - 2 s)) is left at least, and nothing can be too bright.
TEST_F(Scale, FarFromTheOriginAFurnaceLosesNoLight) {
  GltfScene scene;
  nlohmann::json wall = emitter({1, 1, 1});
  wall["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.5, 0.5, 1};
  scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), wall);
  scene.add(box({-0.75, -0.5, -0.75}, {-0.25, 0.5, -0.25}), lambert({1, 1, 1}));
  scene.add(box({0.125, -0.5, -0.5}, {0.625, 0.25, 0}), metal({1, 1, 1}, 0));
  scene.set_perspective(look_at({0, 0, 0.875}, {0, 0, 0}), 0.9);
  scene.set_root(translation(glm::dvec3(FAR)));
  const auto batches = render_batches(prepare_beside_origin(scene, glm::dvec3(FAR)),
                                      box_filtered(SIZE, SIZE, is_slow_device() ? 4 : 32, 64), BATCHES, 4);

  constexpr double SHARE = 2 * POSITION_ERROR, LOWEST = 0.5 / (1 - 0.5 * (1 - 2 * SHARE));
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (const image::Image& batch : batches) {
      const double relative = mean_of(batch)[c] / 2;
      sum += relative, squares += relative * relative;
    }
    const double mean = sum / BATCHES, error = std::sqrt((squares / BATCHES - mean * mean) / (BATCHES - 1));
    // 7 standard errors of 8 degrees of freedom: a false alarm in 9,000.
    std::printf("channel %zu: %.5f +- %.5f of what is known (bounds %.4f and 1, and 7 standard errors)\n", c,
                mean, error, LOWEST);
    EXPECT_GT(mean, LOWEST - 7 * error);
    EXPECT_LT(mean, 1 + 7 * error);
  }
}

// Light through absorbing glass that no ray may leave right where it entered: each way through it is wrong by
// the lift of its origin and by the error of both ends, and absorption turns that into a factor. Reflections
// within carry 4 % of the light at most, and twice that error.
TEST_F(Scale, FarFromTheOriginGlassIsAsThickAsItIs) {
  constexpr double THICKNESS = 0.5, ATTENUATION = 0.1, REFLECTANCE = 0.04;
  GltfScene scene;
  scene.add(box({-4, -4, -THICKNESS}, {4, 4, 0}), glass(1.5, 0, glm::dvec3(ATTENUATION)));
  scene.add({quad({-4, -4, -1}, {8, 0, 0}, {0, 8, 0})}, emitter({1, 1, 1}));
  scene.set_orthographic(look_at({0, 0, 1}, {0, 0, 0}), 0.5, 0.5);
  scene.set_root(translation(glm::dvec3(FAR)));
  const auto batches = render_batches(prepare_beside_origin(scene, glm::dvec3(FAR)),
                                      box_filtered(8, 8, is_slow_device() ? 64 : 256, 16), BATCHES, 5);

  const double once = std::pow(ATTENUATION, THICKNESS), round_trip = std::pow(REFLECTANCE * once, 2);
  const double known = (1 - REFLECTANCE) * (1 - REFLECTANCE) * once / (1 - round_trip);
  ComparisonOptions options;
  options.relative_tolerance = -std::log(ATTENUATION) * 3 * POSITION_ERROR * (1 + 2 * REFLECTANCE);
  std::printf("tolerance %.3f\n", options.relative_tolerance);
  expect_known("glass far from the origin", batches, uniform_image(8, 8, {known, known, known}), options);
}

// A tilted plane that nothing shadows, lit by a point: nothing is random, so a single pixel that its own
// triangle shadows is a failure. Coordinates are not representable, and the plane is a grid of many triangles
// whose edges rays meet too.
void expect_no_acne(double scale, const glm::dvec3& shift, double bound) {
  constexpr int GRID = 7;
  constexpr uint32_t FILM = 64;
  const glm::dmat4 tilt = look_at({0.31, 0.83, 0.47}, {0, 0, 0});
  Polygons plane;
  for (int y = 0; y < GRID; ++y)
    for (int x = 0; x < GRID; ++x)
      plane.push_back(
          quad({2.0 * x / GRID - 1, 2.0 * y / GRID - 1, 0}, {2.0 / GRID, 0, 0}, {0, 2.0 / GRID, 0}));
  GltfScene scene;
  scene.add(transformed(tilt, plane), lambert({1, 1, 1}));
  const glm::dvec3 light = glm::dvec3(tilt * glm::dvec4(0.2, 0.1, 0.9, 1));
  scene.add_point_light(light, glm::dvec3(scale * scale));  // so that the irradiance is that of scale 1
  scene.set_orthographic(tilt * translation({0, 0, 0.5}), 0.9 * scale, 0.9 * scale);
  scene.set_root(translation(shift) * scaling(scale));
  const PreparedScene prepared =
      shift == glm::dvec3(0) ? prepare(scene) : prepare_beside_origin(scene, shift);
  const image::Image image = render(prepared, point_sampled(FILM, FILM, 2)).image;

  double worst = 0;
  for (uint32_t y = 0; y < FILM; ++y)
    for (uint32_t x = 0; x < FILM; ++x) {
      const glm::dvec2 p(0.9 * (2 * (x + 0.5) / FILM - 1), 0.9 * (1 - 2 * (y + 0.5) / FILM));
      const double squared = (p.x - 0.2) * (p.x - 0.2) + (p.y - 0.1) * (p.y - 0.1) + 0.81;
      const double known = 0.9 / (squared * std::sqrt(squared)) / std::numbers::pi;
      worst = std::max(worst, std::abs(image.rgb[3 * (y * FILM + x)] / known - 1));
    }
  std::printf("scale %g, shift %g: worst relative difference %.3g (bound %.2g)\n", scale, shift.x, worst,
              bound);
  EXPECT_LE(worst, bound);
}

TEST_F(Scale, LitPlaneHasNoAcneAtAnyScale) {
  for (const double scale : {1e-4, 1e-3, 1.0, 37.0, 1e4, 1e6}) expect_no_acne(scale, glm::dvec3(0), 1e-3);
}

// A plane through the origin, square to an axis: the coordinate along its normal is exactly 0, and so is any
// error bound that is relative to it. Light from 60 to 85 degrees off the normal, so that the ray's longest
// component is not the normal's.
TEST_F(Scale, LitPlaneThroughTheOriginHasNoAcneInGrazingLight) {
  constexpr uint32_t FILM = 32;
  const struct {
    const char* name;
    glm::dvec3 u, v;
  } planes[] = {
      {"x = 0", {0, 1, 0}, {0, 0, 1}}, {"y = 0", {0, 0, 1}, {1, 0, 0}}, {"z = 0", {1, 0, 0}, {0, 1, 0}}};
  for (const auto& plane : planes)
    for (const double degrees : {60.0, 75.0, 85.0}) {
      const glm::dvec3 normal = glm::cross(plane.u, plane.v);
      const double angle = degrees * std::numbers::pi / 180;
      const glm::dvec3 to_light =
          std::cos(angle) * normal + std::sin(angle) * (0.8 * plane.u + 0.6 * plane.v);
      GltfScene scene;
      scene.add({quad(-3.0 * (plane.u + plane.v), 6.0 * plane.u, 6.0 * plane.v)}, lambert({1, 1, 1}));
      scene.add_directional_light(-to_light, 1);
      scene.set_orthographic(look_at(normal, {0, 0, 0}, plane.v), 1, 1);
      const image::Image image = render(prepare(scene), point_sampled(FILM, FILM, 2)).image;
      int dark = 0;
      double worst = 0;
      for (const float value : image.rgb) {
        dark += value == 0;
        worst = std::max(worst, std::abs(value / (std::cos(angle) / std::numbers::pi) - 1));
      }
      std::printf(
          "plane %s, light at %g degrees: worst relative difference %.3g (bound 1e-3), %d values dark\n",
          plane.name, degrees, worst, dark);
      EXPECT_LE(worst, 1e-3) << plane.name;
    }
}

// At distance D times its size positions are off by half a unit in the last place on each axis, D 2^-24; the
// light, 0.9 away, and the point move against each other by twice that, and 1/d^3 amplifies by 3 (by 4 with
// the cosine).
TEST_F(Scale, LitPlaneHasNoAcneFarFromTheOrigin) {
  for (const double distance : {1e2, 1e3, 1e4}) {
    const double bound = 4 * 2 * std::sqrt(3.0) * distance * 0x1p-23 / 0.9 + 1e-4;
    expect_no_acne(1, glm::dvec3(1, -0.7, 0.9) * distance, bound);
  }
}

}  // namespace
}  // namespace regulus::test

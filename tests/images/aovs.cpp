// AOVs against what is known of simple scenes, and the variance against the spread of independent renders.
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/render_scene.hpp"
#include "render/aov.hpp"
#include "render/noise.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class Aovs : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

const std::vector<float>& floats(const image::Channels& channels, const std::string& name) {
  return std::get<std::vector<float>>(channels.at(name));
}
const std::vector<uint32_t>& integers(const image::Channels& channels, const std::string& name) {
  return std::get<std::vector<uint32_t>>(channels.at(name));
}
glm::dvec3 vector_at(const image::Channels& channels, const std::string& name, size_t pixel) {
  return {floats(channels, name + ".X")[pixel], floats(channels, name + ".Y")[pixel],
          floats(channels, name + ".Z")[pixel]};
}

// A ball with smooth normals before a slanted wall, seen by a camera at (0, 0, 5) that looks along -z: every
// value follows from the ray through the pixel's centre. What the ball's facets cut off its radius is 1 -
// cos(pi / 2 / 48).
struct BallAndWall {
  static constexpr double RADIUS = 1, Y_FOV = 1.0;
  static constexpr int RINGS = 48;
  static constexpr uint32_t SIDE = 33;
  const glm::dvec3 eye{0, 0, 5};
  const glm::dvec3 wall_normal = glm::normalize(glm::dvec3(0.4, 0.2, 1));
  const glm::dvec3 wall_point{0, 0, -3};

  PreparedScene prepared() const {
    GltfScene scene;
    const Polygons ball = sphere({0, 0, 0}, RADIUS, RINGS);
    Corners corners;
    for (const Polygon& polygon : ball)
      for (const glm::dvec3& corner : polygon) corners.normals.push_back(glm::vec3(glm::normalize(corner)));
    scene.add(ball, lambert({0.2, 0.4, 0.6}), glm::dmat4(1), corners);
    const glm::dvec3 u = glm::normalize(glm::cross({0, 1, 0}, wall_normal)), v = glm::cross(wall_normal, u);
    scene.add({quad(wall_point - 20.0 * u - 1.5 * v, 40.0 * u, 3.0 * v)}, lambert({0.7, 0.7, 0.1}));
    scene.add_point_light({0, 0, 4}, {1, 1, 1});
    scene.set_perspective(look_at(eye, {0, 0, 0}), Y_FOV);
    return prepare(scene);
  }

  glm::dvec3 direction(uint32_t pixel) const {
    const double half = std::tan(Y_FOV / 2), x = pixel % SIDE + 0.5, y = pixel / SIDE + 0.5;
    return glm::normalize(glm::dvec3((2 * x / SIDE - 1) * half, (1 - 2 * y / SIDE) * half, -1));
  }
};

TEST_F(Aovs, AreThoseOfTheRayThroughThePixelsCentre) {
  const BallAndWall known;
  const double cut = 1 - std::cos(M_PI / 2 / BallAndWall::RINGS);  // m, that facets lie below the sphere
  render::RenderSettings settings = point_sampled(BallAndWall::SIDE, BallAndWall::SIDE, 2);
  const image::Channels channels = surface_channels(known.prepared(), settings);
  size_t on_ball = 0, on_wall = 0, nowhere = 0;
  for (uint32_t pixel = 0; pixel < BallAndWall::SIDE * BallAndWall::SIDE; ++pixel) {
    const glm::dvec3 d = known.direction(pixel);
    const double b = glm::dot(known.eye, d);
    const double discriminant = b * b - glm::dot(known.eye, known.eye) + 1;
    if (std::abs(discriminant) < 0.2) continue;  // near the rim facets and sphere part
    const glm::dvec3 normal = vector_at(channels, "N", pixel), position = vector_at(channels, "P", pixel);
    const double depth = floats(channels, "Z")[pixel];
    if (discriminant > 0) {
      const glm::dvec3 expected = known.eye + (-b - std::sqrt(discriminant)) * d;
      const double bound = 4 * cut / std::sqrt(discriminant);  // along the ray, and in the normal's angle
      EXPECT_LT(glm::length(position - expected), bound);
      EXPECT_NEAR(depth, known.eye.z - expected.z, bound);
      EXPECT_LT(glm::length(normal - expected), bound);
      EXPECT_LT(glm::length(vector_at(channels, "Ng", pixel) - expected), 2 * M_PI / BallAndWall::RINGS);
      EXPECT_NEAR(floats(channels, "albedo.B")[pixel], 0.6f, 1e-6f);
      EXPECT_EQ(integers(channels, "material")[pixel], 1u);
      EXPECT_EQ(integers(channels, "instance")[pixel], 1u);
      ++on_ball;
    } else if (integers(channels, "instance")[pixel] == 0) {
      EXPECT_TRUE(std::isinf(depth));
      EXPECT_EQ(position, glm::dvec3(0));
      EXPECT_EQ(normal, glm::dvec3(0));
      EXPECT_EQ(floats(channels, "albedo.R")[pixel], 0.0f);
      EXPECT_EQ(integers(channels, "material")[pixel], 0u);
      ++nowhere;
    } else {
      const double t =
          glm::dot(known.wall_point - known.eye, known.wall_normal) / glm::dot(d, known.wall_normal);
      const glm::dvec3 expected = known.eye + t * d;
      EXPECT_LT(glm::length(position - expected), 1e-5 * t);
      EXPECT_NEAR(depth, known.eye.z - expected.z, 1e-5 * t);
      EXPECT_LT(glm::length(normal - known.wall_normal), 1e-6);
      EXPECT_LT(glm::length(vector_at(channels, "Ng", pixel) - known.wall_normal), 1e-6);
      EXPECT_NEAR(floats(channels, "albedo.R")[pixel], 0.7f, 1e-6f);
      EXPECT_EQ(integers(channels, "material")[pixel], 2u);
      EXPECT_EQ(integers(channels, "instance")[pixel], 2u);
      ++on_wall;
    }
  }
  std::printf("%zu pixels on the ball, %zu on the wall, %zu beside\n", on_ball, on_wall, nowhere);
  EXPECT_GT(on_ball, 50u);
  EXPECT_GT(on_wall, 50u);
  EXPECT_GT(nowhere, 50u);
}

// A crop's are those of the whole.
TEST_F(Aovs, OfACropAreThoseOfTheWhole) {
  const PreparedScene scene = BallAndWall().prepared();
  render::RenderSettings settings = box_filtered(BallAndWall::SIDE, BallAndWall::SIDE, 1, 2);
  const image::Channels whole = surface_channels(scene, settings);
  settings.crop = {3, 9, 20, 7};
  const image::Channels part = surface_channels(scene, settings);
  for (const auto& [name, channel] : part)
    for (size_t i = 0; i < 20 * 7; ++i) {
      const size_t there = (i / 20 + 9) * BallAndWall::SIDE + i % 20 + 3;
      if (const auto* values = std::get_if<std::vector<float>>(&channel))
        ASSERT_EQ((*values)[i], floats(whole, name)[there]) << name;
      else
        ASSERT_EQ(integers(part, name)[i], integers(whole, name)[there]) << name;
    }
}

// Path diffusion's footprint in a scene that unfolds to a line: the standard deviation of one coordinate of a
// pixel's angle, s, meets a surface after `before` m, leaves it and meets a wall after `behind` m.
class Sigma : public Aovs {
 protected:
  static constexpr uint32_t SIDE = 5;
  static constexpr double Y_FOV = 0.02;  // narrow, so that all rays are paraxial
  static constexpr double ANGLE = 2 * Y_FOV / 2 / SIDE / 3.4641016151377544;  // tan = angle to 1e-4

  /// What the ray through the middle of the film carries to the wall.
  struct Found {
    double position, angle;
  };
  Found find(GltfScene& scene) {
    scene.add_point_light({0, 50, 0}, {1, 1, 1});
    scene.set_perspective(look_at({0, 0, 5}, {0, 0, 0}), Y_FOV);
    const PreparedScene prepared = prepare(scene);
    render::RenderSettings settings = point_sampled(SIDE, SIDE, 8);
    settings.aovs = render::AOV_SIGMA;
    render::Renderer renderer(*device(), prepared, make_plan(prepared, settings));
    image::Channels channels;
    render::add_sigma_channels(renderer.surface_footprints(), channels);
    const size_t middle = SIDE * SIDE / 2;
    return {floats(channels, "sigma.position")[middle], floats(channels, "sigma.angle")[middle]};
  }
  static void expect(const char* what, const Found& found, double position, double angle, double bound) {
    std::printf("%s: sigma %.6g m, %.6g rad; expected %.6g, %.6g\n", what, found.position, found.angle,
                position, angle);
    EXPECT_NEAR(found.position / position, 1, bound) << what;
    EXPECT_NEAR(found.angle / angle, 1, bound) << what;
  }
  static Polygons wall(double z) { return {quad({-40, -40, z}, {80, 0, 0}, {0, 80, 0})}; }
  static Polygons wall_behind(double z) { return turned(wall(z)); }
};

// At a wall; over a flat mirror as if there were none; a mirror of alpha 0.04 adds 2 alpha^2 to the angle's
// variance, and what that spreads to.
TEST_F(Sigma, GrowsWithTheDistanceAndBySharpLobes) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene plain;
  plain.add(wall(-1), lambert({0.5, 0.5, 0.5}));
  expect("wall", find(plain), 6 * ANGLE, ANGLE, 1e-4);
  for (const double roughness : {0.0, 0.2}) {
    GltfScene scene;
    scene.add(wall(0), metal({1, 1, 1}, roughness));
    scene.add(wall_behind(12), lambert({0.5, 0.5, 0.5}));
    const double alpha = roughness * roughness, lobe = 2 * alpha * alpha;
    expect("flat mirror", find(scene), std::sqrt(17 * 17 * ANGLE * ANGLE + 12 * 12 * lobe),
           std::sqrt(ANGLE * ANGLE + lobe), 1e-4);
  }
}

// A mirror of radius R after a m turns a ray at distance a theta from the axis by 2 a theta / R more. Facets
// lie behind the sphere by at most 1 - cos(pi / 2 / rings) of R.
TEST_F(Sigma, FollowsCurvatureOfMirrors) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  constexpr int RINGS = 96;
  for (const double radius : {1.0, 0.25}) {
    GltfScene scene;
    const Polygons ball = sphere({0, 0, 0}, radius, RINGS);
    Corners corners;
    for (const Polygon& polygon : ball)
      for (const glm::dvec3& corner : polygon) corners.normals.push_back(glm::vec3(glm::normalize(corner)));
    scene.add(ball, metal({1, 1, 1}, 0), glm::dmat4(1), corners);
    scene.add(wall_behind(12), lambert({0.5, 0.5, 0.5}));
    const double before = 5 - radius, behind = 12 - radius, gain = 1 + 2 * before / radius;
    expect("ball", find(scene), (before + behind * gain) * ANGLE, gain * ANGLE, 2e-3);
  }
}

// Inside glass of index n angles are 1 / n as wide; behind a plate as before it.
TEST_F(Sigma, GoesThroughGlass) {
  GltfScene scene;
  scene.add(box({-40, -40, -3}, {40, 40, 0}), glass(1.5));
  scene.add(wall(-4), lambert({0.5, 0.5, 0.5}));
  expect("plate", find(scene), (5 + 3 / 1.5 + 1) * ANGLE, ANGLE, 1e-4);
}

// By camera paths, splats and merges alike: the variance that a render states for its mean is, on average
// over pixels, the spread of the means of independent renders. With 12 renders the mean over 768 values of
// the spread errs by sqrt(2 / 11 / 768) = 1.5 percent if values are independent and normal; they are neither,
// so five times twice that. And the noise that --noise states is the same estimate: one degree of freedom for
// each value.
TEST_F(Aovs, VarianceIsTheSpreadOfIndependentRenders) {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}));
  scene.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1.0);
  const PreparedScene prepared = prepare(scene);
  using namespace technique_sets;
  for (const uint32_t techniques :
       {PT, PT | interface::TECHNIQUE_SPLAT | interface::TECHNIQUE_CONNECT | interface::TECHNIQUE_MERGE}) {
    constexpr int RENDERS = 12;
    render::RenderSettings settings = box_filtered(16, 16, 32, 3);
    settings.techniques = techniques;
    settings.sampler = interface::SAMPLER_HASH;
    settings.aovs = render::AOV_VARIANCE;
    settings.keeps_doublings = true;
    settings.merge_radius = 0.05f;
    std::vector<double> sums(16 * 16 * 3), squares(16 * 16 * 3);
    double stated = 0, stated_noise = 0, known_noise = 0;
    for (uint32_t i = 0; i < RENDERS; ++i) {
      settings.seed = 100 + i;
      render::Renderer renderer(*device(), prepared, make_plan(prepared, settings));
      render::NoiseEstimate noise;
      renderer.render([&](uint64_t, uint64_t) {
        noise.observe(renderer.film());
        return true;
      });
      noise.observe(renderer.film());
      const image::Image image = resolve(renderer.film()), variance = resolve_variance(renderer.film());
      double relative = 0;
      for (size_t v = 0; v < sums.size(); ++v) {
        sums[v] += image.rgb[v];
        squares[v] += double{image.rgb[v]} * image.rgb[v];
        stated += variance.rgb[v] / RENDERS;
        relative += variance.rgb[v] / (double{image.rgb[v]} * image.rgb[v] + image::RELATIVE_EPSILON);
      }
      known_noise += relative / static_cast<double>(sums.size()) / RENDERS;
      stated_noise += noise.relative_error() * noise.relative_error() / RENDERS;
    }
    double spread = 0;
    for (size_t v = 0; v < sums.size(); ++v)
      spread += (squares[v] - sums[v] * sums[v] / RENDERS) / (RENDERS - 1);
    std::printf("techniques %u: stated %.4g, spread %.4g, ratio %.3f; noise %.4g, by the variance %.4g\n",
                techniques, stated, spread, stated / spread, std::sqrt(stated_noise), std::sqrt(known_noise));
    EXPECT_NEAR(stated / spread, 1, 0.15);
    EXPECT_NEAR(stated_noise / known_noise, 1, 0.15);
  }
}

}  // namespace
}  // namespace regulus::test

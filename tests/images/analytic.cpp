// Light on a Lambert plane and through glass, against closed forms.
//
// Pixels are sampled at their centres, so that with punctual lights nothing is random: each pixel must agree
// up to float rounding. About 60 roundings of 2^-24 lie between the camera and the pixel, and the position's
// own error enters the distance: 1e-5 relative bounds them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using render::RenderSettings;
using std::numbers::pi;

constexpr double ROUNDING = 1e-5;
constexpr int BATCHES = 17;
const glm::dvec3 ALBEDO(0.2, 0.5, 0.8);

class Analytic : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

// The plane z = 0, seen from just above by an orthographic camera whose film is the square [-1, 1]^2 of it.
GltfScene lit_plane() {
  GltfScene scene;
  scene.add({quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})}, lambert(ALBEDO));
  scene.set_orthographic(look_at({0, 0, 0.05}, {0, 0, 0}), 1, 1);
  return scene;
}

// Point of the plane under the centre of pixel (x, y) of a size x size film.
glm::dvec3 plane_point(uint32_t x, uint32_t y, uint32_t size) {
  return {2 * (x + 0.5) / size - 1, 1 - 2 * (y + 0.5) / size, 0};
}

using Irradiance = std::function<glm::dvec3(const glm::dvec3&)>;

image::Image plane_image(uint32_t size, const Irradiance& irradiance) {
  image::Image image{size, size, {}};
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const glm::dvec3 radiance = ALBEDO / pi * irradiance(plane_point(x, y, size));
      for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<float>(radiance[c]));
    }
  return image;
}

// Compares each value; `absolute` allows for quantities that go through zero.
void expect_everywhere(const char* what, const image::Image& found, const image::Image& known,
                       double relative, double absolute = 0) {
  double worst = 0;
  size_t worst_at = 0;
  for (size_t i = 0; i < known.rgb.size(); ++i) {
    const double bound = relative * std::abs(known.rgb[i]) + absolute;
    const double ratio = std::abs(double{found.rgb[i]} - known.rgb[i]) / std::max(bound, 1e-30);
    if (!(ratio <= worst)) worst = ratio, worst_at = i;
  }
  std::printf("%s: worst difference %.3g of the bound (relative %.1g, absolute %.1g)\n", what, worst,
              relative, absolute);
  EXPECT_LE(worst, 1) << what << ": value " << worst_at << " is " << found.rgb[worst_at] << ", not "
                      << known.rgb[worst_at];
}

TEST_F(Analytic, PointLight) {
  const glm::dvec3 light(0.3, -0.2, 1.5), intensity(4, 2, 1);
  GltfScene scene = lit_plane();
  scene.add_point_light(light, intensity);
  const auto irradiance = [&](const glm::dvec3& p) {
    const double distance = glm::length(light - p);
    return intensity * (light.z / std::pow(distance, 3));
  };
  expect_everywhere("point light", render(prepare(scene), point_sampled(32, 32, 2)).image,
                    plane_image(32, irradiance), ROUNDING);
}

TEST_F(Analytic, DirectionalLight) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.4, -0.3, -0.9));
  GltfScene scene = lit_plane();
  scene.add_directional_light(direction, 3);
  expect_everywhere("directional light", render(prepare(scene), point_sampled(32, 32, 2)).image,
                    plane_image(32, [&](const glm::dvec3&) { return glm::dvec3(-3 * direction.z); }),
                    ROUNDING);
}

// KHR_lights_punctual: clamp((cos - cos outer) / (cos inner - cos outer))^2.
TEST_F(Analytic, SpotLightFallsOffBetweenItsCones) {
  const glm::dvec3 light(0.1, 0.2, 1.2), direction = glm::normalize(glm::dvec3(0.1, -0.15, -1));
  constexpr double INNER = 0.2, OUTER = 0.6, INTENSITY = 5;
  GltfScene scene = lit_plane();
  scene.add_spot_light(light, direction, INTENSITY, INNER, OUTER);
  int in_penumbra = 0, dark = 0;
  const auto irradiance = [&](const glm::dvec3& p) {
    const double distance = glm::length(p - light), cos_angle = glm::dot((p - light) / distance, direction);
    const double linear =
        std::clamp((cos_angle - std::cos(OUTER)) / (std::cos(INNER) - std::cos(OUTER)), 0.0, 1.0);
    in_penumbra += linear > 0 && linear < 1;
    dark += linear == 0;
    return glm::dvec3(INTENSITY * linear * linear * light.z / std::pow(distance, 3));
  };
  const image::Image known = plane_image(32, irradiance);
  ASSERT_GT(in_penumbra, 100);
  ASSERT_GT(dark, 100);
  // The falloff divides an error of the cosine (some 8 roundings) by cos inner - cos outer = 0.155.
  const double absolute = 2 * 8 * 6e-8 / 0.155 * INTENSITY / (1.2 * 1.2) * ALBEDO.b / pi;
  expect_everywhere("spot light", render(prepare(scene), point_sampled(32, 32, 2)).image, known, ROUNDING,
                    absolute);
}

TEST_F(Analytic, OccluderCastsAHardShadow) {
  const glm::dvec3 light(0, 0, 2);
  GltfScene scene = lit_plane();
  scene.add_point_light(light, {1, 1, 1});
  // At half the height: its shadow is the square [-0.4, 0.4]^2, between pixel centres of a 32 x 32 film.
  scene.add({quad({-0.2, -0.2, 1}, {0.4, 0, 0}, {0, 0.4, 0})}, lambert({1, 1, 1}));
  const auto irradiance = [&](const glm::dvec3& p) {
    const bool shadowed = std::abs(p.x) < 0.4 && std::abs(p.y) < 0.4;
    return shadowed ? glm::dvec3(0) : glm::dvec3(light.z / std::pow(glm::length(light - p), 3));
  };
  expect_everywhere("hard shadow", render(prepare(scene), point_sampled(32, 32, 2)).image,
                    plane_image(32, irradiance), ROUNDING);
}

// Irradiance at `p`, normal +z, of a polygon of radiance 1 that faces p and lies above the horizon (Lambert
// 1760).
double polygon_irradiance(const glm::dvec3& p, const Polygon& polygon) {
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = glm::normalize(polygon[i] - p),
                     b = glm::normalize(polygon[(i + 1) % polygon.size()] - p);
    const glm::dvec3 normal = glm::cross(a, b);
    sum += std::atan2(glm::length(normal), glm::dot(a, b)) * glm::normalize(normal).z;
  }
  return std::abs(sum) / 2;
}

bool faces(const Polygon& polygon, const glm::dvec3& p) {
  return glm::dot(glm::cross(polygon[1] - polygon[0], polygon[2] - polygon[0]), p - polygon[0]) > 0;
}

// Of a closed convex body, or any polygons of which none hides another.
double irradiance_of(const glm::dvec3& p, const Polygons& polygons) {
  double sum = 0;
  for (const Polygon& polygon : polygons)
    if (faces(polygon, p)) sum += polygon_irradiance(p, polygon);
  return sum;
}

const struct {
  const char* name;
  uint32_t bits;
} TECHNIQUE_SETS[] = {{"hit", interface::TECHNIQUE_HIT},
                      {"nee", interface::TECHNIQUE_NEE},
                      {"hit,nee", interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE}};

void expect_area_light(const char* name, const Polygons& polygons, uint32_t stream) {
  constexpr uint32_t SIZE = 8;
  const glm::dvec3 radiance(3, 2, 1);
  GltfScene scene = lit_plane();
  scene.add(polygons, emitter(radiance));
  const PreparedScene prepared = prepare(scene);
  const image::Image known =
      plane_image(SIZE, [&](const glm::dvec3& p) { return radiance * irradiance_of(p, polygons); });
  for (const auto& techniques : TECHNIQUE_SETS) {
    RenderSettings settings = point_sampled(SIZE, SIZE, 2);
    settings.samples = is_slow_device() ? 128 : 512;
    settings.techniques = techniques.bits;
    ComparisonOptions options;
    options.tile = 1;
    expect_known((std::string(name) + " by " + techniques.name).c_str(),
                 render_batches(prepared, settings, BATCHES, stream++), known, options);
  }
}

TEST_F(Analytic, QuadLight) {
  const glm::dmat4 tilt = look_at({0.4, 0.3, 1}, {0, 0, 0});  // -z, so the quad's back, towards the origin
  expect_area_light("quad light", transformed(tilt, turned({quad({-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0})})),
                    1);
}

TEST_F(Analytic, DiskLight) {
  const Polygon light = disk({0, 0, 1}, {0, 0, -1}, 0.6, 64);
  // The polygon's formula itself, against the disk's on its axis: pi r^2 / (h^2 + r^2). The inscribed polygon
  // has 1 - sinc(2 pi / 64) = 0.0016 less area.
  EXPECT_NEAR(polygon_irradiance({0, 0, 0}, light) / (pi * 0.36 / 1.36), 1, 0.0016);
  expect_area_light("disk light", {light}, 5);
}

TEST_F(Analytic, SphereLight) {
  const glm::dvec3 center(0.2, 0.1, 1);
  constexpr double RADIUS = 0.35;
  const Polygons light = sphere(center, RADIUS, 16);
  // A sphere above the horizon: pi (r / d)^2 cos theta; a polyhedron of 32 meridians and 16 rings lies within
  // radii r cos(pi / 32) cos(pi / 32) and r.
  const double of_sphere = pi * RADIUS * RADIUS * center.z / std::pow(glm::length(center), 3);
  const double ratio = irradiance_of({0, 0, 0}, light) / of_sphere, shrunk = std::pow(std::cos(pi / 32), 2);
  EXPECT_LT(ratio, 1);
  EXPECT_GT(ratio, shrunk * shrunk);
  expect_area_light("sphere light", light, 10);
}

// Two emissive panels of different colours with a slab between them: red (and half the blue) shows what
// passes the slab, green (and half the blue) what comes back from it.
PreparedScene slab_scene(const nlohmann::json& material, double tilt, double thickness) {
  GltfScene scene;
  scene.add({quad({-40, -40, -3}, {80, 0, 0}, {0, 80, 0})}, emitter({1, 0, 0.5}));
  scene.add({quad({-40, -40, 3}, {0, 80, 0}, {80, 0, 0})}, emitter({0, 1, 0.5}));
  const double c = std::cos(tilt), s = std::sin(tilt);
  scene.add(box({-4, -4, -thickness / 2}, {4, 4, thickness / 2}), material,
            {{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, {0, 0, 0, 1}});
  scene.set_orthographic(look_at({0, 0, 2.5}, {0, 0, 0}), 0.2, 0.2);
  return prepare(scene);
}

double fresnel(double cos_i, double eta) {
  const double cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t),
               p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return (s * s + p * p) / 2;
}

// Transmittance and reflectance of a slab with all inter-reflections.
struct Slab {
  double transmittance, reflectance;
};
Slab slab(double reflectance, double attenuation) {
  const double round_trip = reflectance * reflectance * attenuation * attenuation;
  const double passed = (1 - reflectance) * (1 - reflectance) * attenuation / (1 - round_trip);
  return {passed, reflectance + passed * reflectance * attenuation};
}

TEST_F(Analytic, GlassSlabPassesAndReflectsWithAllInterReflections) {
  constexpr double IOR = 1.5, THICKNESS = 0.1;
  uint32_t stream = 20;
  for (const glm::dvec3 attenuation : {glm::dvec3(1), glm::dvec3(0.01, 0.001, 1)})
    for (const double tilt : {0.0, 0.5}) {
      const double length = THICKNESS / std::sqrt(1 - std::pow(std::sin(tilt) / IOR, 2));
      const double f = fresnel(std::cos(tilt), IOR);
      const Slab red = slab(f, std::pow(attenuation.r, length)),
                 green = slab(f, std::pow(attenuation.g, length));
      RenderSettings settings = box_filtered(8, 8, is_slow_device() ? 64 : 256, 16);
      ComparisonOptions options;
      options.tile = 2;
      expect_known(("glass slab at " + std::to_string(tilt) + " rad").c_str(),
                   render_batches(slab_scene(glass(IOR, 0, attenuation), tilt, THICKNESS), settings, BATCHES,
                                  stream++),
                   uniform_image(8, 8, {red.transmittance, green.reflectance, 0.5}), options);
    }
}

// An index of 1 reflects nothing: Beer's law alone, without anything random.
TEST_F(Analytic, BeerAttenuationAtIndexOne) {
  const glm::dvec3 attenuation(0.02, 0.5, 0.3);
  constexpr double THICKNESS = 0.7;
  // A ray starts off its surface by the clearance of shaders/lib/geometry.glsl, 20 eps E (E^2 / 2 area),
  // which its way through the glass is short of. The camera sees the middle of 8 m faces: E^2 = 32 m^2, area
  // = 32 m^2.
  const double clearance = 20 * std::ldexp(1.0, -24) * std::sqrt(32.0) * 0.5;
  for (const double tilt : {0.0, 0.6}) {
    const double length = THICKNESS / std::cos(tilt);
    const double missing = -std::log(attenuation.r) * clearance / std::cos(tilt);
    const image::Image known =
        uniform_image(8, 8, {std::pow(attenuation.r, length), 0, 0.5 * std::pow(attenuation.b, length)});
    expect_everywhere(
        "Beer's law",
        render(slab_scene(glass(1, 0, attenuation), tilt, THICKNESS), point_sampled(8, 8, 12)).image, known,
        2 * ROUNDING + missing);
  }
}

TEST_F(Analytic, ThinGlassPassesWhatOneInterfaceDoesNotReflect) {
  nlohmann::json thin = glass(1.5);
  thin["extensions"].erase("KHR_materials_volume");
  GltfScene scene;
  scene.add({quad({-40, -40, -3}, {80, 0, 0}, {0, 80, 0})}, emitter({1, 0, 0.5}));
  scene.add({quad({-40, -40, 3}, {0, 80, 0}, {80, 0, 0})}, emitter({0, 1, 0.5}));
  scene.add({quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0})}, thin);
  scene.set_orthographic(look_at({0, 0, 2.5}, {0, 0, 0}), 0.2, 0.2);
  const double f = fresnel(1, 1.5);
  ComparisonOptions options;
  options.tile = 2;
  expect_known(
      "thin glass",
      render_batches(prepare(scene), box_filtered(8, 8, is_slow_device() ? 64 : 256, 4), BATCHES, 30),
      uniform_image(8, 8, {1 - f, f, 0.5}), options);
}

// KHR_materials_unlit under a light that would add a hundred times its colour: every value is the base colour
// itself.
TEST_F(Analytic, UnlitSurfacesShowTheirBaseColourExactly) {
  nlohmann::json unlit = lambert(ALBEDO);
  unlit["extensions"]["KHR_materials_unlit"] = nlohmann::json::object();
  for (const double height : {0.05, -0.05}) {  // both faces
    GltfScene scene;
    scene.add({quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})}, unlit);
    scene.set_orthographic(look_at({0, 0, height}, {0, 0, 0}), 1, 1);
    scene.add_point_light({0, 0, height}, {1000, 1000, 1000});
    const image::Image found = render(prepare(scene), point_sampled(8, 8, 5)).image;
    for (size_t i = 0; i < found.rgb.size(); ++i)
      ASSERT_EQ(found.rgb[i], static_cast<float>(ALBEDO[static_cast<int>(i % 3)])) << i;
  }
}

// A thin lens before the edge of a lamp: a point of the film sees the share of the lens from which the lamp
// lies behind it, a segment of the disk. Focused behind the lamp and before it, by camera paths and by
// splats.
TEST_F(Analytic, LensBlursAnEdgeByItsOwnShape) {
  constexpr double LENS_RADIUS = 0.05, LAMP_DISTANCE = 2, FILM_HALF_WIDTH = 0.06;  // m; the film at the lamp
  constexpr uint32_t WIDTH = 24, HEIGHT = 8;
  GltfScene scene;
  scene.add({quad({-0.2, -0.1, -LAMP_DISTANCE}, {0.2, 0, 0}, {0, 0.2, 0})}, emitter({1, 2, 3}));
  scene.set_perspective(look_at({0, 0, 0}, {0, 0, -1}),
                        2 * std::atan(FILM_HALF_WIDTH / LAMP_DISTANCE * HEIGHT / WIDTH));
  PreparedScene prepared = prepare(scene);
  prepared.scene.cameras[0].lens_radius = static_cast<float>(LENS_RADIUS);
  uint32_t stream = 50;
  for (const double focus : {5.0, 1.25}) {
    prepared.scene.cameras[0].focus_distance = static_cast<float>(focus);
    const double blur = LENS_RADIUS * std::abs(1 - LAMP_DISTANCE / focus);
    image::Image known{WIDTH, HEIGHT, {}};
    for (uint32_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
      double share = 0;
      constexpr int STEPS = 64;  // over the pixel
      for (int i = 0; i < STEPS; ++i) {
        const double x = FILM_HALF_WIDTH * (2 * (pixel % WIDTH + (i + 0.5) / STEPS) / WIDTH - 1);
        const double t = std::clamp(-x / blur, -1.0, 1.0);
        share += (0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / pi) / STEPS;
      }
      for (int c = 1; c <= 3; ++c) known.rgb.push_back(static_cast<float>(c * share));
    }
    for (const uint32_t technique : {interface::TECHNIQUE_HIT, interface::TECHNIQUE_SPLAT}) {
      RenderSettings settings = box_filtered(WIDTH, HEIGHT, 256, 1);
      settings.techniques = technique;
      ComparisonOptions options;
      options.tile = 2;
      expect_known(technique == interface::TECHNIQUE_HIT ? "thin lens, camera paths" : "thin lens, splats",
                   render_batches(prepared, settings, BATCHES, stream++), known, options);
    }
  }
}

}  // namespace
}  // namespace regulus::test

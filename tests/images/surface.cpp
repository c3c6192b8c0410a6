// What surfaces may carry beside factors: vertex colours, normal maps, alpha, clearcoats, anisotropy.
// Against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "render/names.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec4;
using nlohmann::json;
using std::numbers::pi;

// As in analytic.cpp: 60 roundings of 2^-24 between the camera and the pixel. Colours and texture coordinates
// are interpolated from a few more.
constexpr double ROUNDING = 1e-5;
constexpr uint32_t SIZE = 32;

// The square [-1, 1]^2 of the plane z = 0 with uv (0, 0) at its upper left corner, as an image lies, and an
// orthographic camera whose film is that square.
const Polygon SQUARE = quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
const std::vector<glm::vec2> SQUARE_UVS = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};

GltfScene above_square() {
  GltfScene scene;
  scene.set_orthographic(look_at({0, 0, 0.5}, {0, 0, 0}), 1, 1);
  return scene;
}

dvec2 film_point(uint32_t x, uint32_t y) {
  return {2 * (x + 0.5) / SIZE - 1, 1 - 2 * (y + 0.5) / SIZE};
}

using Radiance = std::function<dvec3(const dvec2&)>;

/// Every pixel against the radiance of its centre's point.
void expect_image(const char* what, const GltfScene& scene, const Radiance& radiance,
                  double relative = ROUNDING) {
  const image::Image found = render(prepare(scene), point_sampled(SIZE, SIZE, 2)).image;
  double worst = 0;
  for (uint32_t y = 0; y < SIZE; ++y)
    for (uint32_t x = 0; x < SIZE; ++x) {
      const dvec3 known = radiance(film_point(x, y));
      for (int c = 0; c < 3; ++c) {
        const double value = found.rgb[3 * (y * SIZE + x) + static_cast<uint32_t>(c)];
        worst = std::max(worst, std::abs(value - known[c]) / std::max(std::abs(known[c]), 1e-3));
      }
    }
  std::printf("%s: worst relative difference %.3g, bound %.3g\n", what, worst, relative);
  EXPECT_LE(worst, relative) << what;
}

class Surfaces : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

// Red grows to the right, green upwards: what the two triangles of the square interpolate between its
// corners.
TEST_F(Surfaces, VertexColoursScaleTheBaseColour) {
  GltfScene scene = above_square();
  Corners corners;
  corners.colors = {{0, 0, 0.5, 1}, {1, 0, 0.5, 1}, {1, 1, 0.5, 1}, {0, 1, 0.5, 1}};
  scene.add({SQUARE}, lambert({0.5, 0.8, 0.6}), glm::dmat4(1), corners);
  scene.add_directional_light({0, 0.6, -0.8}, 2);
  expect_image("vertex colours", scene, [](const dvec2& p) {
    return dvec3(0.5, 0.8, 0.6) * dvec3(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y, 0.5) * (2 * 0.8 / pi);
  });
}

TEST_F(Surfaces, VertexColoursScaleWhatIsUnlit) {
  GltfScene scene = above_square();
  Corners corners;
  corners.colors = {{0, 0, 0.5, 1}, {1, 0, 0.5, 1}, {1, 1, 0.5, 1}, {0, 1, 0.5, 1}};
  json unlit = lambert({0.5, 0.8, 0.6});
  unlit["extensions"] = {{"KHR_materials_unlit", json::object()}};
  scene.add({SQUARE}, unlit, glm::dmat4(1), corners);
  expect_image("unlit vertex colours", scene, [](const dvec2& p) {
    return dvec3(0.5, 0.8, 0.6) * dvec3(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y, 0.5);
  });
}

/// A material with a normal map of a single colour, and the normal that it gives in the tangent frame.
struct NormalMapped {
  dvec3 codes;
  double scale;

  json material(GltfScene& scene, const dvec3& albedo) const {
    json result = lambert(albedo);
    const std::vector<uint8_t> rgba = {static_cast<uint8_t>(codes.x), static_cast<uint8_t>(codes.y),
                                       static_cast<uint8_t>(codes.z), 255};
    result["normalTexture"] = {{"index", scene.add_texture(1, rgba)}, {"scale", scale}};
    return result;
  }
  dvec3 normal() const {
    dvec3 n;
    for (int i = 0; i < 3; ++i) n[i] = (2 * codes[i] / 255 - 1) * (i < 2 ? scale : 1);
    return glm::normalize(n);
  }
};

// The frame of the image: u along `u`, up in the image along `up`.
std::vector<glm::vec2> uvs_along(const dvec3& u, const dvec3& up) {
  std::vector<glm::vec2> uvs;
  for (const dvec3& p : SQUARE) uvs.emplace_back(dot(p, u), -dot(p, up));
  return uvs;
}

// A Lambert plane under a directional light reflects as its mapped normal is turned, in every layout of the
// image; and the tangents of the file count, if it has some.
TEST_F(Surfaces, NormalMapsTurnTheNormal) {
  const NormalMapped map{{204, 90, 220}, 0.7};
  const dvec3 towards_light = glm::normalize(dvec3(0.5, -0.2, 0.8));
  const auto expect_normal = [&](const char* what, const Corners& corners, const dvec3& tangent,
                                 const dvec3& up) {
    GltfScene scene = above_square();
    scene.add({SQUARE}, map.material(scene, {0.5, 0.8, 0.6}), glm::dmat4(1), corners);
    scene.add_directional_light(-towards_light, 2);
    const dvec3 m = map.normal();
    const double cosine = dot(m.x * tangent + m.y * up + dvec3(0, 0, m.z), towards_light);
    expect_image(what, scene, [&](const dvec2&) { return dvec3(0.5, 0.8, 0.6) * (2 * cosine / pi); });
  };
  const dvec3 x(1, 0, 0), y(0, 1, 0);
  Corners corners;
  corners.uvs = uvs_along(x, y);
  expect_normal("u along x", corners, x, y);
  corners.uvs = uvs_along(-y, x);
  expect_normal("u along -y", corners, -y, x);
  corners.uvs = uvs_along(-x, y);
  expect_normal("mirrored", corners, -x, y);
  corners.normals.assign(4, {0, 0, 1});
  corners.tangents.assign(4, {0.6f, 0.8f, 0, -1});
  expect_normal("tangents of the file", corners, {0.6, 0.8, 0}, {0.8, -0.6, 0});
}

// Seen at a slant from behind the mapped normal the surface is as bright as from elsewhere; lit from behind
// it is black.
TEST_F(Surfaces, MappedNormalsAreNotBlackForBeingSeenAtASlant) {
  const NormalMapped map{{230, 128, 200}, 1};
  const dvec3 m = map.normal();
  const auto image = [&](double eye_side, double light_side) {
    GltfScene scene;
    Corners corners;
    corners.uvs = uvs_along({1, 0, 0}, {0, 1, 0});
    scene.add({SQUARE}, map.material(scene, {0.5, 0.5, 0.5}), glm::dmat4(1), corners);
    scene.add_directional_light(glm::dvec3(-light_side, 0, -0.2), 2);
    scene.set_orthographic(look_at({eye_side, 0, 0.2}, {0, 0, 0}, {0, 0, 1}), 0.1, 0.01);
    return mean_of(render(prepare(scene), point_sampled(8, 8, 2)).image)[0];
  };
  ASSERT_LT(dot(m, dvec3(-1, 0, 0.2)), 0);
  const double lit = 0.5 / pi * 2 * dot(m, glm::normalize(dvec3(1, 0, 0.2)));
  EXPECT_NEAR(image(1, 1), lit, ROUNDING * lit);
  EXPECT_NEAR(image(-1, 1), lit, ROUNDING * lit);
  EXPECT_EQ(image(1, -1), 0);
}

json unlit(const dvec3& color, double alpha = 1, const char* mode = "OPAQUE") {
  json material = lambert(color);
  material["extensions"] = {{"KHR_materials_unlit", json::object()}};
  material["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha;
  material["alphaMode"] = mode;
  return material;
}

// A masked pattern of 4 x 4 texels before a red wall: factor, texel and vertex colour together reach the
// cut-off or not, and edges lie where the texels end.
TEST_F(Surfaces, MasksCutWhereTheTexelsEnd) {
  GltfScene scene = above_square();
  std::vector<uint8_t> rgba;
  for (int i = 0; i < 16; ++i)
    for (const int code : {255, 255, 255, i * 16}) rgba.push_back(static_cast<uint8_t>(code));
  json mask = unlit({1, 1, 1}, 0.8, "MASK");
  mask["alphaCutoff"] = 0.2;
  mask["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", scene.add_texture(4, rgba, true)}};
  Corners corners;
  corners.uvs = SQUARE_UVS;
  corners.colors.assign(4, {1, 1, 1, 0.5});
  scene.add({SQUARE}, mask, glm::dmat4(1), corners);
  scene.add({quad({-1, -1, -0.2}, {2, 0, 0}, {0, 2, 0})}, unlit({1, 0, 0}));
  expect_image("mask", scene, [](const dvec2& p) {
    const int column = static_cast<int>(2 * (p.x + 1)), row = static_cast<int>(2 * (1 - p.y));
    const bool is_there = 0.5 * 0.8 * ((4 * row + column) * 16 / 255.0) >= 0.2;
    return is_there ? dvec3(1) : dvec3(1, 0, 0);
  });
}

// A blended pane shows alpha of itself and the rest of what is behind; its shadow takes alpha of the light.
// Rays decide at random: the bound is five standard deviations of as many decisions.
TEST_F(Surfaces, BlendedSurfacesAreThereByChance) {
  const uint32_t samples = is_slow_device() ? 16 : 64;
  constexpr double ALPHA = 0.3;
  GltfScene seen = above_square();
  seen.add({SQUARE}, unlit({1, 0.5, 0.25}, ALPHA, "BLEND"));
  seen.add({quad({-1, -1, -0.2}, {2, 0, 0}, {0, 2, 0})}, unlit({0, 0.25, 1}));
  const auto mean = mean_of(render(prepare(seen), box_filtered(SIZE, SIZE, samples, 2)).image);
  const double deviation = std::sqrt(ALPHA * (1 - ALPHA) / (SIZE * SIZE * samples));
  const dvec3 front(1, 0.5, 0.25), back(0, 0.25, 1);
  for (int c = 0; c < 3; ++c) {
    const double known = ALPHA * front[c] + (1 - ALPHA) * back[c];
    std::printf("blend: %.5f, known %.5f, deviation %.2g\n", mean[static_cast<size_t>(c)], known, deviation);
    EXPECT_NEAR(mean[static_cast<size_t>(c)], known, 5 * deviation * std::abs(front[c] - back[c]));
  }

  // Between camera and lit plane there is nothing: the pane lies beyond the film's square as seen from the
  // light.
  GltfScene lit = above_square();
  lit.add({SQUARE}, lambert({1, 1, 1}));
  lit.add({quad({-20, -20, 2}, {40, 0, 0}, {0, 40, 0})}, unlit({0, 0, 0}, ALPHA, "BLEND"));
  lit.add_directional_light({0, 0, -1}, pi);
  const double lit_mean = mean_of(render(prepare(lit), box_filtered(SIZE, SIZE, samples, 2)).image)[0];
  std::printf("shadow: %.5f, known %.5f\n", lit_mean, 1 - ALPHA);
  EXPECT_NEAR(lit_mean, 1 - ALPHA, 5 * deviation);
}

// A Lambert square under a smooth clearcoat in a room that shines everywhere: the coat reflects c F(o), what
// passes it comes back through it. Schlick's F from 0.04 has the mean 0.04 + 0.96 / 21 over a cosine-weighted
// hemisphere.
TEST_F(Surfaces, ClearcoatsReflectAndPass) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  constexpr double COAT = 0.8, ALBEDO = 0.7;
  for (const double cosine : {1.0, 0.3}) {
    GltfScene scene;
    json coated = lambert(dvec3(ALBEDO));
    coated["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", COAT}};
    scene.add({SQUARE}, coated);
    scene.add(turned(box({-9, -9, -9}, {9, 9, 9})), emitter({1, 1, 1}));
    const double sine = std::sqrt(1 - cosine * cosine);
    scene.set_orthographic(look_at({0.1 * sine, 0, 0.1 * cosine}, {0, 0, 0}), 0.01, 0.01);
    const double fresnel = COAT * (0.04 + 0.96 * std::pow(1 - cosine, 5));
    const double known = fresnel + (1 - fresnel) * ALBEDO * (1 - COAT * (0.04 + 0.96 / 21));
    const auto batches = render_batches(prepare(scene), box_filtered(16, 16, 32, 2), 11, 300);
    expect_known("clearcoat", batches, uniform_image(16, 16, {known, known, known}));
  }
}

// Sheen over black in a room that shines everywhere: the integral of its formulas, by a program of its own
// (Gauss and Legendre, 160 x 160 points).
TEST_F(Surfaces, SheenReflectsWhatItsFormulasSay) {
  GltfScene scene;
  json black = cloth(lambert(dvec3(0)), {1, 0.5, 0.25}, 0.5);
  scene.add({SQUARE}, black);
  scene.add(turned(box({-9, -9, -9}, {9, 9, 9})), emitter({1, 1, 1}));
  scene.set_orthographic(look_at({0.1 * std::sqrt(0.75), 0, 0.05}, {0, 0, 0}), 0.01, 0.01);
  constexpr double KNOWN = 0.187854;
  for (const uint32_t techniques : {find_name(render::names::INTEGRATORS, "pt")->value,
                                    find_name(render::names::INTEGRATORS, "bpt")->value}) {
    render::RenderSettings settings = box_filtered(16, 16, 32, 2);
    settings.techniques = techniques;  // pt, bpt
    const auto batches = render_batches(prepare(scene), settings, 11, 300);
    expect_known("sheen", batches, uniform_image(16, 16, {KNOWN, KNOWN / 2, KNOWN / 4}));
  }
}

// Smooth films on metal and over a black base, seen at 60 degrees in a room that shines everywhere: the
// appendix of KHR_materials_iridescence by a program of its own. The metal's film has its thickness, 150 + .6
// * 500 nm, from the green of a texture.
TEST_F(Surfaces, FilmsHaveTheColoursOfTheirAppendix) {
  constexpr double ABSOLUTE = 3e-5;  // 60 roundings of phases of up to 30 rad
  const auto expect_seen = [](GltfScene& scene, const json& material, const dvec3& known) {
    Corners corners;
    corners.uvs = SQUARE_UVS;
    scene.add({SQUARE}, material, glm::dmat4(1), corners);
    scene.add(turned(box({-9, -9, -9}, {9, 9, 9})), emitter({1, 1, 1}));
    scene.set_orthographic(look_at({0.1 * std::sqrt(0.75), 0, 0.05}, {0, 0, 0}), 0.01, 0.01);
    const image::Image found = render(prepare(scene), point_sampled(4, 4, 2)).image;
    for (size_t i = 0; i < found.rgb.size(); ++i)
      EXPECT_NEAR(found.rgb[i], known[static_cast<int>(i % 3)], ABSOLUTE) << i;
  };
  GltfScene of_metal, of_black;
  json gold = filmed(metal({0.9, 0.7, 0.5}, 0), 1.8, 650);
  json& film = gold["extensions"]["KHR_materials_iridescence"];
  film["iridescenceThicknessMinimum"] = 150;
  film["iridescenceThicknessTexture"] = {{"index", of_metal.add_texture(1, {255, 153, 0, 255}, true)}};
  expect_seen(of_metal, gold, {0.747362788, 0.452796450, 0.450551847});
  expect_seen(of_black, filmed(plastic({0, 0, 0}, 0), 2, 350), {0.000868630, 0.208777486, 0.136762404});
}

// A smooth coat over black, whose own normal turns what it reflects away from the camera: onto the one wall
// of a room that shines, with the share that Schlick's F has at that normal. The base's normal has no say.
TEST_F(Surfaces, ClearcoatsHaveTheirOwnNormals) {
  const NormalMapped of_coat{{204, 100, 220}, 0.7}, of_base{{90, 160, 230}, 1};
  GltfScene scene = above_square();
  json coated = of_base.material(scene, dvec3(0));
  coated["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0}};
  coated["extensions"]["KHR_materials_clearcoat"] = {
      {"clearcoatFactor", 0.8},
      {"clearcoatNormalTexture", of_coat.material(scene, dvec3(0))["normalTexture"]}};
  Corners corners;
  corners.uvs = uvs_along({1, 0, 0}, {0, 1, 0});
  scene.add({SQUARE}, coated, glm::dmat4(1), corners);
  const dvec3 n = of_coat.normal();
  const dvec3 reflected = 2 * n.z * n - dvec3(0, 0, 1);
  ASSERT_GT(reflected.x, 0.5);
  scene.add({quad({2, -9, 0}, {0, 0, 9}, {0, 18, 0})}, emitter({1, 0.5, 0.25}));  // faces -x
  const double known = 0.8 * (0.04 + 0.96 * std::pow(1 - n.z, 5));
  expect_image("clearcoat's normal", scene, [&](const dvec2&) { return known * dvec3(1, 0.5, 0.25); });

  // Without a map of its own the coat is as smooth as the mesh, whatever the base: it reflects the dark
  // above.
  coated["extensions"]["KHR_materials_clearcoat"].erase("clearcoatNormalTexture");
  GltfScene plain = above_square();
  coated["normalTexture"] = of_base.material(plain, dvec3(0))["normalTexture"];
  plain.add({SQUARE}, coated, glm::dmat4(1), corners);
  plain.add({quad({2, -9, 0}, {0, 0, 9}, {0, 18, 0})}, emitter({1, 0.5, 0.25}));
  plain.add({turned({quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0})})}, emitter({0, 0.5, 0}));
  expect_image("clearcoat over relief", plain, [](const dvec2&) { return 0.8 * 0.04 * dvec3(0, 0.5, 0); });
}

}  // namespace
}  // namespace regulus::test

// Lights and their selection.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>

#include "interface/wavefront.h"
#include "scene/alias_table.hpp"
#include "scene/light_power.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

json emitter(double radiance, bool is_double_sided = false) {
  return {{"emissiveFactor", {1, 1, 1}},
          {"doubleSided", is_double_sided},
          {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", radiance}}}}}};
}

Scene load_with_lights(const Gltf& file) {
  Scene scene = file.load();
  build_lights(scene);
  return scene;
}

TEST(SceneLights, PunctualLightsTakeThePlaceAndDirectionOfTheirNode) {
  Gltf file;
  file.triangle();
  // A quarter turn about x: local -z points along +y.
  const json turned = {{"translation", {1, 2, 3}}, {"rotation", {std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}};
  file.light({{"type", "spot"},
              {"color", {1, 0.5, 0.25}},
              {"intensity", 8},
              {"range", 3},
              {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 1.0}}}},
             turned);
  const Scene scene = file.load();
  ASSERT_EQ(scene.lights.size(), 1u);
  const interface::Light& light = scene.lights[0];
  EXPECT_EQ(light.kind, interface::LIGHT_SPOT);
  EXPECT_EQ(light.position, glm::vec3(1, 2, 3));
  EXPECT_LT(glm::length(light.direction - glm::vec3(0, 1, 0)), 1e-6f);
  EXPECT_EQ(light.intensity, glm::vec3(8, 4, 2));
  EXPECT_EQ(light.inner_height, static_cast<float>(1 - std::cos(0.5)));
  EXPECT_EQ(light.outer_height, static_cast<float>(1 - std::cos(1.0)));
  EXPECT_EQ(light.area, 3.0f) << "its range";
  EXPECT_NE(find_features(scene).bits & interface::FEATURE_LIGHT_RANGES, 0u);
}

// As an animation leaves it: the file has its light, and the picture is black.
TEST(SceneLights, ADarkLightBringsNoEnvironment) {
  Gltf file;
  file.triangle();
  file.light({{"type", "point"}, {"intensity", 0}});
  const Scene scene = load_with_lights(file);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_FALSE(scene.environment);
  EXPECT_TRUE(has_warning(scene, "the picture will be black"));
}

TEST(SceneLights, ImpossibleConesStayFinite) {
  Gltf file;
  file.triangle();
  file.light({{"type", "spot"}, {"spot", {{"innerConeAngle", 1.0}, {"outerConeAngle", 0.5}}}});
  file.light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.0}, {"outerConeAngle", 0.0}}}});
  const Scene scene = file.load();
  for (const interface::Light& light : scene.lights) {
    EXPECT_LT(light.inner_height, light.outer_height);
    EXPECT_TRUE(std::isfinite(punctual_power(light, 1)));
  }
  EXPECT_TRUE(has_warning(scene, "(clamped)"));
}

TEST(SceneLights, SpotPowerIsTheIntegralOfItsFalloff) {
  for (const auto& [inner, outer] :
       {std::pair(0.0, 0.7), std::pair(0.3, 0.31), std::pair(0.5, std::numbers::pi / 2)}) {
    interface::Light light {};
    light.kind = interface::LIGHT_SPOT;
    light.intensity = glm::vec3(3);
    light.inner_height = static_cast<float>(1 - std::cos(inner));
    light.outer_height = static_cast<float>(1 - std::cos(outer));
    // Midpoint rule over the cosine; the integrand has slope up to 2 / width, so the error is below
    // 2 pi (2 / width^2) / 24 / n^2 times the interval.
    const int n = 1000000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double height = double{light.outer_height} * (i + 0.5) / n;
      const double falloff = std::clamp(
          (light.outer_height - height) / (double{light.outer_height} - light.inner_height), 0.0, 1.0);
      sum += falloff * falloff;
    }
    const double expected = 3 * 2 * std::numbers::pi * sum * light.outer_height / n;
    EXPECT_NEAR(punctual_power(light, 1), expected, 1e-6 * expected) << inner << " " << outer;
  }
}

TEST(SceneLights, SelectionIsInProportionToPower) {
  Gltf file;
  file.triangle_of(emitter(2));                             // pi * 1/2 * 2
  file.triangle_of(emitter(2, true));                       // twice that
  file.root["meshes"].back()["primitives"][0]["indices"] =  // facing the other way: not the same light
      file.accessor(std::vector<uint8_t>{0, 2, 1}, "SCALAR", 5121);
  file.root["nodes"].back()["translation"] = {0, 0, 1e-4};  // in one place only one of them would shine
  file.light({{"type", "point"}, {"intensity", 0.5}});      // 4 pi * 0.5
  file.light({{"type", "directional"}, {"intensity", 4}});  // pi r^2 * 4, r = sqrt(2) / 2
  const Scene scene = load_with_lights(file);
  ASSERT_EQ(scene.lights.size(), 4u);
  const double powers[4] = {2 * std::numbers::pi, 2 * std::numbers::pi, std::numbers::pi,
                            2 * std::numbers::pi};  // punctual first: point, directional
  const double total = std::accumulate(powers, powers + 4, 0.0);
  for (int i = 0; i < 4; ++i) {
    const size_t k = static_cast<size_t>(i);
    // Powers hold the luminance weights' sum (1 up to double rounding); thresholds are floats.
    EXPECT_NEAR(scene.lights[k].selection_pdf, powers[i] / total, 4 * 0x1p-24) << "light " << i;
  }
  EXPECT_EQ(scene.lights[2].kind, interface::LIGHT_TRIANGLE);
  EXPECT_EQ(scene.lights[2].area, 0.5f);
  EXPECT_EQ(scene.lights[2].intensity, glm::vec3(2));
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    ASSERT_NE(scene.triangles[i].light, interface::INVALID_INDEX);
    EXPECT_EQ(scene.lights[scene.triangles[i].light].triangle, i);
  }
}

TEST(SceneLights, LightsWithoutPowerAreLeftOut) {
  Gltf file;
  file.triangle_of(emitter(0));
  file.light({{"type", "point"}, {"intensity", 0}});
  Scene scene = file.load();
  scene.environment = uniform_environment(glm::vec3(0));
  build_lights(scene);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_TRUE(scene.light_aliases.empty());
  EXPECT_EQ(scene.triangles[0].light, interface::INVALID_INDEX);
  EXPECT_TRUE(has_warning(scene, "no light"));
}

TEST(SceneLights, AnUnlitSceneGetsADimEnvironment) {
  Gltf file;
  file.triangle_of(emitter(0));
  Scene scene = load_with_lights(file);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].kind, interface::LIGHT_ENVIRONMENT);
  EXPECT_EQ(scene.environment->parameters.radiance, glm::vec3(DIM_RADIANCE));
  EXPECT_EQ(scene.environment->parameters.selection_pdf, 1);
  EXPECT_TRUE(has_warning(scene, "no light"));
  build_lights(scene);
  EXPECT_EQ(scene.lights.size(), 1u) << "building twice gives the same";
}

TEST(SceneLights, TheEnvironmentIsChosenByItsPower) {
  Gltf file;
  file.triangle_of(emitter(0));
  file.light({{"type", "directional"}, {"intensity", 4}});  // pi r^2 * 4
  Scene scene = file.load();
  scene.environment = uniform_environment(glm::vec3(1, 1, 1));  // pi r^2 * 4 pi
  build_lights(scene);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_NEAR(scene.environment->parameters.selection_pdf, std::numbers::pi / (1 + std::numbers::pi),
              4 * 0x1p-24);
}

TEST(SceneLights, BuildingTwiceGivesTheSame) {
  Gltf file;
  file.triangle_of(emitter(2));
  file.light({{"type", "point"}});
  Scene scene = load_with_lights(file);
  const size_t count = scene.lights.size();
  build_lights(scene);
  EXPECT_EQ(scene.lights.size(), count);
}

TEST(SceneLights, TexturedEmissionIsAveraged) {
  // A checker of 32 x 32 texels, half of them 1 (linear), seen on one triangle; the other shows black only.
  std::vector<uint16_t> samples;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c)
        samples.push_back(static_cast<uint16_t>(y < 32 && (x + y) % 2 == 0 ? 255 : 0));
  Gltf file;
  const size_t texture = file.texture(make_png(64, 64, 3, 8, samples));
  json material = emitter(4);
  material["emissiveTexture"] = {{"index", texture}};
  file.triangle_of(material);
  file.triangle_of(material);
  file.root["nodes"].back()["translation"] = {0, 0, 1};  // in one place only one of them would shine
  const std::vector<float> lit = {0, 0, 1, 0, 0, 0.5f}, dark = {0.1f, 0.9f, 0.2f, 0.9f, 0.1f, 0.95f};
  file.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = file.accessor(lit, "VEC2", FLOAT);
  file.root["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_0"] = file.accessor(dark, "VEC2", FLOAT);
  file.light({{"type", "point"}});
  Scene scene = load_with_lights(file);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.triangles[1].light, interface::INVALID_INDEX);
  // Mean radiance 4 * 1/2 over area 1/2. Bilinear interpolation makes the checker 1/2 + (1 - 2 a)(1 - 2 b) /
  // 2, of deviation 1/6: 5 deviations of the mean of 64 independent samples, which even ones stay well
  // within.
  const double power = TrianglePower(scene)(scene.triangles[0], 0.5);
  const double bound = std::numbers::pi * 0.5 * 4 * 5 / 6.0 / 8;
  std::printf("textured power %.4f, expected %.4f +- %.4f\n", power, std::numbers::pi * 0.5 * 2, bound);
  EXPECT_NEAR(power, std::numbers::pi * 0.5 * 2, bound);
}

TEST(SceneLights, ATinyBrightSpotKeepsItsTriangleSelectable) {
  std::vector<uint16_t> samples(256 * 256 * 3, 0);
  for (size_t c = 0; c < 3; ++c) samples[(17 * 256 + 23) * 3 + c] = 255;
  Gltf file;
  const size_t texture = file.texture(make_png(256, 256, 3, 8, samples));
  json material = emitter(1);
  material["emissiveTexture"] = {{"index", texture}};
  file.triangle_of(material);
  const Scene scene = load_with_lights(file);
  EXPECT_NE(scene.triangles[0].light, interface::INVALID_INDEX);
}

// A model whose displays glow is shown by the light of the viewer, as its file expects; a lamp or an
// environment, though black, is light that the file speaks of.
TEST(SceneLights, GlowingTexturesAloneDoNotLightAScene) {
  Gltf file;
  json material = emitter(1);
  material["emissiveTexture"] = {{"index", file.texture(make_png(1, 1, 3, 8, {255, 255, 255}))}};
  file.triangle_of(material);
  Scene scene = load_with_lights(file);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.environment->parameters.radiance, glm::vec3(DIM_RADIANCE));
  EXPECT_TRUE(has_warning(scene, "only textures"));
  build_lights(scene);
  EXPECT_EQ(scene.lights.size(), 2u) << "building twice gives the same";

  scene.environment = uniform_environment(glm::vec3(0));
  build_lights(scene);
  EXPECT_EQ(scene.lights.size(), 1u);
  scene.environment.reset();
  scene.materials[0].emissive_texture = interface::INVALID_INDEX;
  build_lights(scene);
  EXPECT_EQ(scene.lights.size(), 1u) << "without a texture it is a lamp";
}

// The lights below each child of a pair, by walking down; checks depth and trails on the way.
size_t count_leaves(const LightTree& tree, uint32_t child, uint32_t depth, uint32_t trail) {
  if ((child & interface::LIGHT_PAIR_LEAF) != 0) {
    const uint32_t light = child & ~interface::LIGHT_PAIR_LEAF;
    EXPECT_LE(depth, interface::MAX_LIGHT_TREE_DEPTH);
    EXPECT_EQ(tree.trails.at(light), trail);
    return 1;
  }
  const interface::LightPair& pair = tree.pairs.at(child);
  return count_leaves(tree, pair.children[0], depth + 1, trail) +
         count_leaves(tree, pair.children[1], depth + 1, trail | 1u << depth);
}

TreeLight point_at(const glm::dvec3& position, double intensity = 1) {
  TreeLight light;
  light.bounds.lower = light.bounds.upper = position;
  light.bounds.theta_o = std::numbers::pi;
  light.bounds.theta_e = std::numbers::pi / 2;
  light.bounds.intensity = intensity;
  return light;
}

TEST(LightTree, HoldsEveryLightOnceHoweverTheyLie) {
  std::vector<TreeLight> same(5000, point_at({1, 2, 3})), halving, one_line, distant(7);
  for (int i = 0; i < 3000; ++i) halving.push_back(point_at({std::ldexp(1.0, -i % 1000), 0, 0}, 1 + i % 7));
  for (int i = 0; i < 1000; ++i) one_line.push_back(point_at({0, i, 0}));
  for (TreeLight& light : distant) light = {true, {}, 2};
  std::vector<TreeLight> mixed = one_line;
  mixed.insert(mixed.begin() + 10, distant.begin(), distant.end());
  for (const auto& lights : {same, halving, one_line, distant, mixed}) {
    const LightTree tree = build_light_tree(lights);
    EXPECT_EQ(tree.pairs.size(), lights.size() - 1);
    EXPECT_EQ(count_leaves(tree, 0, 0, 0), lights.size());
  }
  EXPECT_TRUE(build_light_tree({point_at({0, 0, 0})}).pairs.empty());
  // Lights on a line are halved, not peeled off one by one.
  const std::vector<uint32_t> trails = build_light_tree(one_line).trails;
  EXPECT_LT(*std::ranges::max_element(trails), 1u << 16);
}

TEST(LightTree, DistantLightsShareByPower) {
  std::vector<TreeLight> lights = {point_at({0, 0, 0}), {true, {}, 3}, {true, {}, 1}};
  const LightTree tree = build_light_tree(lights);
  EXPECT_EQ(tree.pairs[0].first_share, static_cast<float>(2.0 / 3));  // two of them against the rest
  EXPECT_EQ(tree.pairs[tree.pairs[0].children[0]].first_share, 0.75f);
}

TEST(LightTree, UnitedConesHoldBoth) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, std::numbers::pi);
  const auto bounds = [&](double theta) {
    LightBounds result;
    result.axis = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    result.theta_o = theta;
    return result;
  };
  for (int i = 0; i < 2000; ++i) {
    const LightBounds a = bounds(i % 3 == 0 ? 0 : uniform(random)),
                      b = i % 5 == 0 ? a : bounds(uniform(random));
    const LightBounds both = united(a, b);
    for (const LightBounds& part : {a, b}) {
      const double between = std::acos(std::clamp(glm::dot(part.axis, both.axis), -1.0, 1.0));
      EXPECT_LE(std::min(between + part.theta_o, std::numbers::pi), both.theta_o + 1e-7) << i;
    }
  }
}

TEST(AliasTable, ReturnsWhatItsWeightsSay) {
  for (const uint32_t seed : {1u, 2u, 3u, 4u}) {
    std::mt19937 random(seed);
    std::lognormal_distribution<double> weight(0, 5);
    std::vector<double> weights(1 + seed * 1000);
    for (double& w : weights) w = weight(random);
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto table = make_alias_table(weights);
    const std::vector<double> pdf = alias_table_pdf(table);
    double worst = 0, sum = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
      ASSERT_LT(table[i].alias, weights.size());
      ASSERT_GE(table[i].threshold, 0.0f);
      ASSERT_LE(table[i].threshold, 1.0f);
      worst = std::max(worst, std::fabs(pdf[i] - weights[i] / total));
      sum += pdf[i];
    }
    // A bucket's threshold is off by half a float spacing (2^-25) at most; an index receives from up to n
    // buckets of 1/n each: 2^-25 in all, plus its own 2^-25 / n.
    const double bound = 0x1p-25 * (1 + 1.0 / static_cast<double>(weights.size())) + 1e-12;
    std::printf("seed %u: worst deviation %.3g, bound %.3g\n", seed, worst, bound);
    EXPECT_LE(worst, bound);
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(AliasTable, ZeroWeightsAreNeverDrawn) {
  const std::vector<double> pdf = alias_table_pdf(make_alias_table({0, 1, 0, 3, 0}));
  EXPECT_EQ(pdf[0], 0);
  EXPECT_EQ(pdf[2], 0);
  EXPECT_EQ(pdf[4], 0);
  EXPECT_NEAR(pdf[1], 0.25, 1e-7);
}

}  // namespace
}  // namespace regulus::scene::test

// Layers of the film: their sums are the picture's word by word, and each holds what closed forms and the
// scalar reference say of it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "check/reference_render.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "render/aov.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using Words = std::vector<uint32_t>;

constexpr uint32_t KINDS = render::LIGHT_AOVS & ~render::AOV_LIGHTS;

class Layers : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

const render::LightLayer& layer_of(const render::Film& film, const std::string& name) {
  for (const render::LightLayer& layer : film.layers)
    if (layer.name == name) return layer;
  throw std::runtime_error("no layer " + name);
}

/// Adds sums of three words.
void add(const Words& more, Words& sums) {
  for (size_t i = 0; i < sums.size(); i += 3) {
    uint64_t carry = 0;
    for (size_t word = i; word < i + 3; ++word) {
      carry += uint64_t{sums[word]} + more[word];
      sums[word] = static_cast<uint32_t>(carry);
      carry >>= 32;
    }
  }
}

bool is_group(const render::LightLayer& layer) {
  return layer.name.starts_with("light_");
}

void expect_sum(const render::Film& film, bool of_groups, Words render::LightLayer::*own,
                const Words& whole) {
  Words sum(whole.size());
  size_t with_light = 0;
  for (const render::LightLayer& layer : film.layers) {
    if (is_group(layer) != of_groups) continue;
    ASSERT_EQ((layer.*own).size(), whole.size());
    add(layer.*own, sum);
    with_light += layer.*own != Words(whole.size()) ? 1 : 0;
  }
  EXPECT_TRUE(sum == whole) << (of_groups ? "groups" : "kinds");
  if (whole != Words(whole.size())) {
    EXPECT_GE(with_light, 2u) << (of_groups ? "groups" : "kinds");
  }
}

/// A closed room with a mirror and a block of glass, a lamp that glows and one without extent.
PreparedScene lit_room() {
  GltfScene scene = room(lambert({0.5, 0.5, 0.5}), metal({0.9, 0.9, 0.9}, 0), glass(1.5));
  scene.add({quad({-0.3, 0.99, -0.3}, {0.6, 0, 0}, {0, 0, 0.6})}, emitter({4, 4, 4}));
  scene.add_point_light({0.5, 0.5, 0.5}, {0.5, 0.4, 0.3});
  return prepare(scene);
}

render::RenderSettings with_layers(uint32_t width, uint32_t height, uint32_t samples, uint32_t techniques) {
  render::RenderSettings settings = box_filtered(width, height, samples, 6);
  settings.techniques = techniques;
  settings.aovs = render::LIGHT_AOVS;
  if ((techniques & TECHNIQUE_MERGE) != 0) settings.merge_radius = 0.1F;
  return settings;
}

double share_of_differences(const image::Image& a, const image::Channels& b, const std::string& name) {
  size_t differ = 0;
  for (size_t c = 0; c < 3; ++c) {
    const auto& values = std::get<std::vector<float>>(b.at(name + "." + "RGB"[c]));
    for (size_t i = 0; i < values.size(); ++i)
      differ += std::abs(a.rgb[3 * i + c] - values[i]) <= 1e-3F * (1 + std::abs(values[i])) ? 0 : 1;
  }
  return static_cast<double>(differ) / static_cast<double>(a.rgb.size());
}

// Every technique, and path tracing, where contributions otherwise meet in the path before they reach the
// film. Paths that rounding turns elsewhere are as many as in whole pictures (DeviceRenders).
TEST_F(Layers, AddUpToThePictureAndAreTheReferences) {
  const PreparedScene prepared = lit_room();
  for (const uint32_t techniques : {TECHNIQUE_HIT | TECHNIQUE_NEE, render::ALL_TECHNIQUES}) {
    const render::RenderSettings settings = with_layers(12, 9, 2, techniques);
    const render::Film film = render(prepared, settings).film;
    ASSERT_EQ(film.layers.size(), 6u);
    for (const bool of_groups : {false, true}) {
      expect_sum(film, of_groups, &render::LightLayer::words, film.words);
      if ((techniques & TECHNIQUE_SPLAT) != 0)
        expect_sum(film, of_groups, &render::LightLayer::splat_words, film.splat_words);
    }
    const auto wanted = check::render_with_reference(prepared, make_plan(prepared, settings),
                                                     [](uint64_t, uint64_t) { return true; });
    for (const render::LightLayer& layer : film.layers) {
      const double share =
          share_of_differences(resolve(film_of_layer(film, layer)), wanted.channels, layer.name);
      std::printf("techniques %u, %s: %.4f of the values differ\n", techniques, layer.name.c_str(), share);
      EXPECT_LE(share, 0.02) << layer.name;
    }
    if (techniques == render::ALL_TECHNIQUES) continue;  // spares kernels
    // The picture is that of a render without layers but for rounding.
    render::RenderSettings plain = settings;
    plain.aovs = 0;
    ASSERT_FALSE(make_plan(prepared, plain).keeps(STATE_LAYERS));
    const image::Image with = resolve(film), without = render(prepared, plain).image;
    for (size_t i = 0; i < with.rgb.size(); ++i)
      EXPECT_NEAR(with.rgb[i], without.rgb[i], 1e-5F * (1 + without.rgb[i]));
  }
}

TEST_F(Layers, GoOnFromAFilmThatWasKept) {
  const PreparedScene prepared = lit_room();
  render::RenderSettings settings = with_layers(12, 9, 2, render::ALL_TECHNIQUES);
  const render::Film whole = render(prepared, settings).film;
  const render::Plan plan = make_plan(prepared, settings);
  render::Renderer first(*device(), prepared, plan);
  first.render([](uint64_t paths, uint64_t) { return paths < 12 * 9; });
  ASSERT_LT(first.film().paths, whole.paths);
  render::Renderer second(*device(), prepared, plan);
  second.resume(first.film());
  second.render([](uint64_t, uint64_t) { return true; });
  for (size_t i = 0; i < whole.layers.size(); ++i) {
    EXPECT_TRUE(second.film().layers[i].words == whole.layers[i].words) << whole.layers[i].name;
    EXPECT_TRUE(second.film().layers[i].splat_words == whole.layers[i].splat_words) << whole.layers[i].name;
  }
}

// A room that emits Le and reflects a everywhere. By hits alone the lamp is Le in each sample, and once
// reflected a Le.
TEST_F(Layers, FurnaceIsEmissionThenDirectThenIndirect) {
  const PreparedScene prepared = prepare(own_scenes() / "furnace/furnace.gltf");
  render::RenderSettings settings = box_filtered(4, 4, 1, 12);
  settings.techniques = TECHNIQUE_HIT;
  settings.aovs = KINDS;
  const render::Film film = render(prepared, settings).film;
  const std::array<float, 3> emitted = {0.5F, 1, 2}, albedo = {0.2F, 0.5F, 0.8F};
  const image::Image emission = resolve(film_of_layer(film, layer_of(film, "emission"))),
                     direct = resolve(film_of_layer(film, layer_of(film, "direct"))),
                     caustics = resolve(film_of_layer(film, layer_of(film, "caustics")));
  for (size_t i = 0; i < emission.rgb.size(); ++i) {
    EXPECT_NEAR(emission.rgb[i], emitted[i % 3], 1e-5);
    EXPECT_NEAR(direct.rgb[i], albedo[i % 3] * emitted[i % 3], 1e-5);
    EXPECT_EQ(caustics.rgb[i], 0);
  }
}

// Glass in a room that emits and reflects nothing: whatever way light takes through it, the lamp is seen.
TEST_F(Layers, WhatGlassShowsOfALampIsEmission) {
  const PreparedScene prepared = prepare(own_scenes() / "furnace/furnace-glass.gltf");
  render::RenderSettings settings = box_filtered(8, 8, 2, 12);
  settings.techniques = TECHNIQUE_HIT;
  settings.aovs = KINDS;
  const render::Film film = render(prepared, settings).film;
  EXPECT_TRUE(layer_of(film, "emission").words == film.words);
  EXPECT_NE(film.words, Words(film.words.size()));
}

// A point light 1 m above a floor and 1 m below a mirror: the mirror's light comes from an image 3 m above
// the floor. Within three edges there is nothing else. Light paths land on the floor at random; the film sees
// one in `landing` of them.
TEST_F(Layers, LightOfAMirrorIsACaustic) {
  GltfScene scene;
  scene.add({quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({-4, -4, 2}, {0, 8, 0}, {8, 0, 0})}, metal({1, 1, 1}, 0));
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  scene.set_perspective(look_at({0, 0, 1.9}, {0, 0, 0}, {0, 1, 0}), 1.2);
  constexpr uint32_t SIDE = 16, SAMPLES = 256;
  render::RenderSettings settings = box_filtered(SIDE, SIDE, SAMPLES, 3);
  settings.techniques = TECHNIQUE_SPLAT;
  settings.aovs = KINDS;
  const render::Film film = render(prepare(scene), settings).film;
  const double half = 1.9 * std::tan(0.6), pixel = 2 * half / SIDE;
  for (const auto& [name, height] : {std::pair("direct", 1.0), std::pair("caustics", 3.0)}) {
    // W/m^2 of a lamp of 1 W/sr at that height is h / d^3; one point in the middle of each of 8 x 8 parts of
    // a pixel.
    double expected = 0, solid_angle = 0;
    constexpr int PARTS = 8;
    for (uint32_t i = 0; i < SIDE * SIDE * PARTS * PARTS; ++i) {
      const double x = (i % (SIDE * PARTS) + 0.5) * pixel / PARTS - half,
                   y = (i / (SIDE * PARTS) + 0.5) * pixel / PARTS - half;
      const double irradiance = height / std::pow(x * x + y * y + height * height, 1.5);
      expected += 0.5 * std::numbers::inv_pi * irradiance / (SIDE * SIDE * PARTS * PARTS);
      solid_angle += irradiance * (pixel / PARTS) * (pixel / PARTS);
    }
    const image::Image found = resolve(film_of_layer(film, layer_of(film, name)));
    double mean = 0;
    for (size_t i = 0; i < found.rgb.size(); i += 3)
      mean += static_cast<double>(found.rgb[i]) / (SIDE * SIDE);
    const double landing = SIDE * SIDE * SAMPLES * solid_angle / (4 * std::numbers::pi);
    // What a path adds varies by less than its mean, so that the relative deviation is at most sqrt(2 /
    // landing).
    const double bound = 5 * std::sqrt(2 / landing);
    std::printf("%s: %.5f, expected %.5f (within %.1f %%)\n", name, mean, expected, 100 * bound);
    EXPECT_NEAR(mean / expected, 1, bound) << name;
  }
  for (const char* name : {"emission", "indirect"}) {
    const render::LightLayer& layer = layer_of(film, name);
    EXPECT_TRUE(layer.splat_words == Words(layer.splat_words.size())) << name;
  }
}

// Two lamps at one place, of 1 and 3 W/sr: `nee` draws them by power, so that each sample belongs to the
// first with probability 1/4. The one has its node's name for a group, the other what its extras say.
TEST_F(Layers, GroupsHoldTheirLamps) {
  GltfScene scene;
  scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.3);
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  scene.add_point_light({0, 0, 1}, {3, 3, 3});
  const TemporaryFolder folder;
  scene.write(folder / "plain.gltf");
  nlohmann::json gltf = nlohmann::json::parse(std::ifstream(folder / "plain.gltf"));
  gltf["nodes"][2]["name"] = "Key";
  gltf["nodes"][3]["extras"]["regulus"]["light_group"] = "fill: left";
  std::ofstream(folder / "named.gltf") << gltf;
  render::RenderSettings settings = box_filtered(9, 9, 64, 2);
  settings.aovs = render::AOV_LIGHTS;
  const render::Film film = render(prepare(folder / "named.gltf"), settings).film;
  ASSERT_EQ(film.layers.size(), 2u);
  EXPECT_EQ(film.layers[0].name, "light_Key");
  EXPECT_EQ(film.layers[1].name, "light_fill__left");
  std::array<double, 2> sums{};
  for (size_t i = 0; i < 2; ++i)
    for (const float value : resolve(film_of_layer(film, film.layers[i])).rgb)
      sums[i] += static_cast<double>(value);
  const double share = sums[0] / (sums[0] + sums[1]), deviation = std::sqrt(0.25 * 0.75 / (9 * 9 * 64));
  std::printf("share of the first lamp %.4f, expected 0.25 (deviation %.4f)\n", share, deviation);
  EXPECT_NEAR(share, 0.25, 5 * deviation);
}

}  // namespace
}  // namespace regulus::test

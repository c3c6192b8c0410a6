// The units of the film: 0 for ordinary light, otherwise what the lights ask for.
#include <gtest/gtest.h>

#include "scene/film_exponents.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// A wall of 1 m^2 and a lamp of this radiance, of half a square metre times `scale`^2.
FilmExponents exponents_of(double radiance, double lamp_scale = 1) {
  Gltf file;
  file.triangle({}, {{"translation", {0, 0, 1}}, {"scale", {2, 1, 1}}});
  json material = {{"emissiveFactor", {1, 1, 1}}};
  material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = radiance;
  file.root["materials"].push_back(material);
  file.triangle({{"material", 0}}, {{"scale", {lamp_scale, lamp_scale, 1}}});
  Scene scene = file.load();
  build_lights(scene);
  return scene.film_exponents;
}

TEST(FilmExponents, AreNoneForOrdinaryLight) {
  for (const double radiance : {1e-6, 1e-3, 1.0, 1e5, 1e9})
    EXPECT_EQ(exponents_of(radiance).radiance, 0) << radiance;
  for (const double radiance : {1e-2, 1.0, 1e4}) EXPECT_EQ(exponents_of(radiance).squares, 0) << radiance;
}

// 2^24 samples of what is brightest fit into 2^55, and what is lit is at least 2^-40 of its own.
TEST(FilmExponents, GiveLightTheRangeThatItNeeds) {
  EXPECT_EQ(exponents_of(0x1p54).radiance, 54 + 24 - 55);
  EXPECT_EQ(exponents_of(0x1p54).squares, 108 + 24 - 55);
  EXPECT_EQ(exponents_of(1e6).squares, 40 + 24 - 55);
  for (const double radiance : {1e-7, 1e-13, 1e-25}) {
    // The lamp's power pi / 2 lights the scene's sphere, its diagonal sqrt(6) / 2: 1 / (12 pi) of the
    // radiance.
    const double level = radiance / (12 * M_PI);
    EXPECT_EQ(exponents_of(radiance).radiance, std::floor(std::log2(level))) << radiance;
    EXPECT_EQ(exponents_of(radiance).squares, std::floor(2 * std::log2(level))) << radiance;
  }
  // A tiny lamp of ordinary radiance whose light is dim: as dim as its own picture allows. Its area is
  // 2^-48.1 of the radius squared, which takes 1.1 bits off the samples.
  const int dim = exponents_of(1, 1e-7).radiance;
  EXPECT_EQ(dim, 0 + 23 - 55);
}

// A lamp of 1 W, however small, leaves a unit that is fine beside what it lights, 1 / (4 pi^2 1.5) W/m^2/sr;
// one sample of the lamp fits.
TEST(FilmExponents, SpecksDoNotHideWhatTheyLight) {
  for (const double size : {1e-3, 1e-6, 1e-8, 1e-10}) {
    const double radiance = 1 / (M_PI * size * size / 2);
    const int exponent = exponents_of(radiance, size).radiance;
    EXPECT_LT(std::ldexp(1.0, exponent - 40), 1e-5 / (4 * M_PI * M_PI * 1.5)) << size;
    EXPECT_LE(radiance, std::ldexp(1.0, exponent + 55)) << size;
  }
}

TEST(FilmExponents, CountEveryKindOfLight) {
  const auto with = [](const std::function<void(Gltf&)>& add) {
    Gltf file;
    file.triangle();
    add(file);
    Scene scene = file.load();
    build_lights(scene);
    return scene.film_exponents.radiance;
  };
  const auto light = [](const char* type, double intensity, double distance) {
    return [=](Gltf& file) {
      file.light({{"type", type}, {"intensity", intensity}}, {{"translation", {0, 0, distance}}});
    };
  };
  EXPECT_LT(with(light("point", 1e-13, 1)), -40);
  EXPECT_LT(with(light("directional", 1e-13, 1)), -40);
  EXPECT_GT(with(light("point", 1e16, 1)), 10);
  EXPECT_GT(with(light("directional", 1e16, 1)), 10);
  // A sun as a point: what arrives counts.
  EXPECT_EQ(with(light("point", 1e25, 1.5e11)), 0);
  const auto environment = [](double radiance) {
    return [=](Gltf& file) {
      file.root["scenes"][0]["extras"]["regulus"]["environment"]["color"] = {radiance, radiance, radiance};
    };
  };
  EXPECT_EQ(with(environment(1)), 0);
  EXPECT_EQ(with(environment(0x1.8p-44)), -44);
  EXPECT_EQ(with(environment(0x1p33)), 33 + 24 - 55);
}

}  // namespace
}  // namespace regulus::scene::test

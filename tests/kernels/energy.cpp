// --energy-compensation on the device: a white surface in even light cannot be seen, at any roughness and
// angle, and a coloured metal has the colour of the series of its bounces, by integrals of the scalar
// reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "energy_albedo.hpp"
#include "reference/bsdf.hpp"
#include "render/energy_tables.hpp"
#include "support/device.hpp"
#include "support/run_length.hpp"

namespace regulus::test {
namespace {

using namespace interface;

struct Model {
  const char* name;
  uint32_t ndf, shadowing;
};
constexpr Model MODELS[] = {{"GGX, Smith", NDF_GGX, SHADOWING_SMITH},
                            {"GGX, uncorrelated Smith", NDF_GGX, SHADOWING_SMITH_UNCORRELATED},
                            {"GGX, V-cavity", NDF_GGX, SHADOWING_V_CAVITY},
                            {"Beckmann, Smith", NDF_BECKMANN, SHADOWING_SMITH},
                            {"Beckmann, V-cavity", NDF_BECKMANN, SHADOWING_V_CAVITY}};
constexpr float ROUGHNESS[] = {0, 0.04f, 0.1f, 0.2f, 0.33f, 0.5f, 0.66f, 0.8f, 0.9f, 1};
constexpr float COSINES[] = {0.03f, 0.06f, 0.1f, 0.2f, 0.31f, 0.45f, 0.6f, 0.75f, 0.9f, 1};
constexpr uint32_t SAMPLES = 1u << 13;

Material white_material() {
  Material material{};
  material.base_color = vec3(1);
  material.roughness = 1;
  material.ior = 1.5f;
  material.specular = 1;
  material.specular_color = vec3(1);
  material.material_class = MATERIAL_CLASS_TRANSMISSIVE;
  material.flags = MATERIAL_VOLUME;
  return material;
}

// Albedos of a material at all of ROUGHNESS (outer) and COSINES.
std::vector<glm::dvec3> albedos(const Model& model, Material material, bool is_front,
                                bool is_compensated = true) {
  render::RenderSettings settings;
  settings.ndf = model.ndf;
  settings.shadowing = model.shadowing;
  const gpu::Buffer tables =
      render::make_energy_tables(*device(), {material}, settings,
                                 {.has_compensation = is_compensated, .has_rough_bases = !is_compensated});
  std::vector<EnergyCase> cases;
  for (const float roughness : ROUGHNESS)
    for (const float cosine : COSINES) {
      material.roughness = roughness;
      cases.push_back({material, device_address(tables.address()), cosine, is_front ? 1u : 0u});
    }
  return energy_albedos(cases, SAMPLES,
                        {{SPEC_NDF, model.ndf},
                         {SPEC_SHADOWING, model.shadowing},
                         {SPEC_ENERGY_COMPENSATION, is_compensated ? 1u : 0u}});
}

// A driver that repeats what another has run takes one model.
std::span<const Model> models_of_this_run() {
  return std::span(MODELS).first(is_repeated_run() ? 1 : std::size(MODELS));
}

// The bound is the one that was set, 1 percent; of it 0.2 are for the sequence of samples.
TEST(EnergyCompensation, WhiteSurfacesReflectAndTransmitEverything) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Material metal = white_material(), plastic = metal, glass = metal, pane = metal;
  metal.metallic = 1;
  glass.transmission = pane.transmission = 1;
  pane.flags = 0;
  const struct {
    const char* name;
    Material material;
    bool is_front;
  } kinds[] = {{"metal", metal, true},
               {"plastic", plastic, true},
               {"glass", glass, true},
               {"glass from inside", glass, false},
               {"pane", pane, true}};
  for (const Model& model : models_of_this_run())
    for (const auto& kind : kinds) {
      double worst = 0, at_roughness = 0, at_cosine = 0;
      const std::vector<glm::dvec3> all = albedos(model, kind.material, kind.is_front);
      for (size_t i = 0; i < all.size(); ++i) {
        const double error = std::abs(all[i].g - 1.0);
        if (error <= worst) continue;
        worst = error;
        at_roughness = ROUGHNESS[i / std::size(COSINES)];
        at_cosine = COSINES[i % std::size(COSINES)];
      }
      std::printf("%-24s %-18s largest error %.4f at roughness %.2f, cosine %.2f\n", model.name, kind.name,
                  worst, at_roughness, at_cosine);
      EXPECT_LT(worst, 0.01) << model.name << ", " << kind.name;
    }
  // Without compensation a third of the light is left at worst.
  const std::vector<glm::dvec3> plain = albedos(MODELS[0], metal, true, false);
  const auto is_darker = [](const glm::dvec3& a, const glm::dvec3& b) { return a.g < b.g; };
  EXPECT_LT(std::min_element(plain.begin(), plain.end(), is_darker)->g, 0.4);
}

// What single scattering at a metal reflects of even light, by the scalar reference.
double single_scattering(const Model& model, double base, double alpha, double cosine) {
  reference::BsdfParameters parameters;
  parameters.base_color = glm::dvec3(base);
  parameters.metallic = 1;
  parameters.alpha = glm::dvec2(alpha);
  parameters.ndf = model.ndf;
  parameters.shadowing = model.shadowing;
  parameters.fresnel_average = 0.1;  // plays no part in a metal
  const reference::Bsdf bsdf(parameters);
  const glm::dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
  constexpr int SIDE = 64;
  double sum = 0;
  for (int i = 0; i < SIDE * SIDE; ++i) {
    const glm::dvec2 u((i % SIDE + 0.5) / SIDE, (i / SIDE + 0.5) / SIDE);
    const double choice = std::fmod(0.5 + 0.6180339887498949 * i, 1.0);
    const reference::BsdfSample sample = bsdf.sample(wo, choice, u, reference::TransportMode::Radiance);
    if (sample.is_valid) sum += sample.weight.x;
  }
  return sum / (SIDE * SIDE);
}

// E F single scattering, (1 - E) F what stays for another bounce, of which E_avg F leaves, and so on (Kulla
// and Conty 2017), with the mean F of all directions, relative to E F.
TEST(EnergyCompensation, MetalsHaveTheColourOfTheirBounces) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr double BASE = 0.4;
  Material material = white_material();
  material.metallic = 1;
  material.base_color = vec3(static_cast<float>(BASE));
  for (const Model& model : {MODELS[0], MODELS[4]}) {
    const std::vector<glm::dvec3> measured = albedos(model, material, true);
    for (const size_t r : {5u, 7u, 9u}) {
      const double alpha = double{ROUGHNESS[r]} * ROUGHNESS[r], fresnel = BASE + (1 - BASE) / 21;
      double mean = 0;  // 2 int E cos dcos
      constexpr int STEPS = 32;
      for (int i = 0; i < STEPS; ++i) {
        const double cosine = (i + 0.5) / STEPS;
        mean += 2 * cosine / STEPS * single_scattering(model, 1, alpha, cosine);
      }
      double worst = 0;
      for (size_t c = 0; c < std::size(COSINES); ++c) {
        const double kept = single_scattering(model, 1, alpha, COSINES[c]);
        const double gain = 1 + (1 - kept) / kept * fresnel * mean / (1 - fresnel * (1 - mean));
        const double known = gain * single_scattering(model, BASE, alpha, COSINES[c]);
        worst = std::max(worst, std::abs(measured[r * std::size(COSINES) + c].g / known - 1));
      }
      std::printf("%-24s roughness %.2f: largest relative error %.4f\n", model.name, ROUGHNESS[r], worst);
      EXPECT_LT(worst, 0.01);
    }
  }
}

}  // namespace
}  // namespace regulus::test

// Diffuse bases under rough dielectrics (shaders/lib/cover.glsl): what they return of even light against an
// independent integral, on the device and by the scalar reference; that they are reciprocal and create no
// light; and that solids which transmit in part are as bright from inside as from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "energy_albedo.hpp"
#include "interface/energy.h"
#include "kernels/bsdf_cases.hpp"
#include "render/energy_tables.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using glm::dvec2;
using glm::dvec3;
using reference::TransportMode;

constexpr float ROUGHNESS[] = {0.2f, 0.3f, 0.5f, 0.7f, 1};
constexpr double ANGLES[] = {0, 45, 60, 75, 85};  // degrees
// E of an interface of index 1.5 at ROUGHNESS (columns) and ANGLES, GGX and height-correlated Smith, to four
// digits: docs/derivations/rough_base.py, which integrates over facets by a midpoint rule.
constexpr double ALBEDO[5][5] = {{0.0400, 0.0397, 0.0370, 0.0286, 0.0127},
                                 {0.0506, 0.0508, 0.0462, 0.0343, 0.0173},
                                 {0.0892, 0.0868, 0.0669, 0.0446, 0.0234},
                                 {0.2407, 0.2037, 0.1163, 0.0695, 0.0376},
                                 {0.4794, 0.3402, 0.1776, 0.1048, 0.0611}};
// Quasi-Monte Carlo with 2048 points per node, of which the tables' bilinear interpolation adds as much
// again.
constexpr double TABLE_ERROR = 2e-3;
constexpr uint32_t SAMPLES = 1u << 16;
constexpr double SAMPLING_ERROR = 1.5e-3;  // of the R3 sequence with so many points
// From inside the integrand jumps where total reflection begins.
constexpr double JUMP_ERROR = 4e-3;

constexpr Model GGX_SOLID{NDF_GGX, SHADOWING_SMITH, MATERIAL_CLASS_TRANSMISSIVE};

double cosine_of(double degrees) {
  return std::cos(degrees * 0.017453292519943295);
}

/// What a material returns and passes on of even light on the device, at `roughness` x `cosines`.
std::vector<double> on_device(Material material, bool is_front, const std::vector<float>& roughness,
                              const std::vector<double>& cosines) {
  const gpu::Buffer tables = cover_tables(GGX_SOLID);
  std::vector<EnergyCase> cases;
  for (const float r : roughness)
    for (const double cosine : cosines) {
      material.roughness = r;
      cases.push_back(
          {material, device_address(tables.address()), static_cast<float>(cosine), is_front ? 1u : 0u});
    }
  std::vector<double> greens;
  for (const glm::dvec3& albedo : energy_albedos(cases, SAMPLES, {{SPEC_ENERGY_COMPENSATION, 0u}}))
    greens.push_back(albedo.g);
  return greens;
}

ReferenceCase case_at(Material material, bool is_front, float roughness, double cosine, double cosine_i = 1) {
  BsdfCase c{};
  material.roughness = roughness;
  c.material = material;
  c.alpha = vec3(-1);
  c.is_front = is_front ? 1 : 0;
  c.wo = dvec3(std::sqrt(1 - cosine * cosine), 0, cosine);
  c.wi = dvec3(std::sqrt(1 - cosine_i * cosine_i), 0, cosine_i);
  c.tables = {1, 0};
  return reference_case(c, GGX_SOLID);
}

/// What the diffuse lobe of the scalar reference returns of even light, by the midpoint rule in cos^2.
double diffuse_of_reference(const Material& material, bool is_front, float roughness, double cosine) {
  constexpr int STEPS = 2048;
  double sum = 0;
  for (int i = 0; i < STEPS; ++i) {
    const ReferenceCase r = case_at(material, is_front, roughness, cosine, std::sqrt((i + 0.5) / STEPS));
    sum += std::numbers::pi * r.bsdf.with_alpha(dvec2(0)).value(r.wo, r.wi, TransportMode::Radiance).y;
  }
  return sum / STEPS;
}

TEST(RoughBase, ReturnsItsColourOfWhatTheInterfaceLeaves) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  constexpr double BASE = 0.8;
  Material plastic = plain_material(Kind::Plastic, 1);
  plastic.base_color = vec3(static_cast<float>(BASE));
  std::vector<double> cosines;
  for (const double angle : ANGLES) cosines.push_back(cosine_of(angle));
  const std::vector<double> device =
      on_device(plastic, true, {std::begin(ROUGHNESS), std::end(ROUGHNESS)}, cosines);
  double worst_device = 0, worst_reference = 0;
  for (size_t r = 0; r < 5; ++r)
    for (size_t a = 0; a < 5; ++a) {
      const double known = ALBEDO[a][r] + BASE * (1 - ALBEDO[a][r]);
      worst_device = std::max(worst_device, std::abs(device[r * 5 + a] - known));
      worst_reference = std::max(
          worst_reference,
          std::abs(ALBEDO[a][r] + diffuse_of_reference(plastic, true, ROUGHNESS[r], cosines[a]) - known));
    }
  std::printf("largest error of the device %.5f, of the reference %.5f\n", worst_device, worst_reference);
  EXPECT_LT(worst_device, TABLE_ERROR + SAMPLING_ERROR);
  EXPECT_LT(worst_reference, TABLE_ERROR);
}

// Whatever is metal, clear or coloured at normal incidence: no more than all light, at any roughness on both
// sides of the join.
TEST(RoughBase, CreatesNoLight) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Material white = plain_material(Kind::Plastic, 1), dark = white, alloy = white, half = white, pane = white;
  dark.specular = 0.5f;
  dark.specular_color = {1, 0.2f, 0};
  alloy.metallic = 0.5f;
  half.material_class = pane.material_class = MATERIAL_CLASS_TRANSMISSIVE;
  half.transmission = pane.transmission = 0.5f;
  half.flags = MATERIAL_VOLUME;
  const std::vector<float> roughness = {0.12f, 0.16f, 0.2f, 0.35f, 0.6f, 1};
  const std::vector<double> cosines = {0.03, 0.1, 0.3, 0.6, 0.74, 0.8, 1};
  const struct {
    const char* name;
    Material material;
    bool is_front;
  } kinds[] = {{"white", white, true},     {"dark coloured", dark, true},       {"alloy", alloy, true},
               {"half solid", half, true}, {"half solid, inside", half, false}, {"half pane", pane, true}};
  for (const auto& kind : kinds) {
    const std::vector<double> all = on_device(kind.material, kind.is_front, roughness, cosines);
    const auto found = std::max_element(all.begin(), all.end());
    const double most = *found;
    const size_t place = static_cast<size_t>(found - all.begin());
    std::printf("%-20s at most %.5f, at roughness %.2f and cosine %.2f\n", kind.name, most,
                roughness[place / cosines.size()], cosines[place % cosines.size()]);
    // From inside .0039 at roughness .12 and cosine .8, beside the critical angle, are the join's: facets in
    // the tail lie beyond that angle, so that the interface reflects .1241 where a smooth one, which has nine
    // tenths of the share there, reflects .1141: (1 - .5) .9 (.1241 - .1141) = .0045 too much for the base.
    EXPECT_LT(most, 1 + TABLE_ERROR + SAMPLING_ERROR + (kind.is_front ? 0 : JUMP_ERROR)) << kind.name;
  }
}

TEST(RoughBase, IsReciprocal) {
  double worst = 0;
  for (const float roughness : {0.15f, 0.3f, 0.8f})
    for (const bool is_front : {true, false}) {
      BsdfCase c{};
      c.material = plain_material(Kind::Mixed, roughness);
      c.alpha = vec3(-1);
      c.is_front = is_front ? 1 : 0;
      c.wo = glm::normalize(dvec3(0.3, 0.2, 0.4));
      c.wi = glm::normalize(dvec3(-0.9, 0.3, 0.1));
      c.tables = {1, 0};
      const ReferenceCase r = reference_case(c, GGX_SOLID);
      const dvec3 forward = r.bsdf.value(r.wo, r.wi, TransportMode::Radiance);
      const dvec3 back = r.bsdf.value(r.wi, r.wo, TransportMode::Radiance);
      worst = std::max(worst, std::abs(forward.y / back.y - 1));
    }
  EXPECT_LT(worst, 1e-6);  // the directions are unit vectors in floats
}

// A smooth interface loses nothing, from neither side: what the diffuse lobe returns is 1 - t of what passes
// the interface. From inside its integrand jumps where total reflection begins, which the device's points
// feel.
TEST(RoughBase, HalfClearSolidsKeepAllLightOnBothSides) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Material half = plain_material(Kind::Solid, 0);
  half.transmission = 0.5f;
  const std::vector<double> cosines = {0.05, 0.3, 0.7, 0.9, 1};
  for (const bool is_front : {true, false}) {
    for (const double all : on_device(half, is_front, {0.0f}, cosines))
      EXPECT_NEAR(all, 1, SAMPLING_ERROR + (is_front ? 0 : JUMP_ERROR));
    for (const float ior : {1.1f, 1.5f, 2.4f})
      for (const double cosine : cosines) {
        half.ior = ior;
        const double diffuse = diffuse_of_reference(half, is_front, 0, cosine);
        const double passed = 1 - reference::fresnel_dielectric(cosine, is_front ? ior : 1 / double{ior});
        EXPECT_NEAR(diffuse, 0.5 * passed, 3e-4) << ior << (is_front ? " front " : " back ") << cosine;
      }
    half.ior = 1.5f;
  }
}

// Device and reference make their tables by code of their own. A sum of 2048 numbers up to 1 is off by some
// ten roundings of 6e-8 each; of facets that stand within .01 of the normal (the first row, of which nothing
// counts yet) single precision knows the masking to 2e-5 only.
TEST(RoughBase, TablesOfDeviceAndReferenceAgree) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const gpu::Buffer buffer = cover_tables(GGX_SOLID);
  const std::vector<float> words =
      gpu::download_all<float>(*device(), buffer, ENERGY_PER_INDEX + ENERGY_INDEX_WORDS);
  const reference::EnergyTables tables({1.5f}, NDF_GGX, SHADOWING_SMITH);
  for (const bool is_inside : {false, true})
    for (uint32_t row = 0; row < COVER_ROWS; row += 7) {
      const size_t side = ENERGY_PER_INDEX + ENERGY_COVERS + (is_inside ? COVER_SIDE_WORDS : 0);
      const double roughness = 0.1 + 0.9 * row / (COVER_ROWS - 1.0);
      double worst = 0;
      const auto compare = [&](uint32_t pair, const dvec2& known) {
        const size_t word = side + 2 * pair;
        worst = std::max({worst, std::abs(words[word] - known.x), std::abs(words[word + 1] - known.y)});
      };
      for (uint32_t node = 0; node < ENERGY_NODES; node += 3) {
        const double root = node / (ENERGY_NODES - 1.0);
        compare(row * ENERGY_NODES + node, tables.cover(0, root * root, roughness, is_inside));
      }
      compare(COVER_NODES + row, tables.cover_mean(0, roughness, is_inside));
      std::printf("%s, roughness %.2f: largest difference %.2e\n", is_inside ? "inside" : "outside",
                  roughness, worst);
      EXPECT_LT(worst, row == 0 ? 4e-5 : 6e-6);
    }
}

}  // namespace
}  // namespace regulus::test

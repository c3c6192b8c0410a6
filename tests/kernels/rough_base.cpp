// Diffuse bases under rough dielectrics (shaders/lib/cover.glsl): what they return of even light against an
// independent integral, on the device and by the scalar reference; that they are reciprocal and create no
// light; and that solids which transmit in part are as bright from inside as from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <span>
#include <utility>

#include "energy_albedo.hpp"
#include "interface/energy.h"
#include "kernels/bsdf_cases.hpp"
#include "reference/fresnel.hpp"
#include "render/energy_tables.hpp"
#include "support/device.hpp"
#include "support/run_length.hpp"

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
// Where facets begin to reflect totally, their reflectance jumps by less than 1. In the square of the two
// numbers that draw a facet it does so along a curve, no longer than 2, which passes through 2 sqrt(2048) =
// 91 of the cells that hold a point each; what such a cell adds is wrong by half a point, to either side. So
// nodes beside the critical angle deviate by sqrt(91) / 2 / 2048, and hardly ever by four times as much.
constexpr double NODE_DEVIATION = 2.4e-3;
// From inside, beside the critical angle, E falls by a half within a distance of alpha in angle, and from one
// row of the tables to the next alpha doubles: there linear interpolation itself errs by up to .012. Tests
// from inside therefore expect what interpolating exact nodes gives, and that this is good enough: of what a
// half-clear solid returns to white, half of the error has to stay below one step of an 8-bit sRGB picture.
constexpr double SRGB_STEP = 0.0088;  // 1 - ((254 / 255 + .055) / 1.055)^2.4
constexpr float INSIDE_ROUGHNESS[] = {0.03f, 0.06f, 0.1f, 0.12f, 0.16f, 0.2f, 0.35f, 0.7f};

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
  } kinds[] = {{"half solid", half, true}, {"half solid, inside", half, false},
               {"white", white, true},     {"dark coloured", dark, true},
               {"alloy", alloy, true},     {"half pane", pane, true}};
  // A driver that repeats what another has run takes the first two.
  for (const auto& kind : std::span(kinds).first(is_repeated_run() ? 2 : std::size(kinds))) {
    const std::vector<double> all = on_device(kind.material, kind.is_front, roughness, cosines);
    const auto found = std::max_element(all.begin(), all.end());
    const double most = *found;
    const size_t place = static_cast<size_t>(found - all.begin());
    std::printf("%-20s at most %.5f, at roughness %.2f and cosine %.2f\n", kind.name, most,
                roughness[place / cosines.size()], cosines[place % cosines.size()]);
    EXPECT_LT(most, 1 + TABLE_ERROR + SAMPLING_ERROR) << kind.name;
  }
}

/// E of GGX facets seen from inside a solid of index `ior`, with height-correlated Smith shadowing, by the
/// midpoint rule over facets (docs/derivations/rough_base.py).
double albedo_from_inside(double cosine, double alpha, double ior) {
  constexpr int STEPS_U = 2048, STEPS_PHI = 64;
  const auto lambda = [&](double c) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)) - 1);
  };
  const double sine = std::sqrt(1 - cosine * cosine), lambda_o = lambda(cosine);
  double sum = 0;
  for (int k = 0; k < STEPS_U; ++k) {
    const double x = (k + 0.5) / STEPS_U, u = x * x * (3 - 2 * x);
    const double t2 = alpha * alpha * u / (1 - u), z = 1 / std::sqrt(1 + t2), s = std::sqrt(t2) * z;
    for (int j = 0; j < STEPS_PHI; ++j) {
      const double c = sine * s * std::cos(std::numbers::pi * (j + 0.5) / STEPS_PHI) + cosine * z;
      const double mirrored = 2 * c * z - cosine;
      if (c <= 0 || mirrored <= 0) continue;
      sum += 6 * x * (1 - x) * c / (cosine * z * (1 + lambda_o + lambda(std::min(mirrored, 1.0)))) *
             reference::fresnel_dielectric(c, 1 / ior);
    }
  }
  return sum / STEPS_U / STEPS_PHI;
}

/// Of the tables' directions, for an index (interface/energy.h).
double cosine_of_node(uint32_t node, bool is_inside, double ior = 1.5) {
  const double critical = std::sqrt(1 - 1 / (ior * ior));
  const double last = ENERGY_NODES - 1.0, middle = COVER_CRITICAL_NODE;
  if (!is_inside) return std::pow(node / last, 2);
  if (node >= middle) return critical + (1 - critical) * std::pow((node - middle) / (last - middle), 2);
  const double x = node / middle;
  return critical * x * x / (x * x + (1 - x) * (1 - x));
}

/// What tables of exact nodes would give: `albedo_from_inside` at the four nodes around, interpolated in the
/// tables' coordinates.
class ExactNodes {
 public:
  explicit ExactNodes(double ior) : ior_(ior) {}

  double at(double cosine, double roughness) {
    const double row = std::sqrt(roughness) * (COVER_ROWS - 1), column = column_of(cosine);
    const auto first_row = static_cast<uint32_t>(row), first_column = static_cast<uint32_t>(column);
    const auto along = [&](uint32_t r) {
      return std::lerp(node(first_column, r), node(first_column + 1, r), column - first_column);
    };
    return std::lerp(along(first_row), along(first_row + 1), row - first_row);
  }

 private:
  /// The inverse of `cosine_of_node`.
  double column_of(double cosine) const {
    const double last = ENERGY_NODES - 1.0, middle = COVER_CRITICAL_NODE;
    const double critical = cosine_of_node(COVER_CRITICAL_NODE, true, ior_);
    if (cosine >= critical) return middle + (last - middle) * std::sqrt((cosine - critical) / (1 - critical));
    const double odds = std::sqrt(cosine / (critical - cosine));  // x / (1 - x)
    return middle * odds / (1 + odds);
  }
  double node(uint32_t column, uint32_t row) {
    const auto [found, is_new] = known_.try_emplace({std::min(column, ENERGY_NODES - 1), row}, 0.0);
    if (is_new)
      found->second = albedo_from_inside(cosine_of_node(found->first.first, true, ior_),
                                         std::pow(row / (COVER_ROWS - 1.0), 4), ior_);
    return found->second;
  }

  double ior_;
  std::map<std::pair<uint32_t, uint32_t>, double> known_;
};

// The base of a solid that transmits in part gets from inside what facets of its interface do not reflect, at
// every roughness, beside the critical angle too, where facets of a distribution's tail lie beyond it: what a
// half-clear solid sends anywhere, less half of what a clear one does, is half of E + (1 - E), where the
// base's E comes from the tables.
TEST(RoughBase, HalfClearSolidsKeepAllLightBesideTheCriticalAngle) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::vector<double> cosines = {0.05, 0.4, 0.7, 0.735, 0.7454, 0.75, 0.76, 0.78, 0.8, 0.9, 1};
  Material half = plain_material(Kind::Solid, 0);
  Material clear = half;
  half.transmission = 0.5f;
  clear.transmission = 1;
  ExactNodes exact(1.5);
  double worst = 0, worst_loss = 0;
  for (const float r : {0.03f, 0.12f, 0.2f}) {
    const std::vector<double> all = on_device(half, false, {r}, cosines);
    const std::vector<double> of_clear = on_device(clear, false, {r}, cosines);
    for (size_t i = 0; i < all.size(); ++i) {
      const double of_base = 1 - exact.at(cosines[i], r);
      const double known = 0.5 * (albedo_from_inside(cosines[i], double{r} * r, 1.5) + of_base);
      worst = std::max(worst, std::abs(all[i] - 0.5 * of_clear[i] - known));
      worst_loss = std::max(worst_loss, std::abs(known - 0.5));
    }
  }
  std::printf("largest error %.5f; interpolation gains or loses %.5f\n", worst, worst_loss);
  EXPECT_LT(worst, 0.5 * 4 * NODE_DEVIATION + SAMPLING_ERROR);
  EXPECT_LT(worst_loss, SRGB_STEP);
}

TEST(RoughBase, TablesFromInsideKnowTheCriticalAngle) {
  for (const float ior : {1.1f, 1.5f, 2.4f}) {
    const reference::EnergyTables tables({ior}, NDF_GGX, SHADOWING_SMITH);
    const double normal = reference::fresnel_normal_incidence(ior);
    const double critical = std::sqrt(1 - 1 / (double{ior} * ior));
    ExactNodes exact(ior);
    double worst = 0, squares = 0, worst_between = 0;
    int count = 0;
    for (const float r : INSIDE_ROUGHNESS)
      for (const double beyond : {-0.3, -0.03, -0.01, -0.003, 0.0, 0.001, 0.003, 0.01, 0.02, 0.04, 0.08}) {
        const dvec2 albedo = tables.cover(0, critical + beyond, r, true);
        const double known = exact.at(critical + beyond, r);
        const double error = normal * albedo.x + (1 - normal) * albedo.y - known;
        worst = std::max(worst, std::abs(error));
        squares += error * error;
        ++count;
        const double truth = albedo_from_inside(critical + beyond, double{r} * r, ior);
        worst_between = std::max(worst_between, std::abs(known - truth));
      }
    const double deviation = std::sqrt(squares / count);
    std::printf("index %.1f: nodes deviate by %.5f, at most %.5f, between nodes %.5f\n", ior, deviation,
                worst, worst_between);
    EXPECT_LT(deviation, NODE_DEVIATION);
    EXPECT_LT(worst, 4 * NODE_DEVIATION);
    EXPECT_LT(0.5 * worst_between, SRGB_STEP);
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
      const double x = row / (COVER_ROWS - 1.0), roughness = is_inside ? x * x : 0.1 + 0.9 * x;
      double worst = 0;
      const auto compare = [&](uint32_t pair, const dvec2& known) {
        const size_t word = side + 2 * pair;
        worst = std::max({worst, std::abs(words[word] - known.x), std::abs(words[word + 1] - known.y)});
      };
      for (uint32_t node = 0; node < ENERGY_NODES; node += 3) {
        compare(row * ENERGY_NODES + node,
                tables.cover(0, cosine_of_node(node, is_inside), roughness, is_inside));
      }
      compare(COVER_NODES + row, tables.cover_mean(0, roughness, is_inside));
      std::printf("%s, roughness %.2f: largest difference %.2e\n", is_inside ? "inside" : "outside",
                  roughness, worst);
      EXPECT_LT(worst, row == 0 ? 4e-5 : 6e-6);
    }
}

}  // namespace
}  // namespace regulus::test

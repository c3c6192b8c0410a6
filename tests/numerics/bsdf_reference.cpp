// The double-precision scattering model alone, against what can be known without it: closed forms,
// normalizations that define a quantity, energy, reciprocity. Quadrature errors are bounded by comparing two
// resolutions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reference/bsdf.hpp"
#include "reference/quadrature.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using std::numbers::pi;

constexpr uint32_t NDFS[] = {NDF_GGX, NDF_BECKMANN, NDF_COSINE};
constexpr uint32_t SHADOWINGS[] = {SHADOWING_SMITH, SHADOWING_SMITH_UNCORRELATED, SHADOWING_V_CAVITY};
const char* const NDF_NAMES[] = {"GGX", "Beckmann", "Cosine"};
const char* const SHADOWING_NAMES[] = {"Smith", "Smith uncorrelated", "V-cavity"};

dvec3 direction(double theta, double phi = 0.3) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// Integral of f(h) over the hemisphere, in coordinates that follow the roughness: tan(theta) = alpha x / (1
/// - x).
template <typename Function>
double integrate_normals(const Function& f, const dvec2& alpha, int pieces = 24) {
  return integrate_2d(
      [&](double phi, double x) {
        const double t = x / (1 - x);
        const dvec3 slope(alpha.x * t * std::cos(phi), alpha.y * t * std::sin(phi), 1);
        const dvec3 h = normalize(slope);
        // d omega = cos^3 dp dq, dp dq = alpha_x alpha_y t dt dphi.
        return f(h) * h.z * h.z * h.z * alpha.x * alpha.y * t / ((1 - x) * (1 - x));
      },
      0, 2 * pi, pieces, 0, 1, pieces);
}

TEST(Fresnel, KnownValues) {
  // Normal incidence, Brewster's angle (tan = eta: parallel light vanishes, and the reflected perpendicular
  // amplitude is (1 - eta^2) / (1 + eta^2)), grazing incidence, total reflection, matched media.
  for (const double eta : {1.1, 1.5, 2.4, 1 / 1.5}) {
    EXPECT_NEAR(fresnel_dielectric(1, eta), std::pow((eta - 1) / (eta + 1), 2), 1e-15);
    const double perpendicular = (1 - eta * eta) / (1 + eta * eta);
    EXPECT_NEAR(fresnel_dielectric(1 / std::sqrt(1 + eta * eta), eta), 0.5 * perpendicular * perpendicular,
                1e-15);
    EXPECT_NEAR(fresnel_dielectric(0, eta), 1, 1e-15);
  }
  const double critical_cos = std::sqrt(1 - 1 / (1.5 * 1.5));
  EXPECT_EQ(fresnel_dielectric(critical_cos - 1e-9, 1 / 1.5), 1);
  EXPECT_LT(fresnel_dielectric(critical_cos + 1e-9, 1 / 1.5), 1);
  EXPECT_EQ(fresnel_dielectric(0.3, 1), 0);
}

TEST(Fresnel, IsTheSameFromBothSides) {
  for (const double cos_outside : {0.02, 0.3, 0.77, 1.0}) {
    const double cos_inside = std::sqrt(1 - (1 - cos_outside * cos_outside) / (1.5 * 1.5));
    EXPECT_NEAR(fresnel_dielectric(cos_outside, 1.5), fresnel_dielectric(cos_inside, 1 / 1.5), 1e-13);
  }
}

TEST(Fresnel, AverageObeysTheIdentityOfBothSides) {
  // n^2 (1 - F_avg(inside)) = 1 - F_avg(outside): what enters a medium through a point in isotropic light is
  // what leaves it. And the published average for water and glass (Kubelka; Egan and Hilgeman 1979): 0.0666
  // for 1.33 (fresh water, 0.066) and 0.0918 for 1.5.
  for (const double eta : {1 + 1e-4, 1.1, 1.33, 1.5, 2.0, 3.0})
    EXPECT_NEAR(eta * eta * (1 - fresnel_dielectric_average(1 / eta)), 1 - fresnel_dielectric_average(eta),
                1e-9)
        << "eta " << eta;
  EXPECT_NEAR(fresnel_dielectric_average(1.5), 0.0918, 5e-5);
  EXPECT_EQ(fresnel_dielectric_average(1), 0);
}

TEST(Fresnel, SpecularRemapKeepsEnds) {
  const auto plain = SpecularDielectric::make(1.5, 1, dvec3(1));
  EXPECT_NEAR(plain.reflectance(0.37, 1.5).x, fresnel_dielectric(0.37, 1.5), 1e-15);
  const auto half = SpecularDielectric::make(1.5, 0.5, dvec3(1, 0.5, 100));
  EXPECT_NEAR(half.reflectance(1, 1.5).x, 0.02, 1e-15);
  EXPECT_NEAR(half.reflectance(1, 1.5).y, 0.01, 1e-15);
  EXPECT_NEAR(half.reflectance(1, 1.5).z, 0.5, 1e-15);
  EXPECT_NEAR(half.reflectance(0, 1.5).y, 0.5, 1e-15);
  EXPECT_EQ(SpecularDielectric::make(1.5, 0, dvec3(1)).reflectance(0.2, 1.5), dvec3(0));
}

TEST(Microfacet, DistributionProjectsToUnitArea) {
  for (const uint32_t ndf : NDFS)
    for (const dvec2 alpha : {dvec2(0.001), dvec2(0.1), dvec2(1), dvec2(0.1, 0.4)}) {
      if (ndf == NDF_COSINE && alpha.x != alpha.y) continue;
      const Microsurface surface{ndf, SHADOWING_SMITH, alpha};
      const double area =
          integrate_normals([&](const dvec3& h) { return distribution(surface, h) * h.z; }, alpha);
      EXPECT_NEAR(area, 1, 1e-7) << NDF_NAMES[ndf] << " alpha " << alpha.x << " " << alpha.y;
    }
}

TEST(Microfacet, VisibleNormalsProjectToTheCosine) {
  // int G1 D <wo, h> dh = cos_o defines Smith's Lambda, and holds for V-cavities.
  double worst = 0;
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : {SHADOWING_SMITH, SHADOWING_V_CAVITY})
      for (const double theta : {0.0, 0.7, 1.4, 1.55})
        for (const dvec2 alpha : {dvec2(0.05), dvec2(0.6), dvec2(0.2, 0.5)}) {
          if (ndf == NDF_COSINE && alpha.x != alpha.y) continue;
          const Microsurface surface{ndf, shadowing, alpha};
          const dvec3 wo = direction(theta);
          const double g1 = shadowing == SHADOWING_SMITH ? 1 / (1 + lambda(surface, wo)) : 0;
          const auto visible = [&](const dvec3& h) {
            return (g1 > 0 ? g1 : masking(surface, wo, h)) * distribution(surface, h) *
                   std::max(0.0, dot(wo, h));
          };
          const double cosine = integrate_normals(visible, alpha, 64);
          worst = std::max(worst, std::abs(cosine / wo.z - 1));
          // The clamped cosine has a kink, so the rule converges only algebraically: error about (1 / 512)^2.
          EXPECT_NEAR(cosine / wo.z, 1, 1e-4) << NDF_NAMES[ndf] << " " << SHADOWING_NAMES[shadowing]
                                              << " theta " << theta << " alpha " << alpha.x;
        }
  std::printf("largest relative error of the projected area %.1e (bound 1e-4)\n", worst);
}

TEST(Microfacet, CosineLambdaTendsToBeckmanns) {
  // Walter 2007 uses Beckmann's Lambda for narrow Cosine lobes; the difference is of order alpha^2.
  for (const double alpha : {0.1, 0.01}) {
    double worst = 0;
    for (const double theta : {0.3, 0.8, 1.2, 1.5, 1.5608}) {
      const Microsurface surface{NDF_COSINE, SHADOWING_SMITH, dvec2(alpha)};
      const dvec3 w = direction(theta);
      worst =
          std::max(worst, std::abs(1 / (1 + lambda(surface, w)) - 1 / (1 + lambda_cosine_walter(alpha, w))));
    }
    std::printf("alpha %.2f: largest difference of G1 %.2e (bound alpha^2 / 2)\n", alpha, worst);
    EXPECT_LT(worst, 0.5 * alpha * alpha);
  }
}

TEST(Microfacet, SampledNormalsHaveTheirDensity) {
  // The mean of any function over samples equals its integral: first and second moments of slopes' bounded
  // images, within 5 standard errors (false alarm below 1e-6 each, 1e-4 in all).
  constexpr int SAMPLES = 40000;
  test::Random random(11);
  const auto image = [](const dvec3& h) { return dvec3(h.x, h.y, h.x * h.x - 0.5 * h.x * h.y + h.z); };
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : {SHADOWING_SMITH, SHADOWING_V_CAVITY})
      for (const double theta : {0.2, 1.0, 1.5}) {
        const Microsurface surface{ndf, shadowing, dvec2(0.5)};
        const dvec3 wo = direction(theta, 0.8);
        dvec3 sum(0), squares(0);
        for (int i = 0; i < SAMPLES; ++i) {
          double u_choice = random.uniform();
          const dvec3 value = image(sample_visible_normal(surface, wo, random.square(), u_choice));
          sum += value;
          squares += value * value;
        }
        const dvec3 mean = sum / double(SAMPLES);
        const dvec3 error = sqrt((squares / double(SAMPLES) - mean * mean) / double(SAMPLES));
        for (int axis = 0; axis < 3; ++axis) {
          const double expected = integrate_normals(
              [&](const dvec3& h) { return image(h)[axis] * visible_normal_pdf(surface, wo, h); }, dvec2(0.5),
              40);
          EXPECT_NEAR(mean[axis], expected, 5 * error[axis] + 1e-4)
              << NDF_NAMES[ndf] << " " << SHADOWING_NAMES[shadowing] << " theta " << theta << " axis "
              << axis;
        }
      }
}

/// Integrals of value |cos_i| (first channel) and of the pdf over all wi: plain cells over the sphere, so
/// that the Jacobians of half vectors are checked, too.
struct Sums {
  double albedo = 0, pdf = 0;
};
Sums integrate_sphere(const Bsdf& bsdf, const dvec3& wo, TransportMode mode, int pieces) {
  Sums sums;
  // Cosines are squared at the horizon, where Smith terms have square-root behaviour.
  for (const int side : {1, -1}) {
    const auto direction_of = [&](double x, double phi) {
      const double z = x * x;
      const double sin_theta = std::sqrt(1 - z * z);
      return dvec3(sin_theta * std::cos(phi), sin_theta * std::sin(phi), side * z);
    };
    sums.albedo += integrate_2d(
        [&](double x, double phi) {
          const dvec3 wi = direction_of(x, phi);
          return bsdf.value(wo, wi, mode).x * std::abs(wi.z) * 2 * x;
        },
        0, 1, pieces, 0, 2 * pi, 2 * pieces);
    sums.pdf += integrate_2d([&](double x, double phi) { return bsdf.pdf(wo, direction_of(x, phi)) * 2 * x; },
                             0, 1, pieces, 0, 2 * pi, 2 * pieces);
  }
  return sums;
}

TEST(WhiteFurnace, GgxLosesTheKnownSingleScatteringEnergy) {
  // Directional albedo of GGX with F = 1; at normal incidence and alpha = 1 analytically 1 - ln 2; other
  // values from an independent computation with 4 decimals (uncorrelated, then height-correlated Smith).
  struct Case {
    uint32_t shadowing;
    double alpha, cos_o, albedo, bound;
  };
  const Case cases[] = {
      {SHADOWING_SMITH, 1.0, 1.0, 1 - std::numbers::ln2, 1e-4},
      {SHADOWING_SMITH_UNCORRELATED, 1.0, 1.0, 1 - std::numbers::ln2, 1e-4},
      {SHADOWING_SMITH_UNCORRELATED, 0.3, 0.5, 0.8181, 2e-3},
      {SHADOWING_SMITH_UNCORRELATED, 0.5, 0.2, 0.7381, 2e-3},
      {SHADOWING_SMITH, 0.3, 0.5, 0.8207, 2e-3},
      {SHADOWING_SMITH, 0.5, 0.2, 0.7897, 2e-3},
      {SHADOWING_SMITH, 1.0, 0.1, 0.7610, 2e-3},
  };
  for (const Case& c : cases) {
    BsdfParameters parameters;
    parameters.base_color = dvec3(1);
    parameters.metallic = 1;
    parameters.alpha = dvec2(c.alpha);
    parameters.shadowing = c.shadowing;
    const double albedo =
        integrate_sphere(Bsdf(parameters), direction(std::acos(c.cos_o)), TransportMode::Radiance, 24).albedo;
    std::printf("GGX %s alpha %.2f cos %.2f: albedo %.5f, known %.5f\n", SHADOWING_NAMES[c.shadowing],
                c.alpha, c.cos_o, albedo, c.albedo);
    EXPECT_NEAR(albedo, c.albedo, c.bound);
  }
}

std::vector<BsdfParameters> materials_for_energy(uint32_t ndf, uint32_t shadowing, double alpha) {
  BsdfParameters white;
  white.base_color = dvec3(1);
  white.alpha = dvec2(alpha);
  white.ndf = ndf;
  white.shadowing = shadowing;
  BsdfParameters metal = white;
  metal.metallic = 1;
  BsdfParameters thin = white;
  thin.transmission = 1;
  BsdfParameters solid = thin;
  solid.is_volume = true;
  BsdfParameters mixed = solid;
  mixed.transmission = 0.5;
  mixed.metallic = 0.25;
  return {white, metal, thin, solid, mixed};
}

TEST(WhiteFurnace, NoModelCreatesEnergyAndPdfsIntegrateToAtMostOne) {
  double most_energy = 0;
  double most_pdf = 0;
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : SHADOWINGS)
      for (const double alpha : {0.2, 0.9})
        for (const double cos_o : {1.0, 0.4, -0.15}) {
          for (const BsdfParameters& parameters : materials_for_energy(ndf, shadowing, alpha)) {
            const Sums sums =
                integrate_sphere(Bsdf(parameters), direction(std::acos(cos_o)), TransportMode::Importance, 8);
            most_energy = std::max(most_energy, sums.albedo);
            most_pdf = std::max(most_pdf, sums.pdf);
            EXPECT_LE(sums.albedo, 1 + 2e-3)
                << NDF_NAMES[ndf] << " " << SHADOWING_NAMES[shadowing] << " alpha " << alpha << " cos "
                << cos_o << " metallic " << parameters.metallic << " transmission "
                << parameters.transmission;
            EXPECT_LE(sums.pdf, 1 + 2e-3);
          }
        }
  std::printf("largest directional albedo %.5f, largest pdf integral %.5f (bound 1 + quadrature 0.002)\n",
              most_energy, most_pdf);
}

TEST(WhiteFurnace, SmoothInterfaceOverDiffuseKeepsAllEnergy) {
  // Delta reflection plus coupled diffuse base of albedo 1: exactly 1 at every angle.
  BsdfParameters parameters;
  parameters.base_color = dvec3(1);
  parameters.alpha = dvec2(0);
  const Bsdf bsdf(parameters);
  for (const double theta : {0.0, 0.6, 1.2, 1.5}) {
    const dvec3 wo = direction(theta);
    const double diffuse = integrate_2d(
        [&](double z, double phi) {
          const double sin_theta = std::sqrt(1 - z * z);
          return bsdf.value(wo, {sin_theta * std::cos(phi), sin_theta * std::sin(phi), z},
                            TransportMode::Radiance)
                     .x *
                 z;
        },
        0, 1, 40, 0, 2 * pi, 2);
    EXPECT_NEAR(diffuse + fresnel_dielectric(wo.z, 1.5), 1, 1e-6) << "theta " << theta;
  }
}

// What the diffuse lobe of a solid that is clear in part sends back inside goes where light can leave: no
// weight grows with the bounces of a path, whose variance would have no bound. (1 - F(wi)) / (1 - F_avg) is
// at most .96 / .9082 for an index of 1.5. Choosing by luminance adds nothing where all is grey.
TEST(WhiteFurnace, DiffuseSamplesInsideSolidsHaveEvenWeights) {
  for (const double transmission : {0.1, 0.5, 0.9}) {
    BsdfParameters parameters;
    parameters.base_color = dvec3(1);
    parameters.alpha = dvec2(0);
    parameters.transmission = transmission;
    parameters.is_volume = true;
    const Bsdf bsdf(parameters);
    for (const double theta : {0.0, 0.4, 0.7}) {
      const dvec3 inside(std::sin(theta), 0, -std::cos(theta));
      for (int i = 0; i < 64; ++i) {
        const dvec2 u((i % 8 + 0.5) / 8, (i / 8 + 0.5) / 8);
        const BsdfSample sample = bsdf.sample(inside, 0, u, TransportMode::Radiance);
        ASSERT_TRUE(sample.is_valid && sample.is_diffuse);
        EXPECT_GT(sample.weight.x, 0) << u.x << ' ' << u.y;
        EXPECT_LT(sample.weight.x, 0.96 / 0.9082) << u.x << ' ' << u.y;
      }
    }
  }
}

TEST(Reciprocity, HoldsUpToTheSquaredIndex) {
  test::Random random(12);
  double worst = 0;
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : SHADOWINGS)
      for (const double alpha : {0.05, 0.4, 1.0})
        for (const BsdfParameters& parameters : materials_for_energy(ndf, shadowing, alpha)) {
          const Bsdf bsdf(parameters);
          for (int i = 0; i < 300; ++i) {
            const dvec3 wo = random.direction();
            const dvec3 wi = random.direction();
            // Radiance: rho(o, i) n_i^2 = rho(i, o) n_o^2 with n of the side each lies on.
            const bool crosses = parameters.is_volume && parameters.transmission > 0 && wo.z * wi.z < 0;
            const double n2_o = crosses && wo.z < 0 ? 2.25 : 1;
            const double n2_i = crosses && wi.z < 0 ? 2.25 : 1;
            if (!crosses && wo.z * wi.z > 0 && wo.z < 0 && parameters.transmission > 0 &&
                parameters.is_volume)
              continue;
            const double forward = bsdf.value(wo, wi, TransportMode::Radiance).y * n2_i;
            const double backward = bsdf.value(wi, wo, TransportMode::Radiance).y * n2_o;
            const double adjoint = bsdf.value(wi, wo, TransportMode::Importance).y;
            const double scale = std::max({forward, backward, 1e-30});
            worst = std::max(worst, std::abs(forward - backward) / scale);
            // The importance walk's function is the radiance function with the directions swapped.
            const double radiance = bsdf.value(wo, wi, TransportMode::Radiance).y;
            worst = std::max(worst, std::abs(radiance - adjoint) / std::max({radiance, adjoint, 1e-30}));
          }
        }
  std::printf("largest relative asymmetry %.2e (bound 1e-9: rounding, amplified by half vectors near 0)\n",
              worst);
  EXPECT_LT(worst, 1e-9);
}

TEST(Slab, SmoothThickSlabTransmitsTheSeriesOfInterreflections) {
  // Following the delta events of a clear slab: T = (1 - F)^2 sum F^(2k) = (1 - F) / (1 + F). The radiance
  // factors of entering and leaving cancel.
  BsdfParameters parameters;
  parameters.base_color = dvec3(1);
  parameters.alpha = dvec2(0);
  parameters.transmission = 1;
  parameters.is_volume = true;
  const Bsdf bsdf(parameters);
  const auto event = [&](const dvec3& wo, bool reflects) {
    const double u_event = reflects ? 0 : std::nextafter(1.0, 0.0);
    return bsdf.sample(wo, u_event, dvec2(0.5), TransportMode::Radiance);
  };
  for (const double theta : {0.0, 0.5, 1.2}) {
    const dvec3 wo = direction(theta);
    const auto factor = [](const BsdfSample& s) { return s.weight.x * s.pdf_forward; };
    const BsdfSample enter = event(wo, false);
    ASSERT_TRUE(enter.is_valid && enter.is_transmitted);
    // Inside, the walk arrives at the far side from wo = -wi, below the (outward) normal of that side.
    const dvec3 inside(-enter.wi.x, -enter.wi.y, enter.wi.z);
    const BsdfSample leave = event(inside, false);
    const BsdfSample bounce = event(inside, true);
    ASSERT_TRUE(leave.is_valid && bounce.is_valid);
    EXPECT_NEAR(length(dvec2(leave.wi) - dvec2(-wo)), 0, 1e-12) << "leaves parallel to how it came";
    const double f = factor(bounce);
    const double slab = factor(enter) * factor(leave) / (1 - f * f);
    const double fresnel = fresnel_dielectric(wo.z, 1.5);
    EXPECT_NEAR(slab, (1 - fresnel) / (1 + fresnel), 1e-12);
  }
}

TEST(Delta, StraightThroughThinWallAndTotalReflection) {
  BsdfParameters parameters;
  parameters.alpha = dvec2(0);
  parameters.transmission = 1;
  parameters.base_color = dvec3(0.25, 0.5, 1);
  const dvec3 wo = direction(0.9);
  const BsdfSample thin = Bsdf(parameters).sample(wo, 0.999999, dvec2(0.1), TransportMode::Radiance);
  ASSERT_TRUE(thin.is_valid && thin.is_transmitted && thin.is_delta);
  EXPECT_EQ(thin.wi, -wo);
  EXPECT_NEAR(thin.weight.x * thin.pdf_forward, 0.25 * (1 - fresnel_dielectric(wo.z, 1.5)), 1e-14);
  parameters.is_volume = true;
  const BsdfSample total =
      Bsdf(parameters).sample({wo.x, wo.y, -wo.z}, 0.999999, dvec2(0.1), TransportMode::Radiance);
  ASSERT_TRUE(total.is_valid && !total.is_transmitted);
  EXPECT_NEAR(total.weight.y * total.pdf_forward, 1, 1e-14);
}

// A white metal and clear glass from both sides in even light give all of it back; 0.2 of the percent are for
// the grid of samples. Uncompensated, the metal of roughness 1 loses more than a fifth.
TEST(EnergyCompensation, WhiteSurfacesKeepAllLight) {
  const EnergyTables tables({1.5F}, NDF_GGX, SHADOWING_SMITH);
  const auto albedo = [](const BsdfParameters& parameters, const dvec3& wo) {
    const Bsdf bsdf(parameters);
    constexpr int SIDE = 64;
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
      const dvec2 u((i % SIDE + 0.5) / SIDE, (i / SIDE + 0.5) / SIDE);
      // Importance of a light walk would count energy at the other end; radiance shrinks by eta^2 in
      // refraction.
      const BsdfSample sample =
          bsdf.sample(wo, std::fmod(0.5 + 0.6180339887498949 * i, 1.0), u, TransportMode::Radiance);
      const double eta = sample.is_transmitted ? bsdf.relative_index(wo) : 1;
      if (sample.is_valid) sum += sample.weight.y * eta * eta;
    }
    return sum / (SIDE * SIDE);
  };
  for (const double roughness : {0.3, 0.7, 1.0})
    for (const double theta : {0.2, 0.9, 1.4}) {
      BsdfParameters white;
      white.base_color = dvec3(1);
      white.alpha = dvec2(roughness * roughness);
      white.energy = &tables;
      BsdfParameters metal = white, glass = white;
      metal.metallic = 1;
      glass.transmission = 1;
      glass.is_volume = true;
      const dvec3 wo = direction(theta), inside(wo.x, wo.y, -wo.z);
      EXPECT_NEAR(albedo(metal, wo), 1, 0.01) << roughness << " " << theta;
      EXPECT_NEAR(albedo(glass, wo), 1, 0.01) << roughness << " " << theta;
      EXPECT_NEAR(albedo(glass, inside), 1, 0.01) << roughness << " " << theta;
      if (roughness < 1) continue;
      metal.energy = nullptr;
      EXPECT_LT(albedo(metal, wo), 0.8);
    }
}

}  // namespace
}  // namespace regulus::reference

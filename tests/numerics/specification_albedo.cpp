// Directional albedo of every lobe against the formulas of the glTF 2.0 specification's appendix B (B.3.2 to
// B.3.6) and of KHR_materials_clearcoat and KHR_materials_transmission, integrated here on their own: what of
// the difference is which choice of this model. docs/results/correctness.md explains the choices and holds
// the table that this test prints.
//
// Where the model is given the specification's shadowing and the specification the exact Fresnel reflectance,
// both must agree to the error of the quadrature.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "reference/bsdf.hpp"
#include "reference/quadrature.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using std::numbers::pi;

constexpr double ROUGHNESSES[] = {0, 0.1, 0.3, 0.5, 1};
constexpr double ANGLES[] = {0, 45, 75, 85};
// Of the rules below: the integrands have kinks where a direction sinks below the surface.
constexpr double QUADRATURE = 1e-3;

dvec3 view(double degrees) {
  const double theta = degrees * pi / 180;
  return {std::sin(theta), 0, std::cos(theta)};
}

double schlick(double f0, double c) {
  return f0 + (1 - f0) * std::pow(1 - std::abs(c), 5);
}

/// Appendix B.3.2: one factor of the separable Smith masking, 2 c / (c + sqrt(a^2 + (1 - a^2) c^2)).
double spec_masking(double alpha, double c) {
  return 2 * c / (c + std::sqrt(alpha * alpha + (1 - alpha * alpha) * c * c));
}

/// Integral of f(h, weight) over GGX facets: weight = what D(h) dh leaves of D (v.h) 4 / (4 n.v n.l) (n.l) /
/// G, so that f has to return Fresnel times G. Facets are drawn in proportion to D(h) n.h: slope^2 = alpha^2
/// u / (1 - u).
double over_facets(double alpha, const dvec3& v, const std::function<double(const dvec3&, const dvec3&)>& f) {
  return integrate_2d(
      [&](double u, double phi) {
        const double slope = alpha * std::sqrt(u / (1 - u));
        const dvec3 h = normalize(dvec3(slope * std::cos(phi), slope * std::sin(phi), 1));
        const double v_dot_h = dot(v, h);
        const dvec3 l = reflect_at(v, h);
        if (v_dot_h <= 0 || l.z <= 0) return 0.0;
        return f(h, l) * v_dot_h / (v.z * h.z) / (2 * pi);
      },
      0, 1, 24, 0, 2 * pi, 12);
}

/// Integral over the hemisphere of f(l) n.l.
double over_hemisphere(const std::function<double(const dvec3&)>& f) {
  return integrate_2d(
      [&](double z2, double phi) {
        const double sine = std::sqrt(1 - z2);
        return 0.5 * f({sine * std::cos(phi), sine * std::sin(phi), std::sqrt(z2)});
      },
      0, 1, 12, 0, 2 * pi, 6);
}

/// specular_brdf(alpha) times a reflectance of the facet cosine: V D, Smith's masking separable.
double spec_specular(double roughness, const dvec3& v, const std::function<double(double)>& fresnel) {
  const double alpha = roughness * roughness;
  if (alpha == 0) return fresnel(v.z);
  return over_facets(alpha, v, [&](const dvec3& h, const dvec3& l) {
    return fresnel(dot(v, h)) * spec_masking(alpha, v.z) * spec_masking(alpha, l.z);
  });
}

/// fresnel_mix's share of the base: (1 - F(v.h)) color / pi.
double spec_diffuse(const dvec3& v, double color) {
  return over_hemisphere(
      [&](const dvec3& l) { return (1 - schlick(0.04, dot(v, normalize(v + l)))) * color / pi; });
}

/// The model's albedo from v, by its own value: lobes with facets, and the diffuse one, apart.
struct Albedo {
  double reflected, transmitted, diffuse;
  double sum() const { return reflected + transmitted + diffuse; }
};

/// A delta event's factor: weight times probability, for all events of one side.
double delta_factor(const Bsdf& bsdf, const dvec3& v, bool is_transmitted) {
  const double u = is_transmitted                 ? std::nextafter(1.0, 0.0)
                   : bsdf.coat_probability(v) > 0 ? 0.0
                                                  : bsdf.diffuse_probability(v) + 1e-12;
  const BsdfSample sample =
      bsdf.sample(v, std::min(u, std::nextafter(1.0, 0.0)), dvec2(0.5), TransportMode::Radiance);
  return sample.is_valid && sample.is_delta && sample.is_transmitted == is_transmitted
             ? sample.weight.y * sample.pdf_forward
             : 0.0;
}

Albedo albedo_of(const BsdfParameters& p, const dvec3& v) {
  const Bsdf bsdf(p);
  const Bsdf flat = bsdf.with_alpha(dvec2(0)).with_coat_alpha(dvec2(0));
  const TransportMode mode = TransportMode::Radiance;
  Albedo albedo{};
  albedo.diffuse = over_hemisphere([&](const dvec3& l) { return flat.value(v, l, mode).y; });
  const double alpha = std::max(p.alpha.x, p.coat_alpha.x);
  if (alpha == 0) {
    albedo.reflected = delta_factor(bsdf, v, false);
    if (p.transmission > 0) albedo.transmitted = delta_factor(bsdf, v, true);
    return albedo;
  }
  const Microsurface facets{NDF_GGX, SHADOWING_SMITH, dvec2(alpha)};
  const auto of_side = [&](double side) {
    return over_facets(alpha, v, [&](const dvec3& h, const dvec3& l) {
      const dvec3 wi(l.x, l.y, side * l.z);
      return (bsdf.value(v, wi, mode).y - flat.value(v, wi, mode).y) * 4 * v.z * l.z /
             distribution(facets, h);
    });
  };
  albedo.reflected = of_side(1);
  if (p.transmission > 0) albedo.transmitted = of_side(-1);
  return albedo;
}

const EnergyTables& covers(uint32_t shadowing) {
  static const EnergyTables smith({1.5f}, NDF_GGX, SHADOWING_SMITH);
  static const EnergyTables separable({1.5f}, NDF_GGX, SHADOWING_SMITH_UNCORRELATED);
  return shadowing == SHADOWING_SMITH ? smith : separable;
}

BsdfParameters parameters(double roughness, uint32_t shadowing) {
  BsdfParameters p;
  p.base_color = dvec3(1);
  p.alpha = dvec2(roughness * roughness);
  p.shadowing = shadowing;
  p.cover = &covers(shadowing);
  return p;
}

class SpecificationAlbedo : public testing::TestWithParam<double> {
 protected:
  double roughness() const { return GetParam(); }
};

double exact(double c) {
  return fresnel_dielectric(c, 1.5);
}

TEST_P(SpecificationAlbedo, MetalsDifferByShadowingAlone) {
  for (const double angle : ANGLES) {
    const dvec3 v = view(angle);
    const double spec = spec_specular(roughness(), v, [](double) { return 1.0; });
    BsdfParameters p = parameters(roughness(), SHADOWING_SMITH_UNCORRELATED);
    p.metallic = 1;
    EXPECT_NEAR(albedo_of(p, v).sum(), spec, QUADRATURE) << angle;
    p.shadowing = SHADOWING_SMITH;
    const double ours = albedo_of(p, v).sum();
    std::printf("metal, white       roughness %.1f angle %2.0f: ours %.3f specification %.3f\n", roughness(),
                angle, ours, spec);
    // Correlated heights shadow less, and no more than all light comes back.
    EXPECT_GE(ours, spec - QUADRATURE) << angle;
    EXPECT_LE(ours, 1 + QUADRATURE) << angle;
  }
}

TEST_P(SpecificationAlbedo, DielectricsKeepTheirEnergy) {
  for (const double angle : ANGLES) {
    const dvec3 v = view(angle);
    // The layer over black: the specification's with the exact reflectance.
    BsdfParameters p = parameters(roughness(), SHADOWING_SMITH_UNCORRELATED);
    p.base_color = dvec3(0);
    EXPECT_NEAR(albedo_of(p, v).sum(), spec_specular(roughness(), v, exact), QUADRATURE) << angle;

    const double layer = spec_specular(roughness(), v, [](double c) { return schlick(0.04, c); });
    const double spec = layer + spec_diffuse(v, 1);
    const Albedo ours = albedo_of(parameters(roughness(), SHADOWING_SMITH), v);
    std::printf(
        "dielectric, white  roughness %.1f angle %2.0f: ours %.3f (%.3f of the layer) specification %.3f "
        "(%.3f)\n",
        roughness(), angle, ours.sum(), ours.reflected, spec, layer);
    // A white base gives back what the layer lets through, so that their sum is 1. Below roughness .3 a
    // smooth interface stands in for the rough one, the more the smoother it is: from .1 that takes what
    // their albedos differ by, of which .015 at 85 degrees.
    const double stand_in =
        std::abs(exact(v.z) - spec_specular(roughness(), v, exact)) * (roughness() < 0.3 ? 1.0 : 0.0);
    EXPECT_LE(ours.sum(), 1 + 3 * QUADRATURE + stand_in) << angle;
    EXPECT_GE(ours.sum(), 1 - 3 * QUADRATURE - stand_in) << angle;
    // The specification's exceeds 1 at grazing angles and falls short elsewhere.
    if (angle == 85 && roughness() > 0 && roughness() <= 0.3) {
      EXPECT_GT(spec, 1.05);
    }
  }
}

TEST_P(SpecificationAlbedo, ThinTransmissionDiffersByShadowingAndFresnel) {
  for (const double angle : ANGLES) {
    const dvec3 v = view(angle);
    BsdfParameters p = parameters(roughness(), SHADOWING_SMITH_UNCORRELATED);
    p.transmission = 1;
    const Albedo same = albedo_of(p, v);
    EXPECT_NEAR(same.reflected, spec_specular(roughness(), v, exact), QUADRATURE) << angle;
    EXPECT_NEAR(same.transmitted, spec_specular(roughness(), v, [](double c) { return 1 - exact(c); }),
                QUADRATURE)
        << angle;
    p.shadowing = SHADOWING_SMITH;
    const double ours = albedo_of(p, v).transmitted;
    const double spec = spec_specular(roughness(), v, [](double c) { return 1 - schlick(0.04, c); });
    std::printf("thin transmission  roughness %.1f angle %2.0f: ours %.3f specification %.3f\n", roughness(),
                angle, ours, spec);
  }
}

TEST_P(SpecificationAlbedo, ClearcoatsReflectByFacetAndPassBothWays) {
  for (const double angle : ANGLES) {
    const dvec3 v = view(angle);
    const auto coated = [&](uint32_t shadowing) {
      BsdfParameters p = parameters(1, shadowing);
      p.specular = 0;  // a bare diffuse base
      p.alpha = dvec2(0);
      p.clearcoat = 1;
      p.coat_alpha = dvec2(roughness() * roughness());
      return p;
    };
    const auto facet = [](double c) { return schlick(0.04, c); };
    const double spec_coat = schlick(0.04, v.z) * spec_specular(roughness(), v, [](double) { return 1.0; });
    const double spec_base = 1 - schlick(0.04, v.z);
    EXPECT_NEAR(albedo_of(coated(SHADOWING_SMITH_UNCORRELATED), v).reflected,
                spec_specular(roughness(), v, facet), QUADRATURE)
        << angle;
    const Albedo ours = albedo_of(coated(SHADOWING_SMITH), v);
    // The base is seen through the coat, and lit through it: (1 - F(v)) times the mean of 1 - F, 1 - (.04 +
    // .96 / 21).
    EXPECT_NEAR(ours.diffuse, spec_base * 0.96 * (1 - 1.0 / 21), QUADRATURE) << angle;
    EXPECT_LE(ours.sum(), 1 + QUADRATURE);
    std::printf("clearcoat on white roughness %.1f angle %2.0f: ours %.3f + %.3f specification %.3f + %.3f\n",
                roughness(), angle, ours.reflected, ours.diffuse, spec_coat, spec_base);
  }
}

INSTANTIATE_TEST_SUITE_P(Roughness, SpecificationAlbedo, testing::ValuesIn(ROUGHNESSES));

}  // namespace
}  // namespace regulus::reference

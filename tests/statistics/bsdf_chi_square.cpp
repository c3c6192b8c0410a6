// Every sampler of the shaders' scattering model against its density: samples are drawn on the device with
// the renderer's random numbers, expected counts integrated in double precision from the reference's pdf. And
// the energy that samples carry, against albedos known from theory.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "kernels/bsdf_cases.hpp"
#include "support/chi_square.hpp"

namespace regulus::test {
namespace {

using glm::dvec3;
using glm::vec3;
using namespace interface;

constexpr uint32_t SAMPLES = 1u << 16;
constexpr double FALSE_ALARM = 1e-3;  // for all chi-square tests of this file together
constexpr int Z_CELLS = 32;
constexpr int AZIMUTH_CELLS = 24;

BsdfCase draw_case(Kind kind, float alpha, double cos_o, bool is_front) {
  BsdfCase c{};
  c.material = plain_material(kind, std::sqrt(alpha));
  c.material.base_color = {0.9f, 0.6f, 0.3f};
  c.alpha = vec3(-1);
  c.is_front = is_front;
  const double sin_o = std::sqrt(1 - cos_o * cos_o);
  c.wo = dvec3(sin_o * std::cos(0.7), sin_o * std::sin(0.7), cos_o);
  return c;
}

/// The cases of one kind, isotropic: roughness and angle vary together so that each pair of neighbours is
/// met.
std::vector<BsdfCase> draw_cases(Kind kind) {
  std::vector<BsdfCase> cases;
  const bool has_back = kind == Kind::Solid || kind == Kind::Mixed || kind == Kind::Coated;
  cases.push_back(draw_case(kind, 0.15f, 0.9, true));
  cases.push_back(draw_case(kind, 0.4f, 0.1, true));
  cases.push_back(draw_case(kind, 1.0f, 0.5, true));
  if (has_back) {
    cases.push_back(draw_case(kind, 0.2f, 0.8, false));
    cases.push_back(draw_case(kind, 0.6f, 0.4, false));
  }
  if (kind == Kind::Plastic || kind == Kind::Coated) {
    cases.push_back(cases[1]);
    cases.back().material.sheen_color = {1, 0.5f, 0.25f};
    cases.back().material.sheen_roughness = 0.4f;
    use_sheen(cases.back());
  }
  if (kind == Kind::Plastic || kind == Kind::Mixed) {
    cases.push_back(cases[0]);
    cases.back().material.iridescence = 0.8f;
    cases.back().material.iridescence_ior = 2;
    cases.back().material.iridescence_thickness = glm::vec2(350);
  }
  for (size_t i = 0; i < cases.size(); ++i)
    cases[i].mode = static_cast<uint32_t>(1000 * base_seed() + i);  // seed
  return cases;
}

class BsdfChiSquare : public testing::TestWithParam<Kind> {};

TEST_P(BsdfChiSquare, SamplesFollowTheirDensity) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  // Models times cases of all kinds (two with sheen, two with a film), the diffuse class, and the anisotropic
  // ones of six models.
  constexpr int TESTS = 9 * (3 + 5 + 3 + 5 + 6 + 6) + 3 + 6 * 6;
  const double significance = significance_per_test(FALSE_ALARM, TESTS);
  double smallest_p = 1;
  for (const Model& model : models_of_class(material_class_of(GetParam()))) {
    std::vector<BsdfCase> cases = draw_cases(GetParam());
    if (model.ndf != NDF_COSINE && GetParam() != Kind::Diffuse) {
      cases.push_back(cases.front());
      cases.back().alpha = {0.5f, 0.15f};
    }
    const gpu::Kernel kernel = create_kernel("bsdf_draw", model);
    // Diffuse bases under rough interfaces: the choice of lobes knows what these reflect.
    gpu::Buffer covers;
    const bool has_base =
        GetParam() == Kind::Plastic || GetParam() == Kind::Mixed || GetParam() == Kind::Coated;
    if (has_base && model.shadowing == SHADOWING_SMITH) {
      covers = cover_tables(model);
      for (BsdfCase& c : cases) c.tables = device_address(covers.address());
    }
    const auto drawn = map_on_device<DrawnDirection>(kernel, cases, SAMPLES, SAMPLES);
    for (size_t i = 0; i < cases.size(); ++i) {
      SphereHistogram histogram(Z_CELLS, AZIMUTH_CELLS);
      for (uint32_t k = 0; k < SAMPLES; ++k) {
        const DrawnDirection& sample = drawn[i * SAMPLES + k];
        if (sample.is_valid != 0)
          histogram.add(mirrored_if_back(sample.direction, cases[i]));
        else
          histogram.add_invalid();
      }
      const ReferenceCase r = reference_case(cases[i], model);
      const ChiSquare result = histogram.test([&](const dvec3& wi) { return r.bsdf.pdf(r.wo, wi); });
      smallest_p = std::min(smallest_p, result.p_value);
      EXPECT_TRUE(result.problem.empty()) << model.name() << " case " << i << ": " << result.problem;
      EXPECT_GT(result.p_value, significance)
          << model.name() << " case " << i << ": chi-square " << result.statistic << " with "
          << result.degrees_of_freedom << " degrees of freedom";
    }
  }
  std::printf("smallest p-value %.2e, alarm below %.2e (false alarm %.0e over %d tests)\n", smallest_p,
              significance, FALSE_ALARM, TESTS);
}

INSTANTIATE_TEST_SUITE_P(Kinds, BsdfChiSquare, testing::ValuesIn(ALL_KINDS));

/// Mean and standard error of the first channel of the weights of samples of one case.
struct Mean {
  double mean, error;
};
Mean mean_weight(const gpu::Kernel& kernel, const BsdfCase& c, uint32_t samples, uint64_t stream) {
  Random random(stream);
  std::vector<BsdfCase> cases(samples, c);
  for (BsdfCase& sample : cases) {
    sample.u_lobe = static_cast<float>(random.index(1u << 24) * 0x1p-24);
    sample.u = {random.index(1u << 24) * 0x1p-24, random.index(1u << 24) * 0x1p-24};
  }
  double sum = 0, squares = 0;
  for (const BsdfSampled& s : map_on_device<BsdfSampled>(kernel, cases)) {
    const double weight = (s.flags & BSDF_SAMPLED_VALID) != 0 ? double{s.weight.x} : 0;
    sum += weight;
    squares += weight * weight;
  }
  const double mean = sum / samples;
  return {mean, std::sqrt(std::max(0.0, squares / samples - mean * mean) / samples)};
}

TEST(WhiteFurnaceOnDevice, GgxLosesTheKnownEnergyAndSmoothInterfacesNone) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  struct Case {
    const char* name;
    Kind kind;
    float alpha;
    double cos_o, albedo, known_to;
    uint32_t mode;
    uint32_t shadowing;
  };
  // alpha = 1 at normal incidence: 1 - ln 2 in closed form; 4 decimals of the others from an independent
  // computation. A smooth interface (delta) over a diffuse or transparent body keeps everything.
  const Case cases[] = {
      {"metal", Kind::Metal, 1.0f, 1.0, 1 - std::numbers::ln2, 0, 0, SHADOWING_SMITH},
      {"metal", Kind::Metal, 0.3f, 0.5, 0.8181, 2e-3, 0, SHADOWING_SMITH_UNCORRELATED},
      {"metal", Kind::Metal, 0.5f, 0.2, 0.7897, 2e-3, 0, SHADOWING_SMITH},
      {"smooth plastic", Kind::Plastic, 0.0f, 0.7, 1, 0, 0, SHADOWING_SMITH},
      {"smooth plastic", Kind::Plastic, 0.0f, 0.1, 1, 0, 0, SHADOWING_SMITH},
      {"diffuse", Kind::Diffuse, 1.0f, 0.4, 1, 0, 0, SHADOWING_SMITH},
      {"smooth thin glass", Kind::Thin, 0.0f, 0.3, 1, 0, 0, SHADOWING_SMITH},
      {"smooth solid glass, importance", Kind::Solid, 0.0f, 0.3, 1, 0, 1, SHADOWING_SMITH},
      {"nearly smooth solid glass, importance", Kind::Solid, 1e-4f, 0.3, 1, 1e-5, 1, SHADOWING_SMITH},
  };
  uint64_t stream = 41;
  for (const Case& c : cases) {
    BsdfCase input = draw_case(c.kind, c.alpha, c.cos_o, true);
    input.material.base_color = vec3(1);
    input.mode = c.mode;
    const gpu::Kernel kernel =
        create_kernel("bsdf_sample", {NDF_GGX, c.shadowing, material_class_of(c.kind)});
    const Mean measured = mean_weight(kernel, input, SAMPLES, stream++);
    // 5 standard errors: false alarm 5e-6 for all; 1e-5 is the rounding of the weights themselves.
    const double bound = 5 * measured.error + c.known_to + 1e-5;
    std::printf("%-38s alpha %-6g cos %.1f: %.5f, known %.5f, bound %.5f\n", c.name, c.alpha, c.cos_o,
                measured.mean, c.albedo, bound);
    EXPECT_NEAR(measured.mean, c.albedo, bound) << c.name;
  }
}

TEST(WhiteFurnaceOnDevice, NoModelCreatesEnergy) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  double most = 0;
  uint64_t stream = 61;
  for (const uint32_t material_class : {MATERIAL_CLASS_OPAQUE, MATERIAL_CLASS_TRANSMISSIVE})
    for (const Model& model : models_of_class(material_class)) {
      const gpu::Kernel kernel = create_kernel("bsdf_sample", model);
      for (const Kind kind : ALL_KINDS) {
        if (material_class_of(kind) != material_class) continue;
        BsdfCase input = draw_case(kind, 0.85f, 0.2, stream % 2 == 0);
        input.material.base_color = vec3(1);
        input.mode = 1;  // importance: a camera walk's radiance changes with the squared index
        const Mean measured = mean_weight(kernel, input, SAMPLES / 4, stream++);
        most = std::max(most, measured.mean);
        EXPECT_LE(measured.mean, 1 + 5 * measured.error) << model.name();
      }
    }
  std::printf("largest energy %.4f (bound 1 + 5 standard errors)\n", most);
}

}  // namespace
}  // namespace regulus::test

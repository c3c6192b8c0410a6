// The shaders' scattering model against the double-precision reference, on random inputs over all
// distributions, shadowing terms and material classes.
//
// The bound: 1e-4 relative for alpha >= 1e-3. Where the result is so sensitive that moving the float inputs
// by ULPS units in the last place already changes it by more, the bound is that change. That is granted only
// to cases that are ill-conditioned by sensitivity(), which knows nothing of errors: narrow lobes seen
// through a half vector that nearly cancels, the horizon, the critical angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "kernels/bsdf_cases.hpp"

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using reference::BsdfSample;

constexpr double RELATIVE_BOUND = 1e-4;
constexpr double ULPS = 2;
// Share of values that must be held to the bound, so that the test is not vacuous: alpha and the two cosines
// come from logarithmic ranges, and where their product is below 0.01 a case may be excused.
constexpr double LEAST_HELD = 0.2;
// Facet densities below the smallest normal float (1.2e-38) are flushed on some devices; values divide them
// by 4 cos_i cos_o, here at least 4e-8.
constexpr double SMALLEST_FLOAT = 1e-30;
constexpr double LARGEST_DENSITY = 1e29;  // above, densities may be clamped
constexpr int CASES_PER_KIND = 1500;

dvec3 random_direction(Random& random, double sign) {
  // Half the directions are uniform, the others approach the horizon logarithmically.
  dvec3 w = random.direction();
  if (random.uniform() < 0.5) {
    const double z = random.log_uniform(1e-4, 1);
    const dvec2 xy = normalize(dvec2(w)) * std::sqrt(1 - z * z);
    w = {xy, z};
  }
  return {w.x, w.y, sign * std::abs(w.z)};
}

/// A case of this kind; `wi` half of the time drawn by the reference's sampler, so that narrow lobes are hit.
BsdfCase random_case(Kind kind, const Model& model, double smallest_alpha, Random& random) {
  BsdfCase c{};
  c.material = random_material(kind, random);
  const double alpha = random.log_uniform(smallest_alpha, 1);
  c.material.roughness = static_cast<float>(std::sqrt(alpha));
  c.alpha = glm::vec2(-1);
  if (model.ndf != NDF_COSINE && random.uniform() < 0.25)
    c.alpha = {static_cast<float>(alpha), static_cast<float>(random.log_uniform(smallest_alpha, 1))};
  c.is_front = random.uniform() < 0.6 ? 1 : 0;
  c.mode = random.index(2);
  c.wo = random_direction(random, 1);
  c.wi = random_direction(random, random.uniform() < 0.5 ? 1 : -1);
  c.u_lobe = static_cast<float>(random.index(1u << 24) * 0x1p-24);
  c.u = {random.index(1u << 24) * 0x1p-24, random.index(1u << 24) * 0x1p-24};
  if (random.uniform() < 0.7) {
    const ReferenceCase r = reference_case(c, model);
    const BsdfSample sample =
        r.bsdf.sample(r.wo, random.uniform(), random.square(), reference::TransportMode::Radiance);
    if (sample.is_valid) c.wi = mirrored_if_back(sample.wi, c);
  }
  return c;
}

/// Relative change that rounding of the inputs may cause, from the differences in the model that can nearly
/// cancel; what was measured does not enter. Directions are known to 2^-22.
/// - A lobe has a relative slope of up to 2 / alpha in the half vector, which is a sum of two vectors: of
/// length 2 cos
///   for reflection and at least |eta - 1| for refraction; and each cosine is known to an absolute error
///   only.
/// - The cosine of a refracted direction is a root, sqrt(1 - sin^2 / eta^2) and back.
/// - V-cavities pass G1 + G1 - 1.
/// - Probabilities of a rare choice are what is left of 1.
/// Several of them can come together, hence the factor of 4.
double sensitivity(const BsdfCase& c, const Model& model) {
  if (model.material_class == MATERIAL_CLASS_DIFFUSE) return 0;
  const ReferenceCase r = reference_case(c, model);
  const reference::BsdfParameters& parameters = r.bsdf.parameters();
  const double eta = r.bsdf.relative_index(r.wo);
  const bool is_transmitted = r.wo.z * r.wi.z < 0, is_refracted = is_transmitted && parameters.is_volume;
  const dvec3 wi = is_transmitted && !is_refracted ? dvec3(r.wi.x, r.wi.y, -r.wi.z) : r.wi;
  const dvec3 h = is_refracted ? reference::refraction_half_vector(r.wo, wi, eta)
                               : reference::reflection_half_vector(r.wo, wi);
  const double o_dot_h = std::abs(dot(r.wo, h)), i_dot_h = std::abs(dot(wi, h));
  const double least_cosine = std::min({std::abs(r.wo.z), std::abs(wi.z), o_dot_h, i_dot_h});
  const double cancellation = is_refracted ? std::min(1.0, std::max(eta, 1 / eta) - 1) : 1;
  double least = std::min(parameters.alpha.x, parameters.alpha.y) * least_cosine * cancellation;
  least = std::min(least, std::abs((o_dot_h * o_dot_h + eta * eta - 1) / (eta * eta)));
  if (is_refracted) least = std::min(least, least_cosine * least_cosine);
  if (is_refracted && model.shadowing == SHADOWING_V_CAVITY) {
    const auto g1 = [&](double cosine, double w_dot_h) {
      return std::min(1.0, 2 * std::abs(h.z * cosine) / w_dot_h);
    };
    least = std::min(least, std::abs(g1(r.wo.z, o_dot_h) + g1(wi.z, i_dot_h) - 1));
  }
  least = std::min(least, least_choice(c, model));
  return 4 * 0x1p-22 / least;
}

/// Collects the errors of one quantity over all cases.
class ErrorStatistics {
 public:
  explicit ErrorStatistics(const char* quantity) : quantity_(quantity) {}

  /// Compares; `allowed()` gives what the conditioning excuses and is only asked where it is needed and where
  /// the case may have an excuse. Returns true if within the bound.
  template <typename Allowed>
  bool add(double measured, double expected, bool may_be_excused, const Allowed& allowed) {
    ++count_;
    held_ += !may_be_excused;
    const double error = std::abs(measured - expected);
    const double relative = error / std::max(std::abs(expected), SMALLEST_FLOAT);
    if (relative <= RELATIVE_BOUND || error <= SMALLEST_FLOAT) {
      worst_ = std::max(worst_, error <= SMALLEST_FLOAT ? 0 : relative);
      return true;
    }
    if (may_be_excused && error <= allowed()) {
      ++excused_;
      return true;
    }
    ++failed_;
    worst_failure_ = std::isfinite(relative) ? std::max(worst_failure_, relative) : relative;
    return false;
  }

  /// Few enough values were wrong that each is worth printing.
  bool should_describe() const { return failed_ <= 3; }

  /// Prints the summary and fails the test if the bound was exceeded, or if it held for too few.
  void report(const std::string& name) const {
    std::printf(
        "%-42s %-12s %6d values, %2.0f %% held to the bound, error %.1e (bound %.0e), %4d of the others "
        "within %g ulp of "
        "inputs, %d wrong\n",
        name.c_str(), quantity_, count_, 100.0 * held_ / count_, worst_, RELATIVE_BOUND, excused_, ULPS,
        failed_);
    EXPECT_EQ(failed_, 0) << name << " " << quantity_ << ": worst relative error " << worst_failure_;
    EXPECT_GE(held_, LEAST_HELD * count_) << name << " " << quantity_;
  }

 private:
  const char* quantity_;
  int count_ = 0, held_ = 0, excused_ = 0, failed_ = 0;
  double worst_ = 0, worst_failure_ = 0;
};

/// Prints a case that went wrong, with all that is needed to repeat it.
void describe_failure(const char* what, const BsdfCase& c, const Model& model, const dvec3& measured,
                      const dvec3& expected) {
  const Material& m = c.material;
  std::printf(
      "  %s %s\n    measured %.7g %.7g %.7g  expected %.7g %.7g %.7g\n    wo (%.9g %.9g %.9g) wi (%.9g %.9g "
      "%.9g) front "
      "%u mode %u roughness %.9g alpha (%.9g %.9g)\n    base (%.3g %.3g %.3g) metallic %.4g ior %.6g "
      "transmission %.4g "
      "specular %.4g (%.3g %.3g %.3g) flags %u u_lobe %.9g u (%.9g %.9g)\n",
      model.name().c_str(), what, measured.x, measured.y, measured.z, expected.x, expected.y, expected.z,
      c.wo.x, c.wo.y, c.wo.z, c.wi.x, c.wi.y, c.wi.z, c.is_front, c.mode, m.roughness, c.alpha.x, c.alpha.y,
      m.base_color.x, m.base_color.y, m.base_color.z, m.metallic, m.ior, m.transmission, m.specular,
      m.specular_color.x, m.specular_color.y, m.specular_color.z, m.flags, c.u_lobe, c.u.x, c.u.y);
}

std::vector<BsdfCase> random_cases(const Model& model, double smallest_alpha, uint64_t stream) {
  Random random(stream);
  std::vector<BsdfCase> cases;
  for (const Kind kind : ALL_KINDS) {
    if (material_class_of(kind) != model.material_class) continue;
    for (int i = 0; i < CASES_PER_KIND; ++i)
      cases.push_back(random_case(kind, model, smallest_alpha, random));
  }
  return cases;
}

/// The conditioning of a case, computed when first asked for.
class LazyConditioning {
 public:
  LazyConditioning(const BsdfCase& c, const Model& model) : case_(c), model_(model) {}
  const Evaluation& get() {
    if (!known_) value_ = conditioning(case_, model_, ULPS);
    known_ = true;
    return value_;
  }

 private:
  const BsdfCase& case_;
  const Model& model_;
  Evaluation value_{};
  bool known_ = false;
};

class BsdfAccuracy : public testing::TestWithParam<uint32_t> {};

TEST_P(BsdfAccuracy, ValueAndPdfsMatchTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const Model& model : models_of_class(GetParam())) {
    const gpu::Kernel kernel = create_kernel("bsdf_evaluate", model);
    const std::vector<BsdfCase> cases = random_cases(model, 1e-3, 21);
    const auto results = map_on_device<BsdfEvaluated>(kernel, cases);
    ErrorStatistics value("value"), forward("pdf forward"), reverse("pdf reverse");
    for (size_t i = 0; i < cases.size(); ++i) {
      const Evaluation expected = evaluate_reference(cases[i], model);
      LazyConditioning allowed(cases[i], model);
      const bool is_excusable = sensitivity(cases[i], model) > RELATIVE_BOUND;
      bool is_right = true;
      for (int channel = 0; channel < 3; ++channel)
        is_right &= value.add(results[i].value[channel], expected.value[channel], is_excusable,
                              [&] { return allowed.get().value[channel]; });
      if (!is_right && value.should_describe())
        describe_failure("value", cases[i], model, results[i].value, expected.value);
      is_right = forward.add(results[i].pdf_forward, expected.pdf_forward, is_excusable,
                             [&] { return allowed.get().pdf_forward; });
      is_right &= reverse.add(results[i].pdf_reverse, expected.pdf_reverse, is_excusable,
                              [&] { return allowed.get().pdf_reverse; });
      if (!is_right && forward.should_describe() && reverse.should_describe())
        describe_failure("pdfs", cases[i], model, {results[i].pdf_forward, results[i].pdf_reverse, 0},
                         {expected.pdf_forward, expected.pdf_reverse, 0});
    }
    value.report(model.name());
    forward.report(model.name());
    reverse.report(model.name());
  }
}

/// The weight value |cos| / pdf of a case by the reference.
dvec3 weight_of(const Evaluation& e, const BsdfCase& c) {
  return e.pdf_forward > 0 ? e.value * std::abs(double{c.wi.z}) / e.pdf_forward : dvec3(0);
}

TEST_P(BsdfAccuracy, SampleWeightIsValueTimesCosineOverPdf) {
  // The kernel's weight and densities come from the half vector it drew; the reference gets only the rounded
  // direction. Delta events are compared in the next test.
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const Model& model : models_of_class(GetParam())) {
    const gpu::Kernel kernel = create_kernel("bsdf_sample", model);
    std::vector<BsdfCase> cases = random_cases(model, 1e-3, 22);
    const auto results = map_on_device<BsdfSampled>(kernel, cases);
    ErrorStatistics weight("weight"), forward("pdf forward"), reverse("pdf reverse");
    int valid = 0;
    for (size_t i = 0; i < cases.size(); ++i) {
      const BsdfSampled& sampled = results[i];
      if ((sampled.flags & BSDF_SAMPLED_VALID) == 0) continue;
      ++valid;
      ASSERT_EQ(sampled.flags & BSDF_SAMPLED_DELTA, 0u);
      EXPECT_EQ((sampled.flags & BSDF_SAMPLED_TRANSMITTED) != 0, sampled.wi.z < 0);
      EXPECT_NEAR(length(dvec3(sampled.wi)), 1, 4e-7) << "4 ulp";
      BsdfCase c = cases[i];
      c.wi = sampled.wi;
      const Evaluation expected = evaluate_reference(c, model);
      LazyConditioning allowed(c, model);
      const bool is_excusable = sensitivity(c, model) > RELATIVE_BOUND;
      const dvec3 expected_weight = weight_of(expected, c);
      bool is_right = true;
      for (int channel = 0; channel < 3; ++channel)
        is_right &= weight.add(sampled.weight[channel], expected_weight[channel], is_excusable, [&] {
          if (expected.pdf_forward <= allowed.get().pdf_forward)
            return std::numeric_limits<double>::infinity();
          const double cosine_over_pdf = std::abs(double{c.wi.z}) / expected.pdf_forward;
          return (allowed.get().value[channel] +
                  expected.value[channel] * allowed.get().pdf_forward / expected.pdf_forward) *
                 cosine_over_pdf;
        });
      if (!is_right && weight.should_describe())
        describe_failure("weight", c, model, sampled.weight, expected_weight);
      is_right = forward.add(sampled.pdf_forward, expected.pdf_forward, is_excusable,
                             [&] { return allowed.get().pdf_forward; });
      is_right &= reverse.add(sampled.pdf_reverse, expected.pdf_reverse, is_excusable,
                              [&] { return allowed.get().pdf_reverse; });
      if (!is_right && forward.should_describe() && reverse.should_describe())
        describe_failure("sampled pdfs", c, model, {sampled.pdf_forward, sampled.pdf_reverse, 0},
                         {expected.pdf_forward, expected.pdf_reverse, 0});
    }
    weight.report(model.name());
    forward.report(model.name());
    reverse.report(model.name());
    EXPECT_GT(valid, static_cast<int>(cases.size() / 3)) << model.name();
  }
}

INSTANTIATE_TEST_SUITE_P(MaterialClass, BsdfAccuracy, testing::Range(0u, MATERIAL_CLASS_COUNT));

TEST(BsdfDelta, EventsMatchTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const uint32_t material_class : {MATERIAL_CLASS_OPAQUE, MATERIAL_CLASS_TRANSMISSIVE}) {
    const Model model{NDF_GGX, SHADOWING_SMITH, material_class};
    const gpu::Kernel kernel = create_kernel("bsdf_sample", model);
    std::vector<BsdfCase> cases = random_cases(model, 1e-3, 23);
    for (BsdfCase& c : cases) {
      c.material.roughness = 0;
      // Every other coat is smooth too: then both lobes make the event.
      if ((&c - cases.data()) % 2 == 0) c.material.clearcoat_roughness = 0;
      c.alpha = glm::vec2(-1);
    }
    const auto results = map_on_device<BsdfSampled>(kernel, cases);
    int events = 0;
    double worst = 0;
    for (size_t i = 0; i < cases.size(); ++i) {
      const BsdfSampled& sampled = results[i];
      if ((sampled.flags & BSDF_SAMPLED_DELTA) == 0 || (sampled.flags & BSDF_SAMPLED_VALID) == 0) continue;
      ++events;
      const BsdfCase& c = cases[i];
      const ReferenceCase r = reference_case(c, model);
      const bool is_transmitted = (sampled.flags & BSDF_SAMPLED_TRANSMITTED) != 0;
      // The first number beyond coat and diffuse lobe, up to its rounding.
      const double p_coat = r.bsdf.coat_probability(r.wo);
      const double u_reflect =
          p_coat + (1 - p_coat) * r.bsdf.diffuse_probability(r.wo) + (p_coat > 0 ? 1e-12 : 0);
      const BsdfSample expected =
          r.bsdf.sample(r.wo, is_transmitted ? std::nextafter(1.0, 0.0) : u_reflect, dvec2(0.5), r.mode);
      ASSERT_TRUE(expected.is_valid && expected.is_delta && expected.is_transmitted == is_transmitted);
      const dvec3 wi = mirrored_if_back(expected.wi, c);
      // Refraction near the critical angle: cos_t has the error of sin^2 divided by 2 cos_t.
      const double direction_bound = 1e-6 + 1e-6 / std::abs(wi.z);
      EXPECT_LT(length(dvec3(sampled.wi) - wi), direction_bound);
      const double fresnel_bound = RELATIVE_BOUND + 1e-6 / (wi.z * wi.z);
      for (int channel = 0; channel < 3; ++channel) {
        const double error =
            std::abs(sampled.weight[channel] - expected.weight[channel]) / expected.weight[channel];
        if (fresnel_bound < 2 * RELATIVE_BOUND) worst = std::max(worst, error);
        EXPECT_LT(error, fresnel_bound);
      }
      EXPECT_NEAR(sampled.pdf_forward / expected.pdf_forward, 1, fresnel_bound);
      // The reverse density is a function of wi, from where the cosine of wo is the ill-conditioned one.
      EXPECT_NEAR(sampled.pdf_reverse / expected.pdf_reverse, 1, fresnel_bound + 1e-6 / (r.wo.z * r.wo.z));
    }
    std::printf("%s: %d delta events, largest relative error of the weight %.1e\n", model.name().c_str(),
                events, worst);
    EXPECT_GT(events, static_cast<int>(cases.size() / 4));
  }
}

}  // namespace
}  // namespace regulus::test

// The shaders' scattering model against the double-precision reference, on random inputs over all
// distributions, shadowing terms and material classes, and where formulas divide by zero.
//
// The bound: what the kernel's arithmetic may do of its own, and what moving the float inputs by ULPS units
// in the last place, one after the other, does to the reference (conditioning()): narrow lobes seen through a
// half vector that nearly cancels, the horizon, the critical angle. The first is some sixty roundings of 6e-8
// and the error of the mean reflectance (1e-5 of its range, lib/fresnel.glsl), 1e-5 together; for the Cosine
// distribution twice the error of its projected area (1e-5, lib/ndf.glsl), one for each direction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "kernels/bsdf_cases.hpp"

namespace regulus::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using reference::BsdfSample;

constexpr double RELATIVE_BOUND = 1e-4;  // that many values keep, however they are conditioned
constexpr double OWN_ERROR = 1e-5;
constexpr double OWN_ERROR_COSINE = 2e-5;
constexpr double ULPS = 2;
// Facet densities below the smallest normal float (1.2e-38) are flushed on some devices; values divide them
// by 4 cos_i cos_o, here at least 4e-8.
constexpr double SMALLEST_FLOAT = 1e-30;
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
  use_sheen(c);
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

/// Collects the errors of one quantity over all cases.
class ErrorStatistics {
 public:
  ErrorStatistics(const char* quantity, const Model& model)
      : quantity_(quantity), bound_(model.ndf == NDF_COSINE ? OWN_ERROR_COSINE : OWN_ERROR) {}

  /// Compares; `explained()` gives what rounding of the inputs explains and is only asked where it is needed.
  /// Returns true if within the bound.
  template <typename Explained>
  bool add(double measured, double expected, const Explained& explained) {
    ++count_;
    const double error = std::abs(measured - expected);
    const double scale = std::max(std::abs(expected), SMALLEST_FLOAT);
    if (error <= SMALLEST_FLOAT) return true;
    above_issue_ += error > RELATIVE_BOUND * scale;
    double own = error / scale;
    if (!(own <= bound_)) {
      ++conditioned_;
      own = (error - explained()) / scale;
    }
    if (!(own <= worst_)) worst_ = own;
    if (own <= bound_) return true;
    ++failed_;
    return false;
  }

  /// Few enough values were wrong that each is worth printing.
  bool should_describe() const { return failed_ <= 3; }

  /// Prints the summary and fails the test if the bound was exceeded.
  void report(const std::string& name) const {
    std::printf(
        "%-42s %-12s %6d values: own error %.1e (bound %.0e) beyond what rounded inputs explain, asked of "
        "%4.1f %%; "
        "%4.1f %% err by more than %g\n",
        name.c_str(), quantity_, count_, worst_, bound_, 100.0 * conditioned_ / count_,
        100.0 * above_issue_ / count_, RELATIVE_BOUND);
    EXPECT_EQ(failed_, 0) << name << " " << quantity_ << ": worst relative error " << worst_;
  }

 private:
  const char* quantity_;
  double bound_;
  int count_ = 0, conditioned_ = 0, above_issue_ = 0, failed_ = 0;
  double worst_ = 0;
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
  LazyConditioning(const BsdfCase& c, const Model& model, double ulps = ULPS)
      : case_(c), model_(model), ulps_(ulps) {}
  const Evaluation& get() {
    if (!known_) value_ = conditioning(case_, model_, ulps_);
    known_ = true;
    return value_;
  }

 private:
  const BsdfCase& case_;
  const Model& model_;
  double ulps_;
  Evaluation value_{};
  bool known_ = false;
};

/// Value and pdfs of one case.
void compare_evaluation(const BsdfCase& c, const Model& model, const BsdfEvaluated& found,
                        ErrorStatistics& value, ErrorStatistics& forward, ErrorStatistics& reverse) {
  const Evaluation expected = evaluate_reference(c, model);
  LazyConditioning explained(c, model);
  bool is_right = true;
  for (int channel = 0; channel < 3; ++channel)
    is_right &= value.add(found.value[channel], expected.value[channel],
                          [&] { return explained.get().value[channel]; });
  if (!is_right && value.should_describe()) describe_failure("value", c, model, found.value, expected.value);
  is_right =
      forward.add(found.pdf_forward, expected.pdf_forward, [&] { return explained.get().pdf_forward; });
  is_right &=
      reverse.add(found.pdf_reverse, expected.pdf_reverse, [&] { return explained.get().pdf_reverse; });
  if (!is_right && forward.should_describe() && reverse.should_describe())
    describe_failure("pdfs", c, model, {found.pdf_forward, found.pdf_reverse, 0},
                     {expected.pdf_forward, expected.pdf_reverse, 0});
}

class BsdfAccuracy : public testing::TestWithParam<uint32_t> {};

TEST_P(BsdfAccuracy, ValueAndPdfsMatchTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const Model& model : models_of_class(GetParam())) {
    const gpu::Kernel kernel = create_kernel("bsdf_evaluate", model);
    const std::vector<BsdfCase> cases = random_cases(model, 1e-3, 21);
    const auto results = map_on_device<BsdfEvaluated>(kernel, cases);
    ErrorStatistics value("value", model), forward("pdf forward", model), reverse("pdf reverse", model);
    for (size_t i = 0; i < cases.size(); ++i)
      compare_evaluation(cases[i], model, results[i], value, forward, reverse);
    value.report(model.name());
    forward.report(model.name());
    reverse.report(model.name());
  }
}

/// The weight value |cos| / pdf of a case by the reference.
dvec3 weight_of(const Evaluation& e, const BsdfCase& c) {
  return e.pdf_forward > 0 ? e.value * std::abs(double{c.wi.z}) / e.pdf_forward : dvec3(0);
}

/// Weight and pdfs of one sample, whose direction `c` has.
void compare_sample(const BsdfCase& c, const Model& model, const BsdfSampled& sampled,
                    ErrorStatistics& weight, ErrorStatistics& forward, ErrorStatistics& reverse) {
  const Evaluation expected = evaluate_reference(c, model);
  // Roundings of the facet are larger by the index in a refracted direction.
  const bool is_refracted = c.wi.z < 0 && (c.material.flags & MATERIAL_VOLUME) != 0;
  LazyConditioning allowed(c, model, is_refracted ? ULPS * c.material.ior : ULPS);
  const dvec3 expected_weight = weight_of(expected, c);
  bool is_right = true;
  for (int channel = 0; channel < 3; ++channel)
    is_right &= weight.add(sampled.weight[channel], expected_weight[channel], [&] {
      if (expected.pdf_forward <= allowed.get().pdf_forward) return std::numeric_limits<double>::infinity();
      const double cosine_over_pdf = std::abs(double{c.wi.z}) / expected.pdf_forward;
      return (allowed.get().value[channel] +
              expected.value[channel] * allowed.get().pdf_forward / expected.pdf_forward) *
             cosine_over_pdf;
    });
  if (!is_right && weight.should_describe())
    describe_failure("weight", c, model, sampled.weight, expected_weight);
  is_right =
      forward.add(sampled.pdf_forward, expected.pdf_forward, [&] { return allowed.get().pdf_forward; });
  is_right &=
      reverse.add(sampled.pdf_reverse, expected.pdf_reverse, [&] { return allowed.get().pdf_reverse; });
  if (!is_right && forward.should_describe() && reverse.should_describe())
    describe_failure("sampled pdfs", c, model, {sampled.pdf_forward, sampled.pdf_reverse, 0},
                     {expected.pdf_forward, expected.pdf_reverse, 0});
}

TEST_P(BsdfAccuracy, SampleWeightIsValueTimesCosineOverPdf) {
  // The kernel's weight and densities come from the half vector it drew; the reference gets only the rounded
  // direction. Delta events are compared in the next test.
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const Model& model : models_of_class(GetParam())) {
    const gpu::Kernel kernel = create_kernel("bsdf_sample", model);
    std::vector<BsdfCase> cases = random_cases(model, 1e-3, 22);
    const auto results = map_on_device<BsdfSampled>(kernel, cases);
    ErrorStatistics weight("weight", model), forward("pdf forward", model), reverse("pdf reverse", model);
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
      compare_sample(c, model, sampled, weight, forward, reverse);
    }
    weight.report(model.name());
    forward.report(model.name());
    reverse.report(model.name());
    EXPECT_GT(valid, static_cast<int>(cases.size() / 3)) << model.name();
  }
}

/// True if the kernel has to find what the reference does. What the model clamps to stay finite is left out:
/// alpha and cosines below 1e-7; indices above 10, where the mean reflectance is less accurate; and
/// refraction lobes that are narrower than eight times what is known of their half vector, 2^-23 / |eta - 1|.
bool must_match(const BsdfCase& c) {
  const Material& m = c.material;
  const float alpha = m.roughness * m.roughness;
  const bool refracts = (m.flags & MATERIAL_VOLUME) != 0 && c.wi.z < 0;
  const bool is_resolved = !refracts || alpha * (m.ior - 1) > 0x1p-20F || (alpha == 0 && m.ior > 1);
  return (alpha == 0 || alpha >= 1e-7F) && std::min(c.wo.z, std::abs(c.wi.z)) >= 1e-7F && m.ior <= 10 &&
         is_resolved;
}

bool is_sound(const Evaluation& e) {
  return std::isfinite(e.value.x + e.value.y + e.value.z + e.pdf_forward + e.pdf_reverse) &&
         std::min({e.value.x, e.value.y, e.value.z, e.pdf_forward, e.pdf_reverse}) >= 0;
}

// Every eighth of the extreme cases, another eighth for each model. The reference alone has to be sound in
// all.
TEST_P(BsdfAccuracy, ExtremesMatchTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  uint32_t offset = 0;
  const std::vector<BsdfCase> all = extreme_cases(GetParam());
  for (const Model& model : models_of_class(GetParam())) {
    std::vector<BsdfCase> cases;
    int unsound = 0;
    for (size_t i = offset++ % 8; i < all.size(); i += 8) {
      if (must_match(all[i])) cases.push_back(all[i]);
      const Evaluation alone = evaluate_reference(all[i], model);
      if (all[i].wo.z <= 0 || is_sound(alone)) continue;
      if (++unsound <= 3)
        describe_failure("reference alone", all[i], model, dvec3(alone.pdf_forward, alone.pdf_reverse, 0),
                         alone.value);
    }
    EXPECT_EQ(unsound, 0) << "values of the reference that are not finite or negative";
    const auto results = map_on_device<BsdfEvaluated>(create_kernel("bsdf_evaluate", model), cases);
    ErrorStatistics value("value", model), forward("pdf forward", model), reverse("pdf reverse", model);
    for (size_t i = 0; i < cases.size(); ++i)
      compare_evaluation(cases[i], model, results[i], value, forward, reverse);
    for (const ErrorStatistics* statistics : {&value, &forward, &reverse}) statistics->report(model.name());

    const auto samples = map_on_device<BsdfSampled>(create_kernel("bsdf_sample", model), cases);
    ErrorStatistics weight("weight", model), sampled("sampled pdf", model), back("its reverse", model);
    for (size_t i = 0; i < cases.size(); ++i) {
      if ((samples[i].flags & BSDF_SAMPLED_VALID) == 0 || (samples[i].flags & BSDF_SAMPLED_DELTA) != 0)
        continue;
      BsdfCase c = cases[i];
      c.wi = samples[i].wi;
      // The kernel knows the half vector that it drew, the reference only what the direction tells of it: of
      // lobes narrower than that nothing can be compared.
      const float cosine = std::min(c.wo.z, std::abs(c.wi.z));
      const float alpha = c.material.roughness * c.material.roughness;
      if (must_match(c) && (alpha == 0 || alpha * cosine > 0x1p-20F))
        compare_sample(c, model, samples[i], weight, sampled, back);
    }
    for (const ErrorStatistics* statistics : {&weight, &sampled, &back}) statistics->report(model.name());
  }
}

// Refraction lobes that narrow are known by the facet that was drawn, which a direction does not tell in
// single precision: the same numbers on both sides. Of a facet that errs by 8 roundings D changes by their
// share of alpha, twice: ln D = -2 ln(1 + tan^2 / alpha^2) + ..., whose slope is 2 / alpha at most.
TEST(BsdfNoBend, SamplesMatchTheReferenceAsFarAsTheirFacetIsKnown) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Model model{NDF_GGX, SHADOWING_SMITH, MATERIAL_CLASS_TRANSMISSIVE};
  Random random(77);
  std::vector<BsdfCase> cases;
  for (const float ior : {1 + 0x1p-23F, 1 + 0x1p-21F, 1.0001F})
    for (const float alpha : {1e-3F, 0.05F, 0.5F, 1.0F})
      for (int i = 0; i < 200; ++i) {
        BsdfCase c{};
        c.material = plain_material(Kind::Solid, std::sqrt(alpha));
        c.material.ior = ior;
        c.alpha = vec3(-1);
        c.is_front = i & 1;
        c.mode = i >> 1 & 1;
        const double theta = 1.4 * random.uniform();
        const double phi = 6.28 * random.uniform();
        c.wo = {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
        c.wi = {0, 0, 1};
        c.u_lobe = static_cast<float>(random.index(1u << 24) * 0x1p-24);
        c.u = {random.index(1u << 24) * 0x1p-24, random.index(1u << 24) * 0x1p-24};
        cases.push_back(c);
      }
  const auto results = map_on_device<BsdfSampled>(create_kernel("bsdf_sample", model), cases);
  double worst_direction = 0, worst_weight = 0, worst_pdf = 0;
  int compared = 0;
  for (size_t i = 0; i < cases.size(); ++i) {
    const BsdfCase& c = cases[i];
    const ReferenceCase r = reference_case(c, model);
    const reference::BsdfSample expected = r.bsdf.sample(normalize(r.wo), c.u_lobe, dvec2(c.u), r.mode);
    const BsdfSampled& found = results[i];
    if (!expected.is_valid || (found.flags & BSDF_SAMPLED_VALID) == 0) continue;  // masked, or at the horizon
    ++compared;
    const auto apart = [](double a, double b) { return std::abs(a - b) / std::abs(b); };
    const double alpha = double{c.material.roughness} * c.material.roughness;
    const double allowed = 1e-4 + 2 * 8 * 0x1p-24 / alpha;
    worst_direction = std::max(worst_direction, length(dvec3(found.wi) - mirrored_if_back(expected.wi, c)));
    worst_weight = std::max(worst_weight, apart(found.weight.x, expected.weight.x));
    worst_pdf = std::max({worst_pdf, apart(found.pdf_forward, expected.pdf_forward) / allowed,
                          apart(found.pdf_reverse, expected.pdf_reverse) / allowed});
  }
  std::printf(
      "%d samples: direction %.1e (bound 1e-6), weight %.1e (bound 1e-4), pdfs %.2f of what is allowed\n",
      compared, worst_direction, worst_weight, worst_pdf);
  EXPECT_GT(compared, 2000);
  EXPECT_LT(worst_direction, 1e-6);
  EXPECT_LT(worst_weight, 1e-4);
  EXPECT_LT(worst_pdf, 1);
}

// Where a cap's point and the direction nearly cancel, the facet is their small sum: an absolute error of
// that sum (five roundings of 6e-8 at the lobe's own width, here below 1) turns the facet by as much over its
// length, and refraction doubles that at most.
TEST(BsdfTail, FacetsFarFromTheLobeAreAsExactAsTheirSum) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Model model{NDF_GGX, SHADOWING_SMITH, MATERIAL_CLASS_TRANSMISSIVE};
  Random random(78);
  std::vector<BsdfCase> cases;
  for (int i = 0; i < 4000; ++i) {
    BsdfCase c{};
    c.material = plain_material(Kind::Solid, static_cast<float>(std::sqrt(random.log_uniform(0.02, 0.3))));
    c.alpha = vec3(-1);
    c.is_front = 1;
    c.wo = random.direction();
    c.wo.z = std::abs(c.wo.z);
    c.wi = {0, 0, 1};
    c.u_lobe = static_cast<float>(random.index(1u << 24) * 0x1p-24);
    c.u = {static_cast<float>(1 - random.log_uniform(1e-4, 1e-2)), random.index(1u << 24) * 0x1p-24};
    cases.push_back(c);
  }
  const auto results = map_on_device<BsdfSampled>(create_kernel("bsdf_sample", model), cases);
  double worst = 0;
  int compared = 0;
  for (size_t i = 0; i < cases.size(); ++i) {
    const BsdfCase& c = cases[i];
    const ReferenceCase r = reference_case(c, model);
    const BsdfSample expected = r.bsdf.sample(normalize(r.wo), c.u_lobe, dvec2(c.u), r.mode);
    if (!expected.is_valid || (results[i].flags & BSDF_SAMPLED_VALID) == 0) continue;
    if (expected.is_transmitted != ((results[i].flags & BSDF_SAMPLED_TRANSMITTED) != 0)) continue;  // a tie
    ++compared;
    const double alpha = double{c.material.roughness} * c.material.roughness;
    const dvec3 stretched = normalize(dvec3(alpha * dvec2(c.wo), c.wo.z));
    const double z = 1 - double{c.u.x} * (1 + stretched.z);
    const double azimuth = 2 * std::numbers::pi * c.u.y;
    const dvec3 sum =
        dvec3(std::sqrt(1 - z * z) * dvec2(std::cos(azimuth), std::sin(azimuth)), z) + stretched;
    const double allowed = 1e-6 + 2 * 5 * 0x1p-24 / length(dvec3(alpha * dvec2(sum), sum.z)) * alpha;
    worst = std::max(worst, length(dvec3(results[i].wi) - expected.wi) / allowed);
  }
  std::printf("%d samples: direction %.2f of what is allowed\n", compared, worst);
  EXPECT_GT(compared, 2000);
  EXPECT_LT(worst, 1);
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
        const double of_film = c.material.iridescence > 0 ? FILM_ERROR / expected.pdf_forward : 0;
        const double difference = std::abs(sampled.weight[channel] - expected.weight[channel]);
        const double error = difference <= of_film ? 0 : (difference - of_film) / expected.weight[channel];
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

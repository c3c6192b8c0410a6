// Microfacet lobes: the shaders' scattering functions and the reference's against extended precision.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "interface/energy.h"
#include "interface/wavefront.h"
#include "reference/regularization.hpp"
#include "stability/batch.hpp"
#include "stability/bsdf_cases.hpp"
#include "stability/exact_bsdf.hpp"
#include "stability/families.hpp"

namespace regulus::stability {

using glm::dvec3;
using namespace interface;

namespace {

struct Model {
  uint32_t ndf, shadowing, bound;
  const char* name;
};

// Every distribution with every shadowing; bounds take turns, so that each meets all of both.
constexpr Model MODELS[] = {
    {NDF_GGX, SHADOWING_SMITH, BOUND_PEAK, "GGX, Smith, peak"},
    {NDF_BECKMANN, SHADOWING_SMITH_UNCORRELATED, BOUND_SMITH, "Beckmann, uncorrelated Smith, smith"},
    {NDF_COSINE, SHADOWING_V_CAVITY, BOUND_DIRECTIONAL, "Cosine, V-cavity, directional"},
    {NDF_GGX, SHADOWING_SMITH_UNCORRELATED, BOUND_DIRECTIONAL, "GGX, uncorrelated Smith, directional"},
    {NDF_BECKMANN, SHADOWING_SMITH, BOUND_DIRECTIONAL, "Beckmann, Smith, directional"},
    {NDF_GGX, SHADOWING_V_CAVITY, BOUND_SMITH, "GGX, V-cavity, smith"},
    {NDF_BECKMANN, SHADOWING_V_CAVITY, BOUND_PEAK, "Beckmann, V-cavity, peak"},
    {NDF_COSINE, SHADOWING_SMITH, BOUND_SMITH, "Cosine, Smith, smith"},
    {NDF_COSINE, SHADOWING_SMITH_UNCORRELATED, BOUND_PEAK, "Cosine, uncorrelated Smith, peak"},
};
constexpr size_t QUICK_MODELS = 5;  // with all three forms of the directional bound

/// A pair in extended precision, whose inputs can be moved.
struct ExactCase {
  ExactLobe lobe;
  ExactVector wo, wi;
  ExactBound bound;
};

ExactCase exact_case(const BsdfCase& c, const Model& model) {
  const StabilityBsdfCase& in = c.inputs;
  return {{model.ndf, model.shadowing, ExactPair(in.alpha), in.material.ior, in.is_front != 0, c.is_metal},
          ExactVector(in.wo),
          ExactVector(in.wi),
          {model.bound, in.tau}};
}

/// Sums what moving each input by `ulps` does to each of the values of f(case).
template <size_t N, typename Function>
std::array<Exact, N> moved_by(const ExactCase& base, const std::array<Exact, N>& at_base, double ulps,
                              const Function& f) {
  std::array<Exact, N> sum{};
  const auto add_effect = [&](const auto& move) {
    std::array<Exact, N> most{};
    for (const double sign : {-1.0, 1.0}) {
      ExactCase moved = base;
      move(moved, 1 + sign * static_cast<Exact>(ulps));
      const std::array<Exact, N> there = f(moved);
      for (size_t k = 0; k < N; ++k) most[k] = std::max(most[k], std::abs(there[k] - at_base[k]));
    }
    for (size_t k = 0; k < N; ++k) sum[k] += most[k];
  };
  for (int axis = 0; axis < 3; ++axis) {
    add_effect([axis](ExactCase& c, Exact factor) { c.wo[axis] *= factor; });
    add_effect([axis](ExactCase& c, Exact factor) { c.wi[axis] *= factor; });
  }
  // Both at once: where both are at the critical angle a product stays 0 while either does.
  add_effect([](ExactCase& c, Exact factor) {
    c.wo.z *= factor;
    c.wi.z *= factor;
  });
  add_effect([](ExactCase& c, Exact factor) { c.lobe.ior *= factor; });
  add_effect([](ExactCase& c, Exact factor) { c.lobe.alpha.x *= factor; });
  add_effect([](ExactCase& c, Exact factor) { c.lobe.alpha.y *= factor; });
  return sum;
}

ExactVector unit(const ExactVector& v) {
  return v / std::sqrt(dot(v, v));
}

// The directions that the rounded vectors stand for have unit length.
std::array<Exact, 5> scattering_of(const ExactCase& c) {
  const ExactScattering s = scatter(c.lobe, unit(c.wo), unit(c.wi), c.bound);
  return {s.value, s.forward, s.reverse, s.raised, s.raised_forward};
}

std::array<Exact, 1> weight_of(const ExactCase& c) {
  const ExactScattering s = scatter(c.lobe, unit(c.wo), unit(c.wi), c.bound);
  return {s.forward > 0 ? s.value * std::abs(unit(c.wi).z) / s.forward : Exact{0}};
}

/// The reference's frame has z at the front side.
dvec3 in_reference_frame(const glm::vec3& w, const BsdfCase& c) {
  return normalize(dvec3(w.x, w.y, c.inputs.is_front != 0 ? double{w.z} : -double{w.z}));
}

reference::Bsdf reference_bsdf(const BsdfCase& c, const Model& model) {
  reference::BsdfParameters p;
  p.base_color = dvec3(1);
  p.metallic = c.inputs.material.metallic;
  p.alpha = glm::dvec2(c.inputs.alpha);
  p.ior = c.inputs.material.ior;
  p.transmission = c.inputs.material.transmission;
  p.is_volume = !c.is_metal;
  p.ndf = model.ndf;
  p.shadowing = model.shadowing;
  p.fresnel_average = 0;  // nothing is diffuse
  return reference::Bsdf(p);
}

/// Value, both pdfs, regularized value and pdf, as ExactScattering.
std::array<double, 5> reference_scattering(const BsdfCase& c, const Model& model) {
  const reference::Bsdf bsdf = reference_bsdf(c, model);
  const dvec3 wo = in_reference_frame(c.inputs.wo, c);
  const dvec3 wi = in_reference_frame(c.inputs.wi, c);
  reference::Regularization regularization;
  regularization.is_on = true;
  regularization.tau = regularization.full_tau = c.inputs.tau;
  regularization.bound = model.bound;
  const auto raised = reference::raise(bsdf, wo, wi, nullptr, regularization);
  return {bsdf.value(wo, wi, reference::TransportMode::Radiance).y, bsdf.pdf(wo, wi), bsdf.pdf(wi, wo),
          raised->value.y, raised->pdf_wi};
}

double reference_weight(const BsdfCase& c, const Model& model) {
  const reference::Bsdf bsdf = reference_bsdf(c, model);
  const dvec3 wo = in_reference_frame(c.inputs.wo, c);
  const dvec3 wi = in_reference_frame(c.inputs.wi, c);
  const double pdf = bsdf.pdf(wo, wi);
  return pdf > 0 ? bsdf.value(wo, wi, reference::TransportMode::Radiance).y * std::abs(wi.z) / pdf : 0;
}

std::string describe(const BsdfCase& c, const Model& model, const char* quantity) {
  const StabilityBsdfCase& in = c.inputs;
  return fmt::format(
      "{}: {} of {} seen from the {}, alpha {:.9g} {:.9g}, index {:.9g}, tau {:.3g}, wo {:.9g} {:.9g} "
      "{:.9g}, wi {:.9g} "
      "{:.9g} {:.9g}",
      model.name, quantity, c.is_metal ? "metal" : "solid", in.is_front != 0 ? "front" : "back", in.alpha.x,
      in.alpha.y, in.material.ior, in.tau, in.wo.x, in.wo.y, in.wo.z, in.wi.x, in.wi.y, in.wi.z);
}

// About sixty roundings of 6e-8, and for Cosine the error of the projected area in two directions (1e-5 each,
// shaders/lib/ndf.glsl).
constexpr double OWN_ERROR = 2.4e-5;
// More of a regularized one: weights blend logarithms of up to 83, rounded three times.
constexpr double OWN_RAISED_ERROR = OWN_ERROR + 3 * 83 * 0x1p-24;
// The reference integrates the Cosine distribution's Lambda.
constexpr double OWN_REFERENCE_ERROR = 1e-9;
constexpr Exact NEGLIGIBLE = 1e-30;
constexpr const char* BOUND =
    "{}, and what moving each input by 2 ulp does to the formula in extended precision";

/// The sweeps that one list of cases fills.
struct BsdfResults {
  Sweep value, pdfs, raised, weight;

  explicit BsdfResults(const BsdfSweep& sweep)
      : value(text(sweep, "value", OWN_ERROR)),
        pdfs(text(sweep, "pdfs", OWN_ERROR)),
        raised(text(sweep, "regularized", OWN_RAISED_ERROR)),
        weight(text(sweep, "sampling weight", OWN_ERROR)) {}

  static SweepText text(const BsdfSweep& sweep, const char* quantity, double own) {
    return {"bsdf",
            fmt::format("{} {}", quantity, sweep.name),
            sweep.parameter,
            fmt::format(BOUND, fmt::format("{:.1e} for arithmetic", own)),
            own,
            OWN_REFERENCE_ERROR};
  }

  void add_lobe(const BsdfCase& c, const Model& model, const StabilityBsdfResult& found,
                uint32_t quantities) {
    const ExactCase exact = exact_case(c, model);
    const std::array<Exact, 5> truth = scattering_of(exact);
    const std::array<Exact, 5> moved = moved_by(exact, truth, ROUNDING_OF_INPUTS, scattering_of);
    const std::array<double, 5> expected = reference_scattering(c, model);
    const std::array<float, 5> measured = {found.value, found.pdf_forward, found.pdf_reverse, found.raised,
                                           found.raised_forward};
    static constexpr const char* NAMES[] = {"value", "pdf", "reverse pdf", "regularized value",
                                            "regularized pdf"};
    const auto add = [&](Sweep& sweep, size_t k) {
      sweep.add({c.parameter, measured[k], expected[k], truth[k], moved[k]},
                [&] { return describe(c, model, NAMES[k]); });
    };
    if ((quantities & LOBE) != 0) {
      add(value, 0);
      add(pdfs, 1);
      add(pdfs, 2);
    }
    if ((quantities & RAISED) != 0) {
      add(raised, 3);
      // Weights clamp densities at 1e-36 (shaders/lib/lobes/facets.glsl), where nothing is measured.
      truth[3] < NEGLIGIBLE ? raised.lose() : add(raised, 4);
    }
  }

  /// The weight at the direction that the device drew.
  void add_weight(BsdfCase c, const Model& model, const StabilityBsdfResult& found) {
    if (found.weight < 0) {
      weight.lose();
      return;
    }
    c.inputs.wi = found.sampled_wi;
    const ExactCase exact = exact_case(c, model);
    const std::array<Exact, 1> truth = weight_of(exact);
    // Roundings of the facet are larger by the index in a refracted direction.
    const double ulps =
        c.inputs.wi.z < 0 ? ROUNDING_OF_INPUTS * std::max(1.0f, c.inputs.material.ior) : ROUNDING_OF_INPUTS;
    const std::array<Exact, 1> moved = moved_by(exact, truth, ulps, weight_of);
    const double expected = reference_weight(c, model);
    weight.add({c.parameter, found.weight, expected, truth[0], moved[0]},
               [&] { return describe(c, model, "weight"); });
  }
};

}  // namespace

std::vector<Sweep> sweep_bsdf(gpu::Device& device, Extent extent) {
  const std::vector<BsdfSweep> sweeps = bsdf_sweeps(extent);
  std::vector<BsdfResults> results;
  results.reserve(sweeps.size());
  for (const BsdfSweep& sweep : sweeps) results.emplace_back(sweep);
  const gpu::Buffer nothing_lost = gpu::upload_new(
      device, std::vector<float>(ENERGY_PER_INDEX + ENERGY_INDEX_WORDS, 1.0f), "energy tables");
  for (size_t m = 0; m < (extent == Extent::Quick ? QUICK_MODELS : std::size(MODELS)); ++m) {
    const Model& model = MODELS[m];
    const gpu::Kernel kernel = create_kernel(device, "bsdf",
                                             {{SPEC_NDF, model.ndf},
                                              {SPEC_SHADOWING, model.shadowing},
                                              {SPEC_MATERIAL_CLASS, MATERIAL_CLASS_TRANSMISSIVE},
                                              {SPEC_FEATURES, FEATURE_ROUGH_SPECULAR},
                                              {SPEC_REGULARIZATION, REGULARIZATION_ROUGHNESS},
                                              {SPEC_BOUND, model.bound}});
    for (size_t s = 0; s < sweeps.size(); ++s) {
      const BsdfSweep& sweep = sweeps[s];
      if (sweep.is_anisotropic && model.ndf == NDF_COSINE) continue;
      std::vector<StabilityBsdfCase> inputs;
      for (const BsdfCase& c : sweep.cases) {
        inputs.push_back(c.inputs);
        inputs.back().energy_tables = device_address(nothing_lost.address());
      }
      const auto found = map_on_device<StabilityBsdfResult>(device, kernel, inputs);
      for (size_t i = 0; i < found.size(); ++i) {
        results[s].add_lobe(sweep.cases[i], model, found[i], sweep.quantities);
        if ((sweep.quantities & WEIGHT) != 0) results[s].add_weight(sweep.cases[i], model, found[i]);
      }
    }
  }
  std::vector<Sweep> all;
  for (BsdfResults& result : results)
    for (Sweep* sweep : {&result.value, &result.pdfs, &result.raised, &result.weight})
      if (sweep->cases() > 0) all.push_back(std::move(*sweep));
  return all;
}

}  // namespace regulus::stability

#include "render/stages.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "render/shaders.hpp"

namespace regulus::render {

using namespace interface;

namespace {

uint32_t groups_of(uint64_t items) {
  return static_cast<uint32_t>((items + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE);
}

}  // namespace

uint32_t effective_techniques(const scene::Features& features, const RenderSettings& settings) {
  uint32_t techniques = settings.techniques;
  constexpr uint32_t EMITTERS = FEATURE_TRIANGLE_LIGHTS | FEATURE_ENVIRONMENT;  // that rays can meet
  constexpr uint32_t LIGHTS = EMITTERS | FEATURE_POINT_LIGHTS | FEATURE_DIRECTIONAL_LIGHTS;
  if ((features.bits & LIGHTS) == 0) techniques &= ~(TECHNIQUE_NEE | LIGHT_SUBPATH_TECHNIQUES);
  if ((features.bits & EMITTERS) == 0) techniques &= ~TECHNIQUE_HIT;
  const bool is_regularized = effective_regularization(features, settings) != REGULARIZATION_NONE;
  if (!features.has_connectible_surfaces && !is_regularized)
    techniques &= ~(TECHNIQUE_CONNECT | TECHNIQUE_MERGE);
  return techniques;
}

uint32_t effective_regularization(const scene::Features& features, const RenderSettings& settings) {
  if (std::isinf(settings.tau)) return REGULARIZATION_NONE;
  // alpha_tau of docs/mathematics.md 2.2: 1 / sqrt(4 pi tau) for reflection, n / |n - 1| / sqrt(pi tau) for
  // refraction.
  const float alpha = 1 / std::sqrt(std::numbers::pi_v<float> * settings.tau);
  const bool is_sharp =
      features.least_reflection_alpha < 0.5f * alpha || features.least_refraction_alpha < alpha;
  return is_sharp || settings.bound != BOUND_PEAK ? settings.regularization : REGULARIZATION_NONE;
}

uint32_t effective_light_sampling(const scene::Scene& scene, const RenderSettings& settings) {
  if ((settings.techniques & TECHNIQUE_NEE) == 0) return LIGHT_SAMPLING_POWER;
  return scene::resolve_light_sampling(settings.light_sampling, scene.lights.size());
}

void require_merge_radius(const RenderSettings& settings) {
  if ((settings.techniques & TECHNIQUE_MERGE) != 0 && !(settings.merge_radius > 0))
    throw std::logic_error("technique merge has no radius");
}

bool is_needed(const StageStep& step, const scene::Features& features, const RenderSettings& settings) {
  if (step.techniques != ANY_TECHNIQUE && (settings.techniques & step.techniques) == 0) return false;
  if (step.needs == Needs::CacheConnections && settings.cache_connections == 0) return false;
  if (step.needs == Needs::Environment && (features.bits & FEATURE_ENVIRONMENT) == 0) return false;
  if (step.needs == Needs::VaryingMedia && !features.has_varying_starts) return false;
  if (step.needs == Needs::Variance && (settings.aovs & AOV_VARIANCE) == 0) return false;
  if (step.needs == Needs::SurfaceAovs && (settings.aovs & SURFACE_AOVS) == 0) return false;
  if (step.needs == Needs::SurfaceFootprints && (settings.aovs & AOV_SIGMA) == 0) return false;
  return step.material_class == ANY_CLASS || (features.material_classes >> step.material_class & 1) != 0;
}

std::vector<PipelineStep> build_pipeline(gpu::Device& device, const scene::Features& features,
                                         const RenderSettings& settings) {
  std::vector<const StageStep*> steps;
  std::vector<gpu::KernelDescription> descriptions;
  for (const StageStep& step : STAGES) {
    if (step.extent == Extent::Scan || !is_needed(step, features, settings)) continue;
    // What shades whatever it meets needs the most general class.
    const uint32_t material_class = step.pass == Pass::Surface         ? MATERIAL_CLASS_TRANSMISSIVE
                                    : step.material_class == ANY_CLASS ? 0
                                                                       : step.material_class;
    steps.push_back(&step);
    descriptions.push_back({step.name,
                            stage_spirv(device, step.shader),
                            {{SPEC_NDF, settings.ndf},
                             {SPEC_SHADOWING, settings.shadowing},
                             {SPEC_MATERIAL_CLASS, material_class},
                             {SPEC_FEATURES, features.bits},
                             {SPEC_TECHNIQUES, settings.techniques},
                             {SPEC_REGULARIZATION, settings.regularization},
                             {SPEC_BOUND, settings.bound},
                             {SPEC_MIS, settings.mis},
                             {SPEC_WALK, step.pass == Pass::Light ? WALK_LIGHT : WALK_CAMERA},
                             {SPEC_SAMPLER_QUALITY, settings.sampler_quality},
                             {SPEC_CLAMP, std::isfinite(settings.largest_contribution) ? 1u : 0u},
                             {SPEC_CROP, settings.crop.pixels() != 0 ? 1u : 0u},
                             {SPEC_ENERGY_COMPENSATION, settings.has_energy_compensation ? 1u : 0u},
                             {SPEC_LIGHT_SAMPLING, settings.light_sampling},
                             {SPEC_STRATEGIES, settings.has_strategy_images ? 1u : 0u},
                             {SPEC_FILM_EXPONENT, static_cast<uint32_t>(features.film_exponents.radiance)},
                             {SPEC_SQUARE_EXPONENT, static_cast<uint32_t>(features.film_exponents.squares)},
                             {SPEC_FILTER, settings.filter},
                             {SPEC_SAMPLER, settings.sampler}}});
  }
  std::vector<gpu::Kernel> kernels = device.create_kernels(descriptions);
  std::vector<PipelineStep> pipeline;
  for (size_t i = 0; i < steps.size(); ++i) pipeline.push_back({*steps[i], std::move(kernels[i])});
  return pipeline;
}

void record_over_queue(gpu::CommandList& commands, const PipelineStep& entry, const StageArguments& arguments,
                       const gpu::Buffer& queue_heads) {
  const uint64_t head = uint64_t{arguments.bounce} * QUEUES_PER_BOUNCE + entry.step.queue;
  commands.dispatch_indirect(entry.kernel, gpu::bytes_of(arguments), queue_heads, head * sizeof(QueueHead));
}

void record_step(gpu::CommandList& commands, const std::vector<PipelineStep>& pipeline, std::string_view name,
                 const StageArguments& arguments, uint64_t items) {
  const auto entry = std::ranges::find(
      pipeline, name, [](const PipelineStep& candidate) { return std::string_view(candidate.step.name); });
  if (entry == pipeline.end()) return;
  constexpr uint64_t MOST = uint64_t{65535} * WORKGROUP_SIZE;  // groups per dispatch, Vulkan's minimum
  for (uint64_t first = 0; first < items; first += MOST) {
    StageArguments own = arguments;
    own.first_pixel += static_cast<uint32_t>(first);
    if (first > 0) commands.independent();
    commands.dispatch(entry->kernel, gpu::bytes_of(own), groups_of(std::min(MOST, items - first)));
  }
}

}  // namespace regulus::render

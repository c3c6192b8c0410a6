#include "render/stages.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "render/host_rays.hpp"
#include "render/shaders.hpp"

namespace regulus::render {

using namespace interface;

namespace {

uint32_t groups_of(uint64_t items) {
  return static_cast<uint32_t>((items + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE);
}

}  // namespace

bool is_needed(const StageStep& step, const Plan& plan) {
  if (step.techniques != ANY_TECHNIQUE && (plan.techniques & step.techniques) == 0) return false;
  if (step.needs == Needs::CacheConnections && plan.cache_connections == 0) return false;
  if (step.needs == Needs::Environment && (plan.features.bits & FEATURE_ENVIRONMENT) == 0) return false;
  if (step.needs == Needs::VaryingMedia && !plan.features.has_varying_starts) return false;
  if (step.needs == Needs::Variance && (plan.aovs & AOV_VARIANCE) == 0) return false;
  if (step.needs == Needs::SurfaceAovs && (plan.aovs & SURFACE_AOVS) == 0) return false;
  if (step.needs == Needs::SurfaceFootprints && (plan.aovs & AOV_SIGMA) == 0) return false;
  return step.material_class == ANY_CLASS || (plan.features.material_classes >> step.material_class & 1) != 0;
}

std::vector<PipelineStep> build_pipeline(gpu::Device& device, const Plan& plan, uint32_t rays) {
  std::vector<PipelineStep> pipeline;
  std::vector<size_t> with_kernel;  // places in the pipeline
  std::vector<gpu::KernelDescription> descriptions;
  for (const StageStep& step : STAGES) {
    if (step.extent == Extent::Scan || !is_needed(step, plan)) continue;
    pipeline.push_back({step, {}});
    const bool is_on_host = rays == RAYS_HOST && HostRays::traces(step);
    if (is_on_host && !HostRays::needs_kernel(step)) continue;
    // What shades whatever it meets needs the most general class.
    const uint32_t material_class = step.pass == Pass::Surface         ? MATERIAL_CLASS_TRANSMISSIVE
                                    : step.material_class == ANY_CLASS ? 0
                                                                       : step.material_class;
    with_kernel.push_back(pipeline.size() - 1);
    descriptions.push_back(
        {step.name,
         stage_spirv(device, step.shader),
         {{SPEC_NDF, plan.ndf},
          {SPEC_SHADOWING, plan.shadowing},
          {SPEC_MATERIAL_CLASS, material_class},
          {SPEC_FEATURES, plan.features.bits},
          {SPEC_TECHNIQUES, plan.techniques},
          {SPEC_REGULARIZATION, plan.regularization},
          {SPEC_BOUND, plan.bound},
          {SPEC_MIS, plan.mis},
          {SPEC_WALK, step.pass == Pass::Light ? WALK_LIGHT : WALK_CAMERA},
          {SPEC_SAMPLER_QUALITY, plan.sampler_quality},
          {SPEC_CLAMP, std::isfinite(plan.largest_contribution) ? 1u : 0u},
          {SPEC_CROP, plan.crop.pixels() != 0 ? 1u : 0u},
          {SPEC_ENERGY_COMPENSATION, plan.has_energy_compensation ? 1u : 0u},
          {SPEC_LIGHT_SAMPLING, plan.light_sampling},
          {SPEC_STRATEGIES, plan.has_strategy_images ? 1u : 0u},
          {SPEC_FILM_EXPONENT, static_cast<uint32_t>(plan.features.film_exponents.radiance)},
          {SPEC_SQUARE_EXPONENT, static_cast<uint32_t>(plan.features.film_exponents.squares)},
          {SPEC_FILTER, plan.filter},
          {SPEC_SAMPLER, plan.sampler},
          {SPEC_RAYS, is_on_host ? RAYS_HOST : RAYS_SOFTWARE}}});
  }
  std::vector<gpu::Kernel> kernels = device.create_kernels(descriptions);
  for (size_t i = 0; i < kernels.size(); ++i) pipeline[with_kernel[i]].kernel = std::move(kernels[i]);
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

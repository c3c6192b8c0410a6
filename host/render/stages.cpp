#include "render/stages.hpp"

#include <algorithm>
#include <cmath>

#include "render/host_rays.hpp"

namespace regulus::render {

using namespace interface;

bool is_needed(const StageStep& step, const Plan& plan) {
  if (step.techniques != ANY_TECHNIQUE && (plan.techniques & step.techniques) == 0) return false;
  if (step.state != STATE_ALWAYS && !plan.keeps(step.state)) return false;
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
    // A pass that shades whatever it meets needs the most general class.
    const uint32_t material_class = step.pass == Pass::Surface         ? MATERIAL_CLASS_TRANSMISSIVE
                                    : step.material_class == ANY_CLASS ? 0
                                                                       : step.material_class;
    with_kernel.push_back(pipeline.size() - 1);
    descriptions.push_back(
        {step.name,
         stage_spirv(device, step.stage, rays),
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
          {SPEC_LIGHT_GUIDE, plan.light_guide ? 1u : 0u},
          {SPEC_SHADOW_ROULETTE, plan.shadow_roulette > 0 ? 1u : 0u},
          {SPEC_WALK_GUIDE, plan.walk_guide ? 1u : 0u},
          {SPEC_STATE, plan.state & STATE_OF_KERNELS},
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
  commands.dispatch_indirect(entry.kernel, gpu::bytes_of(arguments), queue_heads,
                             QueueHeads::offset_of(arguments.bounce, entry.step.queue));
}

void record_items(gpu::CommandList& commands, const PipelineStep& entry, StageArguments arguments,
                  uint64_t items, uint32_t StageArguments::*first, uint64_t most_groups) {
  const uint64_t most = most_groups * WORKGROUP_SIZE;
  for (uint64_t done = 0; done < items; done += most) {
    const uint64_t here = std::min(most, items - done);
    if (done > 0) commands.independent();
    commands.dispatch(entry.kernel, gpu::bytes_of(arguments),
                      static_cast<uint32_t>((here + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE));
    arguments.*first += static_cast<uint32_t>(here);
  }
}

}  // namespace regulus::render

#include "render/stages.hpp"

#include <string_view>

#include "render/shaders.hpp"

namespace regulus::render {

using namespace interface;

bool is_needed(const StageStep& step, const scene::Features& features, const RenderSettings& settings) {
  if (step.technique != 0 && (settings.techniques & step.technique) == 0) return false;
  return step.material_class == ANY_CLASS || (features.material_classes >> step.material_class & 1) != 0;
}

std::vector<PipelineStep> build_pipeline(gpu::Device& device, const scene::Features& features,
                                         const RenderSettings& settings) {
  std::vector<PipelineStep> pipeline;
  for (const StageStep& step : PATH_TRACING_PASS) {
    if (!is_needed(step, features, settings)) continue;
    const uint32_t material_class = step.material_class == ANY_CLASS ? 0 : step.material_class;
    gpu::KernelDescription description{step.name,
                                       stage_spirv(device, step.shader),
                                       {{SPEC_NDF, settings.ndf},
                                        {SPEC_SHADOWING, settings.shadowing},
                                        {SPEC_MATERIAL_CLASS, material_class},
                                        {SPEC_FEATURES, features.bits},
                                        {SPEC_TECHNIQUES, settings.techniques},
                                        {SPEC_FILTER, settings.filter},
                                        {SPEC_SAMPLER, settings.sampler}}};
    pipeline.push_back({step, device.create_kernel(description)});
  }
  return pipeline;
}

void record_wave(gpu::CommandList& commands, const std::vector<PipelineStep>& pipeline,
                 const WaveCommands& wave) {
  StageArguments arguments = wave.arguments;
  const uint32_t wave_groups = (arguments.wave_paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE;
  const auto record_extent = [&](Extent extent) {
    std::string_view previous_shader;
    for (const PipelineStep& entry : pipeline) {
      if (entry.step.extent != extent) continue;
      if (entry.step.shader == previous_shader) commands.independent();
      previous_shader = entry.step.shader;
      if (extent == Extent::Bounce) {
        const uint64_t head = uint64_t{arguments.bounce} * QUEUES_PER_BOUNCE + entry.step.queue;
        commands.dispatch_indirect(entry.kernel, gpu::bytes_of(arguments), wave.queue_heads,
                                   head * sizeof(QueueHead));
      } else {
        commands.dispatch(entry.kernel, gpu::bytes_of(arguments), extent == Extent::Once ? 1 : wave_groups);
      }
    }
  };
  record_extent(Extent::WaveStart);
  for (arguments.bounce = 0; arguments.bounce < wave.bounces; ++arguments.bounce)
    record_extent(Extent::Bounce);
  record_extent(Extent::WaveEnd);
  record_extent(Extent::Once);
}

}  // namespace regulus::render

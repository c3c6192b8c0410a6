// The stages of a pass, in order, as data. A reader who wants to know what the renderer does reads
// PATH_TRACING_PASS; a stage whose condition does not hold is neither built nor dispatched.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/settings.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

/// How often a stage runs in a pass, and over what.
enum class Extent {
  WaveStart,  ///< once, over all path slots, before the first bounce
  Bounce,     ///< per bounce, over the queue named in the step
  WaveEnd,    ///< once, over all path slots, after the last bounce
  Once,       ///< one workgroup, after everything else
};

/// One line of a pass. Steps that follow each other with the same shader work on different items of the
/// same queues and need no order between them.
struct StageStep {
  const char* shader;  ///< file name in shaders/stages
  const char* name;    ///< in timings and statistics
  Extent extent;
  uint32_t queue;           ///< QUEUE_*, for Extent::Bounce
  uint32_t material_class;  ///< MATERIAL_CLASS_*; ANY_CLASS: the stage does not depend on it
  uint32_t technique;       ///< runs only if this TECHNIQUE_* is enabled; 0: always
};

inline constexpr uint32_t ANY_CLASS = interface::INVALID_INDEX;

// clang-format off
inline constexpr std::array PATH_TRACING_PASS = {
    StageStep{"camera_generate",  "camera_generate",  Extent::WaveStart, 0, ANY_CLASS, 0},
    StageStep{"trace_closest",    "trace_closest",    Extent::Bounce, interface::QUEUE_RAYS, ANY_CLASS, 0},
    StageStep{"camera_bounce",    "camera_bounce.diffuse", Extent::Bounce,
              interface::QUEUE_BOUNCE + interface::MATERIAL_CLASS_DIFFUSE, interface::MATERIAL_CLASS_DIFFUSE, 0},
    StageStep{"camera_bounce",    "camera_bounce.opaque", Extent::Bounce,
              interface::QUEUE_BOUNCE + interface::MATERIAL_CLASS_OPAQUE, interface::MATERIAL_CLASS_OPAQUE, 0},
    StageStep{"camera_bounce",    "camera_bounce.transmissive", Extent::Bounce,
              interface::QUEUE_BOUNCE + interface::MATERIAL_CLASS_TRANSMISSIVE, interface::MATERIAL_CLASS_TRANSMISSIVE, 0},
    StageStep{"trace_visibility", "trace_visibility", Extent::Bounce, interface::QUEUE_VISIBILITY, ANY_CLASS, interface::TECHNIQUE_NEE},
    StageStep{"accumulate",       "accumulate",       Extent::WaveEnd, 0, ANY_CLASS, 0},
    StageStep{"count_work",       "count_work",       Extent::Once, 0, ANY_CLASS, 0},
};
// clang-format on

/// A step with its kernel, ready to be recorded.
struct PipelineStep {
  StageStep step;
  gpu::Kernel kernel;
};

/// True if the step runs for a scene with these features under these settings.
bool is_needed(const StageStep& step, const scene::Features& features, const RenderSettings& settings);

/// Compiles the steps of the pass that are needed.
std::vector<PipelineStep> build_pipeline(gpu::Device& device, const scene::Features& features,
                                         const RenderSettings& settings);

/// Where the commands of a wave find their arguments.
struct WaveCommands {
  const gpu::Buffer& queue_heads;
  interface::StageArguments arguments;  ///< `bounce` is filled per bounce
  uint32_t bounces;                     ///< path edges
};

/// Records one wave: every step over its extent, queues dispatched indirectly with exact counts.
void record_wave(gpu::CommandList& commands, const std::vector<PipelineStep>& pipeline,
                 const WaveCommands& wave);

}  // namespace regulus::render

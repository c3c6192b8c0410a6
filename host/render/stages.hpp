// The stages of a render, in order, as data. To know what the renderer does, read STAGES. A stage whose
// condition does not hold is neither built nor dispatched.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/plan.hpp"
#include "render/queues.hpp"
#include "render/shaders.hpp"

namespace regulus::render {

/// A pass runs its stages over one wave of paths, or once over all light vertices of an iteration.
enum class Pass {
  Light,    ///< a wave of light paths
  Cache,    ///< makes the iteration's light vertices countable path by path, for connections to the cache
  Grid,     ///< sorts them into the merge grid
  Camera,   ///< a wave of camera paths
  Sample,   ///< after a sample of every pixel
  Surface,  ///< once per render: what camera rays meet first
};

/// How often a stage runs in its pass, and over what.
enum class Extent {
  WaveStart,      ///< once, over all path slots, before the first bounce
  Bounce,         ///< per bounce, over the queue named in the step
  WaveEnd,        ///< once, over all path slots, after the last bounce
  Once,           ///< one workgroup, after everything else
  LightPaths,     ///< over the light paths of the iteration
  LightVertices,  ///< over the light vertices of the iteration
  Pixels,         ///< over the pixels that are rendered
  MergeCount,     ///< per bounce whose merges are counted, over the queue named in the step
  Scan,           ///< a scan of what the stage before it wrote (render/scan.hpp)
};

/// One line of STAGES. Steps of the same stage that follow each other work on different items of the same
/// queues and need no order between them.
struct StageStep {
  Pass pass;
  Stage stage;
  const char* name;  ///< in timings and statistics
  Extent extent;
  Queue queue;              ///< for Extent::Bounce
  uint32_t material_class;  ///< MATERIAL_CLASS_*; ANY_CLASS: the stage does not depend on it
  uint32_t techniques;      ///< runs only if one of these TECHNIQUE_* is enabled; ANY_TECHNIQUE: whatever is
  uint32_t state = interface::STATE_ALWAYS;  ///< and only if one of these STATE_* is kept
};

inline constexpr uint32_t ANY_CLASS = interface::INVALID_INDEX;
inline constexpr uint32_t ANY_TECHNIQUE = 0;

namespace detail {
using namespace interface;
inline constexpr uint32_t LIGHT = LIGHT_SUBPATH_TECHNIQUES;
inline constexpr uint32_t CAMERA = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
inline constexpr uint32_t DIFFUSE = MATERIAL_CLASS_DIFFUSE, OPAQUE = MATERIAL_CLASS_OPAQUE,
                          TRANSMISSIVE = MATERIAL_CLASS_TRANSMISSIVE;

// clang-format off
inline constexpr std::array STAGES = {
    StageStep{Pass::Light,   Stage::LightGenerate,     "light_generate",             Extent::WaveStart,     Queue::None,                ANY_CLASS,    LIGHT},
    StageStep{Pass::Light,   Stage::StartMedia,        "light.start_media",          Extent::WaveStart,     Queue::None,                ANY_CLASS,    LIGHT,                             STATE_VARYING_STARTS},
    StageStep{Pass::Light,   Stage::TraceClosest,      "light.trace_closest",        Extent::Bounce,        Queue::Rays,                ANY_CLASS,    LIGHT},
    StageStep{Pass::Light,   Stage::LightBounce,       "light_bounce.diffuse",       Extent::Bounce,        bounce_queue(DIFFUSE),      DIFFUSE,      LIGHT},
    StageStep{Pass::Light,   Stage::LightBounce,       "light_bounce.opaque",        Extent::Bounce,        bounce_queue(OPAQUE),       OPAQUE,       LIGHT},
    StageStep{Pass::Light,   Stage::LightBounce,       "light_bounce.transmissive",  Extent::Bounce,        bounce_queue(TRANSMISSIVE), TRANSMISSIVE, LIGHT},
    StageStep{Pass::Light,   Stage::TraceSplats,       "trace_splats",               Extent::Bounce,        Queue::Splats,              ANY_CLASS,    TECHNIQUE_SPLAT},
    StageStep{Pass::Light,   Stage::CountWork,         "light.count_work",           Extent::Once,          Queue::None,                ANY_CLASS,    LIGHT},

    StageStep{Pass::Cache,   Stage::LightPathCounts,   "light_path_counts",          Extent::LightPaths,    Queue::None,                ANY_CLASS,    TECHNIQUE_CONNECT,                 STATE_CACHE},
    StageStep{Pass::Cache,   Stage::ScanSums,          "scan_light_paths",           Extent::Scan,          Queue::None,                ANY_CLASS,    TECHNIQUE_CONNECT,                 STATE_CACHE},

    StageStep{Pass::Grid,    Stage::GridCount,         "grid_count",                 Extent::LightVertices, Queue::None,                ANY_CLASS,    TECHNIQUE_MERGE},
    StageStep{Pass::Grid,    Stage::ScanSums,          "scan_grid",                  Extent::Scan,          Queue::None,                ANY_CLASS,    TECHNIQUE_MERGE},
    StageStep{Pass::Grid,    Stage::GridScatter,       "grid_scatter",               Extent::LightVertices, Queue::None,                ANY_CLASS,    TECHNIQUE_MERGE},

    StageStep{Pass::Camera,  Stage::CameraGenerate,    "camera_generate",            Extent::WaveStart,     Queue::None,                ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera,  Stage::StartMedia,        "start_media",                Extent::WaveStart,     Queue::None,                ANY_CLASS,    CAMERA,                            STATE_VARYING_STARTS},
    StageStep{Pass::Camera,  Stage::TraceClosest,      "trace_closest",              Extent::Bounce,        Queue::Rays,                ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera,  Stage::Escape,            "escape",                     Extent::Bounce,        Queue::Escaped,             ANY_CLASS,    TECHNIQUE_HIT,                     STATE_ESCAPES},
    StageStep{Pass::Camera,  Stage::CameraBounce,      "camera_bounce.diffuse",      Extent::Bounce,        bounce_queue(DIFFUSE),      DIFFUSE,      CAMERA},
    StageStep{Pass::Camera,  Stage::CameraBounce,      "camera_bounce.opaque",       Extent::Bounce,        bounce_queue(OPAQUE),       OPAQUE,       CAMERA},
    StageStep{Pass::Camera,  Stage::CameraBounce,      "camera_bounce.transmissive", Extent::Bounce,        bounce_queue(TRANSMISSIVE), TRANSMISSIVE, CAMERA},
    StageStep{Pass::Camera,  Stage::Connect,           "connect.diffuse",            Extent::Bounce,        pair_queue(DIFFUSE),        DIFFUSE,      TECHNIQUE_CONNECT},
    StageStep{Pass::Camera,  Stage::Connect,           "connect.opaque",             Extent::Bounce,        pair_queue(OPAQUE),         OPAQUE,       TECHNIQUE_CONNECT},
    StageStep{Pass::Camera,  Stage::Connect,           "connect.transmissive",       Extent::Bounce,        pair_queue(TRANSMISSIVE),   TRANSMISSIVE, TECHNIQUE_CONNECT},
    StageStep{Pass::Camera,  Stage::TraceVisibility,   "trace_visibility",           Extent::Bounce,        Queue::Visibility,          ANY_CLASS,    TECHNIQUE_NEE | TECHNIQUE_CONNECT},
    StageStep{Pass::Camera,  Stage::MergeCount,        "merge_count.diffuse",        Extent::MergeCount,    bounce_queue(DIFFUSE),      DIFFUSE,      TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::MergeCount,        "merge_count.opaque",         Extent::MergeCount,    bounce_queue(OPAQUE),       OPAQUE,       TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::MergeCount,        "merge_count.transmissive",   Extent::MergeCount,    bounce_queue(TRANSMISSIVE), TRANSMISSIVE, TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::Merge,             "merge.diffuse",              Extent::Bounce,        bounce_queue(DIFFUSE),      DIFFUSE,      TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::Merge,             "merge.opaque",               Extent::Bounce,        bounce_queue(OPAQUE),       OPAQUE,       TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::Merge,             "merge.transmissive",         Extent::Bounce,        bounce_queue(TRANSMISSIVE), TRANSMISSIVE, TECHNIQUE_MERGE},
    StageStep{Pass::Camera,  Stage::Accumulate,        "accumulate",                 Extent::WaveEnd,       Queue::None,                ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera,  Stage::CountWork,         "count_work",                 Extent::Once,          Queue::None,                ANY_CLASS,    CAMERA},

    StageStep{Pass::Sample,  Stage::SquareSamples,     "square_samples",             Extent::Pixels,        Queue::None,                ANY_CLASS,    ANY_TECHNIQUE,                     STATE_SQUARES},

    StageStep{Pass::Surface, Stage::SurfaceAovs,       "surface_aovs",               Extent::Pixels,        Queue::None,                ANY_CLASS,    ANY_TECHNIQUE,                     STATE_SURFACES},
    StageStep{Pass::Surface, Stage::SurfaceFootprints, "surface_footprints",         Extent::Pixels,        Queue::None,                ANY_CLASS,    ANY_TECHNIQUE,                     STATE_SIGMA},
};
// clang-format on
}  // namespace detail

using detail::STAGES;

/// A step with its kernel, ready to be recorded; without a kernel if the host does the whole step
/// (render/host_rays.hpp).
struct PipelineStep {
  StageStep step;
  gpu::Kernel kernel;
};

/// True if the step runs under the plan.
bool is_needed(const StageStep& step, const Plan& plan);

/// Compiles the steps of STAGES that are needed, except scans (render/scan.hpp). `rays`: RAYS_SOFTWARE,
/// RAYS_HOST or RAYS_HARDWARE.
std::vector<PipelineStep> build_pipeline(gpu::Device& device, const Plan& plan, uint32_t rays);

/// Records a dispatch of a step over its queue of the bounce, with the exact count that `queue_heads` hold.
void record_over_queue(gpu::CommandList& commands, const PipelineStep& entry,
                       const interface::StageArguments& arguments, const gpu::Buffer& queue_heads);

/// Records a step over `items` items, in as many dispatches as the device's limit `most_groups` requires.
/// Each finds its first item in member `first` of its arguments; the first of all is arguments.*first.
void record_items(gpu::CommandList& commands, const PipelineStep& entry, interface::StageArguments arguments,
                  uint64_t items, uint32_t interface::StageArguments::*first, uint64_t most_groups);

}  // namespace regulus::render

// The stages of a render, in order, as data. A reader who wants to know what the renderer does reads STAGES;
// a stage whose condition does not hold is neither built nor dispatched.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/plan.hpp"

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

/// When a step is needed at all, beside its technique.
enum class Needs {
  Nothing,
  CacheConnections,
  Environment,
  Variance,
  SurfaceAovs,
  SurfaceFootprints,
  VaryingMedia
};

/// One line of STAGES. Steps that follow each other with the same shader work on different items of the same
/// queues and need no order between them.
struct StageStep {
  Pass pass;
  const char* shader;  ///< file name in shaders/stages
  const char* name;    ///< in timings and statistics
  Extent extent;
  uint32_t queue;           ///< QUEUE_*, for Extent::Bounce
  uint32_t material_class;  ///< MATERIAL_CLASS_*; ANY_CLASS: the stage does not depend on it
  uint32_t techniques;      ///< runs only if one of these TECHNIQUE_* is enabled; ANY_TECHNIQUE: whatever is
  Needs needs = Needs::Nothing;
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
    StageStep{Pass::Light,  "light_generate",    "light_generate",              Extent::WaveStart,     0,                           ANY_CLASS,    LIGHT},
    StageStep{Pass::Light,  "start_media",       "light.start_media",           Extent::WaveStart,     0,                           ANY_CLASS,    LIGHT,             Needs::VaryingMedia},
    StageStep{Pass::Light,  "trace_closest",     "light.trace_closest",         Extent::Bounce,        QUEUE_RAYS,                  ANY_CLASS,    LIGHT},
    StageStep{Pass::Light,  "light_bounce",      "light_bounce.diffuse",        Extent::Bounce,        QUEUE_BOUNCE + DIFFUSE,      DIFFUSE,      LIGHT},
    StageStep{Pass::Light,  "light_bounce",      "light_bounce.opaque",         Extent::Bounce,        QUEUE_BOUNCE + OPAQUE,       OPAQUE,       LIGHT},
    StageStep{Pass::Light,  "light_bounce",      "light_bounce.transmissive",   Extent::Bounce,        QUEUE_BOUNCE + TRANSMISSIVE, TRANSMISSIVE, LIGHT},
    StageStep{Pass::Light,  "trace_splats",      "trace_splats",                Extent::Bounce,        QUEUE_SPLATS,                ANY_CLASS,    TECHNIQUE_SPLAT},
    StageStep{Pass::Light,  "count_work",        "light.count_work",            Extent::Once,          0,                           ANY_CLASS,    LIGHT},

    StageStep{Pass::Cache,  "light_path_counts", "light_path_counts",           Extent::LightPaths,    0,                           ANY_CLASS,    TECHNIQUE_CONNECT, Needs::CacheConnections},
    StageStep{Pass::Cache,  "scan_sums",         "scan_light_paths",            Extent::Scan,          0,                           ANY_CLASS,    TECHNIQUE_CONNECT, Needs::CacheConnections},

    StageStep{Pass::Grid,   "grid_count",        "grid_count",                  Extent::LightVertices, 0,                           ANY_CLASS,    TECHNIQUE_MERGE},
    StageStep{Pass::Grid,   "scan_sums",         "scan_grid",                   Extent::Scan,          0,                           ANY_CLASS,    TECHNIQUE_MERGE},
    StageStep{Pass::Grid,   "grid_scatter",      "grid_scatter",                Extent::LightVertices, 0,                           ANY_CLASS,    TECHNIQUE_MERGE},

    StageStep{Pass::Camera, "camera_generate",   "camera_generate",             Extent::WaveStart,     0,                           ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera, "start_media",       "start_media",                 Extent::WaveStart,     0,                           ANY_CLASS,    CAMERA,            Needs::VaryingMedia},
    StageStep{Pass::Camera, "trace_closest",     "trace_closest",               Extent::Bounce,        QUEUE_RAYS,                  ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera, "escape",            "escape",                      Extent::Bounce,        QUEUE_ESCAPED,               ANY_CLASS,    TECHNIQUE_HIT, Needs::Environment},
    StageStep{Pass::Camera, "camera_bounce",     "camera_bounce.diffuse",       Extent::Bounce,        QUEUE_BOUNCE + DIFFUSE,      DIFFUSE,      CAMERA},
    StageStep{Pass::Camera, "camera_bounce",     "camera_bounce.opaque",        Extent::Bounce,        QUEUE_BOUNCE + OPAQUE,       OPAQUE,       CAMERA},
    StageStep{Pass::Camera, "camera_bounce",     "camera_bounce.transmissive",  Extent::Bounce,        QUEUE_BOUNCE + TRANSMISSIVE, TRANSMISSIVE, CAMERA},
    StageStep{Pass::Camera, "connect",           "connect.diffuse",             Extent::Bounce,        QUEUE_PAIRS + DIFFUSE,       DIFFUSE,      TECHNIQUE_CONNECT},
    StageStep{Pass::Camera, "connect",           "connect.opaque",              Extent::Bounce,        QUEUE_PAIRS + OPAQUE,        OPAQUE,       TECHNIQUE_CONNECT},
    StageStep{Pass::Camera, "connect",           "connect.transmissive",        Extent::Bounce,        QUEUE_PAIRS + TRANSMISSIVE,  TRANSMISSIVE, TECHNIQUE_CONNECT},
    StageStep{Pass::Camera, "trace_visibility",  "trace_visibility",            Extent::Bounce,        QUEUE_VISIBILITY,            ANY_CLASS,    TECHNIQUE_NEE | TECHNIQUE_CONNECT},
    StageStep{Pass::Camera, "merge_count",       "merge_count.diffuse",         Extent::MergeCount,    QUEUE_BOUNCE + DIFFUSE,      DIFFUSE,      TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "merge_count",       "merge_count.opaque",          Extent::MergeCount,    QUEUE_BOUNCE + OPAQUE,       OPAQUE,       TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "merge_count",       "merge_count.transmissive",    Extent::MergeCount,    QUEUE_BOUNCE + TRANSMISSIVE, TRANSMISSIVE, TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "merge",             "merge.diffuse",               Extent::Bounce,        QUEUE_BOUNCE + DIFFUSE,      DIFFUSE,      TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "merge",             "merge.opaque",                Extent::Bounce,        QUEUE_BOUNCE + OPAQUE,       OPAQUE,       TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "merge",             "merge.transmissive",          Extent::Bounce,        QUEUE_BOUNCE + TRANSMISSIVE, TRANSMISSIVE, TECHNIQUE_MERGE},
    StageStep{Pass::Camera, "accumulate",        "accumulate",                  Extent::WaveEnd,       0,                           ANY_CLASS,    CAMERA},
    StageStep{Pass::Camera, "count_work",        "count_work",                  Extent::Once,          0,                           ANY_CLASS,    CAMERA},

    StageStep{Pass::Sample, "square_samples",    "square_samples",              Extent::Pixels,        0,                           ANY_CLASS,    ANY_TECHNIQUE, Needs::Variance},

    StageStep{Pass::Surface, "surface_aovs",     "surface_aovs",                Extent::Pixels,        0,                           ANY_CLASS,    ANY_TECHNIQUE, Needs::SurfaceAovs},
    StageStep{Pass::Surface, "surface_footprints", "surface_footprints",        Extent::Pixels,        0,                           ANY_CLASS,    ANY_TECHNIQUE, Needs::SurfaceFootprints},
};
// clang-format on
}  // namespace detail

using detail::STAGES;

/// A step with its kernel, ready to be recorded; without one if the host does all of it
/// (render/host_rays.hpp).
struct PipelineStep {
  StageStep step;
  gpu::Kernel kernel;
};

/// True if the step runs under the plan.
bool is_needed(const StageStep& step, const Plan& plan);

/// Compiles the steps of STAGES that are needed, but for scans (render/scan.hpp). `rays`: RAYS_SOFTWARE,
/// RAYS_HOST.
std::vector<PipelineStep> build_pipeline(gpu::Device& device, const Plan& plan, uint32_t rays);

/// Records a dispatch of a step over its queue of the bounce, with the exact count that `queue_heads` hold.
void record_over_queue(gpu::CommandList& commands, const PipelineStep& entry,
                       const interface::StageArguments& arguments, const gpu::Buffer& queue_heads);

/// Records the step named `name`, if it was built, over `items` items from arguments.first_pixel on, which
/// becomes the first item of each dispatch.
void record_step(gpu::CommandList& commands, const std::vector<PipelineStep>& pipeline, std::string_view name,
                 const interface::StageArguments& arguments, uint64_t items);

}  // namespace regulus::render

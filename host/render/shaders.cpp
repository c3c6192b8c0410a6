#include "render/shaders.hpp"

#include <array>
#include <string>

namespace regulus::render {

namespace {

// In the order of the enumeration.
constexpr std::array<std::string_view, STAGE_COUNT> FILES = {
    "accumulate",     "camera_bounce", "camera_generate", "connect",
    "count_work",     "energy_tables", "escape",          "grid_count",
    "grid_scatter",   "light_bounce",  "light_generate",  "light_path_counts",
    "merge",          "merge_count",   "scan_spread",     "scan_sums",
    "square_samples", "start_media",   "surface_aovs",    "surface_footprints",
    "trace_closest",  "trace_splats",  "trace_visibility"};

// As shaders/CMakeLists.txt lists them.
bool traces_rays(Stage stage) {
  switch (stage) {
    case Stage::StartMedia:
    case Stage::SurfaceAovs:
    case Stage::SurfaceFootprints:
    case Stage::TraceClosest:
    case Stage::TraceSplats:
    case Stage::TraceVisibility:
      return true;
    default:
      return false;
  }
}

}  // namespace

std::string_view file_of(Stage stage) {
  return FILES[static_cast<size_t>(stage)];
}

std::span<const uint32_t> stage_spirv(const gpu::Device& device, Stage stage, uint32_t rays) {
  const char* variant = rays == interface::RAYS_HARDWARE && traces_rays(stage) ? ".rays"
                        : device.info().has_int64                              ? ""
                                                                               : ".int32";
  return shaders::spirv(std::string(file_of(stage)) + variant);
}

}  // namespace regulus::render

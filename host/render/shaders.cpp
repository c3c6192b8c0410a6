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

}  // namespace

std::string_view file_of(Stage stage) {
  return FILES[static_cast<size_t>(stage)];
}

std::span<const uint32_t> stage_spirv(const gpu::Device& device, Stage stage) {
  return shaders::spirv(std::string(file_of(stage)) + (device.info().has_int64 ? "" : ".int32"));
}

}  // namespace regulus::render

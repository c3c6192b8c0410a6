#include "render/surface_passes.hpp"

#include <algorithm>
#include <iterator>

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint64_t SURFACE_WAVE_PIXELS = 1u << 14;

}  // namespace

std::vector<AovPixel> trace_surface_aovs(Wavefront& wavefront) {
  const uint64_t count = wavefront.buffers.aovs.size() / sizeof(AovPixel);
  for (uint64_t first = 0; first < count; first += SURFACE_WAVE_PIXELS) {
    StageArguments arguments = wavefront.arguments_of(first, 0, 0);
    for (arguments.surface_ray = 0; arguments.surface_ray <= AOV_RAYS; ++arguments.surface_ray)
      wavefront.run_over(Pass::Surface, Stage::SurfaceAovs, arguments,
                         std::min(SURFACE_WAVE_PIXELS, count - first));
  }
  wavefront.work.finish();
  return gpu::download_all<AovPixel>(wavefront.device, wavefront.buffers.aovs, count);
}

// Path slots serve as pixels, wave by wave.
std::vector<vec3> trace_surface_footprints(Wavefront& wavefront) {
  std::vector<vec3> footprints;
  if (!wavefront.plan.keeps(STATE_SIGMA)) return footprints;
  const uint64_t slots = std::min<uint64_t>(SURFACE_WAVE_PIXELS, wavefront.capacity);
  for (uint64_t first = 0; first < wavefront.pixels; first += slots) {
    const auto count = static_cast<uint32_t>(std::min(slots, wavefront.pixels - first));
    StageArguments arguments = wavefront.arguments_of(first, 0, count);
    for (arguments.bounce = 0; arguments.bounce < wavefront.plan.max_depth; ++arguments.bounce)
      wavefront.run_over(Pass::Surface, Stage::SurfaceFootprints, arguments, count);
    wavefront.work.finish();
    std::ranges::copy(gpu::download_all<vec3>(wavefront.device, wavefront.buffers.path_footprints, count),
                      std::back_inserter(footprints));
  }
  return footprints;
}

}  // namespace regulus::render

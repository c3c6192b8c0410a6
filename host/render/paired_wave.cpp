#include "render/paired_wave.hpp"

#include <algorithm>

namespace regulus::render {

using namespace interface;

bool PairedWave::run(uint64_t first, uint64_t sample, uint32_t paths) {
  // Waves differ by little: room is made, or the wave is cut, before the light paths are walked in vain.
  const auto expected =
      paths_ == 0
          ? 0
          : static_cast<uint64_t>(static_cast<double>(vertices_) / static_cast<double>(paths_) * paths);
  if (expected > wavefront_.buffers.sizes().light_vertices) {
    if (expected > most_vertices() && paths > 1) {
      const uint32_t half = paths / 2;
      return run(first, sample, half) && run(first + half, sample, paths - half);
    }
    make_room(expected);
  }
  return run(first, sample, paths, false);
}

// is_repeated: the splats of these light paths are on the film already.
bool PairedWave::run(uint64_t first, uint64_t sample, uint32_t paths, bool is_repeated) {
  if (wavefront_.has_pass(Pass::Light) && !walk_light_paths(first, sample, paths, is_repeated)) return false;
  if (wavefront_.plan.keeps(STATE_VERTICES)) {
    const uint32_t vertices = stored_vertices();
    vertices_ += vertices;
    paths_ += paths;
    if (vertices > wavefront_.buffers.sizes().light_vertices) {
      if (vertices > most_vertices() && paths > 1) {
        const uint32_t half = paths / 2;
        return run(first, sample, half, true) && run(first + half, sample, paths - half, true);
      }
      make_room(vertices);
      if (!walk_light_paths(first, sample, paths, true)) return false;
    }
  }
  return !wavefront_.has_pass(Pass::Camera) ||
         wavefront_.core.run(Pass::Camera, wavefront_.arguments_of(first, sample, paths));
}

bool PairedWave::walk_light_paths(uint64_t first, uint64_t sample, uint32_t paths, bool is_repeated) {
  const gpu::Buffer& count = wavefront_.buffers.light_vertex_count;
  wavefront_.work.room_for(1).fill(count, 0, count.size(), 0);
  StageArguments arguments = wavefront_.arguments_of(first, sample, paths);
  arguments.is_repeated = is_repeated ? 1 : 0;
  return wavefront_.core.run(Pass::Light, arguments);
}

// For `vertices`, and a tenth more if there is so much.
void PairedWave::make_room(uint64_t vertices) {
  wavefront_.work.finish();
  const uint64_t wanted = std::min(vertices + vertices / 10, most_vertices());
  wavefront_.buffers.grow_light_vertices(wavefront_.device, std::max(vertices, wanted));
}

// What the device's limits and its memory have room for.
uint64_t PairedWave::most_vertices() const {
  const gpu::DeviceInfo& info = wavefront_.device.info();
  const uint64_t each = bytes_per_light_vertex(wavefront_.plan);
  const uint64_t here = wavefront_.buffers.sizes().light_vertices;
  return std::min(
      most_light_vertices(wavefront_.plan, wavefront_.capacity, info.max_groups, info.max_allocation_bytes),
      here + wavefront_.device.free_bytes() / each);
}

uint32_t PairedWave::stored_vertices() const {
  wavefront_.work.finish();
  return gpu::download_all<uint32_t>(wavefront_.device, wavefront_.buffers.light_vertex_count, 1).front();
}

}  // namespace regulus::render

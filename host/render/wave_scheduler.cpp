#include "render/wave_scheduler.hpp"

#include <algorithm>

namespace regulus::render {

using namespace interface;

namespace {

// The first wave is small, so that a surprise (a slow device, an early Ctrl-C) costs little.
constexpr uint32_t FIRST_WAVE_PATHS = 1u << 14;

}  // namespace

uint64_t WaveScheduler::next_wave_paths(uint64_t reach) const {
  const uint32_t capacity = wavefront_.capacity;
  if (wavefront_.plan.wave_paths == 0 && is_first_wave_) return std::min(capacity, FIRST_WAVE_PATHS);
  return std::min(
      {uint64_t{capacity}, wavefront_.work.bound() / ITEMS_PER_PATH, WaveCore::most_paths(reach)});
}

void WaveScheduler::run(uint64_t begin, uint64_t end, uint64_t reach, const RunWave& run_wave) {
  WorkQueue& work = wavefront_.work;
  uint64_t first = begin;
  while (is_running_ && first < end) {
    const auto paths = static_cast<uint32_t>(std::min(next_wave_paths(reach), end - first));
    const std::optional<WavePaths> done = run_wave(first, paths);
    if (!done) return give_up_wave();
    work.when_done([this, wave = *done] {
      finished_.camera += wave.camera;
      finished_.light += wave.light;
    });
    work.flush();
    first += paths;
    is_first_wave_ = false;
    is_running_ = goes_on_();
  }
  work.finish();
}

// What connections, merges and splats of the wave have added to the film already cannot be taken back: the
// last snapshot is then what was rendered. Other techniques add to it when a wave ends.
void WaveScheduler::give_up_wave() {
  wavefront_.work.drop();
  is_running_ = false;
  constexpr uint32_t ADD_AT_ONCE = TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  if ((wavefront_.plan.techniques & ADD_AT_ONCE) != 0) is_film_whole_ = false;
}

}  // namespace regulus::render

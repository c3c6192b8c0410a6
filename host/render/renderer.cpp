#include "render/renderer.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "render/film_store.hpp"
#include "render/iteration.hpp"
#include "render/paired_wave.hpp"
#include "render/rays_choice.hpp"
#include "render/surface_passes.hpp"
#include "render/wave_scheduler.hpp"
#include "render/wavefront.hpp"

namespace regulus::render {

using namespace interface;

namespace {

// Where states of a growing film are wanted, each has at most this many times the paths of the one before.
constexpr double SNAPSHOT_GROWTH = 1.5;

}  // namespace

// The order of waves and iterations, and when the host looks at the film.
struct Renderer::Impl {
  Plan plan;
  RenderStatistics statistics;
  Wavefront wavefront;
  WaveScheduler scheduler;
  Iteration iteration;
  PairedWave wave;
  FilmStore store;
  uint64_t pixels, total_paths;
  uint64_t squared = 0;  // paths whose samples are in film_squares
  const ProgressCallback* progress = nullptr;

  Impl(gpu::Device& device, const PreparedScene& prepared, const Plan& plan_in)
      : plan(plan_in),
        wavefront(device, prepared, plan, resolve_rays(device.info(), prepared, plan), statistics),
        scheduler(wavefront, [this] { return goes_on(); }),
        iteration(wavefront, scheduler),
        wave(wavefront),
        store(wavefront, prepared.features.film_exponents),
        pixels(wavefront.pixels),
        total_paths(pixels * plan.samples) {}

  uint64_t finished() const { return scheduler.finished().camera; }

  // Number of the sample that follows so many. (continue_with may set a first one below 0.)
  uint32_t sample_after(uint64_t done) const { return plan.first_sample + static_cast<uint32_t>(done); }

  void continue_with(uint32_t first_sample, uint32_t samples) {
    const auto done = static_cast<uint32_t>(finished() / pixels);
    plan.first_sample = first_sample - done;
    plan.samples = done + samples;
    total_paths = pixels * plan.samples;
  }

  bool tell_progress() { return (*progress)(finished(), total_paths); }

  // After a wave.
  bool goes_on() {
    const bool is_running = tell_progress() && !wavefront.work.is_cancelled();
    take_snapshot_if_due();
    return is_running;
  }

  // ---- snapshots

  uint64_t paths_of_next_state() const {
    return std::max(pixels, static_cast<uint64_t>(SNAPSHOT_GROWTH * static_cast<double>(store.film().paths)));
  }

  // With a state from halfway, the noise of the last one can be estimated (render/noise.hpp), however short
  // the render.
  uint64_t paths_of_half() const { return plan.samples / 2 * pixels; }

  bool is_half_due() const { return store.film().paths < paths_of_half() && finished() >= paths_of_half(); }

  void take_snapshot_if_due() {
    const bool has_grown = is_half_due() || (plan.keeps_doublings && finished() >= paths_of_next_state());
    if (!has_grown && !store.is_snapshot_due()) return;
    wavefront.work.finish();
    // While a sample is still to be squared, the film is no state to go on from.
    if (plan.keeps(STATE_SQUARES) && finished() % pixels == 0 && finished() != squared) return;
    store.take_snapshot(scheduler.finished());
  }

  // ---- schedules

  // Every wave is complete in itself: light paths, if any, then the camera paths that connect to them. Waves
  // run over pixels and samples alike, but stop at every sample if its square is wanted, and where the next
  // state of the film is due: a GPU's waves are so large that it would be long past it.
  void render_by_waves() {
    while (scheduler.is_running() && finished() < total_paths) {
      run_paths(finished(), next_stop());
      end_sample();
      if (!scheduler.is_running()) continue;
      take_snapshot_if_due();
      if (!plan.keeps_doublings) continue;
      scheduler.set_running(tell_progress());
    }
  }

  uint64_t next_stop() const {
    uint64_t stop = finished() < paths_of_half() ? paths_of_half() : total_paths;
    if (plan.keeps(STATE_SQUARES)) stop = std::min(stop, (finished() / pixels + 1) * pixels);
    if (plan.keeps_doublings) stop = std::min(stop, std::max(paths_of_next_state(), finished() + 1));
    return stop;
  }

  void run_paths(uint64_t begin, uint64_t end) {
    const bool has_light_pass = wavefront.has_pass(Pass::Light);
    scheduler.run(begin, end, 0, [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
      if (!wave.run(first % pixels, sample_after(first / pixels), paths)) return std::nullopt;
      return WavePaths{paths, has_light_pass ? paths : 0};
    });
  }

  // All light paths of an iteration, then one sample of every pixel.
  void render_by_iterations() {
    if (plan.keeps(STATE_CACHE)) iteration.expect_light_vertices();
    for (uint64_t done = finished() / pixels; scheduler.is_running() && done < plan.samples; ++done) {
      const uint64_t sample = sample_after(done);
      // A resumed render may have walked some of this iteration's light paths.
      const uint64_t before = done * plan.light_paths;
      iteration.run_light_pass(
          sample, std::clamp(scheduler.finished().light, before, before + plan.light_paths) - before);
      if (!scheduler.is_running()) break;
      if (wavefront.has_pass(Pass::Camera))
        iteration.run_camera_pass(sample, finished() % pixels);
      else
        scheduler.set_finished({finished() + pixels, scheduler.finished().light});
      end_sample();
    }
  }

  // Squares the sample that has just been completed, if that is wanted.
  void end_sample() {
    if (!plan.keeps(STATE_SQUARES) || finished() % pixels != 0 || finished() == squared ||
        !scheduler.is_film_whole())
      return;
    wavefront.run_over(Pass::Sample, Stage::SquareSamples, wavefront.arguments_of(0, 0, 0), pixels);
    wavefront.work.finish();
    squared = finished();
    take_snapshot_if_due();
  }

  void resume(const Film& film) {
    store.restore(film);
    scheduler.set_finished({film.paths, film.light_paths});
    statistics.paths = statistics.resumed_paths = film.paths;
    statistics.light_paths = film.light_paths;
    squared = film.paths / pixels * pixels;
  }

  void render(const ProgressCallback& progress_in, const std::function<bool()>& is_cancelled) {
    const auto start = std::chrono::steady_clock::now();
    store.start_clock();
    progress = &progress_in;
    scheduler.set_running(scheduler.is_film_whole());
    // Images of strategies have no snapshots.
    if (!plan.has_strategy_images) wavefront.work.set_cancellation(is_cancelled);
    if (!wavefront.has_pass(Pass::Light) && !wavefront.has_pass(Pass::Camera))
      scheduler.set_finished({total_paths, 0});  // no technique can contribute: the image is black
    else if (plan.is_per_wave)
      render_by_waves();
    else
      render_by_iterations();
    if (scheduler.is_film_whole()) store.take_snapshot(scheduler.finished());
    if (scheduler.is_running()) tell_progress();
    statistics.bytes_per_path = bytes_per_path(plan, wavefront.buffers.sizes());
    statistics.render_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
};

Renderer::Renderer(gpu::Device& device, const PreparedScene& prepared, const Plan& plan)
    : impl_(std::make_unique<Impl>(device, prepared, plan)) {}
Renderer::~Renderer() = default;

void Renderer::resume(const Film& film) {
  impl_->resume(film);
}
void Renderer::continue_with(uint32_t first_sample, uint32_t samples) {
  impl_->continue_with(first_sample, samples);
}
std::vector<AovPixel> Renderer::surface_aovs() {
  return trace_surface_aovs(impl_->wavefront);
}
std::vector<RayIds> Renderer::ray_ids() const {
  const gpu::Buffer& ids = impl_->wavefront.buffers.aov_ids;
  return gpu::download_all<RayIds>(impl_->wavefront.device, ids, ids.size() / sizeof(RayIds));
}
std::vector<vec3> Renderer::surface_footprints() {
  return trace_surface_footprints(impl_->wavefront);
}
void Renderer::render(const ProgressCallback& progress, const std::function<bool()>& is_cancelled) {
  impl_->render(progress, is_cancelled);
}
const Film& Renderer::film() const {
  return impl_->store.film();
}
void Renderer::for_each_strategy(const std::function<void(const StrategyImages&)>& use) const {
  impl_->store.for_each_strategy(use);
}
const RenderStatistics& Renderer::statistics() const {
  return impl_->statistics;
}

}  // namespace regulus::render

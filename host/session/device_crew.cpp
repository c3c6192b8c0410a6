#include "session/device_crew.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <thread>

#include "render/film_file.hpp"

namespace regulus::session {

namespace {

using Seconds = std::chrono::duration<double>;

}  // namespace

Crew::Crew(const PreparedScene& prepared, const render::Plan& plan, std::span<gpu::Device* const> devices,
           SampleSplit& split, Watcher& watcher, std::optional<double> time_limit,
           const render::Film* earlier)
    : prepared_(prepared),
      plan_(plan),
      split_(split),
      watcher_(watcher),
      earlier_(earlier),
      time_limit_(time_limit) {
  for (gpu::Device* device : devices) workers_.push_back(std::make_unique<Worker>(device, workers_.size()));
}

void Crew::run(const std::function<void(uint64_t samples)>& look) {
  while (!is_cancelled_ && !is_over_ && done_samples() < plan_.samples && workers_left() != 0) {
    const size_t workers = workers_left();
    std::vector<std::jthread> threads;
    running_ = 0;
    for (const auto& worker : workers_) {
      if (worker->failure) continue;
      ++running_;
      threads.emplace_back([this, &worker = *worker] { work(worker); });
    }
    watch(look);
    // Who is not lost has ended because all samples are given out, or because there is no time for one more.
    is_over_ = time_limit_ && workers_left() == workers && done_samples() != 0;
  }
}

uint64_t Crew::done_samples() const {
  uint64_t samples = 0;
  for (const Share& share : split_.finished()) samples += share.range.count;
  return samples;
}

Done Crew::done() const {
  const std::lock_guard lock(done_mutex_);
  Done all{.film = {}, .shares = split_.finished()};
  if (earlier_ != nullptr) all.film = *earlier_;
  for (const auto& worker : workers_) {
    if (worker->film.paths == 0) continue;
    if (all.film.paths == 0)
      all.film = worker->film;
    else
      render::add(all.film, worker->film);
  }
  return all;
}

size_t Crew::workers_left() const {
  return static_cast<size_t>(
      std::ranges::count_if(workers_, [](const auto& worker) { return !worker->failure; }));
}

void Crew::start_clock() {
  const std::lock_guard lock(mutex_);
  if (time_limit_ && !end_)
    end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(*time_limit_));
}

double Crew::seconds_left() const {
  const std::lock_guard lock(mutex_);
  return end_ ? Seconds(*end_ - Clock::now()).count() : std::numeric_limits<double>::infinity();
}

void Crew::work(Worker& worker) {
  std::optional<SampleRange> range;
  try {
    if (!worker.renderer)
      worker.renderer = std::make_unique<render::Renderer>(*worker.device, prepared_, plan_);
    start_clock();
    while (!is_cancelled_ && (range = split_.take(worker.place, seconds_left())))
      render_range(worker, *range);
  } catch (const Error& error) {
    fail(worker, range, error);
  } catch (const std::bad_alloc&) {
    fail(worker, range, Error(ErrorCode::Failed, "out of memory"));
  }
  const std::lock_guard lock(mutex_);
  --running_;
  ended_.notify_all();
}

void Crew::render_range(Worker& worker, const SampleRange& range) {
  const auto begin = Clock::now();
  worker.renderer->continue_with(static_cast<uint32_t>(range.first), static_cast<uint32_t>(range.count));
  worker.renderer->render(
      [&](uint64_t done, uint64_t) {
        worker.paths = done;
        return !is_cancelled_;
      },
      [&] { return is_cancelled_.load(); });
  if (is_cancelled_) return;  // half a range is none
  const std::lock_guard lock(done_mutex_);
  worker.film = worker.renderer->film();
  worker.paths = worker.film.paths;
  split_.finish(worker.place, range, Seconds(Clock::now() - begin).count());
}

void Crew::fail(Worker& worker, const std::optional<SampleRange>& range, const Error& error) {
  worker.failure = error;
  worker.paths = worker.film.paths;
  split_.lose(worker.place, range);
}

// Tells the watcher how far all are, in its own thread, until the devices have nothing left to do.
void Crew::watch(const std::function<void(uint64_t samples)>& look) {
  constexpr auto INTERVAL = std::chrono::milliseconds(50);
  const uint64_t total = plan_.window().pixels() * plan_.samples;
  const uint64_t earlier = earlier_ != nullptr ? earlier_->paths : 0;
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, INTERVAL, [this] { return running_ == 0; })) {
    lock.unlock();
    uint64_t paths = earlier;
    for (const auto& worker : workers_) paths += worker->paths;
    watcher_.progress({std::min(paths, total), total, earlier});
    if (watcher_.is_cancelled()) is_cancelled_ = true;
    look(done_samples());
    lock.lock();
  }
}

}  // namespace regulus::session

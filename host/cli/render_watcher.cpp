#include "cli/render_watcher.hpp"

#include <spdlog/spdlog.h>

#include <cmath>

#include "base/interrupt.hpp"

namespace regulus::cli {

void RenderWatcher::begin() {
  catch_interrupts();
  start_ = std::chrono::steady_clock::now();
  report_.begin_render(limits_, pixels_);
}

void RenderWatcher::progress(const session::Progress& progress) {
  report_.progress(progress);
  if (std::isnan(progress.noise)) return;
  if (!convergence_.empty() && progress.noise == convergence_.back().error) return;
  convergence_.push_back({std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(),
                          static_cast<double>(progress.paths_done) / static_cast<double>(pixels_),
                          progress.noise});
}

void RenderWatcher::state(const render::Film& film) {
  if (viewer_ == nullptr) return;
  viewer_->offer(film);
  if (const auto warning = viewer_->take_warning()) warn(*warning);
}

bool RenderWatcher::is_cancelled() {
  return is_interrupted();
}

void RenderWatcher::warn(const std::string& text) {
  spdlog::warn("{}", text);
}

}  // namespace regulus::cli

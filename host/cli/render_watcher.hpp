// Who follows a render on the command line: progress, Ctrl-C, the viewer, and what the report tells of it.
#pragma once

#include <vector>

#include "bench/render_page.hpp"
#include "cli/progress.hpp"
#include "session/display_server.hpp"
#include "session/render_job.hpp"

namespace regulus::cli {

class RenderWatcher : public session::Watcher {
 public:
  /// @param pixels of the picture; @param viewer may be null
  RenderWatcher(ProgressReport& report, const Limits& limits, uint64_t pixels, session::DisplayServer* viewer)
      : report_(report), limits_(limits), pixels_(pixels), viewer_(viewer) {}

  void kernels(size_t done, size_t total) override { report_.kernels(done, total); }
  void begin() override;
  void progress(const session::Progress& progress) override;
  void state(const render::Film& film) override;
  bool is_cancelled() override;
  void warn(const std::string& text) override;

  /// Each estimate of the error, when it was made.
  const std::vector<bench::ConvergencePoint>& convergence() const { return convergence_; }

 private:
  ProgressReport& report_;
  Limits limits_;
  uint64_t pixels_;
  session::DisplayServer* viewer_;
  std::chrono::steady_clock::time_point start_;
  std::vector<bench::ConvergencePoint> convergence_;
};

}  // namespace regulus::cli

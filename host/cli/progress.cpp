#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace regulus::cli {

using namespace std::chrono_literals;

ProgressLine::ProgressLine(bool enabled)
    : enabled_(enabled && isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

ProgressLine::~ProgressLine() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::update(uint64_t paths_done, uint64_t paths_total) {
  const auto now = std::chrono::steady_clock::now();
  if (!enabled_ || now - last_ < 200ms || paths_done == 0) return;
  last_ = now;
  drawn_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = static_cast<double>(paths_done) / seconds;
  const double left = static_cast<double>(paths_total - paths_done) / rate;
  // A terminal that went away is no reason to stop: errors are not looked at.
  const std::string line = fmt::format(
      "\r\033[K{:5.1f} %  {:.2f} million samples/s  {:.0f} s left",
      100.0 * static_cast<double>(paths_done) / static_cast<double>(paths_total), 1e-6 * rate, left);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace regulus::cli

#include "cli/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>
#include <system_error>

#include "base/standard_streams.hpp"
#include "base/terminal.hpp"

namespace regulus::cli {

using namespace std::chrono_literals;

namespace {

constexpr auto TERMINAL_PERIOD = 200ms, LINES_PERIOD = 10'000ms, JSON_PERIOD = 1'000ms;

double seconds_between(std::chrono::steady_clock::time_point begin,
                       std::chrono::steady_clock::time_point end) {
  return std::chrono::duration<double>(end - begin).count();
}

std::string duration(double seconds) {
  const auto whole = static_cast<uint64_t>(std::min(std::ceil(seconds), 1e15));
  if (whole < 120) return fmt::format("{} s", whole);
  if (whole < 2 * 3600) return fmt::format("{} min", whole / 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

nlohmann::json number_or_null(std::optional<double> value) {
  return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

const char* words_of(std::string_view phase) {
  if (phase == "load") return "loading the scene";
  if (phase == "prepare") return "building the acceleration structure, choosing techniques";
  if (phase == "device") return "opening the device";
  if (phase == "write") return "writing";
  return "starting to render";
}

}  // namespace

std::optional<double> seconds_left(const session::Progress& progress, const Limits& limits, double seconds) {
  std::optional<double> left;
  const auto consider = [&](double other) { left = std::max(0.0, left ? std::min(*left, other) : other); };
  const auto done = static_cast<double>(progress.paths_done - progress.earlier_paths);
  if (limits.has_samples && done > 0)
    consider(static_cast<double>(progress.paths_total - progress.paths_done) * seconds / done);
  if (limits.seconds) consider(*limits.seconds - seconds);
  // The error falls with the root of the number of samples.
  if (limits.noise && done > 0 && std::isfinite(progress.noise)) {
    const double ratio = progress.noise / *limits.noise;
    if (std::isfinite(ratio))
      consider(static_cast<double>(progress.paths_done) * (ratio * ratio - 1) * seconds / done);
  }
  return left;
}

ProgressReport::ProgressReport(ProgressStyle style, bool is_quiet) {
  if (style == ProgressStyle::Json)
    style_ = Style::Json;
  else if (style == ProgressStyle::None || is_quiet)
    style_ = Style::None;
  else
    style_ = style == ProgressStyle::Auto && stderr_is_terminal() ? Style::Terminal : Style::Lines;
  if (style_ == Style::None) return;
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  } catch (const std::system_error&) {  // no thread can be had: phases are told when they begin
  }
}

ProgressReport::~ProgressReport() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  clear_line();
}

void ProgressReport::run(const std::stop_token& stop) {
  const auto period = style_ == Style::Terminal ? TERMINAL_PERIOD
                      : style_ == Style::Lines  ? LINES_PERIOD
                                                : JSON_PERIOD;
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    wake_.wait_for(lock, stop, period, [] { return false; });
    if (!stop.stop_requested()) say_now();
  }
}

void ProgressReport::begin_frame(uint64_t number) {
  const std::lock_guard lock(mutex_);
  state_.frame = number;
}

void ProgressReport::begin(std::string_view phase) {
  const std::lock_guard lock(mutex_);
  set_phase(phase);
}

void ProgressReport::set_phase(std::string_view phase) {
  state_.phase = phase;
  if (style_ != Style::Lines) say_now();
}

void ProgressReport::kernels(size_t done, size_t total) {
  const std::lock_guard lock(mutex_);
  state_.kernels_done = done;
  state_.kernels_total = total;
  set_phase("kernels");
}

void ProgressReport::begin_render(const Limits& limits, uint64_t pixels) {
  const std::lock_guard lock(mutex_);
  state_.limits = limits;
  state_.pixels = pixels;
  state_.progress.reset();
  state_.render_start = Clock::now();
  set_phase("render");
}

void ProgressReport::progress(const session::Progress& progress) {
  const std::lock_guard lock(mutex_);
  state_.progress = progress;
  state_.phase = "render";  // bands compile kernels after it has begun
}

void ProgressReport::done(nlohmann::json values) {
  const std::lock_guard lock(mutex_);
  if (style_ != Style::Json) return;
  state_.phase = "done";
  values.update(to_json());
  say("{}\n", values.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  flush_stdout();
  state_.phase.clear();
}

void ProgressReport::end() {
  const std::lock_guard lock(mutex_);
  state_.phase.clear();
  clear_line();
}

void ProgressReport::print(std::string_view text) {
  const std::lock_guard lock(mutex_);
  clear_line();
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void ProgressReport::clear_line() {
  if (drawn_.empty()) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_.clear();
}

void ProgressReport::say_now() {
  if (state_.phase.empty()) return;
  try {
    if (style_ == Style::Json) {
      say("{}\n", to_json().dump());
      flush_stdout();
    } else if (style_ == Style::Lines) {
      std::fputs(("regulus: progress: " + to_text() + "\n").c_str(), stderr);
      std::fflush(stderr);
    } else if (style_ == Style::Terminal) {
      if (std::string text = to_text(); text != drawn_) draw(std::move(text));
    }
  } catch (const std::bad_alloc&) {  // the render needs the memory
  }
}

void ProgressReport::draw(std::string line) {
  std::fputs(("\r\033[K" + line).c_str(), stderr);
  std::fflush(stderr);
  drawn_ = std::move(line);
}

nlohmann::json ProgressReport::to_json() const {
  const auto now = Clock::now();
  nlohmann::json json = {{"phase", state_.phase}, {"seconds", seconds_between(start_, now)}};
  if (state_.frame) json["frame"] = *state_.frame;
  if (state_.phase == "kernels") {
    json["kernels_done"] = state_.kernels_done;
    json["kernels_total"] = state_.kernels_total;
  }
  if (state_.phase != "render" || !state_.progress) return json;
  const session::Progress& progress = *state_.progress;
  const double seconds = seconds_between(state_.render_start, now);
  const auto pixels = static_cast<double>(state_.pixels);
  json["samples_done"] = static_cast<double>(progress.paths_done) / pixels;
  json["samples_total"] = state_.limits.has_samples
                              ? number_or_null(static_cast<double>(progress.paths_total) / pixels)
                              : nlohmann::json(nullptr);
  json["samples_per_second"] = static_cast<double>(progress.paths_done - progress.earlier_paths) / seconds;
  json["estimated_error"] = number_or_null(progress.noise);
  json["seconds_left"] = number_or_null(seconds_left(progress, state_.limits, seconds));
  return json;
}

std::string ProgressReport::to_text() const {
  std::string text = state_.frame ? fmt::format("frame {}: ", *state_.frame) : std::string();
  if (state_.phase == "kernels")
    return text + fmt::format("compiling kernels, {} of {} done", state_.kernels_done, state_.kernels_total);
  if (state_.phase != "render" || !state_.progress ||
      state_.progress->paths_done == state_.progress->earlier_paths)
    return text + words_of(state_.phase);
  const session::Progress& progress = *state_.progress;
  const double seconds = seconds_between(state_.render_start, Clock::now());
  const std::optional<double> left = seconds_left(progress, state_.limits, seconds);
  if (left) text += fmt::format("{:.1f} %  ", 100 * seconds / std::max(seconds + *left, 1e-9));
  text +=
      fmt::format("{:.4g}", static_cast<double>(progress.paths_done) / static_cast<double>(state_.pixels));
  if (state_.limits.has_samples) text += fmt::format(" of {}", progress.paths_total / state_.pixels);
  text += fmt::format(" samples  {:.3g} million samples/s",
                      1e-6 * static_cast<double>(progress.paths_done - progress.earlier_paths) / seconds);
  if (std::isfinite(progress.noise)) text += fmt::format("  error {:.3g}", progress.noise);
  if (left) text += fmt::format("  {} left", duration(*left));
  return text;
}

}  // namespace regulus::cli

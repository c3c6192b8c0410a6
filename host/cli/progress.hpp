// What a command says while it renders: a line that is drawn anew on a terminal, a line now and then
// elsewhere, or JSON for programs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "cli/progress_style.hpp"
#include "session/render_job.hpp"

namespace regulus::cli {

/// When a render is over.
struct Limits {
  bool has_samples = true;  ///< when it has the samples of session::Progress
  std::optional<double> seconds{}, noise{};
};

/// Seconds that are left of a render: until the first of its limits is reached, as far as that can be told.
/// @param seconds since its first path
std::optional<double> seconds_left(const session::Progress& progress, const Limits& limits, double seconds);

/// Says in what phase a command is and how far, in a thread of its own, so that it is said in time whatever
/// takes long. Its functions may be called by any thread. What cannot be written is not looked at: a terminal
/// that goes away is no reason to stop.
class ProgressReport {
 public:
  /// @param is_quiet only JSON is written, which is a result
  ProgressReport(ProgressStyle style, bool is_quiet);
  ~ProgressReport();
  ProgressReport(const ProgressReport&) = delete;
  ProgressReport& operator=(const ProgressReport&) = delete;

  bool is_json() const { return style_ == Style::Json; }

  /// A picture of a sequence: its number is said with the rest.
  void begin_frame(uint64_t number);
  /// @param phase "load", "prepare", "device", "render" or "write"
  void begin(std::string_view phase);
  /// Phase "kernels".
  void kernels(size_t done, size_t total);
  /// Phase "render", of a picture of so many pixels.
  void begin_render(const Limits& limits, uint64_t pixels);
  void progress(const session::Progress& progress);
  /// Phase "done", of which only JSON speaks. @param values what there is to say
  void done(nlohmann::json values);

  /// Takes the line away: what follows on stdout has the terminal for itself.
  void end();

  /// Writes a message to stderr without mixing it with the line.
  void print(std::string_view text);

 private:
  enum class Style { Terminal, Lines, Json, None };
  using Clock = std::chrono::steady_clock;
  struct State {
    std::string phase;
    std::optional<uint64_t> frame;
    size_t kernels_done = 0, kernels_total = 0;
    Limits limits;
    uint64_t pixels = 0;
    std::optional<session::Progress> progress;
    Clock::time_point render_start;
  };

  void run(const std::stop_token& stop);
  void set_phase(std::string_view phase);
  void say_now();
  void draw(std::string line);
  void clear_line();
  nlohmann::json to_json() const;
  std::string to_text() const;

  Style style_;
  Clock::time_point start_ = Clock::now();
  std::mutex mutex_;  // of all that follows
  State state_;
  std::string drawn_;  // the line that is on the terminal
  std::condition_variable_any wake_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace regulus::cli

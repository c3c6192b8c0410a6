// A checkpoint: the state of a render in a file, written now and then, and read back to go on.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "session/part.hpp"

namespace regulus::session {

/// Writes the state of a render when it is due. The file changes as a whole (write_file_atomically),
/// so a process may be killed at any time. A state that cannot be written is a warning: the render goes on,
/// and the next state is tried when it is due.
class Checkpoint {
 public:
  /// @param path empty: there is no checkpoint
  /// @param seconds between two states; more if writing takes more than a fiftieth of that
  /// @param write puts a film into the file; throws if it cannot
  /// @param warn is told in one line that a state could not be written
  Checkpoint(std::filesystem::path path, double seconds, std::function<void(const render::Film&)> write,
             std::function<void(const std::string&)> warn)
      : path_(std::move(path)), seconds_(seconds), write_(std::move(write)), warn_(std::move(warn)) {}

  /// Whether a film of so many paths would be written now: it is another than the last one, and the time has
  /// come.
  bool is_due(uint64_t paths) const;
  /// Writes `film` if it is due.
  void update(const render::Film& film);
  /// Writes `film` at once.
  void finish(const render::Film& film);

 private:
  void try_to_write(const render::Film& film, const char* what_next);

  using Clock = std::chrono::steady_clock;
  std::filesystem::path path_;
  double seconds_;
  std::function<void(const render::Film&)> write_;
  std::function<void(const std::string&)> warn_;
  Clock::time_point last_ = Clock::now();
  uint64_t written_paths_ = 0;
  std::string last_problem_;  ///< of the last attempt; empty: it was written
};

/// What a render goes on from.
struct Earlier {
  render::Film film;
  uint32_t rays;                      ///< RAYS_*: who traced them so far, and does from now on
  std::vector<SampleRange> ranges{};  ///< what the film holds, or was to: the last may not be complete
  std::string devices{}, split{};     ///< who rendered it: regulus:device and, of several, regulus:split
};

/// The state in a checkpoint, to go on from by this plan. RAYS_AUTO become those of the checkpoint.
/// @throws regulus::Error (BadFile) if it is of another render or of other samples, (BadUsage) if it has more
/// samples than are asked for
Earlier read_checkpoint(const std::filesystem::path& path, const scene::Scene& scene,
                        const render::Plan& plan);

/// @throws regulus::Error (BadFile) unless the state is of one device, which renders sample after sample
void require_samples_in_order(const Earlier& earlier, const std::filesystem::path& path,
                              const render::Plan& plan);

/// Gives the film of a checkpoint to a renderer. @throws regulus::Error (BadFile) if its sums are not the
/// renderer's
void resume(render::Renderer& renderer, const std::filesystem::path& path, const render::Film& film);

}  // namespace regulus::session

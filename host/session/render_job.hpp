// A render from its plan to what is written of it, whatever renders: a device with the whole film, a device
// in bands of rows, or the scalar reference. The command line and the library call this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "gpu/gpu.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/renderer.hpp"
#include "session/checkpoint.hpp"
#include "session/record.hpp"

namespace regulus::session {

/// What a render is asked for besides its plan. Nothing of it changes a sample.
struct Job {
  std::optional<double> time_limit;    ///< seconds of rendering; every pixel gets one sample all the same
  std::optional<double> noise_target;  ///< see render::NoiseEstimate; needs plan.keeps_doublings
  uint64_t band_pixels = 0;            ///< rendered at once, at most; 0: what the device's buffers hold
  uint64_t memory_bytes = 0;           ///< of the host; 0: the default
  bool holds_sums = false;             ///< it is to be written as a part (session/part.hpp)
  std::filesystem::path checkpoint;    ///< where its state is written now and then; empty: nowhere
  double checkpoint_seconds = 60;      ///< between two states
  std::optional<Earlier> earlier;      ///< what an earlier render of this plan left (read_checkpoint)
  LoadTimes times;                     ///< for the statistics
};

/// How far a render is.
struct Progress {
  uint64_t paths_done = 0, paths_total = 0;  ///< of the camera, those of an earlier render too
  uint64_t earlier_paths = 0;                ///< of paths_done, those that an earlier render did
  /// Estimated relative error (render::NoiseEstimate); NaN if it cannot be told yet, or is not followed: by
  /// the reference, and in bands.
  double noise = std::numeric_limits<double>::quiet_NaN();
};

/// Who follows a render. Called by the thread that renders, but for kernels().
class Watcher {
 public:
  virtual ~Watcher() = default;
  /// So many of the kernels that have to be compiled are done. Called by several threads, one at a time.
  virtual void kernels(size_t /*done*/, size_t /*total*/) {}
  /// All is ready, the first path follows.
  virtual void begin() {}
  virtual void progress(const Progress& /*progress*/) {}
  /// The film as it was when it was last copied from the device: of a whole film on a device, as often as
  /// progress().
  virtual void state(const render::Film& /*film*/) {}
  /// True: begin nothing more. Asked often.
  virtual bool is_cancelled() { return false; }
  /// Nothing is rendered any more.
  virtual void end() {}
  /// Something went wrong that does not end the render. One line.
  virtual void warn(const std::string& /*text*/) {}
};

/// What came out.
struct Result {
  image::Image image;
  image::Channels channels;  ///< as the plan's AOVs ask for
  image::Attributes attributes;
  image::Placement placement;
  nlohmann::json statistics;
  std::unique_ptr<render::Renderer> renderer;  ///< of a whole film on one device; otherwise null
  std::optional<render::Film> film;            ///< of a whole film on several
  std::vector<SampleRange> ranges;             ///< what that film holds
  uint64_t paths = 0;                          ///< camera paths, those of an earlier render too
  bool is_complete = false;                    ///< all samples, or the time or noise that was asked for
  double seconds = 0;                          ///< of rendering
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< estimated, see Progress
  std::string summary;                                      ///< size, samples and seconds in words
  std::vector<std::string> warnings;                        ///< of the film
  std::vector<std::string> bugs;                            ///< what must not happen and did, in words
  std::optional<Error> failure;  ///< what ended the render early; the rest holds what was done before
};

/// Where on the film the pixels lie that are rendered.
image::Placement placement_of(const render::Plan& plan);

/// Renders. A device that is lost, or memory that runs out, after some of it was rendered becomes
/// Result::failure.
/// @param device none: the scalar reference
/// @throws regulus::Error (BadUsage) if the job asks for what neither the reference nor bands can do, as
/// film_memory.hpp, and what the device throws before anything was rendered
Result render(const PreparedScene& prepared, const render::Plan& plan, const Job& job, gpu::Device* device,
              Watcher& watcher);

/// The bytes of a file of what came out; with the sums if `job.holds_sums`. Errors name `path`.
/// @throws regulus::Error (Failed)
std::string encode(const Result& result, const render::Plan& plan, const Job& job, image::Format format,
                   const image::Encoding& encoding, const std::filesystem::path& path);

}  // namespace regulus::session

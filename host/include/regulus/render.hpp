// From a prepared scene and settings, by way of a plan, to a picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "regulus/image.hpp"
#include "regulus/scene.hpp"
#include "regulus/settings.hpp"

namespace regulus {

/// What renders: a Vulkan device, or the scalar reference.
class Device {
 public:
  /// The driver's name for it, or "scalar reference".
  std::string name() const;

  /// @cond internal
  struct Impl;
  explicit Device(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  Impl& impl() const { return *impl_; }
  /// @endcond

 private:
  std::shared_ptr<Impl> impl_;
};

/// A Vulkan device of this machine.
struct DeviceDescription {
  std::string name;                  ///< as its driver calls it
  std::string driver;                ///< name and version
  bool is_software = false;          ///< it runs on the processor
  std::vector<std::string> missing;  ///< what it lacks to be used; empty: nothing
};

/// All Vulkan devices, best first. Empty if there is no loader or no driver.
std::vector<DeviceDescription> list_devices();

/// Opens a device, which may be shared by many renders one after the other.
/// @param select index of list_devices(), or part of a name; empty: the best that can be used
/// @param memory_bytes what may be taken of its memory; 0: what is free
/// @throws Error (NoDevice) that lists what there is
Device open_device(const std::string& select = {}, uint64_t memory_bytes = 0);

/// The scalar double-precision reference, on all processors: slow, and as near to the definition as can be.
Device reference_device();

/// Something that was asked for and is not done.
struct Dropped {
  std::string what;  ///< such as "technique merge"
  std::string why;   ///< a sentence
};

/// A render with every choice made: the same for each device.
class Plan {
 public:
  uint32_t width() const;                       ///< pixels that are rendered: of the crop, if there is one
  uint32_t height() const;                      ///< likewise
  uint32_t samples() const;                     ///< per pixel
  std::vector<std::string> techniques() const;  ///< of hit, nee, splat, connect, merge
  double merge_radius() const;                  ///< metres, of the first iteration; 0: nothing is merged
  std::vector<Dropped> dropped() const;         ///< of what was asked for
  /// What was changed rather than dropped, one line each.
  std::vector<std::string> warnings() const;
  /// Everything that is done, by the names of a picture's header.
  std::map<std::string, std::string> description() const;

  /// @cond internal
  struct Impl;
  explicit Plan(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  const Impl& impl() const { return *impl_; }
  /// @endcond

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Decides what is done of what the scene's own settings and `settings` ask for; the latter win.
/// @throws SettingError for a value that does not fit the scene, Error (BadFile) for one of the scene's
Plan make_plan(const Prepared& scene, const Settings& settings = {});

/// Called by the thread that renders with the paths done and in all, many times a second. False stops the
/// render.
using Progress = std::function<bool(uint64_t paths_done, uint64_t paths_total)>;

/// What a render came to.
struct Outcome {
  bool is_complete = false;  ///< all samples, or the time or noise that was asked for
  uint32_t samples = 0;      ///< that every pixel has
  double noise = 0;          ///< estimated relative error; NaN if it cannot be told (reference, one sample)
  std::string summary;       ///< size, samples and seconds in words
  std::vector<std::string> warnings;  ///< losses and what was changed, one line each
};

/// Renders a plan. The picture is a function of scene and settings alone: stopping, resuming and memory never
/// change a sample.
class Renderer {
 public:
  /// Takes what it needs of the device's memory when it renders. Keeps plan and device alive.
  Renderer(const Plan& plan, const Device& device);
  ~Renderer();
  Renderer(Renderer&&) noexcept;             ///< only to be destroyed or assigned to afterwards
  Renderer& operator=(Renderer&&) noexcept;  ///< likewise

  /// From now on the state of the render is written to a file every so many seconds and at its end. Device
  /// only.
  void checkpoint(const std::filesystem::path& path, double seconds = 60);

  /// Goes on from a checkpoint or a part of the same render. @throws Error (BadFile) if it is of another one,
  /// (BadUsage) if it has more samples than are asked for
  void resume(const std::filesystem::path& path);

  /// Renders what is left. A render that was stopped goes on when it is called again (the reference, and
  /// films larger than a buffer of the device, begin anew). If the device is lost, what was rendered before
  /// can still be had.
  /// @throws Error (NoDevice, Failed)
  Outcome render(const Progress& progress = {});

  /// What has been rendered so far, with the AOVs that the settings ask for. Black before render().
  Picture picture() const;

  /// Writes the picture with the sums of its samples, so that merge_parts() can join it with others and
  /// resume() go on from it. Needs a device. @throws Error (Failed, BadUsage)
  void write_part(const std::filesystem::path& path) const;

  /// Times, rays, memory, scene and settings: JSON, as `regulus render --stats` writes it.
  std::string statistics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Joins parts of one render, ranges of samples ("samples") or crops. The file has exactly the bits that one
/// render of all of them would have. @throws Error (BadFile) if they do not belong together or are damaged
void merge_parts(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& output);

}  // namespace regulus

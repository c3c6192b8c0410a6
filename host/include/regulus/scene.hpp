// Scenes: loaded from glTF, looked at through a camera, prepared for rendering.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace regulus {

struct PreparedScene;  // opaque, see prepare()

/// How a file is read.
struct LoadOptions {
  std::optional<uint32_t> scene{};  ///< index; none: the file's default scene
  std::string variant{};            ///< of materials, by name; empty: the scene's own choice, or none
  std::string animation{};          ///< that poses the scene, by name or index; empty: the scene's, or none
  std::optional<double> time{};     ///< seconds into the animation
  std::filesystem::path environment{};           ///< OpenEXR or Radiance map; empty: the scene's
  std::optional<double> environment_rotation{};  ///< degrees about +y, counterclockwise seen from above
  std::optional<double> environment_scale{};     ///< factor on its radiance, 0 or more
  /// Of the file's document, in this order, as of the command line's -D: "materials.Glass.roughness=0.1". A
  /// name or value that makes no sense is an Error (BadUsage).
  std::vector<std::string> edits{};
  bool allow_external = false;  ///< the scene may refer to files outside its folder
  bool is_strict = false;       ///< faults that could be mended with a warning are errors
  uint64_t memory_bytes = 0;    ///< what the scene may take of the host's memory; 0: three quarters of it
};

/// A camera. World space is that of the file: right-handed, metres, y up.
struct Camera {
  std::string name;                           ///< of the file; may be empty
  std::array<double, 3> position{0, 0, 0};    ///< metres
  std::array<double, 3> direction{0, 0, -1};  ///< of sight; any length but 0
  std::array<double, 3> up{0, 1, 0};          ///< roughly; not along `direction`
  bool is_orthographic = false;               ///< otherwise perspective
  double vertical_fov = 0.8;                  ///< radians, the full angle; perspective
  double half_height = 1;                     ///< metres; orthographic
  double aspect_ratio = 0;    ///< width / height that are seen at least, whatever the film; 0: the film's
  double lens_radius = 0;     ///< metres; 0: a pinhole
  double focus_distance = 1;  ///< metres along `direction`
};

/// The camera with its position, direction and up such that it looks at a point.
Camera look_at(Camera camera, const std::array<double, 3>& position, const std::array<double, 3>& target,
               const std::array<double, 3>& up = {0, 1, 0});

/// A scene as it is loaded. Copies share what is in it until one of them is changed.
class Scene {
 public:
  /// The file it was read from.
  std::filesystem::path path() const;
  /// What LoadOptions::edits came to, one property each; sorted.
  std::vector<std::string> edits() const;
  /// What was mended or left out, one line each.
  std::vector<std::string> warnings() const;
  /// scenes[].extras.regulus: settings by name, which make_plan() takes where none are given.
  std::map<std::string, std::string> settings() const;

  /// At least one: framed on the scene's bounds if the file has none.
  std::vector<Camera> cameras() const;
  /// Replaces a camera; one whose index is the number of cameras is added.
  /// @throws Error (BadUsage) if the index is larger, or something of the camera is not finite or out of
  /// range
  void set_camera(size_t index, const Camera& camera);

  std::array<double, 3> bounds_min() const;  ///< metres, world
  std::array<double, 3> bounds_max() const;  ///< likewise
  uint64_t triangle_count() const;           ///< with those of each copy
  size_t material_count() const;             ///< of the file
  /// Material names, by index; names may be empty.
  std::vector<std::string> material_names() const;

  /// @cond internal
  struct Impl;
  explicit Scene(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  const Impl& impl() const { return *impl_; }
  /// @endcond

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Reads a .gltf or .glb file. @throws Error (BadFile) naming file, element and remedy
Scene load(const std::filesystem::path& path, const LoadOptions& options = {});

/// A scene with its acceleration structure, lights and all that is found out once: const, and shared by every
/// render of it. Takes about as long as loading; afterwards the scene can be rendered with any settings. Only
/// its cameras are fixed.
using Prepared = std::shared_ptr<const PreparedScene>;

/// Prepares a scene, which is copied; changing it later changes nothing here.
Prepared prepare(const Scene& scene);

}  // namespace regulus

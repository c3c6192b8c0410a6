// The renderer's own scene: geometry in a frame near it (Scene::origin) and meshes with their copies,
// materials, textures, lights and cameras, in the structs that kernels and the scalar reference read
// (shaders/interface/scene.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "interface/scene.h"
#include "scene/environment.hpp"
#include "scene/light_tree.hpp"
#include "scene/solids.hpp"

namespace regulus::scene {

inline constexpr float NO_FAR_PLANE = 3.4e38f;  ///< m

/// A camera as the file gives it; becomes an interface::Camera once the film size is known.
struct SceneCamera {
  std::string name;
  bool is_orthographic = false;
  glm::mat4 camera_to_world{1.0f};                 ///< rigid part used; looks down local -z, y up (glTF)
  float y_fov = 0.8f;                              ///< radians, full vertical angle; perspective
  float aspect_ratio = 0;                          ///< width / height; 0: not given
  float x_magnification = 1, y_magnification = 1;  ///< half extents, metres; orthographic
  float lens_radius = 0;                           ///< metres; 0: pinhole
  float focus_distance = 1;                        ///< metres
  float z_near = 0, z_far = NO_FAR_PLANE;          ///< depths between which it sees, metres
};

/// An animation as a user sees it.
struct AnimationSummary {
  std::string name;    ///< may be empty
  double seconds = 0;  ///< time of its last key
};

/// What the file holds and what became of it, for `regulus inspect`.
struct Inventory {
  size_t meshes = 0;                            ///< of the file
  size_t instances = 0;                         ///< meshes that the shown scene places
  size_t images = 0;                            ///< of the file
  bool has_cameras = false;                     ///< false: the only camera is one framed on the bounds
  std::vector<std::string> extensions_read;     ///< of extensionsUsed
  std::vector<std::string> extensions_ignored;  ///< of extensionsUsed
  std::vector<std::string> variants;            ///< KHR_materials_variants, by name
  std::vector<AnimationSummary> animations;     ///< of the file
};

/// An animation at a time: what poses a scene.
struct ScenePose {
  std::string animation;  ///< its name, or its index if it has none
  double seconds = 0;     ///< from its start
};

/// A mesh that is stored once for several copies: consecutive triangles of Scene::triangles, in the mesh's
/// space.
struct SharedMesh {
  uint32_t first_triangle, triangle_count;
};

/// A node of the file as outputs name it.
struct SceneNode {
  std::string name;         ///< "node" and its index if it has none
  std::string light_group;  ///< of its lights (scene/light_groups.hpp)
};

/// A material whose texture slots are all empty, the rest 0.
interface::Material untextured_material();

/// Exponents of the units in which films of the scene sum (interface/wavefront.h, scene/film_exponents.hpp).
struct FilmExponents {
  int radiance = 0;  ///< of samples
  int squares = 0;   ///< of squares of samples
  bool operator==(const FilmExponents&) const = default;
};

/// A loaded scene. Invariants: every index is in range, every number finite, every normal unit length, no
/// triangle has zero area (they are dropped with a warning).
struct Scene {
  std::filesystem::path path;
  /// Where the frame of all that follows stands in the file's world: 0 for scenes near its origin
  /// (scene/origin.hpp). World position = origin + position.
  glm::dvec3 origin{0};
  std::vector<interface::Vertex> vertices;
  std::vector<glm::vec4> vertex_colors;    ///< one per vertex, linear RGBA in [0, 1]; empty: all white
  std::vector<glm::vec2> vertex_uvs;       ///< vertex_uv_sets per vertex: further texture coordinates
  uint32_t vertex_uv_sets = 0;             ///< how many sets some material reads beside its first
  std::vector<glm::vec4> vertex_tangents;  ///< one per vertex, see Frame; empty: no material needs them
  /// `light` is filled by build_lights. First those of the shared meshes.
  std::vector<interface::Triangle> triangles;
  std::vector<SharedMesh> shared_meshes;       ///< one after the other from triangle 0 on; none of them emits
  std::vector<interface::Instance> instances;  ///< their copies; `root` is filled by build_for_scene
  std::vector<uint32_t> instance_blocks;       ///< the copy of each block of numbers, see interface::Instance
  uint32_t instance_block_shift = 0;           ///< blocks are 2^this numbers long
  std::vector<interface::Material> materials;
  std::vector<std::string> material_names;
  std::vector<float> material_priorities;  ///< extras.regulus.priority; where there is none: 0
  std::vector<interface::Texture> textures;
  std::vector<std::vector<uint32_t>> images;  ///< words of texels, see interface::Texture
  std::vector<interface::Light> lights;       ///< punctual after loading; all lights after build_lights
  std::vector<SceneNode> nodes;               ///< of the file
  std::vector<uint32_t> place_nodes;          ///< the node of each place of a mesh, see interface::Triangle
  std::vector<uint32_t> light_nodes;          ///< of each light; INVALID_INDEX: the environment
  std::vector<interface::LightAlias> light_aliases;
  LightTree light_tree;          ///< empty with fewer than two lights
  FilmExponents film_exponents;  ///< by the lights; filled by build_lights
  Solids solids;                 ///< filled by build_for_scene
  std::optional<Environment> environment;
  std::vector<SceneCamera> cameras;  ///< never empty: framed on the bounds if the file has none
  glm::vec3 bounds_min{0}, bounds_max{0};
  std::optional<ScenePose> pose;                ///< none: as the file has it
  std::optional<glm::uvec2> resolution;         ///< asset.extras.resolution
  std::map<std::string, std::string> settings;  ///< scenes[].extras.regulus: option name -> value
  std::vector<std::string> edits;               ///< what LoadOptions::edits came to, one property each
  std::vector<std::string> warnings;            ///< one line each
  Inventory inventory;
  uint64_t hash = 0;  ///< of the file's bytes, everything it refers to, and the LoadOptions that change it
};

/// What a command line says of the environment; it wins over the scene.
struct EnvironmentOptions {
  std::filesystem::path file{};      ///< OpenEXR or Radiance, wherever it lies; empty: what the scene says
  std::optional<double> rotation{};  ///< degrees about +y, counterclockwise seen from above
  std::optional<double> scale{};     ///< factor on the radiance, >= 0
};

/// Bytes that must be gained for copies of meshes to share one stored mesh: rays are slower through copies.
inline constexpr uint64_t SHARING_GAIN = uint64_t{64} << 20;

inline constexpr uint64_t NEVER_SHARE = std::numeric_limits<uint64_t>::max();

struct LoadOptions {
  std::optional<uint32_t> scene{};  ///< index; empty: the file's default scene
  bool allow_external = false;      ///< URIs outside the scene's folder
  bool is_strict = false;           ///< faults that could be mended with a warning are errors
  EnvironmentOptions environment{};
  uint64_t sharing_gain = SHARING_GAIN;  ///< bytes; 0: whatever is placed twice is shared
  /// Material variant by name; empty: what scenes[].extras.regulus says, else the file's own materials.
  std::string variant{};
  uint64_t memory_bytes = 0;  ///< what the scene may take on the host; 0: default_memory_bytes()
  /// Animation that poses the scene, by name or index; empty: what scenes[].extras.regulus says, else the
  /// first one if a time is given, else none.
  std::string animation{};
  std::optional<double> time{};      ///< s, of the animation; none: what scenes[].extras.regulus says, else 0
  std::vector<std::string> edits{};  ///< such as "materials.Glass.roughness=0.1", see apply_edits
};

/// A scene file that stays open: its scene can be had at many times of an animation.
class SceneFile {
 public:
  /// Opens a .gltf or .glb file.
  /// @throws regulus::Error (BadFile) with one line: file, offending element, what to do.
  explicit SceneFile(std::filesystem::path path, const LoadOptions& options = {});
  ~SceneFile();
  SceneFile(SceneFile&&) noexcept;
  SceneFile& operator=(SceneFile&&) noexcept;

  /// The scene in the pose that the options ask for. @throws as the constructor
  Scene load();

  /// Poses a scene of this file by its animation (the first one unless the options name another) at a time in
  /// seconds: afterwards it is, but for the numbers of textures, what load() gives for that time. Images and
  /// environment maps are not read again. @throws as the constructor
  void pose(Scene& scene, double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads a .gltf or .glb file.
/// @throws regulus::Error (BadFile) with one line: file, offending element, what to do.
Scene load(const std::filesystem::path& path, const LoadOptions& options = {});

/// Renumbers the stored triangles: new triangle i is old triangle order[i] (order is a permutation, also of
/// each shared mesh). Call before build_lights.
void reorder_triangles(Scene& scene, const std::vector<uint32_t>& order);

/// Appends a light per emissive triangle and the environment to the punctual lights, fills selection
/// probabilities in proportion to power, the alias table, the light tree, the film's exponents, and
/// Triangle::light. A scene
/// without an environment and without any light but textures that emit gets a dim uniform one, with a
/// warning.
void build_lights(Scene& scene);

/// Film size where none is given: the scene's resolution, else 1280 wide at the camera's aspect.
glm::uvec2 default_film_size(const Scene& scene, uint32_t camera);

/// The camera for a film of width x height pixels. The frame that the camera's aspect ratio gives is never
/// cut: a wider film sees more to the sides, a narrower one more above and below. Without an aspect ratio the
/// vertical field of view is kept.
interface::Camera make_camera(const SceneCamera& camera, uint32_t width, uint32_t height);

/// A feature a scene may have and what kernels are rid of where it has not.
struct FeatureDescription {
  uint32_t bit;         ///< FEATURE_*
  const char* name;     ///< in statistics
  const char* removes;  ///< code that its absence compiles away
};
/// All features there are.
std::span<const FeatureDescription> feature_descriptions();

/// FEATURE_* bits of the scene (shaders/interface/wavefront.h), and the material classes present as bits
/// 1 << MATERIAL_CLASS_*.
struct Features {
  uint32_t bits = 0;
  uint32_t material_classes = 0;
  bool has_connectible_surfaces =
      false;  ///< some surface scatters other than as a perfect mirror or clear glass
  bool has_varying_starts =
      false;  ///< what holds the points of a camera or light is not the same for all of them
  /// Sharpest microfacet lobes, conservatively: least alpha of those that reflect, and of those that refract
  /// with relative index n least alpha |n - 1| / max(n, 1). Infinite without such lobes.
  float least_reflection_alpha = std::numeric_limits<float>::infinity();
  float least_refraction_alpha = std::numeric_limits<float>::infinity();
  FilmExponents film_exponents;  ///< the scene's
};
Features find_features(const Scene& scene);

/// True if a surface is blended: rays decide by their bits whether they meet it, which the scalar reference's
/// own rays do not share.
bool has_blended_surfaces(const Scene& scene);

}  // namespace regulus::scene

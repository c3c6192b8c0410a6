// load: the order in which a scene is read. Also reorder_triangles.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "base/error.hpp"
#include "scene/animation.hpp"
#include "scene/clipping.hpp"
#include "scene/document.hpp"
#include "scene/emitter_overlap.hpp"
#include "scene/environment_file.hpp"
#include "scene/film_limits.hpp"
#include "scene/geometry.hpp"
#include "scene/image_based_light.hpp"
#include "scene/instancing.hpp"
#include "scene/light_groups.hpp"
#include "scene/material.hpp"
#include "scene/nodes.hpp"
#include "scene/origin.hpp"
#include "scene/placement.hpp"
#include "scene/pose.hpp"
#include "scene/punctual.hpp"
#include "scene/scene.hpp"
#include "scene/schema.hpp"
#include "scene/texture.hpp"
#include "scene/variants.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

/// Member `name` of `object` if both are objects.
const json* object_member(const json* object, const char* name) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto member = object->find(name);
  return member != object->end() ? &*member : nullptr;
}

void read_resolution(Document& document, Scene& scene) {
  const json* resolution =
      object_member(object_member(object_member(&document.json, "asset"), "extras"), "resolution");
  if (resolution == nullptr) return;
  const auto is_side = [](const json& side) {
    return side.is_number_unsigned() && side.get<uint64_t>() >= 1 && side.get<uint64_t>() <= MAX_FILM_SIDE;
  };
  if (!resolution->is_array() || resolution->size() != 2 || !is_side((*resolution)[0]) ||
      !is_side((*resolution)[1])) {
    document.warn("asset.extras.resolution is not [width, height] in pixels and is ignored");
    return;
  }
  scene.resolution = glm::uvec2((*resolution)[0].get<uint32_t>(), (*resolution)[1].get<uint32_t>());
}

/// scenes[].extras.regulus; null if there is none.
const json* regulus_extras(const Document& document, const std::optional<size_t>& scene_index) {
  if (!scene_index) return nullptr;
  return object_member(object_member(&document.json["scenes"][*scene_index], "extras"), "regulus");
}

/// Settings that decide what is loaded, not how it is rendered.
bool is_part_of_scene(const std::string& setting) {
  constexpr std::array NAMES = {"environment", "variant", "animation", "at"};
  return std::find(NAMES.begin(), NAMES.end(), setting) != NAMES.end();
}

void read_settings(Document& document, size_t scene_index, Scene& scene) {
  const json* settings = regulus_extras(document, scene_index);
  if (settings == nullptr || !settings->is_object()) return;
  for (const auto& [name, value] : settings->items()) {
    if (is_part_of_scene(name)) continue;
    if (value.is_string())
      scene.settings[name] = value.get<std::string>();
    else if (value.is_number() || value.is_boolean())
      scene.settings[name] = value.dump();
    else
      document.warn(fmt::format("scenes/{}/extras/regulus/{} is not a string, number or bool and is ignored",
                                scene_index, name));
  }
}

/// The variant that the command line or else the scene asks for; empty: none.
std::string asked_variant(const Document& document, const std::optional<size_t>& scene_index,
                          const LoadOptions& options) {
  const json* of_scene = object_member(regulus_extras(document, scene_index), "variant");
  if (!options.variant.empty() || of_scene == nullptr) return options.variant;
  if (!of_scene->is_string())
    document.fail("scenes[].extras.regulus.variant is not a string; write the variant's name");
  return of_scene->get<std::string>();
}

/// An animation of the file and the time at which it poses the scene.
struct AskedPose {
  size_t animation;
  double seconds;
};

/// The pose that the command line or else the scene asks for.
std::optional<AskedPose> asked_pose(const Document& document, const std::optional<size_t>& scene_index,
                                    const LoadOptions& options) {
  const json* extras = regulus_extras(document, scene_index);
  const json* of_scene = object_member(extras, "animation");
  const json* time_of_scene = object_member(extras, "at");
  std::string animation = options.animation;
  if (animation.empty() && of_scene != nullptr)
    animation = of_scene->is_string() ? of_scene->get<std::string>() : of_scene->dump();
  std::optional<double> time = options.time;
  if (!time && time_of_scene != nullptr) {
    if (!time_of_scene->is_number())
      document.fail("scenes[].extras.regulus.at is not a number; write seconds");
    time = time_of_scene->get<double>();
  }
  if (time && !std::isfinite(*time)) document.fail("the time of an animation must be finite; give seconds");
  if (animation.empty() && !time) return std::nullopt;
  return AskedPose{find_animation(document, animation.empty() ? "0" : animation), time.value_or(0)};
}

void set_bounds(Scene& scene) {
  scene.bounds_min = glm::vec3(std::numeric_limits<float>::infinity());
  scene.bounds_max = -scene.bounds_min;
  for (size_t i = first_placed_triangle(scene); i < scene.triangles.size(); ++i) {
    const interface::Triangle& triangle = scene.triangles[i];
    for (const uint32_t vertex : {triangle.v0, triangle.v1, triangle.v2}) {
      scene.bounds_min = glm::min(scene.bounds_min, scene.vertices[vertex].position);
      scene.bounds_max = glm::max(scene.bounds_max, scene.vertices[vertex].position);
    }
  }
  for (const auto& [lower, upper] : instance_bounds(scene)) {
    scene.bounds_min = glm::min(scene.bounds_min, lower);
    scene.bounds_max = glm::max(scene.bounds_max, upper);
  }
}

Inventory take_inventory(const Document& document, size_t places) {
  Inventory inventory;
  inventory.meshes = document.model.meshes.size();
  inventory.instances = places;
  inventory.images = document.images.size();
  inventory.variants = variant_names(document);
  inventory.animations = list_animations(document);
  for (const std::string& name : document.extensions_used())
    (is_known_extension(name) ? inventory.extensions_read : inventory.extensions_ignored).push_back(name);
  return inventory;
}

glm::dvec3 choose_scene_origin(Document& document, const std::vector<PlacedNode>& places,
                               const PlacedBoxes& boxes) {
  const Box box = boxes.all();
  require_fitting_extent(document, box);
  const glm::dvec3 origin = choose_origin(box);
  warn_of_rounding(document, places, boxes, origin);
  return origin;
}

/// The options that make another scene of the same files.
std::string describe(const LoadOptions& options, const std::optional<AskedPose>& pose) {
  std::string text;
  if (pose) text += fmt::format("animation {} at {} ", pose->animation, pose->seconds);
  if (!options.variant.empty()) text += fmt::format("variant {} ", options.variant);
  if (options.scene) text += fmt::format("scene {} ", *options.scene);
  if (options.environment.rotation) text += fmt::format("rotation {} ", *options.environment.rotation);
  if (options.sharing_gain != SHARING_GAIN) text += fmt::format("sharing gain {} ", options.sharing_gain);
  if (options.environment.scale) text += fmt::format("scale {} ", *options.environment.scale);
  return text;
}

std::string describe_edits(const std::vector<std::string>& edits) {
  std::string text;
  for (const std::string& edit : edits) text += fmt::format("edit {} ", edit);
  return text;
}

/// Why a scene without a triangle has none, and what to do. `extent` is that of its meshes.
std::string cause_of_emptiness(const Document& document, const std::optional<size_t>& scene_index,
                               const std::vector<PlacedNode>& nodes, double extent) {
  if (!document.first_loss.empty()) return document.first_loss;
  const auto counted = [](size_t count) { return count == 1 ? "1 mesh" : fmt::format("{} meshes", count); };
  const size_t meshes = document.model.meshes.size();
  if (meshes == 0) return "the file has no mesh; choose another file";
  const auto has_mesh = [&](size_t node) { return document.model.nodes[node].mesh >= 0; };
  const auto placed = static_cast<size_t>(
      std::count_if(nodes.begin(), nodes.end(), [&](const PlacedNode& node) { return has_mesh(node.node); }));
  const auto visible = std::count_if(nodes.begin(), nodes.end(), [&](const PlacedNode& node) {
    return node.is_visible && has_mesh(node.node);
  });
  if (placed == 0) {
    bool is_placed_elsewhere = false;
    for (size_t i = 0; i < document.model.nodes.size(); ++i) is_placed_elsewhere |= has_mesh(i);
    if (!is_placed_elsewhere || !scene_index)
      return counted(meshes) + ", but no node places them; add nodes that do";
    return fmt::format(
        "{}, but no node of scene {} places them; choose another scene, or list their nodes in it",
        counted(meshes), *scene_index);
  }
  if (visible == 0)
    return fmt::format("all {} nodes with a mesh are invisible (KHR_node_visibility); show one", placed);
  if (extent > 0)
    return fmt::format(
        "no triangle has an area that single precision can compute with, in a scene {:.3g} units wide; scale "
        "it up",
        extent);
  return fmt::format(
      "none of the meshes that {} nodes place has a triangle with an area; choose another scene or file",
      placed);
}

}  // namespace

struct SceneFile::Impl {
  std::filesystem::path path;
  LoadOptions options;
  Document document;
  std::optional<size_t> scene_index;
  std::optional<AskedPose> pose;
  std::optional<Animation> animation;
  LoadedTextures textures;  // those of the last scene
  bool has_environment = false;
  uint64_t geometry_bytes = 0;  // what the last scene's geometry was counted as

  Impl(std::filesystem::path file, const LoadOptions& load_options)
      : path(std::move(file)),
        options(load_options),
        document(open_document(path, options.allow_external, options.is_strict,
                               options.memory_bytes != 0 ? options.memory_bytes : default_memory_bytes(),
                               options.edits)),
        scene_index(choose_scene(document, options.scene)),
        pose(asked_pose(document, scene_index, options)) {
    const std::string variant = asked_variant(document, scene_index, options);
    if (!variant.empty()) choose_variant(document, variant);
  }

  void choose_pose(double seconds) {
    if (!pose) pose = AskedPose{find_animation(document, "0"), 0};
    pose->seconds = seconds;
  }

  /// Fills a scene that holds `textures`, and the environment if it has been read.
  void fill(Scene& scene) {
    if (pose && !animation) animation.emplace(document, pose->animation);
    if (pose) animation->pose(document, pose->seconds);
    std::vector<PlacedNode> nodes = place_nodes(document, scene_index);
    scene.path = path;
    std::vector<PlacedNode> places = place_meshes(document, nodes);
    scene.nodes = read_nodes(document);
    for (const PlacedNode& place : places) scene.place_nodes.push_back(static_cast<uint32_t>(place.node));
    drop_unreadable(document, places);
    require_vertices(document, places);
    pose_meshes(document, nodes, places);
    const PlacedBoxes boxes(document, places);
    const double extent = boxes.all().extent();
    scene.origin = choose_scene_origin(document, places, boxes);
    take_off(scene.origin, nodes);
    take_off(scene.origin, places);
    document.files.release_to(document.files.held_bytes() - geometry_bytes);
    const uint64_t held = document.files.held_bytes();
    add_geometry(document, places, boxes.meshes(), options.sharing_gain, scene);
    geometry_bytes = document.files.held_bytes() - held;
    if (scene.triangles.empty())
      document.fail("nothing to render: " + cause_of_emptiness(document, scene_index, nodes, extent));
    set_bounds(scene);
    add_materials(document, scene, textures);
    if (const size_t cut = cut_overlapping_emitters(scene); cut > 0) {
      document.warn(
          fmt::format("{} emissive triangles lie in the plane of others that shine to the same "
                      "side, in part or as a whole; each point shines once",
                      cut));
      if (!number_instances(scene))
        document.fail("more than 2^32 triangles with those of copies; reduce the scene");
    }
    add_punctual_lights(document, nodes, scene);
    add_cameras(document, nodes, scene);
    drop_idle_planes(scene);
    scene.inventory = take_inventory(document, places.size());
    scene.inventory.has_cameras = !scene.cameras.empty();
    if (scene.cameras.empty()) scene.cameras.push_back(frame_bounds(scene.bounds_min, scene.bounds_max));
    read_resolution(document, scene);
    if (scene_index) read_settings(document, *scene_index, scene);
    if (!has_environment) read_environment_of(scene);
    label(scene);
  }

  void read_environment_of(Scene& scene) {
    scene.environment = read_environment(
        document, object_member(regulus_extras(document, scene_index), "environment"), options.environment);
    has_environment = scene.environment.has_value();
    // An animation may turn or dim it: it is read for every pose.
    if (!scene.environment && scene_index)
      scene.environment = read_image_based_light(document, *scene_index, options.environment);
  }

  /// What the scene was made of.
  void label(Scene& scene) {
    if (pose) scene.pose = ScenePose{animation_name(document, pose->animation), pose->seconds};
    scene.edits = document.edits;
    scene.warnings = document.warnings;
    if (document.unsaid_warnings > 0)
      scene.warnings.push_back(fmt::format("{} more warnings are left out", document.unsaid_warnings));
    scene.hash = document.files.hash_with(describe(options, pose) + describe_edits(document.edits));
  }
};

namespace {

/// Runs `action` and says what is to be said if memory runs out.
template <typename Action>
auto with_memory(const std::filesystem::path& path, const Action& action) {
  try {
    return action();
  } catch (const OutOfMemory& error) {
    fail(path, error.what());
  } catch (const std::bad_alloc&) {
    fail(path, "not enough memory to load it; reduce the scene");
  }
}

}  // namespace

SceneFile::SceneFile(std::filesystem::path path, const LoadOptions& options)
    : impl_(with_memory(path, [&] { return std::make_unique<Impl>(path, options); })) {}
SceneFile::~SceneFile() = default;
SceneFile::SceneFile(SceneFile&&) noexcept = default;
SceneFile& SceneFile::operator=(SceneFile&&) noexcept = default;

Scene SceneFile::load() {
  return with_memory(impl_->path, [&] {
    Scene scene;
    impl_->textures = {};
    impl_->has_environment = false;
    impl_->fill(scene);
    return scene;
  });
}

void SceneFile::pose(Scene& scene, double seconds) {
  with_memory(impl_->path, [&] {
    Scene posed;
    posed.textures = std::move(scene.textures);
    posed.images = std::move(scene.images);
    if (impl_->has_environment) posed.environment = std::move(scene.environment);
    impl_->choose_pose(seconds);
    impl_->fill(posed);
    scene = std::move(posed);
  });
}

Scene load(const std::filesystem::path& path, const LoadOptions& options) {
  return SceneFile(path, options).load();
}

void reorder_triangles(Scene& scene, const std::vector<uint32_t>& order) {
  std::vector<interface::Triangle> reordered;
  reordered.reserve(order.size());
  for (const uint32_t old_index : order) reordered.push_back(scene.triangles.at(old_index));
  scene.triangles = std::move(reordered);
  if (scene.solids.of_triangle.empty()) return;
  std::vector<uint32_t> solids;
  solids.reserve(order.size());
  for (const uint32_t old_index : order) solids.push_back(scene.solids.of_triangle.at(old_index));
  scene.solids.of_triangle = std::move(solids);
}

}  // namespace regulus::scene

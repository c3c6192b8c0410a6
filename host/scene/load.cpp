// load: the order in which a scene is read. Also reorder_triangles.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <new>

#include "base/error.hpp"
#include "scene/clipping.hpp"
#include "scene/document.hpp"
#include "scene/environment_file.hpp"
#include "scene/geometry.hpp"
#include "scene/image_based_light.hpp"
#include "scene/instancing.hpp"
#include "scene/material.hpp"
#include "scene/nodes.hpp"
#include "scene/origin.hpp"
#include "scene/placement.hpp"
#include "scene/pose.hpp"
#include "scene/punctual.hpp"
#include "scene/scene.hpp"
#include "scene/schema.hpp"
#include "scene/variants.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

constexpr uint64_t MAX_FILM_SIDE = 65536;

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

void read_settings(Document& document, size_t scene_index, Scene& scene) {
  const json* settings = regulus_extras(document, scene_index);
  if (settings == nullptr || !settings->is_object()) return;
  for (const auto& [name, value] : settings->items()) {
    if (name == "environment" || name == "variant") continue;  // no options but part of the scene
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
std::string describe(const LoadOptions& options) {
  std::string text;
  if (!options.variant.empty()) text += fmt::format("variant {} ", options.variant);
  if (options.scene) text += fmt::format("scene {} ", *options.scene);
  if (options.environment.rotation) text += fmt::format("rotation {} ", *options.environment.rotation);
  if (options.sharing_gain != SHARING_GAIN) text += fmt::format("sharing gain {} ", options.sharing_gain);
  if (options.environment.scale) text += fmt::format("scale {} ", *options.environment.scale);
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
        "{}, but no node of scene {} places them; choose another with --scene, or list their nodes in "
        "it",
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

Scene load_unguarded(const std::filesystem::path& path, const LoadOptions& options) {
  Document document =
      open_document(path, options.allow_external, options.is_strict,
                    options.memory_bytes != 0 ? options.memory_bytes : default_memory_bytes());
  const std::optional<size_t> scene_index = choose_scene(document, options.scene);
  std::vector<PlacedNode> nodes = place_nodes(document, scene_index);
  const std::string variant = asked_variant(document, scene_index, options);
  if (!variant.empty()) choose_variant(document, variant);

  Scene scene;
  scene.path = path;
  std::vector<PlacedNode> places = place_meshes(document, nodes);
  drop_unreadable(document, places);
  require_vertices(document, places);
  pose_meshes(document, nodes, places);
  const PlacedBoxes boxes(document, places);
  const double extent = boxes.all().extent();
  scene.origin = choose_scene_origin(document, places, boxes);
  take_off(scene.origin, nodes);
  take_off(scene.origin, places);
  add_geometry(document, places, boxes.meshes(), options.sharing_gain, scene);
  if (scene.triangles.empty())
    document.fail("nothing to render: " + cause_of_emptiness(document, scene_index, nodes, extent));
  set_bounds(scene);
  add_materials(document, scene);
  add_punctual_lights(document, nodes, scene);
  add_cameras(document, nodes, scene);
  drop_idle_planes(scene);
  scene.inventory = take_inventory(document, places.size());
  scene.inventory.has_cameras = !scene.cameras.empty();
  if (scene.cameras.empty()) scene.cameras.push_back(frame_bounds(scene.bounds_min, scene.bounds_max));
  read_resolution(document, scene);
  if (scene_index) read_settings(document, *scene_index, scene);
  scene.environment = read_environment(
      document, object_member(regulus_extras(document, scene_index), "environment"), options.environment);
  if (!scene.environment && scene_index)
    scene.environment = read_image_based_light(document, *scene_index, options.environment);
  scene.warnings = document.warnings;
  if (document.unsaid_warnings > 0)
    scene.warnings.push_back(fmt::format("{} more warnings are left out", document.unsaid_warnings));
  document.files.add_text_to_hash(describe(options));
  scene.hash = document.files.hash();
  return scene;
}

}  // namespace

Scene load(const std::filesystem::path& path, const LoadOptions& options) {
  try {
    return load_unguarded(path, options);
  } catch (const OutOfMemory& error) {
    fail(path, error.what());
  } catch (const std::bad_alloc&) {
    fail(path, "not enough memory to load it; reduce the scene");
  }
}

void reorder_triangles(Scene& scene, const std::vector<uint32_t>& order) {
  std::vector<interface::Triangle> reordered;
  reordered.reserve(order.size());
  for (const uint32_t old_index : order) reordered.push_back(scene.triangles.at(old_index));
  scene.triangles = std::move(reordered);
}

}  // namespace regulus::scene

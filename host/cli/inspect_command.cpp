// regulus inspect: what a scene holds, what of it is not read, what rendering it needs and skips. Uses no
// device.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "base/standard_streams.hpp"
#include "cli/commands.hpp"
#include "cli/output_guard.hpp"
#include "cli/output_writer.hpp"
#include "cli/render_options.hpp"
#include "cli/validators.hpp"
#include "reference/merge_radius.hpp"
#include "render/device_images.hpp"
#include "render/names.hpp"
#include "render/stages.hpp"
#include "scene/placement.hpp"

namespace regulus::cli {

namespace {

using Json = nlohmann::ordered_json;
using namespace interface;

struct InspectOptions {
  std::string scene_file, json, variant, animation;
  std::vector<std::string> edits;
  std::optional<double> time;
  std::optional<uint32_t> scene_index;
  bool allow_external = false;
  bool is_strict = false;
  uint64_t memory_bytes = 0;
};

/// The settings a plain `regulus render` of the scene would use. What is wrong with those of the file is
/// added to `warnings`.
render::RenderSettings default_settings(const scene::Scene& scene, std::vector<std::string>& warnings) {
  CLI::App command;
  RenderOptions options;
  declare_render_options(command, options);
  std::ranges::move(apply_scene_settings(command, scene), std::back_inserter(warnings));
  return resolve_settings(options, scene);
}

Json cameras_json(const scene::Scene& scene) {
  Json cameras = Json::array();
  for (const scene::SceneCamera& camera : scene.cameras) {
    Json entry = {{"name", camera.name}, {"kind", camera.is_orthographic ? "orthographic" : "perspective"}};
    if (camera.is_orthographic)
      entry["half_extents"] = {camera.x_magnification, camera.y_magnification};
    else
      entry["vertical_degrees"] = glm::degrees(camera.y_fov);
    entry["lens_radius"] = camera.lens_radius;
    entry["from_file"] = scene.inventory.has_cameras;
    cameras.push_back(entry);
  }
  return cameras;
}

Json materials_json(const scene::Scene& scene) {
  std::vector<uint64_t> triangles(scene.materials.size());
  std::vector<uint64_t> copies(scene.shared_meshes.size());
  for (const Instance& copy : scene.instances) ++copies[scene::mesh_index_of(scene, copy)];
  for (size_t i = scene::first_placed_triangle(scene); i < scene.triangles.size(); ++i)
    ++triangles[scene.triangles[i].material];
  for (size_t mesh = 0; mesh < copies.size(); ++mesh) {
    const scene::SharedMesh& shared = scene.shared_meshes[mesh];
    for (uint32_t i = 0; i < shared.triangle_count; ++i)
      triangles[scene.triangles[shared.first_triangle + i].material] += copies[mesh];
  }
  Json materials = Json::array();
  for (size_t i = 0; i < scene.materials.size(); ++i)
    materials.push_back({{"name", scene.material_names[i]},
                         {"class", name_of(render::names::MATERIAL_CLASS, scene.materials[i].material_class)},
                         {"emissive", (scene.materials[i].flags & MATERIAL_EMISSIVE) != 0},
                         {"triangles", triangles[i]}});
  return materials;
}

Json animations_json(const scene::Scene& scene) {
  Json animations = Json::array();
  for (const scene::AnimationSummary& animation : scene.inventory.animations)
    animations.push_back({{"name", animation.name}, {"seconds", animation.seconds}});
  return animations;
}

/// The animation and the time that pose the scene; null: it is at rest.
Json pose_json(const scene::Scene& scene) {
  if (!scene.pose) return nullptr;
  return {{"animation", scene.pose->animation}, {"seconds", scene.pose->seconds}};
}

Json lights_json(const scene::Scene& scene) {
  constexpr const char* KIND_NAMES[] = {"triangle", "point", "spot", "directional", "environment"};
  Json lights = {{"triangle", 0}, {"point", 0}, {"spot", 0}, {"directional", 0}, {"environment", 0}};
  for (const Light& light : scene.lights) {
    Json& count = lights[KIND_NAMES[light.kind]];
    count = count.get<uint64_t>() + 1;
  }
  return lights;
}

// Bytes that the scene and the film take on the device; the paths in flight come on top and depend on the
// device.
Json memory_json(const PreparedScene& prepared, const render::Plan& plan) {
  const scene::Scene& scene = prepared.scene;
  const auto bytes = [](const auto& values) { return uint64_t{values.size()} * sizeof(values[0]); };
  const uint64_t pixels = plan.window().pixels();
  Json memory = {
      {"bvh", bytes(prepared.bvh.nodes) + bytes(prepared.bvh.triangles)},
      {"geometry", bytes(scene.vertices) + bytes(scene.triangles)},
      {"instances", bytes(scene.instances) + bytes(scene.instance_blocks)},
      {"materials", bytes(scene.materials)},
      {"textures", render::texture_bytes(scene)},
      {"lights", bytes(scene.lights) + bytes(scene.light_aliases) + bytes(scene.light_tree.pairs) +
                     bytes(scene.light_tree.trails)},
      {"environment",
       scene.environment ? bytes(scene.environment->texels) + bytes(scene.environment->cdf) : uint64_t{0}},
      {"film", pixels * FILM_WORDS_PER_PIXEL * sizeof(uint32_t)}};
  uint64_t total = 0;
  for (const Json& part : memory) total += part.get<uint64_t>();
  memory["total"] = total;
  return memory;
}

Json features_json(const scene::Features& features) {
  Json present = Json::array(), absent = Json::object();
  for (const scene::FeatureDescription& feature : scene::feature_descriptions()) {
    if (features.bits & feature.bit)
      present.push_back(feature.name);
    else
      absent[feature.name] = feature.removes;
  }
  return {{"present", present}, {"absent", absent}};
}

Json stages_json(const render::Plan& plan) {
  Json run = Json::array(), skipped = Json::array();
  for (const render::StageStep& step : render::STAGES)
    (render::is_needed(step, plan) ? run : skipped).push_back(step.name);
  return {{"run", run}, {"skipped", skipped}};
}

Json dropped_json(const render::Plan& plan) {
  Json dropped = Json::array();
  for (const render::Dropped& entry : plan.dropped)
    dropped.push_back({{"what", entry.what}, {"why", entry.why}});
  return dropped;
}

// Whether connections and merges are regularized, and if not, why.
Json regularization_json(const render::Plan& plan) {
  if (plan.regularization != REGULARIZATION_NONE)
    return {{"used", true}, {"why", fmt::format("tau {:g}", plan.tau)}};
  const std::string* why = plan.why_dropped("regularization");
  if (why != nullptr) return {{"used", false}, {"why", "dropped: " + *why}};
  const bool is_chosen = !plan.asked.techniques && !plan.asked.regularization;
  return {{"used", false}, {"why", is_chosen ? plan.techniques_rule : "the settings ask for none"}};
}

// Whether walks are guided, and why. what: as the plan names it where it is dropped; useless: why there is no
// guide where none was tried.
Json guide_json(const render::Plan& plan, const char* what, uint32_t asked, bool is_used,
                const std::string& rule, const char* useless) {
  const std::string* dropped = plan.why_dropped(what);
  const std::string why = asked == LIGHT_GUIDE_OFF ? "the settings ask for none"
                          : dropped != nullptr     ? "dropped: " + *dropped
                          : !rule.empty()          ? rule
                                                   : useless;
  return {{"used", is_used}, {"why", why}};
}

/// A point of the scene's frame in the file's world.
Json in_world(const scene::Scene& scene, const glm::vec3& point) {
  const glm::dvec3 world = scene.origin + glm::dvec3(point);
  return {world.x, world.y, world.z};
}

Json inspect(const InspectOptions& options) {
  const PreparedScene prepared =
      prepare(scene::load(options.scene_file, {.scene = options.scene_index,
                                               .allow_external = options.allow_external,
                                               .is_strict = options.is_strict,
                                               .variant = options.variant,
                                               .memory_bytes = options.memory_bytes,
                                               .animation = options.animation,
                                               .time = options.time,
                                               .edits = options.edits}));
  const scene::Scene& scene = prepared.scene;
  std::vector<std::string> warnings = scene.warnings;
  const render::RenderSettings settings = default_settings(scene, warnings);
  const render::Plan plan = make_plan(prepared, settings);
  const reference::MergeRadius radius = choose_merge_radius(prepared, settings, &warnings);
  return {
      {"file", scene.path.string()},
      {"hash", fmt::format("{:016x}", scene.hash)},
      {"size", {plan.width, plan.height}},
      {"bounds", {in_world(scene, scene.bounds_min), in_world(scene, scene.bounds_max)}},
      {"origin", {scene.origin.x, scene.origin.y, scene.origin.z}},
      {"cameras", cameras_json(scene)},
      {"meshes", scene.inventory.meshes},
      {"instances", scene.inventory.instances},
      {"triangles", scene::placed_triangle_count(scene)},
      {"stored_triangles", scene.triangles.size()},
      {"shared_meshes", scene.shared_meshes.size()},
      {"copies", scene.instances.size()},
      {"vertices", scene.vertices.size()},
      {"materials", materials_json(scene)},
      {"lights", lights_json(scene)},
      {"variants", scene.inventory.variants},
      {"animations", animations_json(scene)},
      {"pose", pose_json(scene)},
      {"images", scene.inventory.images},
      {"textures", scene.textures.size()},
      {"bytes", memory_json(prepared, plan)},
      {"extensions",
       {{"read", scene.inventory.extensions_read}, {"ignored", scene.inventory.extensions_ignored}}},
      {"settings", scene.settings},
      {"features", features_json(prepared.features)},
      {"stages", stages_json(plan)},
      {"techniques", {{"set", render::technique_set_name(plan.techniques)}, {"rule", plan.techniques_rule}}},
      {"regularization", regularization_json(plan)},
      {"light_guide", guide_json(plan, "guided emission", plan.asked.light_guide, plan.light_guide != nullptr,
                                 plan.light_guide_rule, "no technique uses light paths")},
      {"walk_guide",
       guide_json(plan, "guided camera walks", plan.asked.walk_guide, plan.walk_guide != nullptr,
                  plan.walk_guide_rule, "no camera path goes on from a surface")},
      {"merge_radius",
       {{"metres", radius.metres},
        {"rule", radius.rule},
        {"used", (plan.techniques & TECHNIQUE_MERGE) != 0}}},
      {"dropped", dropped_json(plan)},
      {"warnings", warnings}};
}

// The same with strings that a terminal may be shown.
Json printable(Json value) {
  if (value.is_string()) return regulus::printable(value.get<std::string>());
  for (Json& member : value)
    if (member.is_structured() || member.is_string()) member = printable(std::move(member));
  return value;
}

// Names of a JSON array of strings, "none" if it is empty.
std::string listed(const Json& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names.get<std::vector<std::string>>(), ", "));
}

// Names are printed as JSON has them: a scene could hold any characters.
void print_contents(const Json& scene) {
  for (const Json& camera : scene["cameras"]) {
    const bool is_perspective = camera["kind"] == "perspective";
    say("camera           {}, {}{}{}\n", camera["name"].dump(), camera["kind"].get<std::string>(),
        is_perspective ? fmt::format(", {:.1f} degrees high", camera["vertical_degrees"].get<double>()) : "",
        camera["from_file"] ? "" : ", framed on the bounds: the file has none");
  }
  say("film             {} x {}\n", scene["size"][0].get<uint32_t>(), scene["size"][1].get<uint32_t>());
  say("meshes           {}, placed {} times: {} triangles, {} vertices\n", scene["meshes"].get<uint64_t>(),
      scene["instances"].get<uint64_t>(), scene["triangles"].get<uint64_t>(),
      scene["vertices"].get<uint64_t>());
  if (scene["copies"] > 0)
    say("instances        {} copies of {} meshes: {} triangles stored\n", scene["copies"].get<uint64_t>(),
        scene["shared_meshes"].get<uint64_t>(), scene["stored_triangles"].get<uint64_t>());
  if (scene["origin"] != Json{0.0, 0.0, 0.0})
    say("origin           {}: taken off before positions are rounded\n", scene["origin"].dump());
  for (const Json& material : scene["materials"])
    say("material         {}, {}{}, {} triangles\n", material["name"].dump(),
        material["class"].get<std::string>(), material["emissive"] ? ", emissive" : "",
        material["triangles"].get<uint64_t>());
  for (const Json& variant : scene["variants"]) say("variant          {}\n", variant.dump());
  for (const Json& animation : scene["animations"])
    say("animation        {}, {:g} s\n", animation["name"].dump(), animation["seconds"].get<double>());
  if (!scene["pose"].is_null())
    say("pose             {} at {} s\n", scene["pose"]["animation"].dump(),
        scene["pose"]["seconds"].get<double>());
  for (const auto& [kind, count] : scene["lights"].items())
    if (count > 0) say("lights           {} {}\n", count.get<uint64_t>(), kind);
  say("textures         {} of {} images\n", scene["textures"].get<uint64_t>(),
      scene["images"].get<uint64_t>());
}

void print(const Json& scene) {
  print_contents(scene);
  for (const auto& [part, bytes] : scene["bytes"].items())
    say("memory           {:>10.1f} KiB {}\n", bytes.get<double>() / 1024, part);
  say("extensions       {}\n", listed(scene["extensions"]["read"]));
  say("  ignored        {}\n", listed(scene["extensions"]["ignored"]));
  say("features         {}\n", listed(scene["features"]["present"]));
  for (const auto& [name, removes] : scene["features"]["absent"].items())
    say("  without        {:<18} kernels lose {}\n", name, removes.get<std::string>());
  say("stages           {}\n", listed(scene["stages"]["run"]));
  say("  skipped        {}\n", listed(scene["stages"]["skipped"]));
  say("techniques       {}: {}\n", scene["techniques"]["set"].get<std::string>(),
      scene["techniques"]["rule"].get<std::string>());
  say("regularization   {}: {}\n", scene["regularization"]["used"] ? "on" : "off",
      scene["regularization"]["why"].get<std::string>());
  for (const Json& dropped : scene["dropped"])
    if (dropped["what"] != "regularization")
      say("dropped          {}: {}\n", dropped["what"].get<std::string>(), dropped["why"].get<std::string>());
  say("light guide      {}: {}\n", scene["light_guide"]["used"] ? "yes" : "no",
      scene["light_guide"]["why"].get<std::string>());
  say("walk guide       {}: {}\n", scene["walk_guide"]["used"] ? "yes" : "no",
      scene["walk_guide"]["why"].get<std::string>());
  say("merge radius     {:g} m: {}{}\n", scene["merge_radius"]["metres"].get<double>(),
      scene["merge_radius"]["rule"].get<std::string>(),
      scene["merge_radius"]["used"] ? "" : "; its integrator does not merge");
  for (const Json& warning : scene["warnings"]) say("warning          {}\n", warning.get<std::string>());
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  const auto options = std::make_shared<InspectOptions>();
  CLI::App* command =
      app.add_subcommand("inspect", "What is in a scene, what rendering it needs, and what is skipped");
  command->add_option("scene-file", options->scene_file, "The .gltf or .glb file")
      ->required()
      ->type_name("SCENE");
  command
      ->add_option("--scene", options->scene_index, "Scene of the file by index (default: its own default)")
      ->type_name("INDEX");
  command
      ->add_option("--variant", options->variant, "Material variant by name (default: the scene's, or none)")
      ->type_name("NAME");
  command
      ->add_option("--animation", options->animation,
                   "Animation that poses the scene, by name or index (default: the scene's, or none)")
      ->type_name("ANIMATION");
  command->add_option("--at", options->time, "Time in seconds at which the animation poses the scene")
      ->type_name("SECONDS")
      ->check(number_in(-1e9, 1e9));
  add_edit_option(*command, options->edits);
  command->add_option("--json", options->json, "Write everything to this file")->type_name("FILE");
  command->add_flag("--allow-external", options->allow_external,
                    "Let the scene refer to files outside its folder");
  command->add_flag("--strict", options->is_strict, STRICT_HELP);
  add_memory_option(*command, options->memory_bytes);
  command->callback([options] {
    const Json scene = inspect(*options);
    OutputGuard guard;
    guard.add_scene(options->scene_file);
    if (!options->json.empty()) guard.add_output("--json", options->json);
    OutputWriter writer;
    if (!options->json.empty())
      writer.write(options->json,
                   [&] { return scene.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; });
    print(printable(scene));
    writer.throw_failures();
  });
}

}  // namespace regulus::cli

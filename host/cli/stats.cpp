#include "cli/stats.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/process_usage.hpp"
#include "base/version.hpp"
#include "render/aov.hpp"
#include "scene/placement.hpp"

namespace regulus::cli {

namespace {

using namespace interface;

constexpr std::pair<const char*, uint32_t> TECHNIQUE_NAMES[] = {{"hit", TECHNIQUE_HIT},
                                                                {"nee", TECHNIQUE_NEE},
                                                                {"splat", TECHNIQUE_SPLAT},
                                                                {"connect", TECHNIQUE_CONNECT},
                                                                {"merge", TECHNIQUE_MERGE}};
constexpr const char* CLASS_NAMES[MATERIAL_CLASS_COUNT] = {"diffuse", "opaque", "transmissive"};
constexpr const char* BOUND_NAMES[] = {"peak", "smith", "directional"};
constexpr const char* MIS_NAMES[] = {"blended", "corrected", "unmodified"};
constexpr const char* SAMPLER_QUALITY_NAMES[] = {"off", "on", "smooth"};
constexpr const char* NDF_NAMES[] = {"ggx", "beckmann", "cosine"};
constexpr const char* SHADOWING_NAMES[] = {"smith", "smith-uncorrelated", "v-cavity"};
constexpr const char* LIGHT_SAMPLING_NAMES[] = {"power", "bvh", "uniform", "auto"};
constexpr const char* SAMPLER_NAMES[] = {"sobol", "hash"};
constexpr const char* FILTER_NAMES[] = {"box", "gaussian", "blackman-harris"};

const char* regularization_name(uint32_t regularization) {
  if ((regularization & REGULARIZATION_VIRTUAL_MERGE) != 0) return "virtual-merge";
  if ((regularization & REGULARIZATION_BOTH) != 0) return "both";
  return (regularization & REGULARIZATION_ROUGHNESS) != 0 ? "roughness" : "none";
}

nlohmann::json settings_json(const render::RenderSettings& settings) {
  nlohmann::json techniques = nlohmann::json::array();
  for (const auto& [name, bit] : TECHNIQUE_NAMES)
    if (settings.techniques & bit) techniques.push_back(name);
  const render::Window window = settings.window();
  return {
      {"width", settings.width},
      {"height", settings.height},
      {"crop", {window.x, window.y, window.x + window.width, window.y + window.height}},
      {"aov", render::aov_names(settings.aovs)},
      {"camera", settings.camera},
      {"first_sample", settings.first_sample},
      {"samples", settings.samples},
      {"max_depth", settings.max_depth},
      {"seed", settings.seed},
      {"sampler", SAMPLER_NAMES[settings.sampler]},
      {"techniques", techniques},
      {"light_sampling", LIGHT_SAMPLING_NAMES[settings.light_sampling]},
      {"light_paths", settings.light_paths},
      {"cache_connections", settings.cache_connections},
      {"merge_radius", settings.merge_radius},
      {"merge_radius_rule", settings.merge_radius_rule},
      {"merge_reduction", settings.merge_reduction},
      {"regularization", regularization_name(settings.regularization)},
      {"diffusion", (settings.regularization & REGULARIZATION_DIFFUSION) != 0},
      {"sampler_quality", SAMPLER_QUALITY_NAMES[settings.sampler_quality]},
      {"tau", settings.tau},
      {"tau_schedule", settings.regularization & REGULARIZATION_CONSISTENT ? "consistent" : "fixed"},
      {"bound", BOUND_NAMES[settings.bound]},
      {"mis", MIS_NAMES[settings.mis]},
      {"clamp", std::isfinite(settings.largest_contribution) ? nlohmann::json(settings.largest_contribution)
                                                             : nlohmann::json(nullptr)},
      {"ndf", NDF_NAMES[settings.ndf]},
      {"shadowing", SHADOWING_NAMES[settings.shadowing]},
      {"energy_compensation", settings.has_energy_compensation},
      {"filter", FILTER_NAMES[settings.filter]},
      {"filter_radius", settings.filter_radius},
      {"filter_sigma", settings.filter_sigma}};
}

nlohmann::json scene_json(const scene::Scene& scene) {
  const scene::Features features = scene::find_features(scene);
  nlohmann::json present = nlohmann::json::array(), absent = nlohmann::json::array(),
                 classes = nlohmann::json::array();
  for (const scene::FeatureDescription& feature : scene::feature_descriptions())
    (features.bits & feature.bit ? present : absent).push_back(feature.name);
  for (uint32_t i = 0; i < MATERIAL_CLASS_COUNT; ++i)
    if (features.material_classes >> i & 1) classes.push_back(CLASS_NAMES[i]);
  return {{"file", scene.path.string()},
          {"animation", scene.pose ? nlohmann::json(scene.pose->animation) : nlohmann::json()},
          {"animation_seconds", scene.pose ? nlohmann::json(scene.pose->seconds) : nlohmann::json()},
          {"hash", fmt::format("{:016x}", scene.hash)},
          {"origin", {scene.origin.x, scene.origin.y, scene.origin.z}},
          {"triangles", scene::placed_triangle_count(scene)},
          {"stored_triangles", scene.triangles.size()},
          {"materials", scene.materials.size()},
          {"textures", scene.textures.size()},
          {"lights", scene.lights.size()},
          {"features", present},
          {"features_absent", absent},
          {"material_classes", classes}};
}

// Every step of the pass: those that did not run are listed as skipped.
nlohmann::json stages_json(const render::RenderSettings& settings, const scene::Scene& scene,
                           const render::RenderStatistics& statistics) {
  const scene::Features features = scene::find_features(scene);
  render::RenderSettings effective = settings;
  effective.techniques = render::effective_techniques(features, settings);
  nlohmann::json stages = nlohmann::json::array();
  for (const render::StageStep& step : render::STAGES) {
    const auto found = statistics.stages.find(step.name);
    const render::StageStatistics stage =
        found == statistics.stages.end() ? render::StageStatistics{} : found->second;
    const bool is_skipped = !render::is_needed(step, features, effective);
    // Stages may share a queue: what another one worked on is not this one's.
    const uint64_t items = is_skipped ? 0 : statistics.items(step);
    stages.push_back({{"name", step.name},
                      {"dispatches", stage.dispatches},
                      {"items", items},
                      {"device_ms", stage.device_ms},
                      {"skipped", is_skipped}});
  }
  return stages;
}

// By name of the film's sums: how many left its range.
nlohmann::json saturated_json(const render::Film& film) {
  nlohmann::json saturated;
  for (const render::FilmLayer& layer : render::FILM_LAYERS)
    saturated[layer.name] = render::count_saturated(film.*layer.words);
  return saturated;
}

// What the driver tells of the kernels, by its own names.
nlohmann::json kernels_json(const gpu::Device& device) {
  nlohmann::json kernels = nlohmann::json::array();
  for (const gpu::KernelStatistics& told : device.kernel_statistics()) {
    nlohmann::json values;
    for (const auto& [name, value] : told.values) values[name] = value;
    kernels.push_back({{"stage", told.kernel},
                       {"executable", told.executable},
                       {"subgroup_size", told.subgroup_size},
                       {"statistics", values}});
  }
  return kernels;
}

}  // namespace

nlohmann::json render_statistics(const gpu::Device& device, const scene::Scene& scene,
                                 const render::RenderSettings& settings, const render::Renderer& renderer,
                                 const LoadTimes& times) {
  const render::RenderStatistics& statistics = renderer.statistics();
  const uint64_t pixels = settings.window().pixels();
  return {{"version", VERSION},
          {"commit", COMMIT},
          {"device", {{"name", device.info().name}, {"driver", device.info().driver}}},
          {"scene", scene_json(scene)},
          {"settings", settings_json(settings)},
          {"seconds",
           {{"load", times.load_seconds},
            {"bvh", times.bvh_seconds},
            {"pipelines", times.pipeline_seconds},
            {"render", statistics.render_seconds},
            {"device", statistics.device_seconds},
            {"cpu", process_cpu_seconds()}}},
          {"stages", stages_json(settings, scene, statistics)},
          {"kernels", kernels_json(device)},
          {"rays", {{"closest", statistics.closest_rays()}, {"visibility", statistics.visibility_rays()}}},
          {"spp_done", statistics.paths / pixels},
          {"samples", statistics.paths},
          {"light_paths", statistics.light_paths},
          {"samples_per_second", static_cast<double>(statistics.paths - statistics.resumed_paths) /
                                     std::max(statistics.render_seconds, 1e-9)},
          {"non_finite", statistics.non_finite},
          {"film_exponents", {scene.film_exponents.radiance, scene.film_exponents.squares}},
          {"saturated", saturated_json(renderer.film())},
          {"traversal_overruns", statistics.traversal_overruns},
          {"submissions",
           {{"count", statistics.submissions.count},
            {"bound_items", statistics.submissions.bound_items},
            {"most_items", statistics.submissions.most_items},
            {"longest_device_ms", statistics.submissions.longest_ms}}},
          {"forgotten_media", statistics.forgotten_media},
          {"wave_paths", statistics.wave_capacity},
          {"bytes_per_path", statistics.bytes_per_path},
          {"device_peak_bytes", device.peak_allocated_bytes()},
          {"host_peak_bytes", process_peak_bytes()}};
}

image::Attributes scene_attributes(const scene::Scene& scene, const render::RenderSettings& settings) {
  image::Attributes attributes;
  const nlohmann::json recorded = settings_json(settings);
  for (const auto& [name, value] : recorded.items())
    attributes["regulus:" + name] = value.is_string() ? value.get<std::string>() : value.dump();
  attributes["regulus:scene"] = scene.path.string();
  if (scene.pose) {
    attributes["regulus:animation"] = scene.pose->animation;
    attributes["regulus:animation_seconds"] = fmt::format("{}", scene.pose->seconds);
  }
  attributes["regulus:origin"] =
      fmt::format("{:.17g} {:.17g} {:.17g}", scene.origin.x, scene.origin.y, scene.origin.z);
  attributes["regulus:scene_hash"] = fmt::format("{:016x}", scene.hash);
  attributes["regulus:version"] = fmt::format("{} ({})", VERSION, COMMIT);
  return attributes;
}

image::Attributes image_attributes(const gpu::Device& device, const scene::Scene& scene,
                                   const render::RenderSettings& settings, const render::Renderer& renderer) {
  image::Attributes attributes = scene_attributes(scene, settings);
  attributes["regulus:samples_done"] =
      std::to_string(renderer.statistics().paths / settings.window().pixels());
  attributes["regulus:device"] = device.info().name;
  attributes["regulus:driver"] = device.info().driver;
  attributes["regulus:render_seconds"] = fmt::format("{:.3f}", renderer.statistics().render_seconds);
  attributes["regulus:non_finite"] = std::to_string(renderer.statistics().non_finite);
  return attributes;
}

}  // namespace regulus::cli

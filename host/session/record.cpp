#include "session/record.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "base/process_usage.hpp"
#include "base/version.hpp"
#include "render/aov.hpp"
#include "render/cryptomatte.hpp"
#include "render/names.hpp"
#include "scene/placement.hpp"

namespace regulus::session {

namespace {

using namespace interface;
namespace names = render::names;

const char* regularization_name(uint32_t regularization) {
  return name_of(names::REGULARIZATION, regularization & ~names::REGULARIZATION_MODES);
}

nlohmann::json technique_names(uint32_t techniques) {
  nlohmann::json result = nlohmann::json::array();
  for (const render::Name& technique : names::TECHNIQUES)
    if (techniques & technique.value) result.push_back(technique.name);
  return result;
}

// What was done.
nlohmann::json settings_json(const render::Plan& plan) {
  const render::Window window = plan.window();
  return {{"width", plan.width},
          {"height", plan.height},
          {"crop", {window.x, window.y, window.x + window.width, window.y + window.height}},
          {"aov", render::aov_names(plan.aovs)},
          {"camera", plan.camera},
          {"first_sample", plan.first_sample},
          {"samples", plan.samples},
          {"max_depth", plan.max_depth},
          {"seed", plan.seed},
          {"sampler", name_of(names::SAMPLER, plan.sampler)},
          {"techniques", technique_names(plan.techniques)},
          {"techniques_rule", plan.techniques_rule},
          {"light_sampling", name_of(names::LIGHT_SAMPLING, plan.light_sampling)},
          {"light_guide", plan.light_guide ? fmt::format("on {:016x}", hash_of(*plan.light_guide)) : "off"},
          {"light_guide_rule", plan.light_guide_rule},
          {"shadow_roulette", plan.shadow_roulette},
          {"shadow_roulette_rule", plan.shadow_roulette_rule},
          {"walk_guide", plan.walk_guide ? fmt::format("on {:016x}", hash_of(*plan.walk_guide)) : "off"},
          {"walk_guide_rule", plan.walk_guide_rule},
          {"light_paths", plan.light_paths},
          {"cache_connections", plan.cache_connections},
          {"merge_radius", plan.merge_radius},
          {"merge_radius_rule", plan.merge_radius_rule},
          {"merge_reduction", plan.merge_reduction},
          {"regularization", regularization_name(plan.regularization)},
          {"diffusion", (plan.regularization & REGULARIZATION_DIFFUSION) != 0},
          {"sampler_quality", name_of(names::SAMPLER_QUALITY, plan.sampler_quality)},
          {"tau", plan.tau},
          {"tau_schedule", name_of(names::TAU_SCHEDULE, plan.regularization & REGULARIZATION_CONSISTENT)},
          {"bound", name_of(names::BOUND, plan.bound)},
          {"mis", name_of(names::MIS, plan.mis)},
          {"clamp", std::isfinite(plan.largest_contribution) ? nlohmann::json(plan.largest_contribution)
                                                             : nlohmann::json(nullptr)},
          {"ndf", name_of(names::NDF, plan.ndf)},
          {"shadowing", name_of(names::SHADOWING, plan.shadowing)},
          {"energy_compensation", plan.has_energy_compensation},
          {"filter", name_of(names::FILTER, plan.filter)},
          {"filter_radius", plan.filter_radius},
          {"filter_sigma", plan.filter_sigma}};
}

// What was asked for, where the plan may have decided otherwise; null: its choice.
nlohmann::json asked_json(const render::Plan& plan) {
  const render::RenderSettings& asked = plan.asked;
  const auto given = [](const auto& value) {
    return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
  };
  return {{"techniques", asked.techniques ? technique_names(*asked.techniques) : nlohmann::json(nullptr)},
          {"light_sampling", name_of(names::LIGHT_SAMPLING, asked.light_sampling)},
          {"light_guide", name_of(names::LIGHT_GUIDE, asked.light_guide)},
          {"walk_guide", name_of(names::LIGHT_GUIDE, asked.walk_guide)},
          {"light_paths", given(asked.light_paths)},
          {"merge_radius", given(asked.merge_radius)},
          {"merge_radius_share", given(asked.merge_radius_share)},
          {"regularization", asked.regularization ? nlohmann::json(regularization_name(*asked.regularization))
                                                  : nlohmann::json(nullptr)}};
}

nlohmann::json dropped_json(const render::Plan& plan) {
  nlohmann::json dropped = nlohmann::json::array();
  for (const render::Dropped& entry : plan.dropped)
    dropped.push_back({{"what", entry.what}, {"why", entry.why}});
  return dropped;
}

nlohmann::json scene_json(const PreparedScene& prepared) {
  const scene::Scene& scene = prepared.scene;
  const scene::Features& features = prepared.features;
  nlohmann::json present = nlohmann::json::array(), absent = nlohmann::json::array(),
                 classes = nlohmann::json::array();
  for (const scene::FeatureDescription& feature : scene::feature_descriptions())
    (features.bits & feature.bit ? present : absent).push_back(feature.name);
  for (const render::Name& material_class : names::MATERIAL_CLASS)
    if (features.material_classes >> material_class.value & 1) classes.push_back(material_class.name);
  return {{"file", scene.path.string()},
          {"animation", scene.pose ? nlohmann::json(scene.pose->animation) : nlohmann::json()},
          {"animation_seconds", scene.pose ? nlohmann::json(scene.pose->seconds) : nlohmann::json()},
          {"edits", scene.edits},
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
nlohmann::json stages_json(const render::Plan& plan, const render::RenderStatistics& statistics) {
  nlohmann::json stages = nlohmann::json::array();
  for (const render::StageStep& step : render::STAGES) {
    const auto found = statistics.stages.find(step.name);
    const render::StageStatistics stage =
        found == statistics.stages.end() ? render::StageStatistics{} : found->second;
    const bool is_skipped = !render::is_needed(step, plan);
    // Stages may share a queue: what another one worked on is not this one's.
    const uint64_t items = is_skipped ? 0 : statistics.items(step);
    stages.push_back({{"name", step.name},
                      {"dispatches", stage.dispatches},
                      {"items", items},
                      {"device_ms", stage.device_ms},
                      {"host_ms", stage.host_ms},
                      {"skipped", is_skipped}});
  }
  return stages;
}

// By name of the film's sums: how many left its range.
nlohmann::json saturated_json(const render::Film& film) {
  nlohmann::json saturated;
  for (const auto& [name, words] : render::sums_of(film)) saturated[name] = render::count_saturated(*words);
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

nlohmann::json render_statistics(const gpu::Device& device, const PreparedScene& prepared,
                                 const render::Plan& plan, const render::Renderer& renderer,
                                 const LoadTimes& times) {
  const render::RenderStatistics& statistics = renderer.statistics();
  const uint64_t pixels = plan.window().pixels();
  return {{"version", VERSION},
          {"commit", COMMIT},
          {"device", {{"name", device.info().name}, {"driver", device.info().driver}}},
          {"scene", scene_json(prepared)},
          {"settings", settings_json(plan)},
          {"asked", asked_json(plan)},
          {"dropped", dropped_json(plan)},
          {"seconds",
           {{"load", times.load_seconds},
            {"bvh", times.bvh_seconds},
            {"pipelines", times.pipeline_seconds},
            {"render", statistics.render_seconds},
            {"device", statistics.device_seconds},
            {"cpu", process_cpu_seconds()}}},
          {"stages", stages_json(plan, statistics)},
          {"kernels", kernels_json(device)},
          {"rays",
           {{"by", name_of(names::RAYS, statistics.rays)},
            {"closest", statistics.closest_rays()},
            {"visibility", statistics.visibility_rays()}}},
          {"spp_done", statistics.paths / pixels},
          {"samples", statistics.paths},
          {"light_paths", statistics.light_paths},
          {"samples_per_second", static_cast<double>(statistics.paths - statistics.resumed_paths) /
                                     std::max(statistics.render_seconds, 1e-9)},
          {"non_finite", statistics.non_finite},
          {"film_exponents",
           {prepared.features.film_exponents.radiance, prepared.features.film_exponents.squares}},
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

image::Attributes scene_attributes(const scene::Scene& scene, const render::Plan& plan) {
  image::Attributes attributes;
  const auto record = [&](const std::string& prefix, const nlohmann::json& values) {
    for (const auto& [name, value] : values.items())
      attributes[prefix + name] = value.is_string() ? value.get<std::string>() : value.dump();
  };
  record("regulus:", settings_json(plan));
  record("regulus:asked_", asked_json(plan));
  std::vector<std::string> dropped;
  dropped.reserve(plan.dropped.size());
  for (const render::Dropped& entry : plan.dropped)
    dropped.push_back(fmt::format("{}: {}", entry.what, entry.why));
  attributes["regulus:dropped"] = fmt::format("{}", fmt::join(dropped, "; "));
  render::add_cryptomatte_attributes(scene, plan.aovs, attributes);
  attributes["regulus:scene"] = scene.path.string();
  if (!scene.edits.empty()) attributes["regulus:edits"] = fmt::format("{}", fmt::join(scene.edits, " "));
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
                                   const render::Plan& plan, const render::Renderer& renderer) {
  image::Attributes attributes = scene_attributes(scene, plan);
  attributes["regulus:samples_done"] = std::to_string(renderer.statistics().paths / plan.window().pixels());
  attributes["regulus:rays"] = name_of(names::RAYS, renderer.statistics().rays);
  attributes["regulus:device"] = device.info().name;
  attributes["regulus:driver"] = device.info().driver;
  attributes["regulus:render_seconds"] = fmt::format("{:.3f}", renderer.statistics().render_seconds);
  attributes["regulus:non_finite"] = std::to_string(renderer.statistics().non_finite);
  return attributes;
}

}  // namespace regulus::session

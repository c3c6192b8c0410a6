#include "render/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "reference/merge_radius.hpp"
#include "render/light_guide_choice.hpp"
#include "render/names.hpp"
#include "render/shadow_roulette_choice.hpp"
#include "render/state.hpp"
#include "render/technique_choice.hpp"
#include "render/walk_guide_choice.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint32_t EMITTERS = FEATURE_TRIANGLE_LIGHTS | FEATURE_ENVIRONMENT;  // that rays can meet
constexpr uint32_t LIGHTS = EMITTERS | FEATURE_POINT_LIGHTS | FEATURE_DIRECTIONAL_LIGHTS;

// Why regularization would change nothing; empty if it would change something. Can be told only for
// BOUND_PEAK, whose alpha does not depend on directions.
std::string why_not_regularized(const Plan& plan) {
  if (std::isinf(plan.tau)) return "tau is infinite";
  // alpha_tau of docs/mathematics.md 2.2: 1 / sqrt(4 pi tau) for reflection, n / |n - 1| / sqrt(pi tau) for
  // refraction.
  const float alpha = 1 / std::sqrt(std::numbers::pi_v<float> * plan.tau);
  const scene::Features& features = plan.features;
  const bool is_sharp =
      features.least_reflection_alpha < 0.5f * alpha || features.least_refraction_alpha < alpha;
  if (is_sharp || plan.bound != BOUND_PEAK) return "";
  if (std::isinf(std::min(features.least_reflection_alpha, features.least_refraction_alpha)))
    return "no surface has a microfacet lobe";
  return fmt::format("no lobe is sharper than tau {:g} allows", plan.tau);
}

// Where the settings leave a choice open, `auto` makes it: by a guide of light paths, if it trained one.
std::optional<LightGuideChoice> choose_what_is_open(Plan& plan, const PreparedScene& prepared) {
  const RenderSettings& asked = plan.asked;
  if (asked.techniques) {
    plan.techniques = *asked.techniques;
    plan.techniques_rule = "given";
    // Measured: merging finds what regularization would, and gains nothing from it (docs/results/error.md).
    const bool has_merges = (plan.techniques & TECHNIQUE_MERGE) != 0;
    plan.regularization =
        asked.regularization.value_or(has_merges ? REGULARIZATION_NONE : REGULARIZATION_ROUGHNESS);
    return std::nullopt;
  }
  TechniqueChoice choice = choose_techniques(prepared, asked);
  plan.techniques = choice.techniques;
  plan.regularization = choice.regularization & ~names::REGULARIZATION_MODES;
  plan.techniques_rule = choice.why;
  if (asked.regularization || plan.regularization != REGULARIZATION_NONE)
    return std::move(choice.light_guide);
  if (const std::string why = why_not_regularized(plan); !why.empty())
    plan.dropped.push_back({"regularization", why});
  return std::move(choice.light_guide);
}

void plan_regularization(Plan& plan) {
  const RenderSettings& asked = plan.asked;
  if (plan.regularization == REGULARIZATION_NONE) return;
  plan.regularization |= asked.regularization_modes;
  const std::string why = why_not_regularized(plan);
  if (why.empty()) return;
  plan.regularization = REGULARIZATION_NONE;
  plan.dropped.push_back({"regularization", why});
}

void plan_techniques(Plan& plan) {
  const auto drop = [&](uint32_t technique, const char* name, const char* why) {
    if ((plan.techniques & technique) == 0) return;
    plan.techniques &= ~technique;
    plan.dropped.push_back({fmt::format("technique {}", name), why});
  };
  if ((plan.features.bits & EMITTERS) == 0)
    drop(TECHNIQUE_HIT, "hit", "the scene has no emitter that a ray can meet");
  constexpr std::pair<uint32_t, const char*> FROM_LIGHTS[] = {{TECHNIQUE_NEE, "nee"},
                                                              {TECHNIQUE_SPLAT, "splat"},
                                                              {TECHNIQUE_CONNECT, "connect"},
                                                              {TECHNIQUE_MERGE, "merge"}};
  for (const auto& [technique, name] : FROM_LIGHTS) {
    if ((plan.features.bits & LIGHTS) == 0) drop(technique, name, "the scene has no lights");
    const bool needs_lobes = (technique & (TECHNIQUE_CONNECT | TECHNIQUE_MERGE)) != 0;
    if (needs_lobes && !plan.features.has_connectible_surfaces && plan.regularization == REGULARIZATION_NONE)
      drop(technique, name, "every surface is a perfect mirror or clear glass");
  }
}

void plan_merge_radius(Plan& plan, const PreparedScene& prepared) {
  const RenderSettings& asked = plan.asked;
  if ((plan.techniques & TECHNIQUE_MERGE) == 0) return;
  if (asked.merge_radius && asked.keeps_merge_radius) {
    plan.merge_radius = *asked.merge_radius;
    plan.merge_radius_rule = "given";
    return;
  }
  const reference::MergeRadius chosen = choose_merge_radius(prepared, asked, &plan.warnings);
  plan.merge_radius = chosen.metres;
  plan.merge_radius_rule = chosen.rule;
}

bool has(const Plan& plan, uint32_t techniques) {
  return (plan.techniques & techniques) != 0;
}

// @param chosen what techniques were chosen with
void plan_light_guide(Plan& plan, const PreparedScene& prepared, std::optional<LightGuideChoice> chosen) {
  if (plan.asked.light_guide == LIGHT_GUIDE_OFF) return;
  if (!has(plan, LIGHT_SUBPATH_TECHNIQUES)) {
    if (plan.asked.light_guide == LIGHT_GUIDE_ON)
      plan.dropped.push_back({"guided emission", "no technique uses light paths"});
    return;
  }
  LightGuideChoice choice = chosen ? std::move(*chosen) : choose_light_guide(prepared, plan.asked);
  plan.light_guide = std::move(choice.guide);
  plan.light_guide_rule = std::move(choice.why);
  if (!plan.light_guide && plan.asked.light_guide == LIGHT_GUIDE_ON)
    plan.dropped.push_back({"guided emission", plan.light_guide_rule});
}

void plan_shadow_roulette(Plan& plan, const PreparedScene& prepared) {
  if (plan.asked.shadow_roulette == 0.0f || !has(plan, SHADOW_RAY_TECHNIQUES)) return;
  const ShadowRouletteChoice choice = choose_shadow_roulette(prepared, plan.asked);
  plan.shadow_roulette = choice.least;
  plan.shadow_roulette_rule = choice.why;
}

void plan_walk_guide(Plan& plan, const PreparedScene& prepared) {
  if (plan.asked.walk_guide == LIGHT_GUIDE_OFF) return;
  const bool is_on = plan.asked.walk_guide == LIGHT_GUIDE_ON;
  // Splats need no camera walk; what others have after one edge needs no choice of a direction.
  if (!has(plan, ~TECHNIQUE_SPLAT) || plan.max_depth < 2) {
    if (is_on) plan.dropped.push_back({"guided camera walks", "no camera path goes on from a surface"});
    return;
  }
  WalkGuideChoice choice = choose_walk_guide(prepared, plan.asked, plan.regularization);
  plan.walk_guide = std::move(choice.guide);
  plan.walk_guide_rule = std::move(choice.why);
  if (!plan.walk_guide && is_on) plan.dropped.push_back({"guided camera walks", plan.walk_guide_rule});
}

// Decides how waves run, which follows from the choices.
void plan_waves(Plan& plan) {
  plan.connections_per_vertex = !has(plan, TECHNIQUE_CONNECT) ? 0
                                : plan.cache_connections != 0
                                    ? plan.cache_connections
                                    : static_cast<uint32_t>(vertices_per_path(plan));
  plan.state = choose_state(plan);
  const bool is_paired = plan.light_paths == uint64_t{plan.width} * plan.height;
  const bool draws_from_all = plan.keeps(STATE_MERGES | STATE_CACHE);
  plan.is_per_wave =
      !has(plan, LIGHT_SUBPATH_TECHNIQUES) || (is_paired && !draws_from_all && plan.crop.pixels() == 0);
}

}  // namespace

const std::string* Plan::why_dropped(std::string_view what) const {
  const auto found = std::ranges::find(dropped, what, &Dropped::what);
  return found == dropped.end() ? nullptr : &found->why;
}

Plan make_plan(const PreparedScene& prepared, const RenderSettings& settings) {
  Plan plan;
  static_cast<CommonSettings&>(plan) = settings;
  plan.asked = settings;
  plan.features = prepared.features;
  plan.layers = choose_layers(prepared.scene, plan.aovs);
  std::optional<LightGuideChoice> light_guide = choose_what_is_open(plan, prepared);
  plan_regularization(plan);
  plan_techniques(plan);
  plan.light_sampling = has(plan, TECHNIQUE_NEE) ? scene::resolve_light_sampling(settings.light_sampling,
                                                                                 prepared.scene.lights.size())
                                                 : LIGHT_SAMPLING_POWER;
  plan.light_paths = settings.light_paths.value_or(settings.width * settings.height);
  plan_light_guide(plan, prepared, std::move(light_guide));
  plan_shadow_roulette(plan, prepared);
  plan_walk_guide(plan, prepared);
  plan_merge_radius(plan, prepared);
  plan_waves(plan);
  return plan;
}

Plan plan_for_window(Plan plan, const Window& window) {
  plan.crop = plan.asked.crop = window;
  plan_waves(plan);
  return plan;
}

reference::SeenSurfaces seen_by_camera(const PreparedScene& prepared, uint32_t camera) {
  const glm::uvec2 film = scene::default_film_size(prepared.scene, camera);
  return see_surfaces(reference::World(prepared), prepared.scene.cameras.at(camera), film.x, film.y);
}

reference::MergeRadius choose_merge_radius(const PreparedScene& prepared, const RenderSettings& settings,
                                           std::vector<std::string>* warnings) {
  const glm::dvec3 diagonal = glm::dvec3(prepared.scene.bounds_max) - glm::dvec3(prepared.scene.bounds_min);
  const double scene_radius = 0.5 * glm::length(diagonal);
  const reference::SeenSurfaces seen = seen_by_camera(prepared, settings.camera);
  if (!settings.merge_radius && !settings.merge_radius_share) return default_merge_radius(seen, scene_radius);
  const float asked = settings.merge_radius
                          ? *settings.merge_radius
                          : radius_of_share(*settings.merge_radius_share, seen, scene_radius);
  const reference::MergeRadius chosen = given_merge_radius(asked, seen, scene_radius);
  if (warnings != nullptr && chosen.metres != asked)
    warnings->push_back(fmt::format("merge radius {:g} m does not suit a view of {:.3g} m: {:g} m ({})",
                                    asked, 2 * seen.extent, chosen.metres, chosen.rule));
  return chosen;
}

}  // namespace regulus::render

#include "session/check_run.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "check/check.hpp"
#include "check/reference_render.hpp"
#include "reference/merge_radius.hpp"
#include "render/light_guide_choice.hpp"
#include "render/reference_settings.hpp"
#include "render/walk_guide_choice.hpp"

namespace regulus::session {

namespace {

using namespace interface;
using render::WALK_TECHNIQUES;

struct CheckedIteration {
  uint32_t sample;
  render::Connections connections;
};
using render::Connections;
constexpr CheckedIteration CHECKED_ITERATIONS[] = {
    {0, Connections::Cache}, {1, Connections::Paired}, {1, Connections::Cache}, {1000, Connections::Paired}};
constexpr uint32_t CHECKED_SAMPLES[] = {0, 1000};  // of the stages that walk: the schedule's begin, and late
constexpr uint32_t MOST_ITERATIONS = 10'000;       // of a scene where little can be weighed

/// Hands a line on and returns whether it passed.
bool passes(const check::Tally& tally, const TallySink& sink) {
  sink(tally);
  return tally.is_passed();
}

/// Adds the lines of another iteration to those of the same stages.
void add_tallies(std::vector<check::Tally>& all, const std::vector<check::Tally>& more) {
  for (size_t i = 0; i < more.size(); ++i) i < all.size() ? all[i].add(more[i]) : all.push_back(more[i]);
}

/// The guide of all sets that are checked: the plan's own may have no light paths.
std::shared_ptr<const scene::LightGuide> guide_of_all_sets(const PreparedScene& prepared,
                                                           const render::Plan& plan) {
  if (plan.light_guide || plan.asked.light_guide == LIGHT_GUIDE_OFF) return plan.light_guide;
  return choose_light_guide(prepared, plan.asked).guide;
}

/// Likewise of camera walks.
std::shared_ptr<const scene::WalkGuide> walk_guide_of_all_sets(const PreparedScene& prepared,
                                                               const render::Plan& plan) {
  if (plan.walk_guide || plan.asked.walk_guide == LIGHT_GUIDE_OFF) return plan.walk_guide;
  return choose_walk_guide(prepared, plan.asked, plan.regularization).guide;
}

}  // namespace

bool check_sorted_and_connected(gpu::Device& device, const check::Subject& subject, uint64_t weights,
                                const TallySink& sink) {
  constexpr uint32_t BOTH = TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  render::RenderSettings asked = subject.plan.asked;
  asked.techniques = WALK_TECHNIQUES | BOTH;
  if (asked.cache_connections == 0) asked.cache_connections = 3;
  // So wide that every vertex has some light paths to merge with, few as they are.
  const double extent = render::seen_by_camera(subject.prepared, asked.camera).extent;
  asked.merge_radius = std::max(render::choose_merge_radius(subject.prepared, asked).metres,
                                static_cast<float>(0.05 * extent));
  asked.keeps_merge_radius = true;
  const render::Plan plan = plan_recording(subject.prepared, asked, *asked.techniques);
  if ((plan.techniques & BOTH) != BOTH) return true;  // nothing in the scene can be connected
  render::StageRecorder recorder(device, subject.prepared, plan, plan.width * plan.height);
  const reference::Settings wanted = render::reference_settings(plan);
  const check::Subject same{subject.prepared, subject.world, subject.camera, plan, wanted};
  std::vector<check::Tally> sorting, connections;
  const auto compared = [&] {
    const auto line = std::find_if(connections.begin(), connections.end(),
                                   [](const check::Tally& tally) { return tally.name() == check::WEIGHTS; });
    return line == connections.end() ? 0 : line->items();
  };
  const uint32_t first = subject.plan.first_sample;
  const auto is_enough = [&](uint32_t done) {
    return weights == 0 ? done == std::size(CHECKED_ITERATIONS) : done > 0 && compared() >= weights;
  };
  for (uint32_t i = 0; i < MOST_ITERATIONS && !is_enough(i); ++i) {
    const CheckedIteration iteration =
        weights == 0 ? CHECKED_ITERATIONS[i]
                     : CheckedIteration{i, i % 2 == 0 ? Connections::Cache : Connections::Paired};
    const uint32_t sample = first + iteration.sample;
    render::ConnectionRecording recording = recorder.record_light_vertices(sample, iteration.connections);
    add_tallies(sorting, check_sorting(same, recording));
    // Lists that are broken lead the other stages astray.
    if (!std::all_of(sorting.begin(), sorting.end(), [](const auto& tally) { return tally.is_passed(); }))
      break;
    recorder.record_connections(sample, recording);
    add_tallies(connections, check_connections(same, sample, recording));
  }
  bool is_passed = true;
  for (const std::vector<check::Tally>* tallies : {&sorting, &connections})
    for (const check::Tally& tally : *tallies) is_passed = passes(tally, sink) && is_passed;
  return is_passed;
}

bool check_everything(gpu::Device& device, const check::Subject& subject, const TallySink& sink) {
  const uint32_t pixels = subject.plan.width * subject.plan.height;
  bool is_passed = true;
  const bool is_blended = has_blended_surfaces(subject.prepared.scene);
  {
    render::RenderSettings asked = subject.plan.asked;
    asked.techniques = WALK_TECHNIQUES;
    const render::Plan plan = plan_recording(subject.prepared, asked);
    render::StageRecorder recorder(device, subject.prepared, plan, pixels);
    const reference::Settings walking = render::reference_settings(plan);
    const check::Subject same{subject.prepared, subject.world, subject.camera, plan, walking};
    std::vector<check::Tally> camera_stages, whole_paths, light_stages;
    for (const uint32_t sample : CHECKED_SAMPLES) {
      const uint32_t at = subject.plan.first_sample + sample;
      const render::Recording camera = recorder.record(render::Pass::Camera, 0, at);
      add_tallies(camera_stages, check_stages(same, render::Pass::Camera, camera));
      if (!is_blended) add_tallies(whole_paths, check_paths(same, camera));
      if ((walking.techniques & TECHNIQUE_SPLAT) == 0) continue;
      add_tallies(light_stages,
                  check_stages(same, render::Pass::Light, recorder.record(render::Pass::Light, 0, at)));
    }
    for (const std::vector<check::Tally>* tallies : {&camera_stages, &whole_paths, &light_stages})
      for (const check::Tally& tally : *tallies) is_passed = passes(tally, sink) && is_passed;
  }
  if (is_blended) return is_passed;
  // Images would repeat it at best; lists that are broken may crash the driver.
  if (!check_sorted_and_connected(device, subject, 0, sink)) return false;
  for (const auto& [name, techniques] :
       {std::pair<const char*, uint32_t>{"pt", TECHNIQUE_HIT | TECHNIQUE_NEE},
        {"lt", TECHNIQUE_SPLAT},
        {"bpt", WALK_TECHNIQUES | TECHNIQUE_CONNECT},
        {"bpm", TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_MERGE},
        {"vcm", WALK_TECHNIQUES | TECHNIQUE_CONNECT | TECHNIQUE_MERGE}})
    is_passed = passes(check_image(device, subject, name, techniques), sink) && is_passed;
  return is_passed;
}

render::RenderSettings one_choice(const PreparedScene& prepared, render::RenderSettings settings) {
  if (settings.techniques && settings.regularization) return settings;
  const render::Plan plan = make_plan(prepared, settings);
  settings.techniques = plan.techniques;
  settings.regularization = plan.regularization;
  return settings;
}

CheckedPlan::CheckedPlan(const PreparedScene& prepared, const render::Plan& plan)
    : plan_(plan),
      world_(prepared, plan.ndf, plan.shadowing, plan.asked.light_sampling, plan.has_energy_compensation,
             guide_of_all_sets(prepared, plan), walk_guide_of_all_sets(prepared, plan)),
      camera_(scene::make_camera(prepared.scene.cameras.at(plan.camera), plan.width, plan.height), plan.width,
              plan.height),
      settings_(render::reference_settings(plan_)),
      subject_{prepared, world_, camera_, plan_, settings_} {}

}  // namespace regulus::session

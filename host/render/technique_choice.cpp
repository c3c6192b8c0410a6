#include "render/technique_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "probe/probe.hpp"
#include "render/reference_settings.hpp"

namespace regulus::render {

using namespace interface;

namespace {

constexpr uint32_t PATH_TRACING = TECHNIQUE_HIT | TECHNIQUE_NEE;

constexpr uint32_t PROBE_PIXELS = 1024, PROBE_SAMPLES = 4;
// Sets are chosen for a render of this many samples. The probed iterations are about the middle of it, so
// that their radius and raised roughness are those of most of its samples.
constexpr double NOMINAL_SAMPLES = 64;
constexpr uint32_t PROBED_ITERATION = 24;
constexpr double MOST_OF_A_PATH = 16;  // largest value of a path, in scales of its tile
constexpr double NOTHING = 1e-4;       // share of the light that may be missed for good
// Merges are judged as on a film of at most this many pixels: on larger films they are found in plenty, and
// to find as many would take as long as a picture.
constexpr double MOST_PIXELS = 1 << 22;
// As far as the probe can tell, a set whose expected error is within this factor of the best is as good.
constexpr double AS_GOOD = 1.15;

// Fitted to ratios of processor time of bpt, bpm and vcm to pt on five scenes (docs/results/speed.md).
double cost_of(const probe::Work& work) {
  return work.camera_rays + 1.1 * work.light_rays + 0.4 * work.light_samples +
         0.7 * (work.splats + work.pairs) + 0.4 * work.lookups + 0.1 * work.merges;
}

// The probe's film: of the picture's shape.
void shrink_film(RenderSettings& settings) {
  const double aspect = static_cast<double>(settings.width) / settings.height;
  const double height = std::sqrt(PROBE_PIXELS / aspect);
  settings.height = std::clamp(static_cast<uint32_t>(std::lround(height)), 1u, settings.height);
  settings.width = std::clamp(static_cast<uint32_t>(std::lround(height * aspect)), 1u, settings.width);
}

// The plan of a probe with this regularization.
Plan plan_probe(const PreparedScene& prepared, const RenderSettings& asked, uint32_t regularization) {
  RenderSettings small = asked;
  small.techniques = ALL_TECHNIQUES;
  small.regularization = regularization;
  small.crop = {};
  small.aovs = 0;
  small.seed = 0;
  small.sampler_quality = SAMPLER_QUALITY_OFF;
  small.largest_contribution = std::numeric_limits<float>::infinity();
  small.first_sample = PROBED_ITERATION;
  small.samples = PROBE_SAMPLES;
  small.light_paths.reset();
  small.light_guide = small.walk_guide = LIGHT_GUIDE_OFF;
  small.shadow_roulette = 0;
  small.cache_connections = 0;
  shrink_film(small);
  Plan plan = make_plan(prepared, small);
  // Fewer light paths merge as often as all of them would, with a radius that is larger accordingly.
  const double pixels = std::min(static_cast<double>(asked.width) * asked.height, MOST_PIXELS);
  const double probed_pixels = static_cast<double>(small.width) * small.height;
  plan.merge_radius *= static_cast<float>(std::sqrt(pixels / probed_pixels));
  return plan;
}

// Every set of probed techniques that includes all probed techniques of PATH_TRACING.
std::vector<uint32_t> sets_of(uint32_t techniques) {
  std::vector<uint32_t> sets;
  const uint32_t always = techniques & PATH_TRACING;
  for (uint32_t set = 1; set <= techniques; ++set)
    if ((set & ~techniques) == 0 && (set & always) == always) sets.push_back(set);
  return sets;
}

// What sets are judged by: the findings without regularization.
struct Truth {
  std::vector<double> scales;  // of the tiles
  std::vector<probe::TileMeans> means;
};

Truth take_truth(probe::Findings& findings) {
  Truth truth{probe::tile_scales(tile_means(findings)), {}};
  probe::clamp_values(findings, truth.scales, MOST_OF_A_PATH);
  truth.means = tile_means(findings);
  return truth;
}

void add_candidates(const probe::Findings& findings, const Truth& truth, uint32_t regularization,
                    std::vector<Candidate>& candidates) {
  for (const uint32_t set : sets_of(findings.techniques)) {
    // With regularization a set finds all light, ever more sharply; without it some sets never find it.
    const bool converges = regularization != REGULARIZATION_NONE || missing_share(findings, set) <= NOTHING;
    candidates.push_back({set, regularization,
                          converges
                              ? relative_error(findings, truth.means, truth.scales, set, NOMINAL_SAMPLES)
                              : std::numeric_limits<double>::infinity(),
                          cost_of(work_of(findings.work, set))});
  }
}

// The cheapest of the sets that are as good as the best; without regularization where that makes no
// difference.
const Candidate& choose(const std::vector<Candidate>& candidates) {
  const double least =
      std::ranges::min(candidates, {}, &Candidate::error_at_equal_time).error_at_equal_time();
  const Candidate* chosen = &candidates.front();
  bool is_found = false;
  for (const Candidate& candidate : candidates) {
    if (!(candidate.error_at_equal_time() <= AS_GOOD * least)) continue;
    if (!is_found || candidate.cost < chosen->cost) chosen = &candidate;
    is_found = true;
  }
  return *chosen;
}

}  // namespace

TechniqueChoice choose_techniques(const PreparedScene& prepared, const RenderSettings& settings) {
  if (prepared.scene.lights.empty())
    return {PATH_TRACING, REGULARIZATION_NONE, "the scene has no lights", {}, {}};
  const Plan plain = plan_probe(prepared, settings, settings.regularization.value_or(REGULARIZATION_NONE));
  if (plain.techniques == 0) return {PATH_TRACING, REGULARIZATION_NONE, "no technique finds a light", {}, {}};
  LightGuideChoice light_guide;
  if (settings.light_guide != LIGHT_GUIDE_OFF) light_guide = choose_light_guide(prepared, settings);
  const reference::World world(prepared, plain.ndf, plain.shadowing, settings.light_sampling,
                               plain.has_energy_compensation, light_guide.guide);
  probe::Findings findings = probe::find_paths(world, reference_settings(plain));
  Truth truth = take_truth(findings);
  std::vector<Candidate> candidates;
  add_candidates(findings, truth, plain.regularization, candidates);
  const Plan raised =
      plan_probe(prepared, settings, settings.regularization.value_or(REGULARIZATION_ROUGHNESS));
  if (raised.regularization != plain.regularization) {
    probe::Findings others = probe::find_paths(world, reference_settings(raised));
    probe::clamp_values(others, truth.scales, MOST_OF_A_PATH);
    const double unfound = unfound_variance(findings, others, truth.scales);
    for (Candidate& candidate : candidates)
      candidate.error += hidden_variance(others, truth.scales, candidate.techniques) + unfound;
    truth.means = joint_means(findings, others, truth.scales);
    add_candidates(others, truth, raised.regularization, candidates);
  }
  const Candidate chosen = choose(candidates);
  std::ranges::stable_sort(candidates, {}, &Candidate::error_at_equal_time);
  return {chosen.techniques, chosen.regularization,
          "a probe expects no other set to have much less error at equal time", std::move(candidates),
          std::move(light_guide)};
}

}  // namespace regulus::render

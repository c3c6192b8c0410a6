// What `-i auto` goes by: variances that are estimated by reweighting against those of pictures that the
// scalar reference makes by each set of techniques, and the choice itself.
#include "probe/probe.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "reference/support/reference_images.hpp"
#include "render/shadow_roulette_choice.hpp"
#include "render/technique_choice.hpp"
#include "support/sanitizers.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using reference::Settings;
using reference::World;

/// A closed room under a lamp above the picture, with a block of metal or plastic on its floor.
GltfScene room(const nlohmann::json& block, double lamp = 8) {
  GltfScene scene;
  scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), lambert({0.7, 0.5, 0.3}));
  scene.add({quad({-0.4, 0.99, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})}, emitter(glm::dvec3(lamp)));
  scene.add(box({-0.6, -1, -0.6}, {0.1, -0.4, 0}), block);
  scene.set_perspective(look_at({0, -0.2, 0.95}, {0, -0.5, -1}), 0.9);
  return scene;
}

constexpr uint32_t FILM = 12;  // pixels along each side: four tiles

/// Variance of one sample of a pixel over the square of its tile's scale, averaged over the film, of
/// pictures.
double measured_variance(const World& world, const Settings& settings, const std::vector<double>& scales) {
  const reference::Film film = reference::render(world, settings);
  double sum = 0;
  for (uint32_t y = 0; y < FILM; ++y)
    for (uint32_t x = 0; x < FILM; ++x) {
      const double scale = scales[y / 6 * (FILM / 6) + x / 6];
      const glm::dvec3 variance = film.variance_of_mean(y * FILM + x) * static_cast<double>(film.iterations);
      sum += (variance.r + variance.g + variance.b) / 3 / (scale * scale);
    }
  return sum / (FILM * FILM);
}

// What roulette would have done to walks that did not find a path is not known, so that sets of long walks
// are estimated low: .81 to .87 for pt over three other seeds, .85 to .95 for splats (once .74), .99 to 1.07
// for bpt. A splat that the filter does not spread makes bpt 1.38 to 1.41; a mean that is not taken off more
// than 2.
constexpr double TOLERANCE = 0.25;

void expect_variances(const GltfScene& gltf, uint32_t regularization,
                      const std::vector<NamedTechniques>& sets) {
  const PreparedScene prepared = prepare(gltf);
  const World world(prepared);
  Settings settings = reference_settings(FILM, FILM, 32, 5);
  settings.filter = {FILTER_BLACKMAN_HARRIS, 1.5, 0.5};
  settings.sampler = SAMPLER_HASH;
  settings.regularization = regularization;
  settings.merge_radius = 0.05;
  settings.merge_reduction = 0;
  settings.techniques = VCM;
  const probe::Findings findings = probe::find_paths(world, settings);
  const std::vector<probe::TileMeans> truth = tile_means(findings);
  const std::vector<double> scales = probe::tile_scales(truth);
  settings.samples = 120;
  for (const NamedTechniques& set : sets) {
    settings.techniques = set.bits;
    const double measured = measured_variance(world, settings, scales);
    const double estimated = relative_error(findings, truth, scales, set.bits, 0);
    EXPECT_NEAR(estimated / measured, 1, TOLERANCE) << set.name << ": " << estimated << ", " << measured;
  }
}

TEST(Probe, KnowsTheVarianceOfEverySet) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  expect_variances(room(plastic({0.2, 0.6, 0.8}, 0.4)), REGULARIZATION_NONE,
                   {{"pt", PT},
                    {"bpt", BPT},
                    {"vcm", VCM},
                    {"hit,nee,splat", PT | TECHNIQUE_SPLAT},
                    {"hit,nee,merge", BPM}});
}

TEST(Probe, KnowsTheVarianceOfRegularizedSets) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  expect_variances(room(metal({0.9, 0.8, 0.7}, 0.2)), REGULARIZATION_ROUGHNESS,
                   {{"bpt", BPT}, {"vcm", VCM}, {"hit,nee,splat", PT | TECHNIQUE_SPLAT}});
}

// All that is seen is lit through clear glass by a point: neither hits nor light samples find it.
TEST(Probe, CountsLightThatASetCannotFind) {
  GltfScene scene;
  scene.add({quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4})}, lambert({0.5, 0.5, 0.5}));
  scene.add(box({-0.3, 0.9, -0.3}, {0.3, 1.5, 0.3}), glass(1.5));
  scene.add_point_light({0, 1.2, 0}, {10, 10, 10});
  scene.set_orthographic(look_at({0, 0.8, 0}, {0, 0, 0}, {0, 0, 1}), 0.3, 0.3);
  const PreparedScene prepared = prepare(scene);
  const World world(prepared);
  Settings settings = reference_settings(FILM, FILM, 16, 6);
  settings.techniques = PT | TECHNIQUE_SPLAT;
  const probe::Findings findings = probe::find_paths(world, settings);
  const std::vector<probe::TileMeans> truth = tile_means(findings);
  const std::vector<double> scales = probe::tile_scales(truth);
  constexpr double SAMPLES = 64;
  double missing = 0;  // what a black picture's error would be, from the means themselves
  for (size_t tile = 0; tile < truth.size(); ++tile)
    missing += dot(truth[tile][0], truth[tile][1]) / 3 / (scales[tile] * scales[tile]) /
               static_cast<double>(truth.size());
  ASSERT_GT(missing, 0.3) << "half of the squared scale is the tile's mean";
  EXPECT_NEAR(relative_error(findings, truth, scales, PT, SAMPLES), SAMPLES * missing, 1e-9);
  EXPECT_EQ(missing_share(findings, PT), 1);
  EXPECT_EQ(missing_share(findings, TECHNIQUE_SPLAT), 0);
  EXPECT_NEAR(relative_error(findings, truth, scales, PT | TECHNIQUE_SPLAT, SAMPLES),
              relative_error(findings, truth, scales, PT | TECHNIQUE_SPLAT, 0), 1e-9)
      << "with splats nothing is missing";
}

// A small lamp that is seen in a mirror, and from the floor: without regularization hits alone find it, each
// worth half of the lamp's radiance by assumption. What they bring is known in closed form: the mean.
TEST(Probe, KnowsTheVarianceOfHitsThatItDoesNotMeet) {
  probe::Findings findings{6, 6, 1, VCM, 1, {}, {}};
  probe::FoundPath path;
  path.pixel = 7;
  path.technique = TECHNIQUE_NEE;
  path.value = {0.2, 0.2, 0.2};
  path.value_of_hit = {500, 500, 500};
  path.other_finders = TECHNIQUE_MERGE;
  findings.paths = {path};
  const std::vector<double> scales = {2};
  // f h over 36 pixels and scale^2.
  EXPECT_NEAR(hidden_variance(findings, scales, BPT), 0.2 * 500 / 4 / 36, 1e-12);
  EXPECT_EQ(hidden_variance(findings, scales, BPM), 0) << "merges find it";
}

// Regularization finds twice the scale of a tile where 36 samples without it found nothing.
TEST(Probe, KnowsThatItMissesWhatOthersFind) {
  probe::Findings plain{6, 6, 2, VCM, 1, {}, {}};
  probe::Findings regularized = plain;
  for (const uint32_t iteration : {0u, 1u}) {
    probe::FoundPath path;
    path.iteration = iteration;
    path.value = glm::dvec3(2 * 36);
    regularized.paths.push_back(path);
  }
  const std::vector<double> scales = {1};
  EXPECT_DOUBLE_EQ(unfound_variance(plain, regularized, scales), 36 * 2 * 1.75 * 1.75);
  EXPECT_EQ(unfound_variance(regularized, regularized, scales), 0);
  regularized.paths.pop_back();
  EXPECT_EQ(unfound_variance(plain, regularized, scales), 0) << "one half of the iterations is no proof";
}

render::RenderSettings open_settings() {
  render::RenderSettings settings;
  settings.width = settings.height = 64;
  settings.techniques.reset();
  settings.regularization.reset();
  settings.regularization_modes = REGULARIZATION_CONSISTENT | REGULARIZATION_DIFFUSION;
  return settings;
}

// Two tiles of one iteration each way, of brightness 1 and 9.
TEST(Probe, TypicalBrightnessIsTheSquareOfTheMeanOfRoots) {
  probe::Findings findings{12, 6, 2, TECHNIQUE_NEE, 1, {}, {}};
  for (const uint32_t iteration : {0u, 1u})
    for (const auto& [pixel, value] : {std::pair(3u, 1.0), {9u, 9.0}}) {
      probe::FoundPath path;
      path.pixel = pixel;
      path.iteration = iteration;
      path.value = glm::dvec3(36 * value);  // of 36 pixels of a tile
      findings.paths.push_back(path);
    }
  EXPECT_NEAR(typical_brightness(findings), 4, 1e-12);
}

TEST(ShadowRouletteChoice, FollowsTheLightAndNothingElse) {
  const PreparedScene prepared = prepare(room(metal({0.9, 0.7, 0.4}, 0.3)));
  render::RenderSettings settings;
  settings.width = 30;
  settings.height = 20;
  settings.shadow_roulette.reset();
  const float least = choose_shadow_roulette(prepared, settings).least;
  EXPECT_GT(least, 0);
  render::RenderSettings other = settings;
  other.width = 300;
  other.height = 200;
  other.crop = {3, 4, 20, 10};
  other.seed = 5;
  other.first_sample = 7;
  other.samples = 1;
  other.techniques = VCM;
  EXPECT_EQ(choose_shadow_roulette(prepared, other).least, least);
  EXPECT_EQ(make_plan(prepared, other).shadow_roulette, least);
  int exponent = 0;
  EXPECT_EQ(std::frexp(least, &exponent), 0.5f) << "a power of two";
  // No light sample has less than this.
  other.largest_contribution = 0.5f * least;
  EXPECT_EQ(choose_shadow_roulette(prepared, other).least, 0.5f * least);
  other = settings;
  other.shadow_roulette = 0.3f;
  EXPECT_EQ(make_plan(prepared, other).shadow_roulette, 0.3f) << "given";
  other.techniques = TECHNIQUE_HIT;
  EXPECT_EQ(make_plan(prepared, other).shadow_roulette, 0) << "no shadow rays";
  other.techniques = BPT;
  other.shadow_roulette = 0;
  EXPECT_EQ(make_plan(prepared, other).shadow_roulette, 0) << "off";
  const PreparedScene bright = prepare(room(metal({0.9, 0.7, 0.4}, 0.3), 128));
  EXPECT_EQ(choose_shadow_roulette(bright, settings).least, 16 * least);
}

TEST(TechniqueChoice, IsTheSameForEveryPartOfARender) {
  const PreparedScene prepared = prepare(room(metal({0.9, 0.8, 0.7}, 0.2)));
  const render::RenderSettings whole = open_settings();
  render::RenderSettings part = whole;
  part.first_sample = 100;
  part.samples = 7;
  part.crop = {3, 5, 8, 8};
  part.seed = 9;
  part.aovs = render::AOV_DEPTH | render::AOV_VARIANCE;
  const render::TechniqueChoice all = choose_techniques(prepared, whole);
  const render::TechniqueChoice one = choose_techniques(prepared, part);
  ASSERT_EQ(all.candidates.size(), one.candidates.size());
  for (size_t i = 0; i < all.candidates.size(); ++i)
    EXPECT_EQ(all.candidates[i].error, one.candidates[i].error);
  EXPECT_EQ(all.techniques, one.techniques);
  EXPECT_EQ(make_plan(prepared, whole).techniques, all.techniques);
}

// Scenes for which docs/results/error.md says what pays.
TEST(TechniqueChoice, SuitsScenesThatAreKnown) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  const auto chosen_for = [](const char* name) {
    const std::filesystem::path file = own_scenes() / name / (std::string(name) + ".gltf");
    return choose_techniques(prepare(file), open_settings());
  };
  EXPECT_EQ(chosen_for("plates").techniques, PT) << "large lamps on plates: nothing beats path tracing";
  EXPECT_EQ(chosen_for("plates").regularization & REGULARIZATION_ROUGHNESS, 0u)
      << "nor is there a lamp to be missed";
  const render::TechniqueChoice ring = chosen_for("ring");
  EXPECT_NE(ring.regularization & REGULARIZATION_ROUGHNESS, 0u) << "a small lamp, seen in polished rings";
  EXPECT_NE(chosen_for("mirrors").regularization & REGULARIZATION_ROUGHNESS, 0u)
      << "three quarters of the light come by chains of mirrors from points";
  const render::TechniqueChoice cornell = chosen_for("cornell");
  EXPECT_NE(cornell.techniques & (TECHNIQUE_SPLAT | TECHNIQUE_MERGE), 0u) << "caustics of a glass ball";
}

// A probe of a film of a billion pixels takes as long as that of four million.
TEST(TechniqueChoice, IsAsCheapForTheLargestFilm) {
  const PreparedScene prepared = prepare(room(plastic({0.2, 0.6, 0.8}, 0.4)));
  render::RenderSettings settings = open_settings();
  settings.width = settings.height = 2048;
  const render::TechniqueChoice large = choose_techniques(prepared, settings);
  settings.width = settings.height = 32768;
  const render::TechniqueChoice largest = choose_techniques(prepared, settings);
  ASSERT_EQ(large.candidates.size(), largest.candidates.size());
  for (size_t i = 0; i < large.candidates.size(); ++i)
    EXPECT_EQ(large.candidates[i].error, largest.candidates[i].error);
}

// A corner of a wide plain under a sun, behind and below a pane of glass: what passes the pane only light
// paths find, and of those that start by power few come there.
TEST(TechniqueChoice, IsMadeWithTheGuideThatLightPathsGet) {
  GltfScene gltf;
  gltf.add({quad({-30, 0, -30}, {0, 0, 60}, {60, 0, 0})}, lambert({0.5, 0.5, 0.5}));
  gltf.add(box({18, 0.8, 18}, {22, 0.81, 22}), glass(1.5));
  gltf.add_directional_light({0.1, -1, 0}, 2);
  gltf.set_perspective(look_at({20, 0.4, 21.5}, {20, 0, 20}), 0.8);
  const PreparedScene prepared = prepare(gltf);
  render::RenderSettings settings = open_settings();
  const auto error_of_splats = [](const render::TechniqueChoice& choice) {
    for (const render::Candidate& candidate : choice.candidates)
      if (candidate.techniques == (TECHNIQUE_NEE | TECHNIQUE_SPLAT) &&
          candidate.regularization == REGULARIZATION_NONE)
        return candidate.error;
    return 0.0;
  };
  const render::TechniqueChoice plain = choose_techniques(prepared, settings);
  EXPECT_FALSE(plain.light_guide.guide);
  settings.light_guide = LIGHT_GUIDE_AUTO;
  const render::TechniqueChoice guided = choose_techniques(prepared, settings);
  ASSERT_TRUE(guided.light_guide.guide);
  std::printf("error by splats %.3g, guided %.3g: %s\n", error_of_splats(plain), error_of_splats(guided),
              guided.light_guide.why.c_str());
  EXPECT_GT(error_of_splats(guided), 0);
  EXPECT_LT(error_of_splats(guided), 0.2 * error_of_splats(plain));
  const render::Plan plan = make_plan(prepared, settings);
  ASSERT_TRUE(plan.light_guide);
  EXPECT_EQ(hash_of(*plan.light_guide), hash_of(*guided.light_guide.guide));

  const render::TechniqueChoice closed = choose_techniques(prepare(room(lambert({0.6, 0.6, 0.6}))), settings);
  EXPECT_FALSE(closed.light_guide.guide);
  EXPECT_NE(closed.light_guide.why.find("glimpse"), std::string::npos) << closed.light_guide.why;
}

TEST(TechniqueChoice, TakesWhatIsGiven) {
  const PreparedScene prepared = prepare(room(metal({0.9, 0.8, 0.7}, 0.2)));
  render::RenderSettings settings = open_settings();
  settings.regularization = REGULARIZATION_NONE;
  for (const render::Candidate& candidate : choose_techniques(prepared, settings).candidates)
    EXPECT_EQ(candidate.regularization & REGULARIZATION_ROUGHNESS, 0u);
  settings.techniques = BPT;
  const render::Plan plan = make_plan(prepared, settings);
  EXPECT_EQ(plan.techniques, BPT);
  EXPECT_EQ(plan.techniques_rule, "given");
}

}  // namespace
}  // namespace regulus::test

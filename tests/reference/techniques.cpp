// Any two sets of techniques that can find all light of a scene must find the same: closed rooms with glass,
// metal, smooth normals, and every kind of light. The estimators share walks and f, but each has pdfs, sample
// counts and weights of its own, so an error in any of them moves one mean and not the other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "images/support/comparison.hpp"
#include "reference/estimator.hpp"
#include "reference/support/reference_images.hpp"
#include "support/random.hpp"
#include "support/sanitizers.hpp"

namespace regulus::test {
namespace {

using interface::TECHNIQUE_CONNECT;
using interface::TECHNIQUE_HIT;
using interface::TECHNIQUE_MERGE;
using interface::TECHNIQUE_NEE;
using interface::TECHNIQUE_SPLAT;
using reference::Settings;

constexpr int BATCHES = 17;

// A closed room of 2 m, seen from inside.
GltfScene room() {
  GltfScene scene;
  scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), lambert({0.7, 0.5, 0.3}));
  scene.set_perspective(look_at({0, 0.1, 0.95}, {0, -0.3, -1}), 1.2);
  return scene;
}

Polygon ceiling_panel() {
  return quad({-0.4, 0.98, -0.4}, {0.8, 0, 0}, {0, 0, 0.8});
}

struct Case {
  const char* name;
  GltfScene scene;
  bool has_point_like_light = false;
  bool is_clear_glass = false;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const char* name) -> GltfScene& {
    all.push_back({name, room()});
    return all.back().scene;
  };
  GltfScene& plastics = add("area light, plastic and rough metal boxes");
  plastics.add({ceiling_panel()}, emitter({8, 8, 8}));
  plastics.add(box({-0.7, -1, -0.6}, {-0.1, -0.3, 0}), plastic({0.2, 0.6, 0.8}, 0.4));
  plastics.add(box({0.1, -1, -0.6}, {0.6, -0.5, 0}), metal({0.9, 0.7, 0.4}, 0.5));

  GltfScene& two_sided = add("double-sided light amid the room");
  two_sided.add({quad({-0.3, 0.3, -0.5}, {0.6, 0.1, 0}, {0, 0.1, 0.6})}, emitter({4, 4, 4}, true));

  GltfScene& rough_glass = add("spot light on rough glass");
  rough_glass.add_spot_light({0.2, 0.9, 0.1}, {-0.2, -1, -0.2}, 6, 0.3, 0.8);
  rough_glass.add(box({-0.4, -0.7, -0.6}, {0.3, -0.2, 0}), glass(1.5, 0.6, {0.5, 0.8, 0.9}));

  all.back().has_point_like_light = true;

  GltfScene& smooth_glass = add("area light behind clear glass");
  smooth_glass.add({ceiling_panel()}, emitter({8, 8, 8}));
  smooth_glass.add(box({-0.6, -0.9, -0.6}, {0.5, -0.2, 0}), glass(1.5));
  all.back().is_clear_glass = true;

  GltfScene court;
  const Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  for (const size_t wall : {0u, 1u, 2u, 4u, 5u}) court.add({walls[wall]}, lambert({0.7, 0.5, 0.3}));
  court.add(box({-0.6, -1, -0.6}, {0.1, -0.4, 0}), plastic({0.2, 0.6, 0.8}, 0.4));
  court.add({ceiling_panel()}, emitter({2, 2, 2}));
  court.set_perspective(look_at({0, 0.1, 0.95}, {0, -0.3, -1}), 1.2);
  court.set_setting("environment", {{"color", {0.5, 1, 1.5}}});
  all.push_back({"court under the sky and a lamp", court});
  return all;
}

// Under sanitizers fewer samples, at the same rate of false alarms.
constexpr uint32_t SAMPLES_DIVISOR = IS_SANITIZED ? 2 : 1;

Settings settings_of(uint32_t techniques, uint32_t samples) {
  Settings settings = reference_settings(8, 8, samples / SAMPLES_DIVISOR, 6);
  settings.techniques = techniques;
  settings.light_paths = 96;  // not the number of pixels, so that the two cannot be mistaken for each other
  return settings;
}

TEST(ReferenceTechniques, BidirectionalSetsAgreeWithPathTracing) {
  uint32_t stream = 100;
  for (const Case& scene : cases()) {
    const PreparedScene prepared = prepare(scene.scene);
    const auto path_traced = reference_batches(prepared, settings_of(PT, 128), BATCHES, stream++);
    for (const NamedTechniques techniques : {NamedTechniques{"bpt", BPT},
                                             {"nee,splat,connect", BPT & ~TECHNIQUE_HIT},
                                             {"hit,connect", TECHNIQUE_HIT | TECHNIQUE_CONNECT}}) {
      // A spot that shines straight onto what the camera sees is found by nee and splats alone; light through
      // clear glass onto clear glass by hits alone.
      const bool has_hits = (techniques.bits & TECHNIQUE_HIT) != 0;
      const bool has_ends = (techniques.bits & (TECHNIQUE_NEE | TECHNIQUE_SPLAT)) != 0;
      if ((scene.is_clear_glass && !has_hits) || (scene.has_point_like_light && !has_ends)) continue;
      ComparisonOptions options;
      options.tile = 4;
      expect_equal((std::string(scene.name) + ": pt and " + techniques.name).c_str(), path_traced,
                   reference_batches(prepared, settings_of(techniques.bits, 16), BATCHES, stream++), options);
    }
  }
}

// A contribution of which a share of the least is left to chance, over many rays.
TEST(ShadowRoulette, TracesInProportionAndDependsOnEveryNumber) {
  constexpr uint32_t RAYS = 1u << 18;
  Settings settings = reference_settings(8, 8, 1, 6);
  settings.shadow_roulette = 0.25;
  for (const double ratio : {1e-12, 1e-4, 0.003, 0.25, 0.7, 0.9999, 1.0, 3.0}) {
    const glm::dvec3 value = 0.25 * ratio * glm::dvec3(0.1, 1, 0.5);
    uint32_t traced = 0;
    double probability = 0;
    for (uint32_t i = 0; i < RAYS; ++i) {
      const reference::Tracing tracing =
          play_shadow_roulette(settings, value, {i % 4096, i / 4096, 1 + i % 3, i % 5, i % 7});
      traced += tracing.is_traced ? 1 : 0;
      probability = tracing.probability;
    }
    // In proportion, but never less than once in 1024.
    EXPECT_NEAR(probability, std::clamp(ratio, 1.0 / 1024, 1.0), 0x1p-24) << ratio;
    const double deviation = std::sqrt(RAYS * probability * (1 - probability));
    EXPECT_NEAR(traced, RAYS * probability, 5 * deviation) << ratio;
  }
  // Rays that differ in one number are decided by themselves: half of 64 on either side.
  const glm::dvec3 half(0.125);
  const auto count = [&](const auto& ray) {
    uint32_t traced = 0;
    for (uint32_t i = 1; i <= 64; ++i) traced += play_shadow_roulette(settings, half, ray(i)).is_traced;
    return traced;
  };
  using Ray = reference::ShadowRay;
  for (const uint32_t traced : {count([](uint32_t i) {
                                  return Ray{i, 2, 3, 4, 5};
                                }),
                                count([](uint32_t i) {
                                  return Ray{1, i, 3, 4, 5};
                                }),
                                count([](uint32_t i) {
                                  return Ray{1, 2, i, 4, 5};
                                }),
                                count([](uint32_t i) {
                                  return Ray{1, 2, 3, i, 5};
                                }),
                                count([](uint32_t i) {
                                  return Ray{1, 2, 3, 4, i};
                                })}) {
    EXPECT_GT(traced, 10u);
    EXPECT_LT(traced, 54u);
  }
}

TEST(ShadowRoulette, KeepsTheMean) {
  const PreparedScene prepared = prepare(cases().front().scene);
  Settings settings = settings_of(BPT, 16);
  const auto all = reference_batches(prepared, settings, BATCHES, 180);
  settings.shadow_roulette = mean_of(all[0])[0];
  ComparisonOptions options;
  options.tile = 4;
  expect_equal("bpt with and without roulette", all, reference_batches(prepared, settings, BATCHES, 181),
               options);
}

// Merging blurs light over its radius and loses some of it at edges: where a wall ends, the disk does. Of a
// wall of side 2 the share r / 2 lies within r of an edge and loses at most half; with all walls and merges
// as one technique of several, 1 percent bounds what a radius of 0.02 does.
TEST(ReferenceTechniques, SetsWithMergesAgreeWithPathTracingUpToTheirBlur) {
  uint32_t stream = 150;
  for (const Case& scene : cases()) {
    const PreparedScene prepared = prepare(scene.scene);
    const auto path_traced = reference_batches(prepared, settings_of(PT, 128), BATCHES, stream++);
    for (const NamedTechniques techniques : {NamedTechniques{"bpm", BPM}, {"vcm", VCM}}) {
      Settings settings = settings_of(techniques.bits, 8);
      settings.merge_radius = 0.02;
      settings.merge_reduction = 0;
      settings.light_paths = 1000;
      ComparisonOptions options;
      options.tile = 8;
      options.relative_tolerance = 0.01;
      expect_equal((std::string(scene.name) + ": pt and " + techniques.name).c_str(), path_traced,
                   reference_batches(prepared, settings, BATCHES, stream++), options);
    }
  }
}

}  // namespace
}  // namespace regulus::test

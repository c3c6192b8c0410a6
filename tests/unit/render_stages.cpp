// What is planned of what was asked, and which stages are built: none that a scene or the techniques do not
// need.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "base/error.hpp"
#include "render/stages.hpp"
#include "render/state.hpp"

namespace regulus::render {
namespace {

using namespace interface;
using Names = std::set<std::string>;

Names needed(uint32_t material_classes, uint32_t techniques) {
  Plan plan;
  plan.features.material_classes = material_classes;
  plan.techniques = techniques;
  plan.state = choose_state(plan);
  Names names;
  for (const StageStep& step : STAGES)
    if (is_needed(step, plan)) names.insert(step.name);
  return names;
}

constexpr uint32_t DIFFUSE = 1u << MATERIAL_CLASS_DIFFUSE, OPAQUE = 1u << MATERIAL_CLASS_OPAQUE,
                   TRANSMISSIVE = 1u << MATERIAL_CLASS_TRANSMISSIVE;

TEST(Stages, DiffuseSceneBuildsOneBounceStage) {
  EXPECT_EQ(needed(DIFFUSE, TECHNIQUE_HIT | TECHNIQUE_NEE),
            (Names{"camera_generate", "trace_closest", "camera_bounce.diffuse", "trace_visibility",
                   "accumulate", "count_work"}));
}

TEST(Stages, EveryMaterialClassHasItsOwn) {
  EXPECT_EQ(needed(DIFFUSE | OPAQUE | TRANSMISSIVE, TECHNIQUE_HIT | TECHNIQUE_NEE),
            (Names{"camera_generate", "trace_closest", "camera_bounce.diffuse", "camera_bounce.opaque",
                   "camera_bounce.transmissive", "trace_visibility", "accumulate", "count_work"}));
  EXPECT_EQ(needed(OPAQUE, TECHNIQUE_NEE), (Names{"camera_generate", "trace_closest", "camera_bounce.opaque",
                                                  "trace_visibility", "accumulate", "count_work"}));
}

TEST(Stages, WithoutLightSamplingNothingIsTracedForVisibility) {
  EXPECT_EQ(
      needed(TRANSMISSIVE, TECHNIQUE_HIT),
      (Names{"camera_generate", "trace_closest", "camera_bounce.transmissive", "accumulate", "count_work"}));
}

/// A plan for an empty scene that is said to have these features; merges have a radius.
Plan plan_of(const scene::Features& features, RenderSettings settings) {
  PreparedScene prepared;
  prepared.features = features;
  settings.merge_radius = 1;
  settings.keeps_merge_radius = true;
  return make_plan(prepared, settings);
}

// Techniques that cannot contribute to the scene are dropped, and with them their stages and their share of
// weights. The plan says which and why.
TEST(Techniques, ThatTheSceneCannotUseAreDropped) {
  RenderSettings settings;
  settings.techniques = ALL_TECHNIQUES;
  scene::Features features;
  features.has_connectible_surfaces = true;
  const Plan dark = plan_of(features, settings);
  EXPECT_EQ(dark.techniques, 0u) << "no light";
  for (const char* name : {"nee", "splat", "connect", "merge"}) {
    const std::string* why = dark.why_dropped(std::string("technique ") + name);
    ASSERT_NE(why, nullptr) << name;
    EXPECT_EQ(*why, "the scene has no lights");
  }
  features.bits = FEATURE_POINT_LIGHTS;
  const Plan points = plan_of(features, settings);
  EXPECT_EQ(points.techniques, ALL_TECHNIQUES & ~TECHNIQUE_HIT) << "delta lights cannot be hit";
  ASSERT_NE(points.why_dropped("technique hit"), nullptr);
  EXPECT_EQ(*points.why_dropped("technique hit"), "the scene has no emitter that a ray can meet");
  EXPECT_EQ(points.asked.techniques, ALL_TECHNIQUES);
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  EXPECT_EQ(plan_of(features, settings).techniques, ALL_TECHNIQUES);
  EXPECT_TRUE(plan_of(features, settings).dropped.empty());
  features.has_connectible_surfaces = false;
  features.least_reflection_alpha = 0;
  EXPECT_EQ(plan_of(features, settings).techniques, ALL_TECHNIQUES & ~(TECHNIQUE_CONNECT | TECHNIQUE_MERGE))
      << "perfect mirrors cannot be connected";
  EXPECT_EQ(plan_of(features, settings).merge_radius, 0) << "nothing is merged";
  settings.regularization = REGULARIZATION_ROUGHNESS;
  EXPECT_EQ(plan_of(features, settings).techniques, ALL_TECHNIQUES) << "but with raised roughness they can";
}

// What is left open is chosen: roughness is regularized, but nothing where vertices are merged; a light path
// for every pixel.
TEST(Choices, AreMadeByThePlan) {
  RenderSettings settings;
  settings.width = 6;
  settings.height = 5;
  settings.regularization.reset();
  settings.regularization_modes = REGULARIZATION_CONSISTENT;
  scene::Features mirrors;
  mirrors.bits = FEATURE_TRIANGLE_LIGHTS;
  mirrors.has_connectible_surfaces = true;
  mirrors.least_reflection_alpha = 0;
  const Plan plan = plan_of(mirrors, settings);
  EXPECT_EQ(plan.regularization, REGULARIZATION_ROUGHNESS | REGULARIZATION_CONSISTENT);
  EXPECT_EQ(plan.light_paths, 30u);
  settings.techniques = ALL_TECHNIQUES;
  EXPECT_EQ(plan_of(mirrors, settings).regularization, REGULARIZATION_NONE);
  settings.regularization = REGULARIZATION_NONE;
  settings.light_paths = 7;
  EXPECT_EQ(plan_of(mirrors, settings).light_paths, 7u);
  EXPECT_EQ(plan_of(mirrors, settings).regularization, REGULARIZATION_NONE) << "modes of nothing are nothing";
}

// Nothing of light subpaths is built for a path tracer.
TEST(Stages, PathTracingHasNoLightSubpaths) {
  for (const std::string& name : needed(DIFFUSE | OPAQUE | TRANSMISSIVE, TECHNIQUE_HIT | TECHNIQUE_NEE))
    for (const char* part : {"light", "splat", "connect", "merge", "grid", "scan"})
      EXPECT_EQ(name.find(part), std::string::npos) << name;
}

// Solids are kept beside paths where the scene has contacts, and those around starts are found path by path
// only where they vary.
TEST(Stages, SolidsAroundPathsAreKeptWhereTheyMatter) {
  scene::Features features;
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  features.has_connectible_surfaces = true;
  RenderSettings settings;
  settings.techniques = ALL_TECHNIQUES;
  const auto start_stages = [](const Plan& plan) {
    return std::ranges::count_if(STAGES, [&](const StageStep& step) {
      return step.stage == Stage::StartMedia && is_needed(step, plan);
    });
  };
  const Plan apart = plan_of(features, settings);
  EXPECT_FALSE(apart.keeps(STATE_MEDIA));
  EXPECT_EQ(start_stages(apart), 0);
  features.bits |= FEATURE_CONTACTS;
  const Plan touching = plan_of(features, settings);
  EXPECT_TRUE(touching.keeps(STATE_MEDIA));
  EXPECT_EQ(start_stages(touching), 0);
  EXPECT_GT(bytes_per_path(touching), bytes_per_path(apart));
  features.has_varying_starts = true;
  EXPECT_EQ(start_stages(plan_of(features, settings)), 2) << "of light paths and of camera paths";
  settings.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE;
  EXPECT_EQ(start_stages(plan_of(features, settings)), 1);
}

// tau 100 raises reflection to alpha 1 / sqrt(400 pi) = 0.0282 and refraction by n = 1.5 to 3 / sqrt(100 pi)
// = 0.169.
TEST(Regularization, IsDroppedWhereEveryLobeIsBroadEnough) {
  RenderSettings settings;
  settings.regularization = REGULARIZATION_ROUGHNESS;
  settings.tau = 100;
  const auto is_dropped = [&](const scene::Features& features) {
    const Plan plan = plan_of(features, settings);
    EXPECT_EQ(plan.why_dropped("regularization") != nullptr, plan.regularization == REGULARIZATION_NONE);
    return plan.regularization == REGULARIZATION_NONE;
  };
  scene::Features features;
  EXPECT_TRUE(is_dropped(features)) << "no microfacet lobe";
  features.least_reflection_alpha = 0.0283F;
  EXPECT_TRUE(is_dropped(features));
  features.least_reflection_alpha = 0.0281F;
  EXPECT_FALSE(is_dropped(features));
  features.least_reflection_alpha = 0.5F;
  features.least_refraction_alpha = 0.170F / 3;
  EXPECT_TRUE(is_dropped(features));
  features.least_refraction_alpha = 0.168F / 3;
  EXPECT_FALSE(is_dropped(features));
  settings.tau = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(is_dropped(features));
  settings.tau = 100;
  settings.bound = BOUND_DIRECTIONAL;
  features = {};
  EXPECT_FALSE(is_dropped(features)) << "the alpha of other bounds depends on directions";
}

// By the sizes of the structs: with 1023 light vertices of the cache to connect to a path has 1024 candidates
// of 44 bytes and three lists of 1023 pairs of 8; of its own light path two vertices are expected. 65,535
// groups of 64 are what Vulkan guarantees.
TEST(PathSlots, FitIntoADispatchAndAnAllocation) {
  scene::Features features;
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  features.has_connectible_surfaces = true;
  RenderSettings settings;
  settings.width = settings.height = 64;
  constexpr uint64_t MUCH = uint64_t{1} << 50, GROUPS = 65535;
  const Plan plain = plan_of(features, settings);
  EXPECT_EQ(most_paths(plain, GROUPS, MUCH), GROUPS * 64) << "a path has one item in any queue";
  EXPECT_EQ(most_paths(plain, MUCH, 64 * 1000), 1000u) << "paths are the largest array";
  settings.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT;
  settings.max_depth = 1024;
  const Plan paired = plan_of(features, settings);
  EXPECT_EQ(most_paths(paired, GROUPS, MUCH), GROUPS * 64 / 3);
  EXPECT_EQ(most_paths(paired, MUCH, uint64_t{1} << 31), (uint64_t{1} << 31) / (3 * 44)) << "candidates";
  EXPECT_EQ(most_light_vertices(paired, 1000, GROUPS, MUCH), GROUPS * 64 - 1000) << "candidates";
  EXPECT_EQ(most_light_vertices(paired, 1000, MUCH, 1 << 20), (1u << 20) / 64) << "light vertices";
  settings.cache_connections = 1024;
  const Plan cached = plan_of(features, settings);
  EXPECT_EQ(most_paths(cached, MUCH, uint64_t{1} << 31), (uint64_t{1} << 31) / (1025 * 44)) << "candidates";
  EXPECT_LE(most_paths(cached, MUCH, MUCH) * 1025, UINT32_MAX) << "items are counted with 32 bits";
}

// By the sizes of the structs. A path tracer's slot: Path 64, Hit 16, radiance 12, two ray queues of 4, three
// bounce queues of 4, one candidate of 44. A bidirectional one has the head of a light path of 8, a camera
// vertex of 64 and a splat of 52; each light vertex takes 64, another candidate, and a pair of 8 in three
// lists.
TEST(PathSlots, CostWhatTheirArraysHold) {
  scene::Features features;
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  features.has_connectible_surfaces = true;
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.max_depth = 4;
  EXPECT_EQ(bytes_per_path(plan_of(features, settings)), 64u + 16 + 12 + 8 + 12 + 44);
  settings.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT;
  const Plan paired = plan_of(features, settings);
  EXPECT_EQ(bytes_per_light_vertex(paired), 64u + 44 + 3 * 8);
  EXPECT_EQ(bytes_per_path(paired, sizes_of(paired, 1000, 2500)),
            156 + 8 + 64 + 52 + 5u * (64 + 44 + 3 * 8) / 2);
  EXPECT_EQ(bytes_per_path(paired, sizes_of(paired, 1000, 9000)),
            156 + 8 + 64 + 52 + 9u * 64 + 3 * (44 + 3 * 8))
      << "a camera vertex meets three light vertices at most";
  settings.techniques = TECHNIQUE_SPLAT;
  EXPECT_EQ(bytes_per_path(plan_of(features, settings)), 64u + 16 + 12 + 8 + 12 + 2 * 52)
      << "nothing is traced for visibility, and an emitter has a splat of its own";
  settings.techniques = TECHNIQUE_HIT | TECHNIQUE_MERGE;
  const Plan merging = plan_of(features, settings);
  EXPECT_EQ(bytes_per_path(merging), 64u + 16 + 12 + 8 + 12 + 64 + 4) << "light vertices are the iteration's";
  EXPECT_EQ(bytes_per_light_vertex(merging), 64u + 16 + 4) << "with their place in the grid";
  settings.aovs = AOV_VARIANCE | AOV_DEPTH;
  const PixelBytes pixel = bytes_per_pixel(plan_of(features, settings));
  EXPECT_EQ(pixel.all, 3u * 36 + 64);
  EXPECT_EQ(pixel.largest, 64u);
}

// Whatever the device, the settings and the memory: what is chosen fits, and where nothing does it is said.
TEST(PathSlots, AreChosenWithinTheLimitsOfTheDevice) {
  scene::Features features;
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  features.has_connectible_surfaces = true;
  RenderSettings settings;
  settings.width = settings.height = 4096;
  settings.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT;
  constexpr uint64_t FILM = 4096 * 4096;
  for (const uint32_t max_depth : {1u, 12u, 1024u})
    for (const uint32_t max_groups : {65535u, 4096u, UINT32_MAX})
      for (const uint64_t megabytes : {4, 256, 1 << 20})
        for (const uint32_t wave_paths : {0u, 64u, 10'000'000u}) {
          settings.max_depth = max_depth;
          settings.wave_paths = wave_paths;
          const Plan plan = plan_of(features, settings);
          gpu::DeviceInfo device;
          device.kind = gpu::DeviceKind::Discrete;
          device.max_groups = max_groups;
          device.max_allocation_bytes = megabytes << 20;
          const uint64_t paths = choose_capacity(device, megabytes << 24, plan, FILM);
          const uint64_t vertices = paths * std::min(max_depth, 2u);  // expected
          EXPECT_EQ(paths % 64, 0u);
          EXPECT_GE(paths, 64u);
          EXPECT_LE(paths + vertices, 64ull * max_groups) << "light samples and connections";
          EXPECT_LE((paths + vertices) * 44, megabytes << 20);
          EXPECT_LE(vertices * 64, megabytes << 20) << "light vertices";
          EXPECT_GE(most_light_vertices(plan, paths, max_groups, megabytes << 20),
                    std::max(max_depth, 2u) - 1)
              << "those of one path";
          if (wave_paths == 64) {
            EXPECT_EQ(paths, 64u);
          }
        }
  gpu::DeviceInfo tiny;
  tiny.max_groups = 65535;
  tiny.max_allocation_bytes = 64 * 1023 * 64 - 1;  // a byte less than the light vertices of 64 paths
  settings.max_depth = 1024;
  EXPECT_THROW(choose_capacity(tiny, FILM, plan_of(features, settings), FILM), Error);
  ++tiny.max_allocation_bytes;
  EXPECT_EQ(choose_capacity(tiny, FILM, plan_of(features, settings), FILM),
            64u * 1023 * 64 / (3 * 44) / 64 * 64)
      << "candidates of a path with two light vertices";
}

}  // namespace
}  // namespace regulus::render

// Which stages of the pass are built: none that a scene or the techniques do not need.
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "render/stages.hpp"
#include "render/wavefront_buffers.hpp"

namespace regulus::render {
namespace {

using namespace interface;
using Names = std::set<std::string>;

Names needed(uint32_t material_classes, uint32_t techniques) {
  scene::Features features;
  features.material_classes = material_classes;
  RenderSettings settings;
  settings.techniques = techniques;
  Names names;
  for (const StageStep& step : STAGES)
    if (is_needed(step, features, settings)) names.insert(step.name);
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

// Techniques that cannot contribute to the scene are dropped, and with them their stages and their share of
// weights.
TEST(Techniques, ThatTheSceneCannotUseAreDropped) {
  constexpr uint32_t ALL =
      TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  RenderSettings settings;
  settings.techniques = ALL;
  scene::Features features;
  features.has_connectible_surfaces = true;
  EXPECT_EQ(effective_techniques(features, settings), 0u) << "no light";
  features.bits = FEATURE_POINT_LIGHTS;
  EXPECT_EQ(effective_techniques(features, settings), ALL & ~TECHNIQUE_HIT) << "delta lights cannot be hit";
  features.bits = FEATURE_TRIANGLE_LIGHTS;
  EXPECT_EQ(effective_techniques(features, settings), ALL);
  features.has_connectible_surfaces = false;
  features.least_reflection_alpha = 0;
  EXPECT_EQ(effective_techniques(features, settings), ALL & ~(TECHNIQUE_CONNECT | TECHNIQUE_MERGE))
      << "perfect mirrors cannot be connected";
  settings.regularization = REGULARIZATION_ROUGHNESS;
  EXPECT_EQ(effective_techniques(features, settings), ALL) << "but with raised roughness they can";
}

// Nothing of light subpaths is built for a path tracer.
TEST(Stages, PathTracingHasNoLightSubpaths) {
  for (const std::string& name : needed(DIFFUSE | OPAQUE | TRANSMISSIVE, TECHNIQUE_HIT | TECHNIQUE_NEE))
    for (const char* part : {"light", "splat", "connect", "merge", "grid", "scan"})
      EXPECT_EQ(name.find(part), std::string::npos) << name;
}

// tau 100 raises reflection to alpha 1 / sqrt(400 pi) = 0.0282 and refraction by n = 1.5 to 3 / sqrt(100 pi)
// = 0.169.
TEST(Regularization, IsDroppedWhereEveryLobeIsBroadEnough) {
  RenderSettings settings;
  settings.regularization = REGULARIZATION_ROUGHNESS;
  settings.tau = 100;
  const auto is_dropped = [&](const scene::Features& features) {
    return effective_regularization(features, settings) == REGULARIZATION_NONE;
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

// By the sizes of the structs: with 1023 light vertices to connect to a path has 1024 candidates of 44 bytes
// and three lists of 1023 pairs of 8; 65,535 groups of 64 are what Vulkan guarantees.
TEST(PathSlots, FitIntoADispatchAndAnAllocation) {
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.light_paths = 64 * 64;
  constexpr uint64_t MUCH = uint64_t{1} << 50, GROUPS = 65535;
  EXPECT_EQ(most_paths(settings, GROUPS, MUCH), GROUPS * 64) << "a path has one item in any queue";
  EXPECT_EQ(most_paths(settings, MUCH, 64 * 1000), 1000u) << "paths are the largest array";
  settings.techniques |= TECHNIQUE_SPLAT | TECHNIQUE_CONNECT;
  settings.max_depth = 1024;
  EXPECT_EQ(most_paths(settings, GROUPS, MUCH), GROUPS * 64 / 1024);
  EXPECT_EQ(most_paths(settings, MUCH, uint64_t{1} << 31), (uint64_t{1} << 31) / (1023 * 64))
      << "light vertices";
  settings.cache_connections = 1024;
  EXPECT_EQ(most_paths(settings, MUCH, uint64_t{1} << 31), (uint64_t{1} << 31) / (1025 * 44)) << "candidates";
  EXPECT_LE(most_paths(settings, MUCH, MUCH) * 1025, UINT32_MAX) << "items are counted with 32 bits";
}

}  // namespace
}  // namespace regulus::render

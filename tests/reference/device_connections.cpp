// The device's connections and merges against the reference's, and proof that the comparison sees what is
// wrong: a recording that is spoilt in one place must fail in that stage.
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "check/check.hpp"
#include "check/reference_render.hpp"
#include "images/support/copies.hpp"
#include "images/support/prepared_scene.hpp"
#include "images/support/render_scene.hpp"
#include "reference/support/device_scenes.hpp"
#include "render/reference_settings.hpp"
#include "support/device.hpp"
#include "support/run_length.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using check::Tally;

/// A scene seen through a lens of this radius, m, in focus at 1 m.
PreparedScene with_lens(PreparedScene prepared, float radius) {
  prepared.scene.cameras[0].lens_radius = radius;
  prepared.scene.cameras[0].focus_distance = 1;
  return prepared;
}

/// An iteration with connections to the cache and merges, regularized or not.
class CheckedConnections {
 public:
  CheckedConnections(PreparedScene prepared, const render::RenderSettings& settings)
      : prepared_(std::move(prepared)),
        recorder_(*device(), prepared_, plan_recording(prepared_, settings, *settings.techniques),
                  SIZE * SIZE),
        world_(prepared_, settings.ndf, settings.shadowing, settings.light_sampling,
               settings.has_energy_compensation, recorder_.plan().light_guide, recorder_.plan().walk_guide),
        camera_(scene::make_camera(prepared_.scene.cameras[0], SIZE, SIZE), SIZE, SIZE),
        reference_(render::reference_settings(recorder_.plan())) {}

  /// A narrow bound `tau` and wide merges make much of what regularization does.
  static render::RenderSettings settings(uint32_t regularization, float tau = 20) {
    render::RenderSettings result;
    result.width = result.height = SIZE;
    result.filter = FILTER_BOX;
    result.filter_radius = 0.5F;
    result.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | render::LIGHT_SUBPATH_TECHNIQUES;
    result.cache_connections = 2;
    result.merge_radius = 0.02F;
    result.keeps_merge_radius = true;
    result.regularization = regularization;
    result.tau = tau;
    return result;
  }

  render::ConnectionRecording record(render::Connections connections = render::Connections::Cache) {
    render::ConnectionRecording recording = recorder_.record_light_vertices(SAMPLE, connections);
    recorder_.record_connections(SAMPLE, recording);
    return recording;
  }
  std::vector<Tally> check(const render::ConnectionRecording& recording) const {
    const check::Subject subject{prepared_, world_, camera_, recorder_.plan(), reference_};
    std::vector<Tally> tallies = check_sorting(subject, recording);
    for (const Tally& tally : check_connections(subject, SAMPLE, recording)) tallies.push_back(tally);
    return tallies;
  }

 private:
  static constexpr uint32_t SIZE = 32, SAMPLE = 2;

  PreparedScene prepared_;
  render::StageRecorder recorder_;
  reference::World world_;
  reference::Camera camera_;
  reference::Settings reference_;
};

void expect_agreement(PreparedScene prepared, const render::RenderSettings& settings) {
  CheckedConnections checked(std::move(prepared), settings);
  for (const Tally& tally : checked.check(checked.record())) {
    std::printf("%s\n", tally.line().c_str());
    EXPECT_TRUE(tally.is_passed());
  }
}

TEST(DeviceConnections, AgreeWithTheReferenceAndAFaultInAnyStageIsFound) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device()) GTEST_SKIP() << "compiles for minutes here";
  CheckedConnections checked(prepare(own_scenes() / "cornell/cornell.gltf"),
                             CheckedConnections::settings(REGULARIZATION_NONE));
  const render::ConnectionRecording recording = checked.record();
  for (const Tally& tally : checked.check(recording)) {
    std::printf("%s\n", tally.line().c_str());
    EXPECT_TRUE(tally.is_passed());
  }
  using Plant = std::function<void(render::ConnectionRecording&)>;
  // Which line has to fail; values and weights only if more than the allowed share is wrong.
  const std::pair<const char*, Plant> faults[] = {
      {"light_path_counts", [](auto& r) { ++r.path_counts[3]; }},
      {"scan_light_paths", [](auto& r) { ++r.path_ends[700]; }},
      {"grid_count", [](auto& r) { ++r.ranks[5]; }},
      {"scan_grid", [](auto& r) { ++r.cell_ends[100]; }},
      {"grid_scatter", [](auto& r) { r.entries[8].vertex = r.entries[9].vertex; }},
      {"light vertices stored", [](auto& r) { ++r.light_vertices[40].edges; }},
      {"found by one side only",
       [](auto& r) {
         for (auto& splat : r.splats) splat.film *= 1.01F;
       }},
      {"found by one side only",
       [](auto& r) { r.bounces[0].light_samples.resize(r.bounces[0].light_samples.size() - 40); }},
      {"walks followed",
       [](auto& r) {
         for (auto& hit : r.bounces[1].hits) hit.u *= 0.9F;
       }},
      {"connection pairs", [](auto& r) { r.bounces[0].pairs.pop_back(); }},
      {"choices of a light", [](auto& r) { r.bounces[0].light_samples[3].direction.x += 0.01F; }},
      {"hit",
       [](auto& r) {
         for (auto& met : r.bounces[1].met) met *= 1.0003F;
       }},
      {"connect",
       [](auto& r) {
         for (auto& candidate : r.bounces[0].connections) candidate.contribution *= 1.0003F;
       }},
      {"merge",
       [](auto& r) {
         for (auto& sum : r.bounces[0].merged) sum *= 1.0003;
       }},
      {"splats",
       [](auto& r) {
         for (auto& splat : r.splats) splat.segment.contribution *= 1.0003F;
       }},
      {"weights (absolute)",
       [](auto& r) {
         for (auto& candidate : r.bounces[0].light_samples) candidate.contribution *= 1.00005F;
       }},
      {"trace_splats",
       [](auto& r) {
         for (auto& sum : r.splat_film) sum *= 1.0003;
       }},
  };
  for (const auto& [name, plant] : faults) {
    render::ConnectionRecording spoilt = recording;
    plant(spoilt);
    bool is_found = false;
    for (const Tally& tally : checked.check(spoilt))
      is_found = is_found || (tally.name() == name && !tally.is_passed());
    EXPECT_TRUE(is_found) << "fault in " << name;
  }

  // Each camera path with its own light path, and not with its neighbour's.
  const render::ConnectionRecording paired = checked.record(render::Connections::Paired);
  for (const Tally& tally : checked.check(paired)) {
    if (tally.name() == "connection pairs" || tally.name() == "connect") {
      std::printf("%s\n", tally.line().c_str());
      EXPECT_GT(tally.items(), 100);
    }
    EXPECT_TRUE(tally.is_passed());
  }
  render::ConnectionRecording swapped = paired;
  for (ConnectionPair& pair : swapped.bounces[0].pairs) pair.slot ^= 1;
  const auto tallies = checked.check(swapped);
  const auto of_pairs =
      std::ranges::find_if(tallies, [](const Tally& tally) { return tally.name() == "connection pairs"; });
  ASSERT_NE(of_pairs, tallies.end());
  EXPECT_FALSE(of_pairs->is_passed());
}

TEST(DeviceConnections, ThroughAThinLensAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  expect_agreement(with_lens(prepare(own_scenes() / "cornell/cornell.gltf"), 0.05F),
                   CheckedConnections::settings(REGULARIZATION_NONE));
}

// Regularized with the schedule that renders use, in an iteration that is not its first; each case has a
// bound of its own.
constexpr uint32_t ON = REGULARIZATION_ROUGHNESS | REGULARIZATION_CONSISTENT;

// Wide merges also join the glass sphere's vertices with the floor's, which diffuses and the glass does not.
TEST(DeviceConnections, RegularizedBehindWhatDiffusesAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  render::RenderSettings settings = CheckedConnections::settings(ON | REGULARIZATION_DIFFUSION, 0.6F);
  settings.merge_radius = 0.06F;
  settings.bound = BOUND_SMITH;
  settings.sampler_quality = SAMPLER_QUALITY_SMOOTH;
  settings.filter = FILTER_GAUSSIAN;
  settings.filter_radius = 1.5F;
  expect_agreement(prepare(own_scenes() / "cornell/cornell.gltf"), settings);
}

/// A lamp and a sun over mirror, glass and gloss: the sun's edges have no length, and what lies in the glass
/// is seen, and lit, through one refraction.
GltfScene sunlit_room() {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0})}, metal({0.9, 0.9, 0.9}, 0));
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.4));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), glass(1.5, 0, {0.5, 0.7, 0.9}));
  scene.add(box({0.25, 0.2, -0.15}, {0.55, 0.4, 0.15}), lambert({0.6, 0.7, 0.5}));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.add_directional_light({0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  return scene;
}

// With a choice by nee that knows the surface, and by power; regularized and not.
TEST(DeviceConnections, GuidedAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  for (const bool is_regularized : {false, true}) {
    render::RenderSettings settings = CheckedConnections::settings(
        is_regularized ? ON | REGULARIZATION_DIFFUSION : uint32_t{REGULARIZATION_NONE});
    settings.light_guide = settings.walk_guide = LIGHT_GUIDE_ON;
    settings.light_sampling = is_regularized ? LIGHT_SAMPLING_BVH : LIGHT_SAMPLING_POWER;
    expect_agreement(guided_scene(), settings);
  }
}

TEST(DeviceConnections, RegularizedTwiceByQualityAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device()) GTEST_SKIP() << "compiles for minutes here";
  render::RenderSettings settings = CheckedConnections::settings(ON | REGULARIZATION_BOTH, 0.6F);
  settings.sampler_quality = SAMPLER_QUALITY_SMOOTH;
  settings.light_sampling = LIGHT_SAMPLING_BVH;
  settings.bound = BOUND_DIRECTIONAL;
  expect_agreement(prepare(sunlit_room()), settings);
}

// Smooth glass under a rough coat diffuses from inside as from outside: all that a camera in such a block
// sees is regularized, through one face. And splats of `both` count by what the camera has met, which is
// nothing where they leave a nearly sharp mirror behind gloss.
TEST(DeviceConnections, BothThroughCoatedGlassAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  nlohmann::json coated = glass(1.5, 0);
  coated["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1},
                                                     {"clearcoatRoughnessFactor", 0.5}};
  const glm::dvec3 eye(0, 1.2, 2.2), half_block(0.2, 0.2, 0.2);
  for (const glm::dvec3& block : {glm::dvec3(0.6, 0.9, 0.2), eye}) {
    GltfScene scene = sunlit_room();
    scene.add(box(block - half_block, block + half_block), coated);
    scene.add({quad({-0.9, 0.1, -0.8}, {1.6, 0, 0}, {0, 1.2, -0.1})}, metal({0.9, 0.9, 0.9}, 0.2));
    expect_agreement(prepare(scene),
                     CheckedConnections::settings(ON | REGULARIZATION_BOTH | REGULARIZATION_DIFFUSION, 0.6F));
  }
}

// A camera in dyed glass sees from its near plane on; what lies before the plane dyes all the same, by splats
// too.
TEST(DeviceConnections, BehindTheNearPlaneInAMediumAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  GltfScene scene;
  scene.add(box({-2, -2, -2}, {2, 2, 2}), glass(1.5, 0, {0.3, 0.5, 0.8}));
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-0.3, 0.9, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.set_perspective(look_at({0, 1.2, 1.5}, {0, 0, 0}), 0.9);
  scene.add({quad({-0.1, 1, 1.2}, {0.2, 0, 0}, {0, 0.1, 0})},
            lambert({0.5, 0.5, 0.5}));  // hidden by the plane
  scene.set_near_plane(0.7);
  expect_agreement(prepare(scene), CheckedConnections::settings(REGULARIZATION_NONE));
}

// Both ends of a connection, or a merge, may have met dispersive glass, one of them, or none.
TEST(DeviceConnections, ThroughDispersiveGlassAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  expect_agreement(prepare(dispersive_scene()), CheckedConnections::settings(REGULARIZATION_NONE));
  expect_agreement(prepare(dispersive_scene()),
                   CheckedConnections::settings(ON | REGULARIZATION_BOTH | REGULARIZATION_DIFFUSION, 0.6F));
}

TEST(DeviceConnections, RegularizedVirtuallyAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  render::RenderSettings settings =
      CheckedConnections::settings(ON | REGULARIZATION_DIFFUSION | REGULARIZATION_VIRTUAL_MERGE);
  settings.shadowing = SHADOWING_SMITH_UNCORRELATED;
  settings.filter = FILTER_BLACKMAN_HARRIS;
  settings.filter_radius = 1.5F;
  settings.bound = BOUND_DIRECTIONAL;
  expect_agreement(prepare(own_scenes() / "cornell/cornell.gltf"), settings);
}

// Clearcoats, smooth and rough, measure by cones of their own. Without splats: the first edge counts for
// sampler quality as nee samples it, the last as nothing does.
TEST(DeviceConnections, CoatsRegularizedVirtuallyAgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  render::RenderSettings settings = CheckedConnections::settings(ON | REGULARIZATION_VIRTUAL_MERGE, 0.6F);
  settings.techniques = *settings.techniques & ~TECHNIQUE_SPLAT;
  settings.sampler_quality = SAMPLER_QUALITY_SMOOTH;
  expect_agreement(prepare(coats_scene()), settings);
}

// Rough lobes under rough coats, with energy compensation: raised to the utmost, and hardly at all.
TEST(DeviceConnections, RegularizedCoatsAgreeWithTheReferenceWhateverTheBound) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  for (const float tau : {1e-4F, 1e9F}) {
    render::RenderSettings settings = CheckedConnections::settings(ON, tau);
    settings.has_energy_compensation = true;
    expect_agreement(prepare(coats_scene()), settings);
    if (HasFailure()) return;
  }
}

// A floor whose normals lean far over: light from the other side arrives above the surface, but behind its
// shading normal. The walk ends there, yet a merge scatters at the camera's surface and needs the vertex.
TEST(DeviceConnections, VerticesBehindTheirShadingNormalAreStored) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  GltfScene scene;
  Corners leaning;
  leaning.normals.assign(4, glm::normalize(glm::vec3(0.95F, 0.3F, 0)));
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}), glm::dmat4(1), leaning);
  scene.add_point_light({0, 0.5, 0}, {1, 1, 1});
  scene.set_perspective(look_at({0, 2, 0}, {0, 0, 0.001}), 1);
  const PreparedScene prepared = prepare(scene);
  constexpr uint32_t PATHS = 16 * 16, TECHNIQUES = TECHNIQUE_NEE | render::LIGHT_SUBPATH_TECHNIQUES;
  render::RenderSettings settings = box_filtered(16, 16, 1, 2);
  settings.techniques = TECHNIQUES;
  settings.cache_connections = 1;
  settings.merge_radius = 0.1F;
  render::StageRecorder recorder(*device(), prepared, plan_recording(prepared, settings, TECHNIQUES), PATHS);
  const size_t stored = recorder.record_light_vertices(0).light_vertices.size();
  const reference::World world(prepared);
  reference::Settings wanted;
  wanted.width = wanted.height = 16;
  wanted.max_depth = 2;
  size_t arrived = 0, behind = 0;
  for (uint32_t path = 0; path < PATHS; ++path)
    for (const reference::WalkVertex& vertex : walk_from_light(world, wanted, path, 0).vertices) {
      ++arrived;
      behind += dot(vertex.w_back, vertex.surface.shading_normal) < 0 ? 1 : 0;
    }
  std::printf("%zu light vertices stored, %zu arrived, %zu of them behind the shading normal\n", stored,
              arrived, behind);
  EXPECT_GT(behind, arrived / 10);
  EXPECT_EQ(stored, arrived);
}

}  // namespace
}  // namespace regulus::test

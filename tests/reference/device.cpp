// The device's stages against the reference, and proof that the comparison sees what is wrong: a recording
// that is spoilt in one place must fail in that stage.
#include "support/device.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "check/check.hpp"
#include "check/reference_render.hpp"
#include "images/support/copies.hpp"
#include "images/support/prepared_scene.hpp"
#include "images/support/render_scene.hpp"
#include "render/reference_settings.hpp"
#include "support/run_length.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using check::Tally;
using render::Pass;
using render::Recording;

/// A scene with everything that a check needs.
class Checked {
 public:
  explicit Checked(const char* scene) : Checked(prepare(own_scenes() / scene)) {}
  explicit Checked(PreparedScene prepared) : Checked(std::move(prepared), settings()) {}
  Checked(PreparedScene prepared, const render::RenderSettings& settings)
      : prepared_(std::move(prepared)),
        recorder_(*device(), prepared_, plan_recording(prepared_, settings), SIZE * SIZE),
        world_(prepared_, settings.ndf, settings.shadowing, settings.light_sampling,
               settings.has_energy_compensation, recorder_.plan().light_guide, recorder_.plan().walk_guide),
        camera_(scene::make_camera(prepared_.scene.cameras[0], SIZE, SIZE), SIZE, SIZE) {
    reference_.width = reference_.height = SIZE;
    reference_.max_depth = recorder_.plan().max_depth;
    reference_.techniques = recorder_.plan().techniques;
    reference_.filter = {FILTER_BOX, 0.5, 0};
  }

  Recording record(Pass pass) { return recorder_.record(pass, 0, 3); }
  std::vector<Tally> check(Pass pass, const Recording& recording) const {
    return check_stages(subject(), pass, recording);
  }
  bool has_blended_surfaces() const { return scene::has_blended_surfaces(prepared_.scene); }
  std::vector<Tally> paths(const Recording& recording) const { return check_paths(subject(), recording); }

  /// Path-traced images of both, by pixels, of paths of so many edges in the reference.
  std::vector<check::ImageTest> statistics(uint32_t reference_depth) const {
    render::RenderSettings asked = recorder_.plan().asked;
    asked.width = asked.height = 12;
    asked.samples = 4;
    asked.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE;
    reference::Settings wanted = reference_;
    wanted.width = wanted.height = 12;
    wanted.samples = 4;
    wanted.techniques = asked.techniques.value_or(render::ALL_TECHNIQUES);
    wanted.max_depth = reference_depth;
    const render::Plan plan = make_plan(prepared_, asked);
    return check::check_statistics(*device(), {prepared_, world_, camera_, plan, wanted}, 9, std::nullopt,
                                   1e-5);
  }
  uint32_t max_depth() const { return reference_.max_depth; }

  static render::RenderSettings settings() {
    render::RenderSettings result;
    result.width = result.height = SIZE;
    result.filter = FILTER_BOX;
    result.filter_radius = 0.5F;
    result.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT;
    return result;
  }

 private:
  static constexpr uint32_t SIZE = 48;

  check::Subject subject() const { return {prepared_, world_, camera_, recorder_.plan(), reference_}; }

  PreparedScene prepared_;
  render::StageRecorder recorder_;
  reference::World world_;
  reference::Camera camera_;
  reference::Settings reference_;
};

class DeviceStages : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

void expect_agreement(Checked& checked) {
  std::printf("%s\n", Tally::header().c_str());
  const auto expect_all = [](const std::vector<Tally>& tallies) {
    for (const Tally& tally : tallies) {
      std::printf("%s\n", tally.line().c_str());
      EXPECT_TRUE(tally.is_passed());
    }
  };
  const Recording camera = checked.record(Pass::Camera);
  expect_all(checked.check(Pass::Camera, camera));
  // What a ray does at a blended surface hangs on its bits, so whole paths part there.
  if (!checked.has_blended_surfaces()) expect_all(checked.paths(camera));
  expect_all(checked.check(Pass::Light, checked.record(Pass::Light)));
}

TEST_P(DeviceStages, AgreeWithTheReference) {
  Checked checked(GetParam());
  expect_agreement(checked);
}

// An environment map beside a lamp: directions out of its distribution, and what rays that leave the scene
// meet.
TEST(DeviceStagesEnvironment, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.5));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), glass(1.5, 0, {0.5, 0.7, 0.9}));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  image::Image sky{32, 16, {}};
  for (uint32_t i = 0; i < 32 * 16; ++i)
    for (const float channel : {0.2F, 0.4F, 0.8F})
      sky.rgb.push_back(i == 5 * 32 + 20 ? 50 : i < 256 ? channel * static_cast<float>(i % 7) : 0);
  Checked checked(prepare(scene, sky, 40));
  expect_agreement(checked);
}

// A light of every kind, far more of whose light is lost than is seen.
PreparedScene guided_scene() {
  GltfScene scene;
  scene.add({quad({-20, 0, 20}, {40, 0, 0}, {0, 0, -40})}, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.5));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), glass(1.5, 0, {0.5, 0.7, 0.9}));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.add({quad({-1.5, 1, -1.3}, {0.1, 0.5, 0}, {0, 0.5, 0.1})}, emitter({20, 10, 1}));
  scene.add_point_light({3, 2, 1}, {5, 3, 4});
  scene.add_spot_light({1, 4, 1}, {-0.3, -1, -0.4}, 20, 0.2, 1.2);
  scene.add_directional_light({0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  image::Image sky{32, 16, {}};
  for (uint32_t i = 0; i < 32 * 16; ++i)
    for (const float channel : {0.2F, 0.4F, 0.8F})
      sky.rgb.push_back(i == 5 * 32 + 20 ? 50 : i < 256 ? channel * static_cast<float>(i % 7) : 0);
  return prepare(scene, sky, 40);
}

TEST(DeviceStagesGuided, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  render::RenderSettings settings = Checked::settings();
  settings.light_guide = settings.walk_guide = LIGHT_GUIDE_ON;
  Checked checked(guided_scene(), settings);
  expect_agreement(checked);
}

// Clipping planes, and lights of limited range.
TEST(DeviceStagesPlanesAndRanges, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.5));
  scene.add(box({-0.5, 0, 1.2}, {0.5, 1, 1.4}), lambert({0.9, 0, 0}));
  scene.add_point_light({0.3, 0.8, 0.3}, {1, 1, 1});
  scene.add_spot_light({-0.5, 1, 0.5}, {0.3, -1, -0.4}, 2, 0.3, 0.7);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  PreparedScene prepared = prepare(scene);
  prepared.scene.cameras[0].z_near = 1.3F;
  prepared.scene.cameras[0].z_far = 2.9F;
  for (Light& light : prepared.scene.lights) light.area = 1.1F;
  prepared.features = find_features(prepared.scene);
  Checked checked(std::move(prepared));
  expect_agreement(checked);
}

// Textures with coordinates of their own, and textures of specular reflection.
TEST(DeviceStagesTextures, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const char* file : {"blender-io/20_specular/20_specular.gltf",
                           "tinygltf/models/Cube-texture-ext/Cube-textransform.gltf"}) {
    const std::filesystem::path scene = assets() / "gltf" / file;
    if (!std::filesystem::exists(scene)) GTEST_SKIP() << "no " << scene;
    Checked checked(prepare(scene));
    expect_agreement(checked);
  }
}

// Copies of meshes: turned, stretched, mirrored, with normal maps, anisotropy, colours, glass and masks.
TEST(DeviceStagesInstances, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Checked checked(shared_copies(copies_scene()));
  expect_agreement(checked);
}

// Clearcoats with normals of their own: smooth over rough, rough over a mirror, and over glass from both
// sides.
TEST(DeviceStagesCoats, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  Checked checked(prepare(coats_scene()));
  expect_agreement(checked);
}

// Energy compensation where the denser side of an interface is its front: rough glass in glass of a greater
// index.
TEST(DeviceStagesEnergyCompensation, InDenserGlassAgreesWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.7, 0.1, -0.6}, {0.5, 0.8, 0.3}), glass(1.6));
  scene.add(box({-0.6, 0.2, -0.3}, {0.2, 0.6, 0.1}), glass(1.3, 0.4));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  render::RenderSettings settings = Checked::settings();
  settings.has_energy_compensation = true;
  Checked checked(prepare(scene), settings);
  expect_agreement(checked);
}

/// Dispersive glass of all kinds: smooth with a block of another index within, rough, and under a clearcoat.
/// What lies in it is seen and lit through it.
GltfScene dispersive_scene() {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0})}, plastic({0.5, 0.5, 0.6}, 0.3));
  scene.add(box({-0.7, 0.1, -0.4}, {-0.1, 0.8, 0.2}), dispersive(glass(1.6, 0, {0.5, 0.7, 0.9}), 2));
  scene.add(box({-0.6, 0.2, -0.3}, {-0.3, 0.5, 0.1}), dispersive(glass(1.3, 0.3), 1));
  scene.add({quad({-0.28, 0.3, -0.2}, {0.15, 0, 0}, {0, 0.3, 0.1})}, lambert({0.6, 0.7, 0.5}));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), dispersive(glass(1.5, 0.4), 5));
  scene.add(box({0.1, 0.02, 0.4}, {0.5, 0.3, 0.7}), coated(dispersive(glass(2.4, 0), 0.36), 0.3));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.add_directional_light({0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  return scene;
}

// A wavelength for each sample: of rays, of pairs in the same iteration.
TEST(DeviceStagesDispersion, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (is_slow_device() || is_repeated_run()) GTEST_SKIP() << "compiles for minutes";
  for (const bool has_compensation : {false, true}) {
    render::RenderSettings settings = Checked::settings();
    settings.has_energy_compensation = has_compensation;
    Checked checked(prepare(dispersive_scene()), settings);
    expect_agreement(checked);
  }
}

// With a microfacet model whose visible normals take part of the number that also chooses reflection.
TEST(DeviceStagesEnergyCompensation, AgreeWithTheReference) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  render::RenderSettings settings = Checked::settings();
  settings.has_energy_compensation = true;
  settings.ndf = NDF_BECKMANN;
  settings.shadowing = SHADOWING_V_CAVITY;
  Checked checked(prepare(own_scenes() / "gallery/gallery.gltf"), settings);
  expect_agreement(checked);
}

INSTANTIATE_TEST_SUITE_P(OwnScenes, DeviceStages,
                         testing::Values("cornell/cornell.gltf", "plates/plates.gltf",
                                         "furnace/furnace-point.gltf", "smallvcm/smallvcm-background.gltf",
                                         "gallery/gallery.gltf"));

TEST(DeviceStatistics, ImagesHaveTheReferencesMeanAndMissingLightIsFound) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Checked checked("furnace/furnace-point.gltf");
  for (const check::ImageTest& test : checked.statistics(checked.max_depth())) {
    std::printf("%s\n", test.line.c_str());
    EXPECT_EQ(test.agreement, check::Agreement::Agree);
  }
  // Planted: paths that end too early, confirmed with more samples.
  const check::ImageTest planted = checked.statistics(4).back();
  std::printf("%s\n", planted.line.c_str());
  EXPECT_EQ(planted.agreement, check::Agreement::Differ);
  EXPECT_NE(planted.line.find(" 3 of 3 alarms confirmed"), std::string::npos);
}

struct Fault {
  const char* name;
  Pass pass;
  size_t line;  // of check_stages that has to fail
  std::function<void(Recording&)> plant;
};

/// Changes the first sixteen paths that hit something and go on. One alone may lie where rounding moves the
/// reference as far as the fault does, and which path comes first is the device's affair.
template <typename Change>
void change_paths(render::RecordedBounce& bounce, Change change) {
  int count = 0;
  for (const uint32_t slot : bounce.continuing)
    if (bounce.hits[slot].triangle != INVALID_INDEX && count++ < 16) change(bounce.after[slot]);
}

TEST(DeviceStagesControl, AFaultInAnyStageIsFound) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  Checked checked("cornell/cornell.gltf");
  const Recording camera = checked.record(Pass::Camera);
  const Recording light = checked.record(Pass::Light);
  const auto rotated = [](glm::vec3 v) { return glm::normalize(v + glm::vec3(1e-3F, -1e-3F, 5e-4F)); };
  const Fault faults[] = {
      {"camera ray", Pass::Camera, 0,
       [&](Recording& r) { r.generated[5].direction = rotated(r.generated[5].direction); }},
      {"another triangle", Pass::Camera, 1, [](Recording& r) { r.bounces[0].hits[7].triangle ^= 1U; }},
      {"distance of a hit", Pass::Camera, 1, [](Recording& r) { r.bounces[0].hits[9].t *= 1.001F; }},
      {"throughput", Pass::Camera, 2,
       [](Recording& r) { change_paths(r.bounces[1], [](Path& path) { path.throughput *= 1.001F; }); }},
      {"direction", Pass::Camera, 2,
       [&](Recording& r) {
         change_paths(r.bounces[0], [&](Path& path) { path.direction = rotated(path.direction); });
       }},
      {"a path that ends", Pass::Camera, 2, [](Recording& r) { r.bounces[0].continuing.pop_back(); }},
      {"a shadow", Pass::Camera, 3,
       [](Recording& r) {
         render::RecordedBounce& bounce = r.bounces[0];
         for (const VisibilityCandidate& candidate : bounce.candidates) {
           if (bounce.radiance[candidate.receiver] == bounce.radiance_before_visibility[candidate.receiver])
             continue;
           bounce.radiance[candidate.receiver] = bounce.radiance_before_visibility[candidate.receiver];
           if (glm::length(candidate.contribution) > 1e-3F) break;
         }
       }},
      {"a shadow segment that ends too early", Pass::Camera, 3,
       [](Recording& r) { r.bounces[0].probes.back().is_open = true; }},
      {"emitted power", Pass::Light, 0, [](Recording& r) { r.generated[3].throughput *= 1.001F; }},
      {"light path's throughput", Pass::Light, 2,
       [](Recording& r) { change_paths(r.bounces[0], [](Path& path) { path.throughput *= 1.001F; }); }},
  };
  for (const Fault& fault : faults) {
    Recording spoilt = fault.pass == Pass::Camera ? camera : light;
    fault.plant(spoilt);
    const std::vector<Tally> tallies = checked.check(fault.pass, spoilt);
    ASSERT_LT(fault.line, tallies.size());
    EXPECT_FALSE(tallies[fault.line].is_passed()) << fault.name << " was not found\n"
                                                  << tallies[fault.line].line();
  }
}

// ---- connections and merges

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

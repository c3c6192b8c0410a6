// The device's stages against the reference, and proof that the comparison sees what is wrong: a recording
// that is spoilt in one place must fail in that stage.
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
  Checked checked(prepare(scene, striped_sky(), 40));
  expect_agreement(checked);
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

}  // namespace
}  // namespace regulus::test

// libregulus as a program calls it: only public headers.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <regulus/regulus.hpp>

#include "cli/small_scenes.hpp"

namespace regulus::test {
namespace {

/// Radiance of the lit square's middle, W / (m^2 sr): a point light of 1 W/sr, 1 m above a diffuse albedo of
/// 0.5.
constexpr double MIDDLE = 0.5 * std::numbers::inv_pi;

/// That of a point at distance r from the middle: the cosine and the squared distance fall off.
double radiance_at(double r_squared) {
  return MIDDLE / std::pow(1 + r_squared, 1.5);
}

/// Of a film of 9 x 9 pixels by the square's camera: half the width of a pixel on the square, m.
const double HALF_PIXEL = 2 * std::tan(0.4) / 9;

class Library : public testing::Test {
 protected:
  Library() { write_lit_square(file("scene.gltf")); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  Scene load_scene() const { return load(file("scene.gltf")); }

 private:
  const TemporaryFolder folder_;
};

Settings small(int samples = 4) {
  return Settings().set("size", "9x9").set("spp", samples).set("filter", "box");
}

double middle_of(const Picture& picture) {
  const size_t pixel = picture.height / 2 * picture.width + picture.width / 2;
  return static_cast<double>(picture.rgb.at(3 * pixel));
}

Picture render_all(const Prepared& scene, const Settings& settings, const Device& device) {
  Renderer renderer(make_plan(scene, settings), device);
  EXPECT_TRUE(renderer.render().is_complete);
  return renderer.picture();
}

template <typename Action>
std::string error_of(ErrorCode code, const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

TEST_F(Library, DeviceAndReferenceFindTheKnownRadiance) {
  const Prepared scene = prepare(load_scene());
  for (const Device& device : {open_device(), reference_device()}) {
    const double found = middle_of(render_all(scene, small(), device));
    EXPECT_LE(found, MIDDLE * (1 + 1e-5)) << device.name();
    EXPECT_GE(found, radiance_at(2 * HALF_PIXEL * HALF_PIXEL) * (1 - 1e-5)) << device.name();
  }
}

TEST_F(Library, MovedCameraSeesWhatLiesThere) {
  Scene scene = load_scene();
  const Scene unmoved = scene;
  Camera camera = scene.cameras().front();
  camera.position[0] += 0.5;
  scene.set_camera(0, camera);
  EXPECT_DOUBLE_EQ(unmoved.cameras().front().position[0] + 0.5, scene.cameras().front().position[0]);
  const double found = middle_of(render_all(prepare(scene), small(), open_device()));
  const double nearest = 0.5 - HALF_PIXEL, farthest = 0.5 + HALF_PIXEL;
  EXPECT_LE(found, radiance_at(nearest * nearest) * (1 + 1e-5));
  EXPECT_GE(found, radiance_at(farthest * farthest + HALF_PIXEL * HALF_PIXEL) * (1 - 1e-5));
}

TEST_F(Library, CameraThatSeesNothingIsRefused) {
  Scene scene = load_scene();
  const Camera good = scene.cameras().front();
  const auto refused = [&](const auto& spoil) {
    Camera camera = good;
    spoil(camera);
    return error_of(ErrorCode::BadUsage, [&] { scene.set_camera(0, camera); });
  };
  EXPECT_NE(refused([](Camera& c) { c.direction = {0, 0, 0}; }).find("direction"), std::string::npos);
  EXPECT_NE(refused([](Camera& c) { c.up = c.direction; }).find("up"), std::string::npos);
  EXPECT_NE(refused([](Camera& c) { c.position[1] = NAN; }).find("position"), std::string::npos);
  EXPECT_NE(refused([](Camera& c) { c.vertical_fov = 4; }).find("vertical_fov"), std::string::npos);
  EXPECT_NE(refused([](Camera& c) { c.lens_radius = -1; }).find("lens_radius"), std::string::npos);
  error_of(ErrorCode::BadUsage, [&] { scene.set_camera(2, good); });
  scene.set_camera(1, look_at(good, {0, 0, 3}, {0, 0, 0}));
  EXPECT_EQ(scene.cameras().size(), 2u);
  EXPECT_DOUBLE_EQ(scene.cameras()[1].direction[2], -1);
}

TEST_F(Library, StoppedRenderGoesOnToTheSameBits) {
  const Device device = open_device();
  const Prepared scene = prepare(load_scene());
  const Settings settings = small(64).set("wave", 81);  // an iteration at a time
  Renderer renderer(make_plan(scene, settings), device);
  const Outcome stopped = renderer.render([](uint64_t, uint64_t) { return false; });
  EXPECT_FALSE(stopped.is_complete);
  EXPECT_LT(stopped.samples, 64u);
  uint64_t last = 0, all = 0;
  EXPECT_TRUE(renderer
                  .render([&](uint64_t done, uint64_t total) {
                    last = done;
                    all = total;
                    return true;
                  })
                  .is_complete);
  EXPECT_EQ(all, 64u * 81u);
  EXPECT_LE(last, all);
  EXPECT_EQ(renderer.picture().rgb, render_all(scene, settings, device).rgb);
}

TEST_F(Library, PartsMergeAndCheckpointsResumeToTheSameBits) {
  const Device device = open_device();
  const Prepared scene = prepare(load_scene());
  const Picture whole = render_all(scene, small(4), device);
  const Settings any = small().unset("spp");
  for (const char* range : {"0:2", "2:2"}) {
    Renderer renderer(make_plan(scene, Settings(any).set("samples", range)), device);
    renderer.render();
    renderer.write_part(file(std::string("part") + range[0] + ".exr"));
  }
  merge_parts({file("part0.exr"), file("part2.exr")}, file("merged.exr"));
  EXPECT_EQ(read_picture(file("merged.exr")).rgb, whole.rgb);

  Renderer first(make_plan(scene, small(2)), device);
  first.checkpoint(file("state.exr"));
  first.render();
  Renderer second(make_plan(scene, small(4)), device);
  second.resume(file("state.exr"));
  EXPECT_EQ(second.render().samples, 4u);
  EXPECT_EQ(second.picture().rgb, whole.rgb);
  Renderer other(make_plan(scene, small(4).set("seed", 7)), device);
  EXPECT_NE(error_of(ErrorCode::BadFile, [&] { other.resume(file("state.exr")); }).find("seed"),
            std::string::npos);
}

TEST_F(Library, PartsOfAnotherCameraAreOfAnotherRender) {
  const Device device = open_device();
  Scene scene = load_scene();
  Renderer first(make_plan(prepare(scene), small()), device);
  first.render();
  first.write_part(file("front.exr"));
  Camera camera = scene.cameras().front();
  camera.position[0] += 0.5;
  scene.set_camera(0, camera);
  Renderer second(make_plan(prepare(scene), small()), device);
  EXPECT_NE(error_of(ErrorCode::BadFile, [&] { second.resume(file("front.exr")); }).find("scene_hash"),
            std::string::npos);
}

TEST_F(Library, WrittenPictureIsReadBackWithItsAovs) {
  const Picture picture =
      render_all(prepare(load_scene()), small().set("aov", "albedo,Z").set("crop", "2,3,7,8"), open_device());
  EXPECT_EQ(picture.width, 5u);
  EXPECT_EQ(picture.film_width, 9u);
  const auto& albedo = std::get<std::vector<float>>(picture.channels.at("albedo.R"));
  EXPECT_FLOAT_EQ(albedo.at(12), 0.5f);
  EXPECT_FLOAT_EQ(std::get<std::vector<float>>(picture.channels.at("Z")).at(12), 2);
  write_picture(file("picture.exr"), picture);
  const Picture read = read_picture(file("picture.exr"));
  EXPECT_EQ(read.rgb, picture.rgb);
  EXPECT_EQ(read.attributes.at("regulus:samples"), "4");
  EXPECT_EQ(compare(read, picture).mse, 0);
  Picture brighter = picture;
  for (float& value : brighter.rgb) value += 0.5f;
  EXPECT_NEAR(compare(brighter, picture).mae, 0.5, 1e-6);
  brighter.width = 1;
  brighter.height = 25;
  error_of(ErrorCode::BadFile, [&] { compare(brighter, picture); });
  error_of(ErrorCode::BadUsage, [&] { write_picture(file("picture.tiff"), picture); });
}

TEST_F(Library, PlanSaysWhatIsDroppedAndWhy) {
  const Plan plan = make_plan(prepare(load_scene()), small().set("integrator", "vcm"));
  // A point light and one flat square: no light path has a second surface to reach, merges need none but two.
  EXPECT_EQ(plan.samples(), 4u);
  EXPECT_EQ(plan.width(), 9u);
  EXPECT_EQ(plan.description().at("regulus:samples"), "4");
  for (const Dropped& dropped : plan.dropped()) {
    EXPECT_FALSE(dropped.what.empty());
    EXPECT_FALSE(dropped.why.empty());
  }
}

TEST(LibrarySettings, EveryOneRefusesWhatItCannotTake) {
  for (const SettingDescription& setting : Settings::known()) {
    EXPECT_FALSE(setting.values.empty()) << setting.name;
    const std::string error =
        error_of(ErrorCode::BadUsage, [&] { Settings().set(setting.name, std::string()); });
    EXPECT_EQ(error.rfind(setting.name, 0), 0u) << error;
  }
  EXPECT_NE(error_of(ErrorCode::BadUsage, [] { Settings().set("max-deph", 3); }).find("max-depth?"),
            std::string::npos);
  EXPECT_NE(error_of(ErrorCode::BadUsage, [] { Settings().set("ndf", "gxg"); }).find("did you mean ggx?"),
            std::string::npos);
  error_of(ErrorCode::BadUsage, [] { Settings().set("spp", 0); });
  error_of(ErrorCode::BadUsage, [] { Settings().set("tau", std::nan("")); });
}

TEST_F(Library, SettingsThatNeedTheSceneAreRefusedByThePlan) {
  const Prepared scene = prepare(load_scene());
  for (const auto& [name, value] : {std::pair{"camera", "7"},
                                    {"size", "9by9"},
                                    {"crop", "0,0,10,9"},
                                    {"techniques", "hit,magic"},
                                    {"aov", "beauty"},
                                    {"connections", "some"},
                                    {"shadow-roulette", "-1"},
                                    {"merge-radius", "wide"},
                                    {"samples", "4"}}) {
    const std::string error = error_of(
        ErrorCode::BadUsage, [&] { make_plan(scene, Settings().set("size", "9x9").set(name, value)); });
    EXPECT_EQ(error.rfind(std::string(name) + " ", 0), 0u) << error;
  }
}

TEST_F(Library, EditsChangeTheSceneAndItsHash) {
  LoadOptions options;
  options.edits = {"lights.0.intensity=2", "materials.0.color=0.25,0.25,0.25,1"};
  const Scene edited = load(file("scene.gltf"), options);
  EXPECT_EQ(edited.edits().size(), 2u);
  EXPECT_TRUE(load_scene().edits().empty());
  const Prepared scene = prepare(edited);
  // Twice the light on half of the albedo.
  const double found = middle_of(render_all(scene, small(), reference_device()));
  EXPECT_LE(found, MIDDLE * (1 + 1e-5));
  EXPECT_GE(found, radiance_at(2 * HALF_PIXEL * HALF_PIXEL) * (1 - 1e-5));
  options.edits = {"materials.0.color=0.25,0.25,0.25,1"};
  const double dimmed =
      middle_of(render_all(prepare(load(file("scene.gltf"), options)), small(), reference_device()));
  EXPECT_NEAR(dimmed, found / 2, 1e-6 * found);
  options.edits = {"lights.0.intensty=2"};
  const std::string error = error_of(ErrorCode::BadUsage, [&] { load(file("scene.gltf"), options); });
  EXPECT_NE(error.find("did you mean intensity?"), std::string::npos) << error;
}

TEST_F(Library, ErrorsSayTheirKind) {
  EXPECT_NE(error_of(ErrorCode::BadFile, [&] { load(file("none.gltf")); }).find("none.gltf"),
            std::string::npos);
  error_of(ErrorCode::NoDevice, [] { open_device("no such device"); });
  const Prepared scene = prepare(load_scene());
  const Plan timed = make_plan(scene, small().unset("spp").set("time", 1));
  error_of(ErrorCode::BadUsage, [&] { Renderer(timed, reference_device()).render(); });
  error_of(ErrorCode::BadUsage, [&] { check_device(timed, reference_device()); });
}

TEST_F(Library, CheckPassesAndTracedPathsAgree) {
  const Device device = open_device();
  const Plan plan = make_plan(prepare(load_scene()), small());
  size_t told = 0;
  const std::vector<CheckLine> lines = check_device(plan, device, [&](const CheckLine&) { ++told; });
  EXPECT_GT(lines.size(), 5u);
  EXPECT_EQ(told, lines.size());
  for (const CheckLine& line : lines) EXPECT_TRUE(line.is_passed) << line.text;

  const TracedPath path = trace_path(plan, device, 4, 4, 0);
  ASSERT_FALSE(path.vertices.empty());
  const TracedVertex& vertex = path.vertices.front();
  ASSERT_TRUE(vertex.is_on_device);
  EXPECT_EQ(vertex.triangle, vertex.device_triangle);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(vertex.position[c], vertex.device_position[c], 1e-5);
    EXPECT_NEAR(path.radiance[c], path.device_radiance[c], 1e-5);
  }
  EXPECT_NEAR(vertex.position[2], 0, 1e-6);
  EXPECT_NEAR(vertex.geometric_normal[2], 1, 1e-6);
  double sum = 0;
  for (const TracedContribution& found : path.contributions) {
    double weights = 0;
    for (const TracedTechnique& technique : found.techniques) weights += technique.weight;
    EXPECT_NEAR(weights, 1, 1e-9);
    sum += found.weight * found.unweighted[0];
  }
  EXPECT_NEAR(sum, path.radiance[0], 1e-12);
  const double r_squared = vertex.position[0] * vertex.position[0] + vertex.position[1] * vertex.position[1];
  EXPECT_NEAR(sum, radiance_at(r_squared), 1e-6);
  error_of(ErrorCode::BadUsage, [&] { trace_path(plan, device, 9, 0, 0); });
}

}  // namespace
}  // namespace regulus::test

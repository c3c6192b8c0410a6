// What the command line says to those who use it wrongly: one line and the exit status of its kind. Nothing
// here needs a Vulkan device.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

class Usage : public testing::Test {
 protected:
  void SetUp() override {
    scene_.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
    scene_.add_point_light({0, 0, 1}, {1, 1, 1});
    scene_.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
    scene_.write(gltf());
  }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  std::string exr() const { return (folder_ / "out.exr").string(); }

  Finished render(Arguments more) const {
    Arguments arguments = {"render", gltf(), "-o", exr(), "--size", "8x8", "--spp", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  // Neither output nor any temporary of it.
  void expect_nothing_written() const {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path()))
      EXPECT_EQ(entry.path().string().find(".exr"), std::string::npos) << entry.path();
  }

  TemporaryFolder folder_;
  GltfScene scene_;
};

void write_file(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(Usage, HelpAndVersionEndWithZero) {
  for (const Arguments& arguments : {Arguments{"--help"}, Arguments{"--version"},
                                     Arguments{"render", "--help"}, Arguments{"devices", "--help"}}) {
    const Finished finished = run(arguments);
    EXPECT_EQ(finished.status, 0) << arguments.back();
    EXPECT_EQ(finished.err, "");
    EXPECT_GE(count_lines(finished.out), 1u);
  }
  EXPECT_EQ(run({"--version"}).out.rfind("regulus ", 0), 0u);
  const std::string help = run({"render", "--help"}).out;
  for (const char* option :
       {"--output", "--integrator", "--techniques", "--spp", "--size", "--camera", "--max-depth", "--seed",
        "--device", "--stats", "--png", "--exposure", "--quiet", "--verbose"})
    EXPECT_NE(help.find(option), std::string::npos) << option;
}

TEST_F(Usage, WrongOptionsEndWithTwo) {
  expect_error(run({}), 2);
  expect_error(run({"paint"}), 2, {"paint"});
  expect_error(run({"render"}), 2);
  expect_error(render({"--no-such-option"}), 2, {"--no-such-option"});
  expect_error(render({"--spp"}), 2, {"--spp"});
  for (const char* value : {"0", "-3", "many", "1e9999"}) expect_error(render({"-s", value}), 2, {"--spp"});
  for (const char* value : {"0", "1.5", "none"})
    expect_error(render({"--max-depth", value}), 2, {"--max-depth"});
  expect_error(render({"--integrator", "magic"}), 2, {"magic"});
  expect_error(render({"--techniques", "hit,magic"}), 2, {"magic"});
  expect_error(render({"--techniques", ","}), 2, {"--techniques"});
  expect_error(render({"--ndf", "phong"}), 2, {"phong"});
  expect_nothing_written();
}

// What is no number never is an option's value, wherever the option is given.
TEST_F(Usage, NotANumberIsNoValue) {
  for (const char* option : {"--tau",
                             "--clamp",
                             "--exposure",
                             "--time",
                             "--noise",
                             "--env-rotation",
                             "--env-scale",
                             "--filter-radius",
                             "--merge-radius",
                             "--merge-reduction",
                             "--shadow-roulette",
                             "--checkpoint-seconds",
                             "--spp",
                             "--max-depth",
                             "--seed",
                             "--light-paths",
                             "--wave",
                             "--crop",
                             "--size",
                             "--samples"})
    for (const char* value : {"nan", "-nan(1)", "1e-60x", ""})
      expect_error(render({option, value}), 2, {option});
  for (const char* option : {"--exposure", "--time", "--noise", "--env-rotation", "--env-scale",
                             "--filter-radius", "--merge-radius", "--merge-reduction", "--shadow-roulette"})
    for (const char* value : {"inf", "1e9999"}) expect_error(render({option, value}), 2, {option});
  for (const char* option : {"--tau", "--clamp"})
    for (const char* value : {"-inf", "0", "-1", "1e-60"}) expect_error(render({option, value}), 2, {option});
  expect_error(run({"check", gltf(), "--tolerance", "nan"}), 2, {"--tolerance"});
  // Of three seeds a pixel of 96x64 would have to differ by ten thousand standard errors.
  expect_error(run({"check", gltf(), "--statistics", "3"}), 2, {"--statistics 3", "or more"});
  expect_error(run({"bench", "error", "--scenes", gltf(), "--time", "nan"}), 2, {"--time"});
  expect_nothing_written();
  scene_.set_setting("tau", "nan");
  scene_.write(gltf());
  expect_error(run({"render", gltf(), "-o", exr()}), 3, {"scene.gltf", "tau"});
  expect_nothing_written();
}

// As the help says: no regularization.
TEST_F(Usage, InfiniteTauIsNoRegularization) {
  const auto picture = [&](const std::string& name, Arguments more) {
    const std::string file = (folder_ / name).string();
    Arguments arguments = {"render", gltf(),      "--size",    "8x8", "--spp",
                           "2",      "--backend", "reference", "-o",  file};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished finished = run(arguments);
    EXPECT_EQ(finished.status, 0) << finished.err;
    return image::read_exr(file).rgb;
  };
  EXPECT_EQ(picture("inf.exr", {"--tau", "inf"}), picture("none.exr", {"--regularization", "none"}));
}

// Of one edge there is only what the camera sees itself: no light that a surface reflects, whatever looks for
// it.
TEST_F(Usage, OneEdgeIsOneEdgeByTheReference) {
  for (const char* integrator : {"pt", "lt", "bpt", "bpm", "vcm"})
    for (const char* depth : {"1", "2"}) {
      const Finished finished = run({"render", gltf(), "-o", exr(), "--size", "8x8", "-s", "4", "--backend",
                                     "reference", "-i", integrator, "--max-depth", depth});
      ASSERT_EQ(finished.status, 0) << finished.err;
      const std::vector<float> rgb = image::read_exr(exr()).rgb;
      EXPECT_EQ(std::any_of(rgb.begin(), rgb.end(), [](float value) { return value != 0; }), depth[0] == '2')
          << integrator << " --max-depth " << depth;
    }
}

TEST_F(Usage, AnEqualsSignAfterAShortOptionIsNoPartOfItsValue) {
  const std::string other = (folder_ / "other.exr").string();
  const Finished finished =
      run({"render", gltf(), "-o=" + other, "--size=4x4", "-s=2", "-i=pt", "--backend=reference"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  image::Attributes attributes;
  EXPECT_EQ(image::read_exr(other, &attributes).width, 4u);
  EXPECT_EQ(attributes.at("regulus:samples"), "2");
  expect_error(render({"-s=-3"}), 2, {"--spp", "-3"});
  expect_error(render({"-i=magic"}), 2, {"--integrator", "magic"});
  // What is another option's value stays as it is.
  expect_error(render({"--camera", "-o=x"}), 2, {"--camera -o=x"});
}

TEST_F(Usage, MistypedNamesGetNearOnes) {
  expect_error(run({"rendr", gltf()}), 2, {"rendr", "did you mean render?"});
  expect_error(run({"bench", "eror"}), 2, {"eror", "did you mean error?"});
  expect_error(render({"--intergrator", "pt"}), 2, {"--intergrator", "did you mean --integrator?"});
  expect_error(render({"--max-deph=3"}), 2, {"--max-deph", "did you mean --max-depth?"});
  expect_error(render({"--xyzzy"}), 2, {"--xyzzy is not an option"});
  expect_error(render({"-i", "vmc"}), 2, {"--integrator", "\"vmc\" is not one of", "did you mean vcm?"});
  expect_error(render({"--ndf", "gxg"}), 2, {"--ndf", "ggx, beckmann, cosine", "did you mean ggx?"});
  expect_error(render({"--ndf", "1"}), 2, {"--ndf", "ggx, beckmann, cosine"});
  expect_error(render({"--techniques", "hit,conect"}), 2, {"conect", "did you mean connect?"});
  expect_error(render({"--aov", "albedo,Sigma"}), 2, {"Sigma", "did you mean sigma?"});
  expect_error(render({"--aov", "beauty"}), 2, {"beauty", ", sigma"});
  expect_nothing_written();
}

TEST_F(Usage, HelpSaysWhatIsDone) {
  const std::string help = run({"render", "--help"}).out;
  EXPECT_NE(help.find("bvh from 4 lights on"), std::string::npos) << help;
  EXPECT_NE(help.find("sigma"), std::string::npos);
  for (const char* topic : {"Output:", "Quality:", "Transport:", "Regularization:", "Camera and scene:",
                            "Device:", "Long renders:"})
    EXPECT_NE(help.find(topic), std::string::npos) << topic;
  EXPECT_NE(help.find("--light-sampling auto|bvh|power|uniform"), std::string::npos) << help;
  EXPECT_NE(help.find("(default: auto)"), std::string::npos) << help;
  EXPECT_NE(help.find("--spp N"), std::string::npos) << help;
  // No type or number that only the program knows.
  for (const char* inner : {"TEXT", "UINT", "FLOAT", "->"})
    EXPECT_EQ(help.find(inner), std::string::npos) << inner;
}

TEST_F(Usage, BadSizesEndWithTwo) {
  for (const char* size : {"8", "8x", "x8", "0x8", "8x0", "-8x8", "8x8x8", "8 x 8", "wide", "99999999999x1",
                           "1e3x4", "32769x1", " 8x8"})
    expect_error(run({"render", gltf(), "-o", exr(), "--size", size}), 2, {"--size", size});
  expect_nothing_written();
}

TEST_F(Usage, UnknownCamerasEndWithTwoAndAreListed) {
  for (const char* camera : {"1", "-1", "front", "0x0"})
    expect_error(render({"--camera", camera}), 2, {"--camera", camera});
  expect_nothing_written();
}

TEST_F(Usage, MissingScenesEndWithThree) {
  expect_error(run({"render", (folder_ / "absent.gltf").string(), "-o", exr()}), 3, {"absent.gltf"});
  expect_error(run({"render", folder_.path().string(), "-o", exr()}), 3, {folder_.path().string()});
  expect_error(run({"render", gltf(), "--scene", "5", "-o", exr()}), 3, {"scene"});
  expect_nothing_written();
}

// One JSON chunk (the buffer is a data URI).
std::string glb_of(std::string json) {
  while (json.size() % 4 != 0) json += ' ';
  const auto word = [](size_t value) {
    const auto bits = static_cast<uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&bits), 4);
  };
  return "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json;
}

TEST_F(Usage, TruncatedFilesEndWithThree) {
  const std::string glb = glb_of(read_file(gltf())), text = read_file(gltf());
  const std::string broken_glb = (folder_ / "broken.glb").string(),
                    broken_gltf = (folder_ / "broken.gltf").string();
  // The bad camera proves that the whole file is read without complaint: usage is only wrong after loading.
  write_file(broken_glb, glb);
  expect_error(run({"render", broken_glb, "-o", exr(), "--camera", "nobody"}), 2, {"nobody"});
  for (const size_t size :
       {size_t{0}, size_t{3}, size_t{12}, size_t{19}, size_t{20}, glb.size() / 2, glb.size() - 1}) {
    write_file(broken_glb, glb.substr(0, size));
    expect_error(run({"render", broken_glb, "-o", exr()}), 3, {"broken.glb"});
  }
  for (const size_t size : {size_t{0}, size_t{1}, text.size() / 2, text.size() - 1}) {
    write_file(broken_gltf, text.substr(0, size));
    expect_error(run({"render", broken_gltf, "-o", exr()}), 3, {"broken.gltf"});
  }
  write_file(broken_gltf, "a picture of a house");
  expect_error(run({"render", broken_gltf, "-o", exr()}), 3, {"broken.gltf"});
  expect_nothing_written();
}

TEST_F(Usage, PlacesThatCannotBeWrittenEndWithOneBeforeAnythingIsRendered) {
  const std::string file = gltf();
  for (const char* option : {"--output", "--png", "--stats"}) {
    const auto try_place = [&](const std::string& place) {
      // A device that does not exist would be the next error.
      expect_error(run({"render", gltf(), option, place, "--device", "no such device"}), 1, {option, place});
    };
    try_place((folder_ / "absent" / "out.x").string());
    try_place((fs::path(file) / "out.x").string());
    try_place(folder_.path().string());
  }
  expect_nothing_written();
}

TEST_F(Usage, UnknownDevicesEndWithFour) {
  expect_error(render({"--device", "no such device"}), 4, {"no such device"});
  expect_error(render({"--device", "4711"}), 4, {"4711"});
  expect_nothing_written();
}

TEST_F(Usage, NoDriverEndsWithFour) {
  const Environment none = {{"VK_DRIVER_FILES", "/nonexistent"}, {"VK_ICD_FILENAMES", "/nonexistent"}};
  expect_error(run({"render", gltf(), "-o", exr()}, none), 4);
  expect_error(run({"devices"}, none), 4);
  expect_nothing_written();
}

TEST_F(Usage, EnvironmentsThatCannotBeReadAreNamed) {
  write_file(folder_ / "text.exr.txt", "no image");
  expect_error(render({"--env", "missing.hdr"}), 3, {"missing.hdr"});
  expect_error(render({"--env", (folder_ / "text.exr.txt").string()}), 3, {"text.exr.txt"});
  expect_error(render({"--env-rotation", "left"}), 2);
  expect_error(render({"--env-scale", "-1"}), 2);
  fs::remove(folder_ / "text.exr.txt");
  expect_nothing_written();
}

TEST_F(Usage, SceneSettingsThatMakeNoSenseNameTheFile) {
  scene_.set_setting("spp", "plenty");
  scene_.write(gltf());
  // Without --spp, which would win.
  expect_error(run({"render", gltf(), "-o", exr()}), 3, {"scene.gltf", "spp"});
  expect_nothing_written();
}

}  // namespace
}  // namespace regulus::test

// -D: the picture of an edited scene is that of a file that says the same, and parts know of it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;

class Edits : public testing::Test {
 protected:
  void SetUp() override { write_lit_square(file("scene.gltf")); }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }

  Finished render(const std::string& output, const Arguments& more,
                  const std::string& scene = "scene.gltf") const {
    Arguments arguments = {"render", file(scene), "-o", file(output), "--size", "8x8", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  /// Of the pixel next to the middle.
  float middle(const std::string& name) const {
    const auto contents = image::read_exr_contents(file(name));
    return std::get<std::vector<float>>(contents.channels.at("G"))[4 * 8 + 4];
  }

  TemporaryFolder folder_;
};

// Both backends read the same edited document: the square shows albedo / pi times the light.
TEST_F(Edits, AreWhatTheFileWouldSay) {
  const Arguments reference = {"--backend", "reference", "-s", "16", "--filter", "box"};
  const auto with = [&](Arguments more) {
    more.insert(more.end(), reference.begin(), reference.end());
    return more;
  };
  ASSERT_EQ(render("plain.exr", reference).status, 0);
  const Finished edited = render("edited.exr", with({"-D", "lights.0.intensity=3", "-Dcameras.0.yfov=0.5"}));
  ASSERT_EQ(edited.status, 0) << edited.err;
  EXPECT_NEAR(middle("edited.exr"), 3 * middle("plain.exr"), 0.1 * middle("plain.exr"));

  json scene = json::parse(std::ifstream(file("scene.gltf")));
  scene["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 3.0;
  scene["cameras"][0]["perspective"]["yfov"] = 0.5;
  std::ofstream(file("written.gltf")) << scene.dump();
  ASSERT_EQ(render("written.exr", reference, "written.gltf").status, 0);
  const image::ExrContents a = image::read_exr_contents(file("edited.exr")),
                           b = image::read_exr_contents(file("written.exr"));
  EXPECT_TRUE(a.channels == b.channels);
  EXPECT_EQ(a.attributes.at("regulus:edits"),
            "cameras/0/perspective/yfov=0.5 extensions/KHR_lights_punctual/lights/0/intensity=3.0");
  EXPECT_FALSE(b.attributes.contains("regulus:edits"));
}

TEST_F(Edits, ThatAreWrongAreRefused) {
  expect_error(render("x.exr", {"-D", "lights.0.intensty=3"}), 2,
               {"--define lights.0.intensty=3", "did you mean intensity"});
  expect_error(render("x.exr", {"-D", "nodes.9.translation=0,0,0"}), 2, {"--define", "no \"9\""});
  expect_error(run({"inspect", file("scene.gltf"), "-D", "lights.x.color=1,1,1"}), 2, {"lights.x"});
}

TEST_F(Edits, MakeAnotherScene) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const auto part = [&](const std::string& name, const std::string& samples, const std::string& intensity) {
    ASSERT_EQ(
        render(name, {"-i", "pt", "--samples", samples, "-D", "lights.0.intensity=" + intensity}).status, 0);
  };
  part("a.exr", "0:1", "2");
  part("b.exr", "1:1", "2.0");
  part("c.exr", "1:1", "3");
  EXPECT_EQ(run({"merge", file("ab.exr"), file("a.exr"), file("b.exr")}).status, 0);
  expect_error(run({"merge", file("ac.exr"), file("a.exr"), file("c.exr")}), 3,
               {"edits", "intensity=2.0", "intensity=3.0"});
}

}  // namespace
}  // namespace regulus::test

// How pictures are shown and stored: --view, --exposure auto, --half, --dwaa.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/color_config.hpp"
#include "image/encoding.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"
#include "images/support/render_scene.hpp"

namespace regulus::test {
namespace {

class Looks : public testing::Test {
 protected:
  void SetUp() override { write_lit_square(file("scene.gltf")); }
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  Finished render(const std::string& output, const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "-o",        file(output), "--size", "8x8", "-s",
                           "2",      "--backend",        "reference", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  std::string bytes(const std::string& name) const {
    std::ifstream stream(file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  TemporaryFolder folder_;
};

// The PNG beside a picture is what its view makes of it.
TEST_F(Looks, ThePreviewIsThePictureSeenThatWay) {
  for (const std::string& view : image::view_names()) {
    ASSERT_EQ(render("a.exr", {"--png", file("a.png"), "--view", view, "--exposure", "1.5"}).status, 0)
        << view;
    image::Encoding encoding(1.5F);
    encoding.view = image::view_of(view);
    EXPECT_EQ(bytes("a.png"), image::encode_picture(image::Format::Png, image::read_exr(file("a.exr")),
                                                    encoding, {}, {}, {}, "a"))
        << view;
  }
  ASSERT_EQ(render("a.exr", {"--png", file("auto.png"), "--exposure", "auto"}).status, 0);
  const image::Image picture = image::read_exr(file("a.exr"));
  EXPECT_EQ(bytes("auto.png"), image::encode_picture(image::Format::Png, picture,
                                                     image::automatic_exposure(picture), {}, {}, {}, "a"));
  expect_error(render("a.exr", {"--view", "agy"}), 2, {"agy", "did you mean agx"});
  expect_error(render("a.exr", {"--exposure", "much"}), 2, {"--exposure"});
}

// The square is seen as about 0.5 / pi; a config shows its square root.
TEST_F(Looks, ConfigsOfOpenColorIOShowThePreview) {
  if (!image::has_color_configs()) GTEST_SKIP() << "built without OpenColorIO";
  std::ofstream(file("config.ocio"))
      << "ocio_profile_version: 2\nroles: {default: linear, scene_linear: linear}\n"
         "displays:\n  Screen:\n    - !<View> {name: Root, colorspace: root}\n"
         "colorspaces:\n  - !<ColorSpace> {name: linear}\n  - !<ColorSpace>\n"
         "    name: root\n    from_scene_reference: !<ExponentTransform> {value: "
         "[0.5, 0.5, 0.5, 1]}\n";
  const Finished finished = render("a.exr", {"--png", file("a.png"), "--ocio", file("config.ocio")});
  ASSERT_EQ(finished.status, 0) << finished.err;
  image::Image root = image::read_exr(file("a.exr"));
  for (float& value : root.rgb) value = std::sqrt(value);
  image::Encoding raw;
  raw.view = image::View::Raw;
  EXPECT_EQ(bytes("a.png"), image::encode_picture(image::Format::Png, root, raw, {}, {}, {}, "a"));
  expect_error(render("b.exr", {"--png", file("b.png"), "--ocio", file("config.ocio"), "--ocio-view", "Rot"}),
               2, {"config.ocio: view", "did you mean Root?"});
  expect_error(render("b.exr", {"--ocio-view", "Root"}), 2, {"--ocio-view", "--ocio"});
  expect_error(render("b.exr", {"--ocio", file("none.ocio")}), 3, {"none.ocio"});
}

TEST_F(Looks, FewerBitsAreAskedForAndNeverOfParts) {
  ASSERT_EQ(render("a.exr", {"--aov", "Z,albedo"}).status, 0);
  ASSERT_EQ(render("half.exr", {"--aov", "Z,albedo", "--half"}).status, 0);
  EXPECT_EQ(image::read_exr(file("half.exr")).largest_finite, 65504);
  EXPECT_LT(bytes("half.exr").size(), bytes("a.exr").size());
  expect_error(render("b.exr", {"--aov", "crypto_object", "--dwaa"}), 2, {"--dwaa"});
  ASSERT_EQ(render("dwaa.exr", {"--dwaa"}).status, 0);
  EXPECT_GT(image::read_exr(file("dwaa.exr")).largest_finite, 65504) << "no halves without --half";
  expect_error(
      run({"render", file("scene.gltf"), "-o", file("b.exr"), "--size", "8x8", "--half", "--samples", "0:2"}),
      2, {"--samples", "--half"});
}

}  // namespace
}  // namespace regulus::test

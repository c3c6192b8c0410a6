// Denoising from the outside, with a library in place of Open Image Denoise whose results are known.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "images/support/render_scene.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;
using Plane = std::vector<float>;

class Denoise : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  const Plane& plane(const image::ExrContents& contents, const std::string& name) const {
    return std::get<Plane>(contents.channels.at(name));
  }
  Finished denoise(const std::string& from, const std::string& to, const Environment& more = {}) const {
    fs::remove(file("log"));
    Environment environment = {{"FAKE_OIDN_LOG", file("log")}, {"REGULUS_OIDN", FAKE_OIDN}};
    for (const auto& [name, value] : more) environment[name] = value;
    return run({"denoise", file(from), "-o", file(to)}, environment);
  }
  std::string log() const {
    std::ifstream stream(file("log"));
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  /// 2 x 2 pixels, one of them not a number; with alpha, a sum of samples, and where it lies on a film of 4
  /// x 3.
  void write_picture(const std::string& name, bool has_albedo) const {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    image::Image picture{2, 2, {1, 2, 3, nan, 4, -5, 6, 7, 8, 9, 10, INFINITY}};
    image::Channels channels = {{"A", Plane{1, 0.5F, 0.25F, 0}},
                                {"film.sum.R0", std::vector<uint32_t>{1, 2, 3, 4}}};
    if (has_albedo)
      for (const char* component : {"R", "G", "B"})
        channels[std::string("albedo.") + component] = Plane{0.5F, 0.25F, nan, 2};
    if (has_albedo)
      for (const char* component : {"X", "Y", "Z"})
        channels[std::string("N.") + component] = Plane{0, 1, -1, nan};
    image::write_exr(file(name), picture, {{"regulus:seed", "7"}, {"regulus:sample_ranges", "0:4"}}, channels,
                     {1, 1, 4, 3});
  }

  TemporaryFolder folder_;
};

TEST_F(Denoise, GivesTheLibraryCleanPicturesAndKeepsTheNoisyOne) {
  write_picture("in.exr", true);
  const Finished finished = denoise("in.exr", "out.exr");
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  EXPECT_EQ(log(),
            "device 1\nalbedo output 0\nnormal output 0\nalbedo color normal output cleanAux=1 hdr=1 "
            "0\nreleased\n");
  const image::ExrContents in = image::read_exr_contents(file("in.exr")),
                           out = image::read_exr_contents(file("out.exr"));
  // color + albedo / 2 after what is not finite has become 0, negative light too, and albedo at most 1.
  EXPECT_EQ(plane(out, "R"), (Plane{1.25F, 0.125F, 6, 9.5F}));
  EXPECT_EQ(plane(out, "G"), (Plane{2.25F, 4.125F, 7, 10.5F}));
  EXPECT_EQ(plane(out, "B"), (Plane{3.25F, 0.125F, 8, 0.5F}));
  for (const char* component : {"R", "G", "B"}) {
    const Plane &was = plane(in, component), &kept = plane(out, std::string("noisy.") + component);
    for (size_t i = 0; i < was.size(); ++i)
      EXPECT_EQ(std::bit_cast<uint32_t>(was[i]), std::bit_cast<uint32_t>(kept[i])) << component << i;
  }
  EXPECT_EQ(plane(out, "A"), plane(in, "A"));
  EXPECT_EQ(plane(out, "N.X").size(), 4u);
  EXPECT_FALSE(out.channels.contains("film.sum.R0")) << "a denoised picture is no part";
  EXPECT_FALSE(out.attributes.contains("regulus:sample_ranges"));
  EXPECT_EQ(out.attributes.at("regulus:seed"), "7");
  EXPECT_EQ(out.attributes.at("regulus:denoised"), "Open Image Denoise");
  EXPECT_EQ(out.placement.x, 1u);
  EXPECT_EQ(out.placement.film_width, 4u);

  // Once more it is the noisy picture that is denoised.
  ASSERT_EQ(denoise("out.exr", "again.exr").status, 0);
  EXPECT_EQ(plane(image::read_exr_contents(file("again.exr")), "R"), plane(out, "R"));
}

// What lamps show of themselves stays as it is: a denoiser spreads a pixel that is a thousand times as bright
// as its neighbours over them.
TEST_F(Denoise, LeavesLampsAsTheyAreSeen) {
  const image::Image picture{2, 1, {1, 2, 3, 1004, 5, 6}};
  image::Channels channels;
  for (const char* component : {"R", "G", "B"}) {
    channels[std::string("albedo.") + component] = Plane{0.5F, 0.5F};
    channels[std::string("emission.") + component] = Plane{0, component[0] == 'R' ? 1000.0F : 0.0F};
  }
  image::write_exr(file("in.exr"), picture, {}, channels);
  ASSERT_EQ(denoise("in.exr", "out.exr", {{"FAKE_OIDN_MOST", "6"}}).status, 0);
  const image::ExrContents out = image::read_exr_contents(file("out.exr"));
  EXPECT_EQ(plane(out, "R"), (Plane{1.25F, 1004.25F}));
  EXPECT_EQ(plane(out, "noisy.R"), (Plane{1, 1004}));
}

TEST_F(Denoise, WithoutAlbedoGoesByColorsAlone) {
  write_picture("in.exr", false);
  const Finished finished = denoise("in.exr", "out.exr");
  ASSERT_EQ(finished.status, 0);
  EXPECT_NE(finished.err.find("has no albedo"), std::string::npos) << finished.err;
  EXPECT_EQ(log(), "device 1\ncolor output hdr=1 0\nreleased\n");
  ASSERT_EQ(denoise("in.exr", "out.png").status, 0);
  EXPECT_TRUE(fs::exists(file("out.png")));
}

TEST_F(Denoise, SaysWhatIsMissingOrFails) {
  write_picture("in.exr", true);
  expect_error(denoise("in.exr", "x.exr", {{"REGULUS_OIDN", file("nowhere.so")}}), 1,
               {"Open Image Denoise cannot be loaded", "nowhere.so", "--oidn FILE or REGULUS_OIDN"});
  expect_error(denoise("in.exr", "x.exr", {{"REGULUS_OIDN", "libm.so.6"}}), 1,
               {"oidnNewDevice", "version 2"});
  expect_error(denoise("in.exr", "x.exr", {{"FAKE_OIDN_FAILS", "1"}}), 1,
               {"Open Image Denoise failed: as asked for"});
  expect_error(denoise("none.exr", "x.exr"), 3, {"none.exr"});
  expect_error(denoise("in.exr", "in.exr"), 2, {"in.exr", "the picture to denoise"});
  expect_error(run({"denoise", file("in.exr"), "-o", file("x.exr"), "--denoiser", "cross"}), 3, {"variance"});
  EXPECT_FALSE(fs::exists(file("x.exr")));
}

TEST_F(Denoise, WhileRenderingAddsWhatItNeeds) {
  write_lit_square(file("scene.gltf"));
  const auto render = [&](const Arguments& more, const std::string& library = FAKE_OIDN) {
    Arguments arguments = {"render", file("scene.gltf"), "--size",    "8x8",    "-s",
                           "2",      "--backend",        "reference", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments, {{"FAKE_OIDN_LOG", file("log")}, {"REGULUS_OIDN", library}});
  };
  ASSERT_EQ(render({"-o", file("noisy.exr"), "--filter", "box"}).status, 0);
  const Finished finished = render({"-o", file("out.exr"), "--denoise"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const image::ExrContents noisy = image::read_exr_contents(file("noisy.exr")),
                           out = image::read_exr_contents(file("out.exr"));
  EXPECT_EQ(plane(out, "noisy.R"), plane(noisy, "R")) << "the box filter is that of --denoise";
  for (size_t i = 0; i < 64; ++i)
    EXPECT_EQ(plane(out, "R")[i], plane(noisy, "R")[i] + plane(out, "albedo.R")[i] / 2);
  EXPECT_EQ(render({"-o", file("out.png"), "--denoise"}).status, 0);
  ASSERT_EQ(render({"-o", file("cross.exr"), "--denoise", "--denoiser", "cross"}, "").status, 0);
  EXPECT_EQ(image::read_exr_contents(file("cross.exr")).attributes.at("regulus:denoised"), "cross filter");
  // Before anything is rendered.
  expect_error(render({"-o", file("x.exr"), "--denoise"}, file("nowhere.so")), 1,
               {"Open Image Denoise cannot be loaded"});
  expect_error(run({"render", file("scene.gltf"), "-o", file("x.exr"), "--denoise", "--samples", "0:2"}), 2,
               {"--denoise", "merge"});
}

}  // namespace
}  // namespace regulus::test

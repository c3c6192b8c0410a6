// regulus render when the device is lost under it: one line of error, status 4, and what was rendered is
// written.
//
// The program is regulus with tests/cli/lose_device.cpp. A snapshot of the film takes two downloads, sums and
// counters, a quarter of a second after the render began at the earliest and as often from there.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

// A render in waves of one whole sample per pixel.
Arguments render_command(const std::string& scene, const std::string& output, const std::string& samples) {
  return {"render", scene, "-o", output, "--size", "128x128", "-s", samples, "--wave", "16384"};
}

class DeviceLoss : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write_lit_square(gltf());
  }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  std::string exr() const { return (folder_ / "out.exr").string(); }
  std::string stats() const { return (folder_ / "stats.json").string(); }

  // Renders without end until the device is lost.
  Finished render_until_loss(const std::string& downloads) const {
    Arguments arguments = render_command(gltf(), exr(), "16000000");
    arguments.insert(arguments.end(),
                     {"--stats", stats()});  // times every stage, so that the last one is known
    return run(arguments, {{"REGULUS_TEST_DOWNLOADS_BEFORE_LOSS", downloads}});
  }

  TemporaryFolder folder_;
};

// The file must hold whole samples of the first snapshot: bit by bit what an undisturbed render of as many
// gives.
void expect_first_snapshot(const std::string& scene, const std::string& written, const fs::path& folder) {
  image::Attributes attributes;
  const image::Image image = image::read_exr(written, &attributes);
  const std::string samples = attributes.at("regulus:samples_done");
  std::printf("lost after the snapshot of %s samples per pixel\n", samples.c_str());
  ASSERT_GT(std::stoull(samples), 0u);

  const std::string undisturbed = (folder / "undisturbed.exr").string();
  const Finished reference = run(render_command(scene, undisturbed, samples));
  ASSERT_EQ(reference.status, 0) << reference.err;
  EXPECT_TRUE(image.rgb == image::read_exr(undisturbed).rgb);
}

TEST_F(DeviceLoss, BetweenWavesWritesTheLastSnapshot) {
  const Finished finished = render_until_loss("2");
  expect_error(finished, 4,
               {device()->info().name, "lost", "after stage ", "out.exr holds what was rendered"});
  expect_first_snapshot(gltf(), exr(), folder_.path());
  EXPECT_TRUE(fs::exists(stats()));
}

// Between the sums and the counters of the second snapshot: the first one stands.
TEST_F(DeviceLoss, WithinASnapshotWritesTheOneBefore) {
  const Finished finished = render_until_loss("3");
  expect_error(finished, 4, {device()->info().name, "lost", "out.exr holds what was rendered"});
  expect_first_snapshot(gltf(), exr(), folder_.path());
}

// While the scene goes to the device, and within the very first snapshot.
TEST_F(DeviceLoss, BeforeAnythingWasRenderedLeavesTheOldPicture) {
  for (const char* downloads : {"0", "1"}) {
    std::ofstream(exr()) << "the old picture";
    expect_error(render_until_loss(downloads), 4, {device()->info().name, "lost"});
    std::ifstream file(exr());
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "the old picture");
  }
}

}  // namespace
}  // namespace regulus::test

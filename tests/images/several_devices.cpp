// One picture by two devices of one kind: the bits of one alone, whoever renders which samples, and whoever
// is lost.
#include "session/several_devices.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "images/support/gltf_scene.hpp"
#include "images/support/render_scene.hpp"
#include "render/film_file.hpp"
#include "session/sample_split.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;

class SeveralDevices : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    GltfScene scene;
    scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
    scene.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({6, 6, 5}));
    scene.set_perspective(look_at({0, 1, 2.5}, {0, 0.3, 0}), 0.8);
    prepared_ = prepare(scene);
    settings_ = box_filtered(12, 8, 7, 4);
    settings_.first_sample = 2;
    settings_.techniques = TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT;
    const std::string index = std::to_string(device()->info().index);
    for (auto& one : devices_) one = std::make_unique<gpu::Device>(gpu::DeviceOptions{.select = index});
  }
  void TearDown() override { gpu::faults() = {}; }

  session::Result render_on_both(const std::string& split) const {
    const std::array<gpu::Device*, 2> devices = {devices_[0].get(), devices_[1].get()};
    session::Watcher watcher;
    return render_on_devices(prepared_, make_plan(prepared_, settings_), {}, devices, split, watcher);
  }
  void expect_bits_of_one(const session::Result& found) const {
    const render::Film expected = render(prepared_, settings_).film;
    EXPECT_EQ(found.film->words, expected.words);
    EXPECT_EQ(found.film->splat_words, expected.splat_words);
    EXPECT_EQ(found.film->paths, expected.paths);
    EXPECT_EQ(found.film->light_paths, expected.light_paths);
    EXPECT_TRUE(found.is_complete);
    EXPECT_FALSE(found.failure);
  }

  PreparedScene prepared_;
  render::RenderSettings settings_;
  std::array<std::unique_ptr<gpu::Device>, 2> devices_;
};

TEST_F(SeveralDevices, OfOneKindHaveTheBitsOfOne) {
  const session::Result found = render_on_both("");
  expect_bits_of_one(found);
  const std::string split = found.attributes.at("regulus:split");
  session::require_whole(session::parse_split(split), {2, 7}, 2);
  expect_bits_of_one(render_on_both(split));
  const session::Result given = render_on_both("1=2:1,0=3:4,1=7:2");
  EXPECT_EQ(given.attributes.at("regulus:split"), "1=2:1,0=3:4,1=7:2");
  expect_bits_of_one(given);
}

// Light paths of an iteration first, and radii that shrink from sample to sample.
TEST_F(SeveralDevices, MergeAlike) {
  settings_.techniques = *settings_.techniques | TECHNIQUE_MERGE;
  settings_.merge_radius = 0.1F;
  settings_.samples = 4;
  expect_bits_of_one(render_on_both("0=2:1,1=3:1,0=4:2"));
}

TEST_F(SeveralDevices, TheOthersDoWhatALostOneHadBegun) {
  size_t losses = 0, losses_after_a_range = 0;
  for (uint32_t submissions = 4;; submissions += 6) {  // while its memory is set up, and while it renders
    ASSERT_LT(submissions, 1000u);
    gpu::faults().only_device = devices_[1].get();
    gpu::faults().submissions_before_loss = submissions;
    const session::Result found = render_on_both("1=2:1,0=3:1,1=4:5");
    gpu::faults() = {};
    expect_bits_of_one(found);
    if (found.warnings.empty()) break;
    EXPECT_NE(found.warnings[0].find("lost"), std::string::npos) << found.warnings[0];
    ++losses;
    losses_after_a_range += found.attributes.at("regulus:split").find("1=2:1,0=") == 0 ? 1 : 0;
    devices_[1] =
        std::make_unique<gpu::Device>(gpu::DeviceOptions{.select = std::to_string(device()->info().index)});
  }
  std::printf("lost %zu times, %zu of them after a range\n", losses, losses_after_a_range);
  EXPECT_GT(losses, losses_after_a_range);
  EXPECT_GT(losses_after_a_range, 0u);
}

TEST_F(SeveralDevices, AllOfThemLostIsAnError) {
  gpu::faults().lost_at_submit = true;
  try {
    render_on_both("");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
  }
}

/// Cancels a render on two devices once one of them has begun its second range.
class CancelsEarly : public session::Watcher {
 public:
  explicit CancelsEarly(uint64_t pixels) : pixels_(pixels) {}
  void progress(const session::Progress& progress) override {
    is_cancelled_ = progress.paths_done > 2 * pixels_ + progress.earlier_paths;
  }
  bool is_cancelled() override { return is_cancelled_; }

 private:
  uint64_t pixels_;
  bool is_cancelled_ = false;
};

// Which samples are done when it is cancelled is left to the clock; from there to the end they are those of
// one device. Twice, so that a state that has holes is gone on from as well.
TEST_F(SeveralDevices, GoOnFromTheirCheckpoint) {
  settings_.samples = 1500;
  const TemporaryFolder folder;
  const render::Plan plan = make_plan(prepared_, settings_);
  const auto go_on = [&](session::Watcher& watcher) {
    session::Job job;
    job.checkpoint = folder / "state.exr";
    if (std::filesystem::exists(job.checkpoint))
      job.earlier = session::read_checkpoint(job.checkpoint, prepared_.scene, plan);
    const std::array<gpu::Device*, 2> devices = {devices_[0].get(), devices_[1].get()};
    return render_on_devices(prepared_, plan, job, devices, "", watcher);
  };
  for (int round = 0; round < 2; ++round) {
    CancelsEarly watcher(plan.window().pixels());
    const session::Result part = go_on(watcher);
    EXPECT_FALSE(part.is_complete);
    // As a part it says which samples it holds.
    session::Job as_part;
    as_part.holds_sums = true;
    write_file_atomically(folder / "part.exr",
                          encode(part, plan, as_part, image::Format::Exr, {}, folder / "part.exr"));
    const session::Part read = session::read_part(folder / "part.exr");
    EXPECT_EQ(read.ranges, session::ranges_of(session::parse_split(part.attributes.at("regulus:split"))));
    EXPECT_TRUE(read.is_complete());
    std::printf("cancelled at %s\n", part.attributes.at("regulus:split").c_str());
  }
  session::Watcher watcher;
  const session::Result found = go_on(watcher);
  expect_bits_of_one(found);
  session::require_whole(session::parse_split(found.attributes.at("regulus:split")), {2, 1500}, 2);
}

TEST_F(SeveralDevices, GoOnFromAStateOfOneOfThem) {
  const render::Plan plan = make_plan(prepared_, settings_);
  render::RenderSettings first = settings_;
  first.samples = 3;
  session::Job job;
  job.earlier =
      session::Earlier{render(prepared_, first).film, plan.rays, {{2, 7}}, device()->info().name, ""};
  const std::array<gpu::Device*, 2> devices = {devices_[0].get(), devices_[1].get()};
  session::Watcher watcher;
  const session::Result found = render_on_devices(prepared_, plan, job, devices, "", watcher);
  expect_bits_of_one(found);
  const session::Share first_share = session::parse_split(found.attributes.at("regulus:split")).front();
  EXPECT_EQ(first_share.device, 0u);
  EXPECT_EQ(first_share.range.first, 2u);
  EXPECT_GE(first_share.range.count, 3u);
  const auto expect_refusal = [&](const char* mention) {
    try {
      render_on_devices(prepared_, plan, job, devices, "", watcher);
      FAIL() << mention;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::BadUsage);
      EXPECT_NE(std::string(error.what()).find(mention), std::string::npos) << error.what();
    }
  };
  job.earlier->devices = "another card";
  expect_refusal("another card");
  job.earlier->devices = device()->info().name;
  --job.earlier->film.paths;
  expect_refusal("within a sample");
}

// When the time is up there are whole samples of each pixel, and the sums are theirs. The one that has holes
// is as whole as the one that has none.
TEST_F(SeveralDevices, StopInTimeWithWholeSamples) {
  settings_.samples = 1'000'000;
  session::Job job;
  job.time_limit = 1;
  const std::array<gpu::Device*, 2> devices = {devices_[0].get(), devices_[1].get()};
  session::Watcher watcher;
  const session::Result found =
      render_on_devices(prepared_, make_plan(prepared_, settings_), job, devices, "", watcher);
  EXPECT_TRUE(found.is_complete);
  std::printf("%s in %.2f s\n", found.attributes.at("regulus:split").c_str(), found.seconds);
  render::Film expected;
  for (const session::SampleRange& range : found.ranges) {
    settings_.first_sample = static_cast<uint32_t>(range.first);
    settings_.samples = static_cast<uint32_t>(range.count);
    const render::Film film = render(prepared_, settings_).film;
    if (expected.paths == 0)
      expected = film;
    else
      render::add(expected, film);
  }
  EXPECT_EQ(found.film->paths, expected.paths);
  EXPECT_EQ(found.film->words, expected.words);
  EXPECT_EQ(found.film->splat_words, expected.splat_words);
  EXPECT_GT(expected.paths, found.film->pixels());
}

// A device takes no range that would end when half of the time that is left has gone, and none if a sample
// takes longer than that.
TEST(SampleSplit, KeepsToTheTime) {
  session::SampleSplit split({0, 1'000'000}, 2);
  const double sample_seconds[] = {0.01, 1.5}, limit = 10;
  double clock[] = {0, 0};
  bool ended[] = {false, false};
  while (!ended[0] || !ended[1]) {
    const size_t next = ended[0] || (!ended[1] && clock[1] < clock[0]) ? 1 : 0;
    const auto range = split.take(next, limit - clock[next]);
    ended[next] = !range;
    if (!range) continue;
    const double seconds = static_cast<double>(range->count) * sample_seconds[next];
    split.finish(next, *range, seconds);
    clock[next] += seconds;
  }
  for (size_t device = 0; device < 2; ++device) {
    EXPECT_LE(clock[device], limit);
    EXPECT_GT(clock[device], limit - 2 * sample_seconds[device]);
  }
  // Late as it may be, there is a sample.
  session::SampleSplit late({0, 4}, 1);
  const auto one = late.take(0, -1);
  ASSERT_TRUE(one);
  EXPECT_FALSE(late.take(0, -1));
  late.lose(0, one);
  EXPECT_TRUE(late.take(0, -1));
}

TEST(SampleSplit, GivesOutWhatIsLeft) {
  session::SampleSplit split({10, 20}, 1, {{0, {12, 3}}, {0, {20, 1}}, {0, {21, 9}}});
  while (const auto range = split.take(0)) split.finish(0, *range, 1);
  session::require_whole(split.finished(), {10, 20}, 1);
}

// By speed: the faster one gets more, nothing twice, nothing left out.
TEST(SampleSplit, GivesOutEachSampleOnceAndMoreToTheFaster) {
  session::SampleSplit split({10, 1000}, 2);
  std::array<uint64_t, 2> counts{};
  std::array<double, 2> clock{};
  while (true) {
    const size_t next = clock[0] <= clock[1] ? 0 : 1;
    const auto range = split.take(next);
    if (!range) break;
    const double seconds = static_cast<double>(range->count) * (next == 0 ? 0.03 : 0.01);
    split.finish(next, *range, seconds);
    clock[next] += seconds;
    counts[next] += range->count;
  }
  session::require_whole(split.finished(), {10, 1000}, 2);
  // Three times as fast; both end within the last range, which takes less than a tenth of all.
  EXPECT_NEAR(static_cast<double>(counts[1]) / static_cast<double>(counts[0]), 3, 0.3);
  EXPECT_NEAR(clock[0] / clock[1], 1, 0.1);
}

TEST(SampleSplit, WhatALostDeviceHadTakenComesBack) {
  session::SampleSplit split({{0, {0, 4}}, {1, {4, 4}}, {1, {8, 2}}}, 2);
  const auto lost = split.take(1);
  ASSERT_TRUE(lost);
  split.lose(1, lost);
  uint64_t samples = 0;
  while (const auto range = split.take(0)) {
    split.finish(0, *range, 1);
    samples += range->count;
  }
  EXPECT_EQ(samples, 10u);
  EXPECT_EQ(session::format_split(split.finished()), "0=0:10");
}

}  // namespace
}  // namespace regulus::test

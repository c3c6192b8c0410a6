// Parts of a render from the outside: --samples, --crop, merge, rays and devices of the record.
#include "cli/render_parts.hpp"

#include <algorithm>
#include <fstream>
#include <random>

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

TEST_F(RenderParts, MergedRangesAreTheirUnionBitByBit) {
  const std::vector<const char*> integrators =
      is_slow_device() ? std::vector{"pt"} : std::vector{"pt", "vcm"};
  for (const char* integrator : integrators) {
    const Arguments own = {"-i", integrator, "--aov", "variance,samples,Z,direct,lights"};
    const auto part = [&](const std::string& output, const std::string& range) {
      Arguments arguments = own;
      arguments.insert(arguments.end(), {"--samples", range});
      render(output, arguments);
    };
    part("all.exr", "0:7");
    part("a.exr", "0:2");
    part("b.exr", "2:4");
    part("c.exr", "6:1");
    for (const char* merged : {"bc.exr", "merged.exr"})
      fs::remove(file(merged));  // never replaced, see below
    ASSERT_EQ(run({"merge", file("bc.exr"), file("c.exr"), file("b.exr")}).status,
              0);  // merged parts are parts
    const Finished merged = run({"merge", file("merged.exr"), file("bc.exr"), file("a.exr")});
    ASSERT_EQ(merged.status, 0) << merged.err;
    const image::ExrContents all = contents("all.exr"), sum = contents("merged.exr");
    EXPECT_TRUE(all.channels == sum.channels) << integrator;
    EXPECT_EQ(sum.attributes.at("regulus:sample_ranges"), "0:7");
    EXPECT_EQ(sum.attributes.at("regulus:samples_done"), "7");
    // And the picture is that of a plain render.
    Arguments plain = own;
    plain.insert(plain.end(), {"--spp", "7"});
    render("plain.exr", plain);
    for (const char* name : {"R", "G", "B", "variance.G", "samples", "Z"})
      EXPECT_TRUE(contents("plain.exr").channels.at(name) == sum.channels.at(name)) << name;
    EXPECT_FALSE(contents("plain.exr").channels.contains("film.sum.R0")) << "sums are for parts alone";
  }
}

// What one part was asked for another one chose, or took from the first: done alike, they are one render.
TEST_F(RenderParts, BelongTogetherByWhatWasDone) {
  for (const char* name : {"a.exr", "b.exr", "merged.exr"}) fs::remove(file(name));
  render("a.exr", {"-i", "bpt", "--samples", "0:2"});
  render("b.exr", {"--settings-from", file("a.exr"), "--samples", "2:1"});
  const Finished merged = run({"merge", file("merged.exr"), file("a.exr"), file("b.exr")});
  ASSERT_EQ(merged.status, 0) << merged.err;
  render("all.exr", {"-i", "bpt", "--samples", "0:3"});
  EXPECT_TRUE(contents("all.exr").channels == contents("merged.exr").channels);
}

TEST_F(RenderParts, WhatDoesNotBelongTogetherIsRefused) {
  render("a.exr", {"--samples", "0:2"});
  render("overlapping.exr", {"--samples", "1:2"});
  render("seed.exr", {"--samples", "2:2", "--seed", "3"});
  render("plain.exr", {"-s", "2"});
  const auto merge = [&](const std::string& other) {
    return run({"merge", file("out.exr"), file("a.exr"), file(other)});
  };
  expect_error(merge("overlapping.exr"), 3, {"a.exr", "overlapping.exr", "sample 1"});
  expect_error(merge("seed.exr"), 3, {"a.exr", "seed.exr", "seed"});
  expect_error(merge("plain.exr"), 3, {"plain.exr", "range of samples"});
  expect_error(merge("none.exr"), 3, {"none.exr"});
  expect_error(run(command("x.exr", {"--samples", "0:2", "-s", "2"})), 2, {"--samples"});
  expect_error(run(command("x.exr", {"--samples", "2"})), 2, {"--samples 2"});
  expect_error(run(command("x.exr", {"--crop", "0,0,25,16"})), 2, {"--crop 0,0,25,16"});
  expect_error(run(command("x.exr", {"--aov", "albedo,beauty"})), 2, {"beauty"});
  expect_error(run(command("x.exr", {"--resume"})), 2, {"--checkpoint"});
  expect_error(run(command("x.exr", {"-s", "2", "--checkpoint", file("a.exr")})), 2, {"--resume"});
  const auto resume = [&](const std::string& from, const Arguments& more) {
    Arguments arguments = {"--checkpoint", file(from), "--resume"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(command("x.exr", arguments));
  };
  expect_error(resume("a.exr", {"-s", "4", "--seed", "3"}), 3, {"a.exr", "seed"});
  expect_error(resume("a.exr", {"-s", "1"}), 2, {"a.exr", "2 samples"});
  expect_error(resume("overlapping.exr", {"-s", "4"}), 3, {"overlapping.exr"});
  expect_error(resume("plain.exr", {"-s", "4"}), 3, {"plain.exr"});
  expect_error(resume("scene.gltf", {"-s", "4"}), 2, {"scene.gltf", "is the scene"});
  std::ofstream(file("text.exr")) << "no picture";
  expect_error(resume("text.exr", {"-s", "4"}), 3, {"text.exr"});
  EXPECT_FALSE(fs::exists(file("out.exr")));
  EXPECT_FALSE(fs::exists(file("x.exr")));
}

TEST_F(RenderParts, ACropIsPlacedOnTheFilm) {
  render("all.exr", {"-s", "2"});
  render("crop.exr", {"-s", "2", "--crop", "5,3,17,14"});
  const image::ExrContents all = contents("all.exr"), crop = contents("crop.exr");
  EXPECT_EQ(all.placement.x + all.placement.y, 0u);
  EXPECT_EQ(crop.width, 12u);
  EXPECT_EQ(crop.height, 11u);
  EXPECT_EQ(crop.placement.x, 5u);
  EXPECT_EQ(crop.placement.y, 3u);
  EXPECT_EQ(crop.placement.film_width, 24u);
  EXPECT_EQ(crop.placement.film_height, 16u);
  const auto& whole = std::get<std::vector<float>>(all.channels.at("G"));
  const auto& part = std::get<std::vector<float>>(crop.channels.at("G"));
  for (size_t i = 0; i < part.size(); ++i) EXPECT_EQ(part[i], whole[(i / 12 + 3) * 24 + i % 12 + 5]);
}

// A film that is rendered in bands, as one that is larger than a buffer of the device, is that of one piece.
TEST_F(RenderParts, BandsAreThePictureOfOnePiece) {
  const Arguments own = {"-i",    is_slow_device() ? "pt" : "bpt", "-s", "3",
                         "--aov", "variance,samples,P,material"};
  render("whole.exr", own);
  Arguments in_bands = own;
  in_bands.insert(in_bands.end(), {"--band", "100"});  // four rows of 24 pixels
  render("bands.exr", in_bands);
  EXPECT_TRUE(contents("whole.exr").channels == contents("bands.exr").channels);
  EXPECT_EQ(contents("bands.exr").attributes.at("regulus:samples_done"), "3");
  EXPECT_EQ(contents("bands.exr").attributes.at("regulus:rays"),
            contents("whole.exr").attributes.at("regulus:rays"));
  in_bands.insert(in_bands.end(), {"--crop", "3,2,20,15"});
  render("crop.exr", in_bands);
  EXPECT_EQ(contents("crop.exr").placement.y, 2u);
  EXPECT_EQ(contents("crop.exr").height, 13u);
  expect_error(run(command("x.exr", {"--band", "100", "--time", "1"})), 2, {"time", "crops"});
}

std::string read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// `merge a.exr b.exr` lacks an output, and took a.exr for it.
TEST_F(RenderParts, MergeDestroysNoPartAndNothingElseUnasked) {
  render("a.exr", {"--samples", "0:1"});
  render("b.exr", {"--samples", "1:1"});
  const std::string a = read_file(file("a.exr")), b = read_file(file("b.exr"));
  const auto merge = [&](const std::string& output, Arguments more = {}) {
    Arguments arguments = {"merge", file(output), file("a.exr"), file("b.exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  expect_error(run({"merge", file("a.exr"), file("b.exr")}), 2, {"a.exr", "is a part"});
  expect_error(run({"merge", file("a.exr"), file("b.exr"), "--force"}), 2, {"a.exr", "is a part"});
  fs::create_hard_link(file("a.exr"), file("hard.exr"));
  fs::create_symlink("b.exr", file("link.exr"));
  for (const char* name : {"a.exr", "b.exr", "hard.exr", "link.exr"}) {
    expect_error(merge(name), 2, {name, "one of the parts"});
    expect_error(merge(name, {"--force"}), 2, {name, "one of the parts"});
  }
  std::ofstream(file("other.exr")) << "someone's";
  expect_error(merge("other.exr"), 2, {"other.exr", "--force"});
  EXPECT_EQ(read_file(file("other.exr")), "someone's");
  EXPECT_EQ(merge("other.exr", {"--force"}).status, 0);
  EXPECT_EQ(contents("other.exr").attributes.at("regulus:sample_ranges"), "0:2");
  EXPECT_EQ(read_file(file("a.exr")), a);
  EXPECT_EQ(read_file(file("b.exr")), b);
  EXPECT_EQ(merge("all.jpg").status, 0);
  EXPECT_TRUE(read_file(file("all.jpg")).starts_with("\xff\xd8\xff"));
  expect_error(merge("all.tif"), 2, {"all.tif", ".exr"});
  expect_error(merge("none/all.exr"), 1, {"none/all.exr"});
}

// What a header says is trusted as far as its checksum goes: a flipped range was merged without a word.
TEST_F(RenderParts, DamagedPartsAreRefused) {
  render("a.exr", {"--samples", "0:4"});
  render("b.exr", {"--samples", "4:4", "--aov", "Z"});
  render("c.exr", {"--samples", "4:4"});
  const auto damage = [&](const std::string& from, const std::string& to) {
    std::string bytes = read_file(file("c.exr"));
    const size_t at = bytes.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    ASSERT_EQ(from.size(), to.size());
    bytes.replace(at, from.size(), to);
    std::ofstream(file("damaged.exr"), std::ios::binary) << bytes;
  };
  ASSERT_EQ(run({"merge", file("whole.exr"), file("a.exr"), file("c.exr")}).status, 0);
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"4:4", "5:4"},
                                                        {"4:4", "4:5"},
                                                        {"film.sum.R0", "film.sum.S0"},
                                                        {"regulus:paths", "regulus:pathz"},
                                                        {"regulus:checksum", "regulus:checksun"},
                                                        {"regulus:seed", "regulus:sead"}}) {
    damage(from, to);
    expect_error(run({"merge", file("out.exr"), file("a.exr"), file("damaged.exr")}), 3, {"damaged.exr"});
    expect_error(run(command("out.exr", {"--checkpoint", file("damaged.exr"), "--resume", "-s", "16"})), 3,
                 {"damaged.exr"});
  }
  EXPECT_FALSE(fs::exists(file("out.exr")));
}

// Four tiles, one of them in two ranges of samples, are the whole, bit by bit.
TEST_F(RenderParts, MergedCropsAreTheWholeBitByBit) {
  const std::string integrator = is_slow_device() ? "pt" : "bpt";  // whose splats cross the edges of crops
  const auto part = [&](const std::string& name, const std::string& crop, const std::string& samples) {
    Arguments more = {"-i", integrator, "--samples", samples, "--aov", "variance,Z,material"};
    if (!crop.empty()) more.insert(more.end(), {"--crop", crop});
    render(name + ".exr", more);
    return file(name + ".exr");
  };
  const std::string whole = part("whole", "", "0:3");
  const std::string a = part("a", "0,0,10,16", "0:3"), b = part("b", "10,0,24,7", "0:1"),
                    b2 = part("b2", "10,0,24,7", "1:2"), c = part("c", "10,7,24,16", "0:3");
  const auto merge = [&](const Arguments& parts) {
    fs::remove(file("joined.exr"));
    Arguments arguments = {"merge", file("joined.exr")};
    arguments.insert(arguments.end(), parts.begin(), parts.end());
    return run(arguments);
  };
  const Finished merged = merge({c, b2, a, b});
  ASSERT_EQ(merged.status, 0) << merged.err;
  const image::ExrContents joined = contents("joined.exr"), known = contents("whole.exr");
  EXPECT_TRUE(joined.channels == known.channels) << integrator;
  for (const char* name :
       {"regulus:crop", "regulus:sample_ranges", "regulus:paths", "regulus:light_paths_done"})
    EXPECT_EQ(joined.attributes.at(name), known.attributes.at(name)) << name;
  // The right half is a crop again.
  ASSERT_EQ(merge({b, b2, c}).status, 0);
  EXPECT_EQ(contents("joined.exr").placement.x, 10u);
  EXPECT_EQ(contents("joined.exr").attributes.at("regulus:crop"), "[10,0,24,16]");
  expect_error(merge({a, b, b2}), 3, {"gaps"});
  expect_error(merge({a, b, c}), 3, {"different samples"});
  expect_error(merge({a, b, b2, c, whole}), 3, {"overlap"});
}

// Guides are functions of the scene, the camera and the whole film: tiles, ranges and a resumed render train
// the same.
TEST_F(RenderParts, GuidedPartsAreTheWholeBitByBit) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const auto guided = [&](const std::string& name, Arguments more) {
    more.insert(more.end(), {"-i", "bpt", "--guide-light", "on", "--guide", "on"});
    render(name, more);
    return file(name);
  };
  const std::string whole = guided("whole.exr", {"--samples", "0:3"});
  const std::string left = guided("left.exr", {"--samples", "0:3", "--crop", "0,0,10,16"});
  const std::string first = guided("first.exr", {"--samples", "0:1", "--crop", "10,0,24,16"});
  const std::string rest = guided("rest.exr", {"--samples", "1:2", "--crop", "10,0,24,16"});
  const Finished merged = run({"merge", file("joined.exr"), rest, left, first});
  ASSERT_EQ(merged.status, 0) << merged.err;
  const image::ExrContents known = contents("whole.exr");
  EXPECT_TRUE(contents("joined.exr").channels == known.channels);
  guided("begun.exr", {"-s", "1", "--checkpoint", file("state.exr")});
  guided("resumed.exr", {"-s", "3", "--checkpoint", file("state.exr"), "--resume"});
  guided("plain.exr", {"-s", "3"});
  EXPECT_TRUE(contents("resumed.exr").channels == contents("plain.exr").channels);
  // The guides did something, and who has none, or one of them, is another render.
  render("unguided.exr", {"-i", "bpt", "--samples", "3:1"});
  for (const char* guide : {"regulus:light_guide", "regulus:walk_guide"}) {
    EXPECT_EQ(contents("unguided.exr").attributes.at(guide), "off");
    EXPECT_NE(known.attributes.at(guide), "off");
  }
  expect_error(run({"merge", file("out.exr"), whole, file("unguided.exr")}), 3,
               {"unguided.exr", "light_guide"});
  render("lights.exr", {"-i", "bpt", "--samples", "3:1", "--guide-light", "on"});
  expect_error(run({"merge", file("out.exr"), whole, file("lights.exr")}), 3, {"lights.exr", "walk_guide"});
  expect_error(
      run(command("out.exr", {"-i", "bpt", "-s", "4", "--checkpoint", file("state.exr"), "--resume"})), 3,
      {"state.exr", "light_guide"});
}

// A flipped bit, wherever it is, is found, or changes nothing that is merged.
TEST_F(RenderParts, FlippedBitsNeverMergeIntoAnotherPicture) {
  render("a.exr", {"--samples", "0:2"});
  render("b.exr", {"--samples", "2:2"});
  ASSERT_EQ(run({"merge", file("whole.exr"), file("a.exr"), file("b.exr")}).status, 0);
  const image::ExrContents whole = contents("whole.exr");
  const std::string bytes = read_file(file("b.exr"));
  const size_t header = bytes.find("regulus:width");
  ASSERT_NE(header, std::string::npos);
  std::minstd_rand random(17);
  constexpr int FLIPS = 60;
  int refused = 0;
  for (int i = 0; i < FLIPS; ++i) {
    std::string damaged = bytes;
    // Half of them in the header.
    const size_t at = random() % (i % 2 == 0 ? std::min(bytes.size(), header + 500) : bytes.size());
    damaged[at] = static_cast<char>(damaged[at] ^ 1 << random() % 8);
    std::ofstream(file("damaged.exr"), std::ios::binary) << damaged;
    fs::remove(file("out.exr"));
    const Finished merged = run({"merge", file("out.exr"), file("a.exr"), file("damaged.exr")});
    EXPECT_EQ(merged.signal, 0);
    if (merged.status == 3) {
      ++refused;
      continue;
    }
    ASSERT_EQ(merged.status, 0) << "byte " << at << ": " << merged.err;
    const image::ExrContents out = contents("out.exr");
    EXPECT_TRUE(out.channels == whole.channels) << "byte " << at;
    EXPECT_EQ(out.attributes.at("regulus:sample_ranges"), "0:4") << "byte " << at;
  }
  std::printf("%d of %d flips refused, the others changed nothing\n", refused, FLIPS);
  EXPECT_GT(refused, FLIPS / 3);
}

// Who traces rays decides ties: what one has begun the same one goes on with.
TEST_F(RenderParts, RaysAreThoseOfTheRecord) {
  if (device()->info().kind != gpu::DeviceKind::Software) GTEST_SKIP() << "not a software device";
  const auto rays_in = [&](const std::string& name) { return contents(name).attributes.at("regulus:rays"); };
  render("auto.exr", {"--samples", "0:1", "--rays", "auto"});
  render("host.exr", {"--samples", "1:1", "--rays", "host"});
  render("kernels.exr", {"--samples", "1:1", "--rays", "software"});
  EXPECT_EQ(rays_in("auto.exr"), "host");
  EXPECT_EQ(rays_in("kernels.exr"), "software");
  EXPECT_EQ(run({"merge", file("sum.exr"), file("auto.exr"), file("host.exr")}).status, 0);
  expect_error(run({"merge", file("sum2.exr"), file("auto.exr"), file("kernels.exr")}), 3,
               {"rays is host and software"});

  render("x.exr", {"-s", "1", "--checkpoint", file("state.exr"), "--rays", "software"});
  render("x.exr", {"-s", "2", "--checkpoint", file("state.exr"), "--resume", "--rays", "auto"});
  EXPECT_EQ(rays_in("x.exr"), "software");
  expect_error(
      run(command("x.exr", {"-s", "3", "--checkpoint", file("state.exr"), "--resume", "--rays", "host"})), 3,
      {"state.exr", "rays is software and host"});
}

// Rays of the device's own queries likewise; where there are none they are refused.
TEST_F(RenderParts, HardwareRaysAreThoseOfTheRecord) {
  if (!device()->info().has_ray_query) {
    expect_error(run(command("x.exr", {"-s", "1", "--rays", "hardware"})), 2,
                 {"--rays hardware", "lacks VK_KHR_ray_query", "--rays software"});
    return;
  }
  const auto rays_in = [&](const std::string& name) { return contents(name).attributes.at("regulus:rays"); };
  render("a.exr", {"--samples", "0:1", "--rays", "hardware", "--checkpoint", file("state.exr")});
  render("b.exr", {"--samples", "1:1", "--rays", "hardware"});
  render("kernels.exr", {"--samples", "1:1", "--rays", "software"});
  EXPECT_EQ(rays_in("a.exr"), "hardware");
  EXPECT_EQ(run({"merge", file("sum.exr"), file("a.exr"), file("b.exr")}).status, 0);
  expect_error(run({"merge", file("sum2.exr"), file("a.exr"), file("kernels.exr")}), 3,
               {"rays is hardware and software"});
  render("x.exr", {"-s", "2", "--checkpoint", file("state.exr"), "--resume", "--rays", "auto"});
  EXPECT_EQ(rays_in("x.exr"), "hardware");
  render("whole.exr", {"-s", "2", "--rays", "hardware"});
  EXPECT_TRUE(contents("x.exr").channels == contents("whole.exr").channels);
  render("part.exr", {"--samples", "0:2", "--rays", "hardware"});
  EXPECT_TRUE(contents("sum.exr").channels == contents("part.exr").channels);
}

// Devices of different drivers, those that cmake/drivers got: the record, repeated, has the same bits, and
// its parts are those that each device renders alone.
TEST_F(RenderParts, DevicesOfSeveralDriversShareARender) {
  const fs::path drivers = fs::path(REGULUS_SOURCE_DIR) / "build/drivers";
  const std::string first = drivers / "L25/icd.json", second = drivers / "SW/icd.json";
  if (!fs::exists(first) || !fs::exists(second)) GTEST_SKIP() << "no two drivers in " << drivers;
  const Environment both = {{"VK_DRIVER_FILES", first + ":" + second},
                            {"VK_ICD_FILENAMES", first + ":" + second}};
  const auto render_on_both = [&](const std::string& output, const Arguments& more) {
    const Finished finished = run(command(output, more), both);
    ASSERT_EQ(finished.status, 0) << finished.err;
  };
  const Arguments own = {"--rays", "software", "--samples", "3:9"};
  const auto with = [&](Arguments more) {
    more.insert(more.end(), own.begin(), own.end());
    return more;
  };
  render_on_both("a.exr", with({"--device", "all"}));
  const image::ExrContents a = contents("a.exr");
  const std::string split = a.attributes.at("regulus:split");
  std::printf("%s on %s\n", split.c_str(), a.attributes.at("regulus:device").c_str());
  EXPECT_NE(a.attributes.at("regulus:device").find("; "), std::string::npos);
  EXPECT_EQ(a.attributes.at("regulus:samples_done"), "9");
  render_on_both("again.exr", with({"--device", "0,1", "--split", split}));
  EXPECT_TRUE(a.channels == contents("again.exr").channels);

  render_on_both("given.exr", with({"--device", "0,1", "--split", "1=3:2,0=5:7"}));
  EXPECT_EQ(contents("given.exr").attributes.at("regulus:split"), "1=3:2,0=5:7");
  render_on_both("part1.exr", {"--device", "1", "--rays", "software", "--samples", "3:2"});
  render_on_both("part0.exr", {"--device", "0", "--rays", "software", "--samples", "5:7"});
  ASSERT_EQ(run({"merge", file("sum.exr"), file("part1.exr"), file("part0.exr")}).status, 0);
  EXPECT_TRUE(contents("given.exr").channels == contents("sum.exr").channels);

  for (const auto& [wrong, mention] :
       {std::pair("1=3:2,0=6:6", "sample 5"), std::pair("0=3:2,1=4:8", "sample 4"),
        std::pair("0=3:8", "ends"), std::pair("2=3:9", "device 2"), std::pair("0=3:9,", "expected"),
        std::pair("x", "expected")})
    expect_error(run(command("x.exr", with({"--device", "0,1", "--split", wrong})), both), 2,
                 {"--split", mention});
  expect_error(run(command("x.exr", {"--device", "0,1", "--noise", "0.1"}), both), 2,
               {"--device", "noise target"});
  expect_error(run(command("x.exr", {"--device", "0,1", "--time", "5", "--split", "0=0:4"}), both), 2,
               {"--split", "--time"});

  // For a while, then from the state that was left to more samples.
  render_on_both("timed.exr", {"--device", "0,1", "--time", "0.5"});
  EXPECT_GE(std::stoi(contents("timed.exr").attributes.at("regulus:samples_done")), 1);
  const Arguments resumed = {"--device",        "0,1",     "--rays", "software", "--checkpoint",
                             file("state.exr"), "--resume"};
  for (const char* samples : {"4", "9"}) {
    Arguments more = resumed;
    more.insert(more.end(), {"-s", samples});
    render_on_both("resumed.exr", more);
  }
  const image::Attributes all = contents("resumed.exr").attributes;
  EXPECT_EQ(all.at("regulus:samples_done"), "9");
  render_on_both("repeated.exr",
                 {"--device", "0,1", "--rays", "software", "-s", "9", "--split", all.at("regulus:split")});
  EXPECT_TRUE(contents("resumed.exr").channels == contents("repeated.exr").channels);
}

}  // namespace
}  // namespace regulus::test

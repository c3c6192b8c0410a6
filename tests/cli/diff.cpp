// regulus diff as a user runs it: what it prints and writes, and how it fails.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

class Diff : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, uint32_t width, uint32_t height, float value) const {
    image::write_exr(file(name), {width, height, std::vector<float>(size_t{3} * width * height, value)});
    return file(name);
  }

  TemporaryFolder folder_;
};

// (1.5 - 1)^2 = 0.25; over 1 + 0.01.
TEST_F(Diff, PrintsAndWritesEveryMetric) {
  const std::string a = write("a.exr", 6, 4, 1.5f), b = write("b.exr", 6, 4, 1);
  const Finished finished = run({"diff", a, b, "--json", file("d.json"), "--heat-map", file("heat.png")});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  std::ifstream stream(file("d.json"));
  const nlohmann::json json = nlohmann::json::parse(stream);
  EXPECT_EQ(json.size(), 10u);
  EXPECT_DOUBLE_EQ(json.at("mse"), 0.25);
  EXPECT_NEAR(json.at("relmse").get<double>(), 0.25 / 1.01, 1e-14);
  EXPECT_NEAR(json.at("mrse").get<double>(), 0.25 / 1.01, 1e-14);
  EXPECT_DOUBLE_EQ(json.at("mae"), 0.5);
  EXPECT_NEAR(json.at("psnr").get<double>(), 6.0206, 1e-4);
  EXPECT_GT(json.at("flip").get<double>(), 0.0);
  EXPECT_EQ(json.at("mean"), nlohmann::json({1.5, 1.5, 1.5}));
  EXPECT_EQ(json.at("reference_mean"), nlohmann::json({1.0, 1.0, 1.0}));
  EXPECT_EQ(json.at("non_finite"), 0);
  for (const auto& [name, value] : json.items())
    EXPECT_NE(finished.out.find(name.substr(0, name.find('_'))), std::string::npos) << name;
  EXPECT_GT(fs::file_size(file("heat.png")), 0u);
}

TEST_F(Diff, EqualImagesHaveNoError) {
  const std::string a = write("a.exr", 3, 5, 0.25f);
  const Finished finished = run({"diff", a, a, "--json", file("d.json")});
  EXPECT_EQ(finished.status, 0) << finished.err;
  std::ifstream stream(file("d.json"));
  const nlohmann::json json = nlohmann::json::parse(stream);
  for (const char* metric : {"mse", "relmse", "trimmed_relmse", "mrse", "mae", "flip"})
    EXPECT_EQ(json.at(metric), 0.0) << metric;
  EXPECT_TRUE(json.at("psnr").is_null()) << "infinite";
}

TEST_F(Diff, UnequalSizesAreABadFile) {
  const std::string a = write("a.exr", 6, 4, 1), b = write("b.exr", 4, 6, 1);
  expect_error(run({"diff", a, b, "--json", file("d.json")}), 3, {"a.exr", "b.exr", "6 x 4", "4 x 6"});
  EXPECT_FALSE(fs::exists(file("d.json")));
}

TEST_F(Diff, WhatIsNoImageIsABadFile) {
  const std::string a = write("a.exr", 6, 4, 1);
  std::ofstream(file("b.exr")) << "not an image";
  expect_error(run({"diff", a, file("b.exr")}), 3, {"b.exr"});
  expect_error(run({"diff", file("missing.exr"), a}), 3, {"missing.exr"});
  EXPECT_EQ(run({"diff", a}).status, 2);
}

}  // namespace
}  // namespace regulus::test

// regulus when an allocation fails: one line of error, and what was rendered before is written.
//
// The program is regulus with tests/cli/failing_new.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class WithoutMemory : public testing::Test {
 protected:
  void SetUp() override { write_lit_square(gltf()); }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  std::string exr() const { return (folder_ / "out.exr").string(); }

  unsigned long count_allocations(const Arguments& arguments, Environment environment) const {
    environment["REGULUS_TEST_COUNT_ALLOCATIONS"] = (folder_ / "count").string();
    EXPECT_EQ(run(arguments, environment).status, 0);
    unsigned long count = 0;
    std::ifstream(folder_ / "count") >> count;
    return count;
  }

  TemporaryFolder folder_;
};

// For less, the libraries of JSON and of the command line ask within functions that must not throw, such as
// destructors; no machine is that short of memory.
TEST_F(WithoutMemory, AnyAllocationMayFail) {
  constexpr unsigned long MOST_TRIALS = 60;  // of each command
  const Environment large = {{"REGULUS_TEST_LEAST_BYTES", "1024"}};
  for (const Arguments& arguments :
       {Arguments{"inspect", gltf()}, Arguments{"render", gltf(), "--backend", "reference", "--size", "4x4",
                                                "-s", "1", "-q", "-o", exr()}}) {
    const unsigned long count = count_allocations(arguments, large);
    ASSERT_GT(count, 30u);
    unsigned long trials = 0, errors = 0;
    for (unsigned long failing = 1; failing <= count;
         failing += std::max(1ul, count / MOST_TRIALS), ++trials) {
      std::ofstream(exr()) << "old";
      Environment environment = large;
      environment["REGULUS_TEST_FAILING_ALLOCATION"] = std::to_string(failing);
      const Finished finished = run(arguments, environment);
      SCOPED_TRACE(arguments[0] + ", allocation " + environment["REGULUS_TEST_FAILING_ALLOCATION"]);
      if (finished.status == 0) continue;  // something was done without
      ++errors;
      expect_error({finished.status, finished.signal, "", finished.err}, finished.status == 3 ? 3 : 1);
      EXPECT_EQ(std::filesystem::file_size(exr()), 3u) << "the old picture";
    }
    std::printf("%s: %lu allocations, of %lu that failed in turn %lu were errors\n", arguments[0].c_str(),
                count, trials, errors);
    EXPECT_GT(errors, 0u);
  }
}

// The film is downloaded again and again, 36 bytes a pixel; the fourth allocation of this size fails.
TEST_F(WithoutMemory, WhatWasRenderedBeforeIsWritten) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Finished finished = run({"render", gltf(), "--size", "256x256", "-s", "16000000", "-q", "-o", exr()},
                                {{"REGULUS_TEST_LEAST_BYTES", std::to_string(36 * 256 * 256)},
                                 {"REGULUS_TEST_FAILING_ALLOCATION", "4"}});
  expect_error(finished, 1, {"out of memory", "out.exr holds what was rendered before"});
  image::Attributes attributes;
  const image::Image image = image::read_exr(exr(), &attributes);
  EXPECT_GE(std::stoull(attributes.at("regulus:samples_done")), 1u);
  EXPECT_NEAR(image.rgb[3 * (128 * 256 + 128)], 0.5 / M_PI, 0.01);
}

}  // namespace
}  // namespace regulus::test

// Files that users' reports led to, whose pictures have a known mean: the reference's.
#include <gtest/gtest.h>

#include <cstdio>

#include "images/support/report_cases.hpp"
#include "reference/support/reference_images.hpp"

namespace regulus::test {
namespace {

TEST(ReferenceReportCases, MeansAreAsTheyShouldBe) {
  for (const ReportCase& c : report_cases()) {
    reference::Settings settings = reference_settings(c.size, c.size, c.samples, c.max_depth);
    settings.techniques = PT;
    settings.camera = c.camera;
    const double found = mean_of_part(render_reference(prepare(report_file(c)), settings), c.part);
    std::printf("%s: %.5f, known %.5f, bound %.1e\n", c.file, found, c.radiance, c.bound);
    EXPECT_NEAR(found, c.radiance, c.bound) << c.file;
  }
}

}  // namespace
}  // namespace regulus::test

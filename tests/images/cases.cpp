// Files that users' reports led to, whose pictures have a known mean.
#include <gtest/gtest.h>

#include <cstdio>

#include "images/support/render_scene.hpp"
#include "images/support/report_cases.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

TEST(ReportCases, MeansAreAsTheyShouldBe) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  for (const ReportCase& c : report_cases()) {
    render::RenderSettings settings = box_filtered(c.size, c.size, c.samples, c.max_depth);
    settings.camera = c.camera;
    settings.regularization = interface::REGULARIZATION_NONE;
    const double found = mean_of_part(render(prepare(report_file(c)), settings).image, c.part);
    std::printf("%s: %.5f, known %.5f, bound %.1e\n", c.file, found, c.radiance, c.bound);
    EXPECT_NEAR(found, c.radiance, c.bound) << c.file;
  }
}

}  // namespace
}  // namespace regulus::test

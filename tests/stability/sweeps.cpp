// The quick run of `regulus bench stability`: every family within its bounds on this device.
#include <gtest/gtest.h>

#include <cstdio>

#include "stability/report.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace stability;

class Stability : public testing::TestWithParam<std::string> {};

TEST_P(Stability, SweepsStayWithinTheirBounds) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const Report report = measure(*device(), Extent::Quick, {GetParam()}, nullptr);
  ASSERT_FALSE(report.sweeps.empty());
  for (const Sweep& sweep : report.sweeps) {
    std::printf("%-48s %6zu cases: device %.1e (%.2f of its bound), reference %.1e (%.2f), %zu lost\n",
                sweep.text().name.c_str(), sweep.cases(), sweep.worst_device(), sweep.device_ratio(),
                sweep.worst_reference(), sweep.reference_ratio(), sweep.lost());
    EXPECT_TRUE(sweep.holds()) << sweep.text().name << ": not finite " << sweep.non_finite_device() << " + "
                               << sweep.non_finite_reference() << "\n  device: " << sweep.worst_case()
                               << "\n  reference: " << sweep.worst_reference_case();
    EXPECT_LT(sweep.lost(), sweep.cases()) << sweep.text().name << " compares next to nothing";
  }
}

INSTANTIATE_TEST_SUITE_P(Family, Stability, testing::ValuesIn(family_names()),
                         [](const auto& family) { return family.param; });

}  // namespace
}  // namespace regulus::test

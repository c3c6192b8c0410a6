// What a sweep counts, on numbers made up for it: a bound that is left, a NaN, and inputs whose rounding says
// nothing.
#include <gtest/gtest.h>

#include <limits>

#include "stability/sweep.hpp"

namespace regulus::test {
namespace {

using namespace stability;

Sweep some_sweep() {
  return Sweep({"family", "name", "parameter", "bound", 1e-5, 1e-12, 1e-30});
}

void add(Sweep& sweep, const Measured& measured) {
  sweep.add(measured, [&] { return "case at " + std::to_string(measured.parameter); });
}

TEST(StabilitySweep, HoldsWithinOwnErrorAndWhatInputsMove) {
  Sweep sweep = some_sweep();
  add(sweep, {1, 2 * (1 + 0.9e-5), 2, 2, 0});
  add(sweep, {2, 2 * (1 + 1e-3), 2, 2, 2e-3});  // moved: 1e-3 of it
  EXPECT_TRUE(sweep.holds());
  EXPECT_NEAR(sweep.device_ratio(), 1e-3 / 1.01e-3, 1e-6);
  EXPECT_EQ(sweep.cases(), 2u);
}

TEST(StabilitySweep, NamesTheCaseThatLeavesItsBound) {
  Sweep sweep = some_sweep();
  add(sweep, {1, 2, 2, 2, 0});
  add(sweep, {3, 2 * (1 + 1.1e-5), 2, 2, 0});
  EXPECT_FALSE(sweep.holds());
  EXPECT_NE(sweep.worst_case().find("case at 3"), std::string::npos);
}

TEST(StabilitySweep, HoldsTheReferenceToDoublePrecision) {
  Sweep sweep = some_sweep();
  add(sweep, {1, 2, 2 * (1 + 1e-7), 2, 2e-3});  // what rounding to double moves is 2^-29 of that
  EXPECT_FALSE(sweep.holds());
  EXPECT_LT(sweep.device_ratio(), 1);
}

TEST(StabilitySweep, CountsWhatIsNotFiniteAndWhatIsLost) {
  Sweep sweep = some_sweep();
  add(sweep, {1, 2, 2, 2, 0});
  add(sweep, {2, 700, 2, 2, 1.5});  // rounding of the inputs moves it by 75 %
  EXPECT_TRUE(sweep.holds());
  EXPECT_EQ(sweep.lost(), 1u);
  add(sweep, {2, std::numeric_limits<double>::quiet_NaN(), 2, 2, 1.5});
  EXPECT_EQ(sweep.non_finite_device(), 1u);
  EXPECT_FALSE(sweep.holds());
}

TEST(StabilitySweep, FindsTheLongestAccurateRange) {
  Sweep sweep = some_sweep();
  for (const double parameter : {1, 2, 3, 4, 5, 6})
    add(sweep, {parameter, parameter == 2 ? 1.5 : 1.0, 1, 1, 0});
  EXPECT_EQ(sweep.accurate_range(0.01), std::pair(3.0, 6.0));
}

}  // namespace
}  // namespace regulus::test

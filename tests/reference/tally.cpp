// What `regulus check` lets pass: judged among all items, and in each class of them.
#include "check/tally.hpp"

#include <gtest/gtest.h>

namespace regulus::check {
namespace {

/// 5000 items of class "many", `wrong` of which differ, and `rare` of another, of which `rare_wrong` differ.
/// One of a thousand may.
Tally tally(int wrong, int rare, int rare_wrong, Difference kind = Difference::Real) {
  Tally result("items", 1e-4, 1e-3);
  for (int i = 0; i < 5000; ++i) result.add_error(i < wrong ? 1 : 0, 0, "many");
  for (int i = 0; i < rare; ++i) {
    if (i < rare_wrong)
      result.add_difference(kind, "rare");
    else
      result.add_error(0, 0, "rare");
  }
  return result;
}

TEST(Tally, AllowsAShareOfAll) {
  EXPECT_TRUE(tally(5, 0, 0).is_passed());
  EXPECT_FALSE(tally(6, 0, 0).is_passed());
}

// Five wrong ones would be allowed among 5005. All five of a class, or five of its forty, are a fault of that
// class; two of forty, where a hundredth of a class may differ, come by chance.
TEST(Tally, RareOnesDoNotHideInTheMany) {
  EXPECT_FALSE(tally(0, 5, 5).is_passed());
  EXPECT_NE(tally(0, 5, 5).line().find("class rare: of 5 items 0 ties, 5 real"), std::string::npos);
  EXPECT_FALSE(tally(0, 40, 7).is_passed());
  EXPECT_TRUE(tally(0, 40, 2).is_passed());
  EXPECT_TRUE(tally(0, 40, 1).is_passed());
  // Ties too: 30 of 5030 would pass for ordinary.
  EXPECT_FALSE(tally(0, 30, 30, Difference::Tie).is_passed());
  EXPECT_TRUE(tally(0, 30, 3, Difference::Tie).is_passed());
}

TEST(Tally, ClassesAddUp) {
  Tally sum("items", 1e-4, 1e-3);
  sum.add(tally(0, 3, 3));
  EXPECT_TRUE(sum.is_passed());  // three are too few to tell
  sum.add(tally(0, 3, 3));
  EXPECT_FALSE(sum.is_passed());
}

}  // namespace
}  // namespace regulus::check

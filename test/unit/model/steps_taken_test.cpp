#include "battery_sof/model/steps_taken.hpp"

#include <gtest/gtest.h>

using namespace battery_sof;

namespace {

/// Steps that an interval takes whose steps all end within the tolerance or all miss it. @param step [s], wanted throughout.
int stepsOf(double duration, double step, bool is_within) {
  StepsTaken taken;
  double left = duration;
  while (left > 0.0) {
    const double h = taken.next(left, step);
    if (taken.accept(h, is_within)) left -= h;
    if (!is_within && step > kShortestStep) step = step / 2.0 > kShortestStep ? step / 2.0 : kShortestStep;
  }
  return taken.tried;
}

}  // namespace

TEST(StepsTaken, AreAsManyAsTheToleranceAsksForInTheEnd) {
  EXPECT_EQ(stepsOf(1.0, 0.125, true), 8);
  EXPECT_EQ(stepsOf(1.0, 3.0, true), 1);
}

TEST(StepsTaken, AreFewWhereEvenTheShortestMissTheTolerance) { EXPECT_LT(stepsOf(1000.0, 1.0, false), kMostMissed + 40); }

TEST(StepsTaken, ComeToAnEndWhereAllAreWithinTheToleranceButShort) { EXPECT_EQ(stepsOf(1000.0, 1e-6, true), kMostTried + 1); }

TEST(StepsTaken, ThatMissTheToleranceAndCanBeShorterDoNotCount) {
  StepsTaken taken;
  EXPECT_FALSE(taken.accept(1.0, false));
  EXPECT_TRUE(taken.accept(kShortestStep, false));
  EXPECT_TRUE(taken.accept(1.0, true));
}

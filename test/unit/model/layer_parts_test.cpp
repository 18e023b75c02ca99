#include "model/layer_parts.hpp"

#include <gtest/gtest.h>

using namespace battery_sof;

namespace {

/// Steps that an interval takes whose steps all end within the tolerance or all miss it. @param
/// step [s], wanted throughout.
int stepsOf(double duration, double step, bool is_within) {
  LayerPace pace;
  StepsTaken taken(pace);
  double left = duration;
  while (left > 0.0) {
    const double h = taken.next(left, step);
    if (taken.accept(h, is_within)) left -= h;
    if (!is_within && step > kShortestStep)
      step = step / 2.0 > kShortestStep ? step / 2.0 : kShortestStep;
  }
  return taken.tried;
}

}  // namespace

TEST(StepsTaken, AreAsManyAsTheToleranceAsksForInTheEnd) {
  EXPECT_EQ(stepsOf(1.0, 0.125, true), 8);
  EXPECT_EQ(stepsOf(1.0, 3.0, true), 1);
}

TEST(StepsTaken, AreFewWhereEvenTheShortestMissTheTolerance) {
  EXPECT_LT(stepsOf(1000.0, 1.0, false), kMaxMissed + 40);
}

TEST(StepsTaken, ComeToAnEndWhereAllAreWithinTheToleranceButShort) {
  EXPECT_EQ(stepsOf(1000.0, 1e-6, true), kMaxTried + 1);
}

TEST(StepsTaken, ThatMissTheToleranceAndCanBeShorterDoNotCount) {
  LayerPace pace;
  StepsTaken taken(pace);
  EXPECT_FALSE(taken.accept(1.0, false));
  EXPECT_TRUE(taken.accept(kShortestStep, false));
  EXPECT_TRUE(taken.accept(1.0, true));
}

TEST(StepsTaken, BeyondTheUsualAreThoseOfAllIntervalsTogether) {
  LayerPace pace;
  int tried = 0;
  for (int interval = 0; interval < 100; ++interval) {
    StepsTaken taken(pace);
    while (!taken.areTooMany()) taken.accept(1e-6, true);
    tried += taken.tried;
  }
  EXPECT_EQ(pace.beyond, 0);
  EXPECT_EQ(tried, 100 * kUsualSteps + kMaxBeyond);
}

TEST(StepsTaken, UsualOnesLeaveWhatOthersMayTake) {
  LayerPace pace;
  StepsTaken taken(pace);
  for (int n = 0; n < kUsualSteps; ++n) taken.accept(1e-3, true);
  EXPECT_EQ(pace.beyond, kMaxBeyond);
}

#include "prediction/reasons.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

TEST(Reasons, TellTheVoltsOfARowAndNothingElseTimesItsBlocks) {
  const auto told = [](ReasonKind kind, const std::array<double, 5>& numbers) {
    return toString(Reason{kind, numbers, "the limit"}, 4.0);
  };
  EXPECT_EQ(
      told(ReasonKind::kMissedVoltage, {-0.5, 0.25}),
      "the model misses the present voltage by -2.00 V, more than the 1.00 V of its interval");
  EXPECT_EQ(told(ReasonKind::kMissedCrank, {8.0, 9.0, 9.5}),
            "the last crank reached 32.00 V, outside the predicted 36.00 to 38.00 V");
  EXPECT_EQ(told(ReasonKind::kVoltage, {15.0, 14.0}),
            "it goes to 60.00 V but the window's highest voltage was 56.00 V");
  EXPECT_EQ(told(ReasonKind::kNoVoltage, {-1.0, 16.0}),
            "its result is -4.00 V, expected 0 to 64 V for such a battery");
  EXPECT_EQ(
      told(ReasonKind::kWideSample, {6.0, 17.0, 16.0, 10.0, 7.0}),
      "sample 7: its 90 % interval of 24.00 to 68.00 V is of no use, expected inside 0 to 64 V "
      "and narrower than 40 V");
  EXPECT_EQ(told(ReasonKind::kHeldDiscrepancy, {0.02}),
            "the discrepancy is held at the end of its range, 80 mV from its extrapolated value");
  EXPECT_EQ(told(ReasonKind::kMissedCranks, {3.0, 0.2, 0.1}),
            "it misses the lowest voltages of the window's 3 cranks by 800 mV RMS, the baseline by "
            "400 mV");
  EXPECT_EQ(told(ReasonKind::kDischarge, {-500.0, -300.0}),
            "it draws -500 A but the window's largest discharge was -300 A");
  EXPECT_EQ(told(ReasonKind::kMovedCharge, {2.0, 1.0, 2.0, 50.0}),
            "it moves 2.00 Ah but the model supports at most 1.00 Ah (2 % of 50 Ah, or what the "
            "window moved if it determined how the open-circuit voltage follows the charge)");
}

TEST(Reasons, AreJoinedInTheirOrder) {
  const Reasons reasons = {{ReasonKind::kNoWindow}, {ReasonKind::kUndetermined, {}, "u_dc"}};
  EXPECT_EQ(
      toString(reasons, 1.0),
      "no window has been fitted yet, and charges need one; the window did not determine u_dc");
  EXPECT_EQ(toString(Reasons(), 1.0), "");
}

}  // namespace
}  // namespace battery_sof

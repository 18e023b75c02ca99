#include "recording/control_mode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// Ten samples a second apart, then five more after a gap of 100 s.
Series twoParts() {
  Series series;
  for (int n = 0; n < 15; ++n) {
    series.append({n < 10 ? n : n + 100.0, 0.0, 12.0});
  }
  return series;
}

/// Load, two reasons for a controlled voltage, load; behind the gap a controlled voltage up to the
/// end.
ControlModeOverview madeOverview() {
  constexpr auto kLoad = ControlModeReason::kLoad, kSource = ControlModeReason::kSource,
                 kHeld = ControlModeReason::kHeldVoltage;
  std::vector<ControlModeReason> reasons = {kLoad, kLoad, kSource, kSource, kHeld,
                                            kHeld, kHeld, kLoad,   kLoad};
  reasons.resize(15, kSource);
  return overviewOf(twoParts(), reasons, {});
}

TEST(ControlModeOverview, CountsStretchesAndSamplesByReason) {
  const auto totals = madeOverview().totals;
  ASSERT_EQ(totals.size(), 3u);
  EXPECT_EQ(totals[0].reason, toString(ControlModeReason::kLoad));
  EXPECT_EQ(totals[0].mode, ControlMode::kCurrent);
  EXPECT_EQ(totals[0].stretches, 2u);
  EXPECT_EQ(totals[0].samples, 4u);
  EXPECT_EQ(totals[1].reason, toString(ControlModeReason::kSource));
  EXPECT_EQ(totals[1].stretches, 3u);
  EXPECT_EQ(totals[1].samples, 8u);
  EXPECT_EQ(totals[2].reason, toString(ControlModeReason::kHeldVoltage));
}

TEST(ControlModeOverview, JoinsNeighboursOfOneJudgementAndEndsAtGaps) {
  const auto times = madeOverview().times;
  ASSERT_EQ(times.size(), 3u);
  EXPECT_EQ(times[0].from, 2.0);
  EXPECT_EQ(times[0].to, 7.0);
  EXPECT_EQ(times[1].from, 9.0);
  EXPECT_EQ(times[1].to, 9.0);
  EXPECT_EQ(times[2].from, 110.0);
  EXPECT_EQ(times[2].to, 114.0);
}

TEST(ControlModeOverview, OfAFoundSourceHoldsTheShareOfItsSamples) {
  test::Random random(3);
  Series series;
  for (int n = 0; n < 1200; ++n) {
    const bool is_load = n % 120 < 40;
    const double current =
        is_load ? -20.0 - 5.0 * std::sin(n / 3.0) : 3.0 + 40.0 * std::exp(-(n % 120 - 40) / 8.0);
    series.time.push_back(n);
    series.current.push_back(current + 0.1 * random.normal());
    series.voltage.push_back((is_load ? 12.4 + 0.008 * current : 14.2) + 0.012 * random.normal());
  }
  const ControlModeOverview overview = detectControlMode(series);
  double held = 0.0;
  for (const ControlledTime& time : overview.times) held += time.to - time.from;
  EXPECT_TRUE(overview.seen);
  EXPECT_NEAR(overview.share, 2.0 / 3.0, 0.02);
  EXPECT_NEAR(held / 1200.0, overview.share, 0.01);
}

TEST(ControlModeOverview, OfAnEmptySeriesIsEmpty) {
  const ControlModeOverview overview = detectControlMode({});
  EXPECT_FALSE(overview.seen);
  EXPECT_TRUE(overview.totals.empty());
  EXPECT_TRUE(overview.times.empty());
}

}  // namespace
}  // namespace battery_sof

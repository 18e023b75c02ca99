#include "recording/control_mode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

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
ControlModes madeSource() {
  ControlModes source;
  source.voltage_controlled.assign(15, 0);
  source.seen = true;
  source.share = 11.0 / 15.0;
  source.rule.max_gap = 5.0;
  source.stretches = {
      {{0, 2}, ControlMode::kCurrent, "load"},    {{2, 4}, ControlMode::kVoltage, "source"},
      {{4, 7}, ControlMode::kVoltage, "held"},    {{7, 9}, ControlMode::kCurrent, "load"},
      {{9, 10}, ControlMode::kVoltage, "source"}, {{10, 15}, ControlMode::kVoltage, "source"}};
  source.summary = "A source.";
  return source;
}

TEST(ControlModeOverview, CountsStretchesAndSamplesByReason) {
  const auto totals = totalsOf(madeSource());
  ASSERT_EQ(totals.size(), 3u);
  EXPECT_EQ(totals[0].reason, "held");
  EXPECT_EQ(totals[1].reason, "load");
  EXPECT_EQ(totals[1].mode, ControlMode::kCurrent);
  EXPECT_EQ(totals[1].stretches, 2u);
  EXPECT_EQ(totals[1].samples, 4u);
  EXPECT_EQ(totals[2].samples, 8u);
}

TEST(ControlModeOverview, JoinsNeighboursOfOneJudgementAndEndsAtGaps) {
  const auto times = overviewOf(madeSource(), twoParts()).voltage_controlled;
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
  const ControlModes source = detectControlMode(series);
  const ControlModeOverview overview = overviewOf(source, series);
  double held = 0.0;
  for (const ControlledTime& time : overview.voltage_controlled) held += time.to - time.from;
  EXPECT_TRUE(overview.seen);
  EXPECT_NEAR(overview.share, 2.0 / 3.0, 0.02);
  EXPECT_NEAR(held / 1200.0, overview.share, 0.01);
}

TEST(ControlModeOverview, OfAnEmptySeriesIsEmpty) {
  const ControlModeOverview overview = overviewOf(detectControlMode({}), {});
  EXPECT_FALSE(overview.seen);
  EXPECT_TRUE(overview.totals.empty());
  EXPECT_TRUE(overview.voltage_controlled.empty());
}

TEST(ControlModeOverview, RefusesAnotherSeries) {
  EXPECT_THROW(overviewOf(madeSource(), {}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

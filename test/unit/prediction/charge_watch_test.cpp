#include "prediction/event_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

constexpr double kMaxGap = 5.0;

/// Runs currents at 10 Hz past a watch whose tracker knows the battery, and counts what came of
/// them.
class Ride {
 public:
  std::vector<EventComparison> comparisons;

  void hold(double current, double duration) {
    for (long n = 0; n < std::lround(duration / 0.1); ++n) pass(current, 0.1);
  }
  void pass(double current, double interval) {
    time_ += interval;
    u_c2_ = step_.advance(u_c2_, 0.5 * (before_ + current), interval);
    before_ = current;
    const Sample sample{time_, current, test::terminalVoltage(drivenBattery(), current, u_c2_)};
    const WatchedSample at = watch_.advance(sample, tracker_, kMaxGap);
    if (const auto charge = watch_.charges.add(at)) comparisons.push_back(*charge);
    tracker_.follow(time_, current, sample.voltage);
  }
  void reset() { watch_.reset(); }

 private:
  test::BaseStep step_{drivenBattery()};
  StateTracker tracker_{knownModel(), kMaxGap};
  EventWatch watch_{EventLimits()};
  double time_ = 100.0, u_c2_ = 0.0, before_ = 0.0;
};

TEST(ChargeWatch, ComparesAChargeOnceAfterTenSeconds) {
  Ride run;
  run.hold(-10.0, 5.0);
  run.hold(40.0, 60.0);
  ASSERT_EQ(run.comparisons.size(), 1u);
  const EventComparison& charge = run.comparisons[0];
  EXPECT_NEAR(charge.time, 105.1, 1e-6);
  EXPECT_NEAR(charge.duration, 10.0, 0.11);
  EXPECT_NEAR(charge.measured, 40.0, 1e-9);
  EXPECT_NEAR(charge.expected.value, 40.0, 2.0);
  EXPECT_GT(charge.voltage, 12.9);
}

TEST(ChargeWatch, ComparesTheNextChargeAnew) {
  Ride run;
  for (int k = 0; k < 3; ++k) {
    run.hold(30.0, 15.0);
    run.hold(-20.0, 5.0);
  }
  EXPECT_EQ(run.comparisons.size(), 3u);
}

TEST(ChargeWatch, DropsAChargeOfLessThanTenSeconds) {
  Ride run;
  run.hold(40.0, 9.0);
  run.hold(1.9, 5.0);
  run.hold(40.0, 9.0);
  EXPECT_TRUE(run.comparisons.empty());
}

TEST(ChargeWatch, BeginsAnewBehindAGapAndAfterAReset) {
  Ride run;
  run.hold(40.0, 8.0);
  run.pass(40.0, 20.0);
  run.hold(40.0, 9.0);
  EXPECT_TRUE(run.comparisons.empty());
  run.hold(40.0, 3.0);
  EXPECT_EQ(run.comparisons.size(), 1u);

  Ride other;
  other.hold(40.0, 8.0);
  other.reset();
  other.hold(40.0, 8.0);
  EXPECT_TRUE(other.comparisons.empty());
}

}  // namespace
}  // namespace battery_sof

#include "estimation/depth_physics.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

/// A sample a minute, each of a current.
struct Minutes {
  Series series;
  Minutes& hold(int minutes, double current) {
    for (int n = 0; n < minutes; ++n)
      series.append({60.0 * static_cast<double>(series.size()), current, 12.5});
    return *this;
  }
  MovedCharge moved() const { return movedCharge(series, {0, series.size()}); }
};

TEST(MovedCharge, ADischargeMovesWhatItTakesOneWay) {
  const MovedCharge moved = Minutes().hold(31, 0.0).hold(120, -5.0).hold(30, 0.0).moved();
  EXPECT_NEAR(moved.span, 10.0, 1e-9);
  EXPECT_NEAR(moved.throughput, 10.0, 1e-9);
  EXPECT_TRUE(moved.isOneCycle());
  EXPECT_TRUE(moved.isDeep(100.0));
  EXPECT_FALSE(moved.isDeep(101.0));
}

TEST(MovedCharge, OneChargeAndOneDischargeAreOneCycleAndStopsOfACarAreNot) {
  EXPECT_TRUE(Minutes().hold(120, 5.0).hold(120, -5.0).moved().isOneCycle());
  Minutes car;
  for (int stop = 0; stop < 10; ++stop) car.hold(2, -30.0).hold(3, 20.0);
  EXPECT_FALSE(car.moved().isOneCycle());
}

TEST(MovedCharge, DepthCallsForTheEndsThatItHas) {
  using Effects = std::vector<std::string>;
  const MovedCharge both = Minutes().hold(120, 5.0).hold(120, -5.0).moved();
  EXPECT_EQ(physicsOfDepth(both, 50.0, true),
            (Effects{"ocv_soc", "acceptance_soc", "end_of_discharge"}));
  EXPECT_EQ(physicsOfDepth(both, 50.0, false), (Effects{"ocv_soc", "end_of_discharge"}));
  EXPECT_EQ(physicsOfDepth(both, 200.0, true), Effects());
  const MovedCharge filled = Minutes().hold(120, 5.0).moved();
  EXPECT_EQ(physicsOfDepth(filled, 50.0, true), (Effects{"ocv_soc", "acceptance_soc"}));
}

TEST(MovedCharge, AGapIsARest) {
  Minutes night;
  night.hold(60, -1.0);
  night.series.append({1e6, -1.0, 12.5});
  EXPECT_NEAR(night.moved().span, 59.0 / 60.0, 1e-9);
}

TEST(MovedCharge, TheCurrentIsLinearBetweenSamples) {
  EXPECT_NEAR(Minutes().hold(1, 0.0).hold(1, -6.0).moved().span, 0.05, 1e-12);
}

TEST(MovedCharge, AWindowOfOneSampleMovesNothing) {
  const Series series = Minutes().hold(10, -1.0).series;
  EXPECT_EQ(movedCharge(series, {4, 5}).span, 0.0);
  EXPECT_EQ(movedCharge(series, {4, 5}).throughput, 0.0);
}

TEST(MovedCharge, CountsTheLargestFallAndTheLargestRiseWhicheverComesFirst) {
  const MovedCharge down_first =
      Minutes().hold(31, 0.0).hold(120, -5.0).hold(1, 0.0).hold(36, 5.0).hold(1, 0.0).moved();
  EXPECT_NEAR(down_first.drawn, 10.0, 1e-9);
  EXPECT_NEAR(down_first.charged, 3.0, 1e-9);
  const MovedCharge up_first =
      Minutes().hold(31, 0.0).hold(120, 5.0).hold(1, 0.0).hold(36, -5.0).hold(1, 0.0).moved();
  EXPECT_NEAR(up_first.drawn, 3.0, 1e-9);
  EXPECT_NEAR(up_first.charged, 10.0, 1e-9);
  EXPECT_TRUE(up_first.isDrawnDeep(29.9));
  EXPECT_FALSE(up_first.isDrawnDeep(31.0));
  EXPECT_TRUE(up_first.isChargedDeep(99.9));
  EXPECT_FALSE(up_first.isChargedDeep(101.0));
}

TEST(DischargeUnderWay, BeginsBehindTheFirstTenthOfWhatWasDrawnSinceTheLastCharge) {
  const Series series = Minutes().hold(60, -5.0).hold(60, 5.0).hold(60, 0.0).hold(600, -5.0).series;
  const auto range = dischargeUnderWay(series, {0, series.size()}, 100.0);
  ASSERT_TRUE(range);
  EXPECT_EQ(range->last, series.size());
  EXPECT_NEAR(static_cast<double>(range->first), 180.0 + 60.0, 1.0);
}

TEST(DischargeUnderWay, IsNoneWhereItHasEndedOrIsShallow) {
  const auto found = [](const Series& series, double capacity) {
    return dischargeUnderWay(series, {0, series.size()}, capacity).has_value();
  };
  EXPECT_FALSE(found(Minutes().hold(600, -5.0).hold(1, 0.0).series, 100.0));
  EXPECT_FALSE(found(Minutes().hold(600, -5.0).hold(1, 5.0).series, 100.0));
  EXPECT_TRUE(found(Minutes().hold(1, 0.0).hold(600, -5.0).series, 449.0));
  EXPECT_FALSE(found(Minutes().hold(1, 0.0).hold(600, -5.0).series, 451.0));
  EXPECT_FALSE(found(Minutes().hold(1, -5.0).series, 1.0));
}

}  // namespace
}  // namespace battery_sof

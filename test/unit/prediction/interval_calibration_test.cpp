#include "prediction/interval_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

constexpr double kNinety = 1.6449;

/// Events with a standard deviation of 1, believed to be `claimed`.
IntervalCalibration estimated(double claimed, int events, std::uint64_t seed) {
  test::Random random(seed);
  IntervalCalibration scale;
  for (int n = 0; n < events; ++n) {
    const double half = kNinety * claimed * scale.factor;
    update(scale, random.normal(), {0.0, -half, half});
  }
  return scale;
}

TEST(IntervalCalibration, NineOfTenEventsComeToLieInsideHoweverWrongTheWidthsWere) {
  for (const double claimed : {0.2, 0.5, 1.0, 2.0, 5.0}) {
    const IntervalCalibration scale = estimated(claimed, 1000, 7);
    EXPECT_EQ(scale.events, 1000);
    // |ln(last / first)| / (eta n) bounds how far the share may be off.
    const double bound = std::abs(std::log(scale.factor)) / (0.25 * 1000) + 1e-9;
    EXPECT_NEAR(scale.inside / 1000.0, 0.9, bound) << claimed;
    EXPECT_NEAR(scale.inside / 1000.0, 0.9, 0.01) << claimed;
    EXPECT_NEAR(std::log(scale.factor * claimed), 0.0, 0.7) << claimed;
  }
}

TEST(IntervalCalibration, AnEventOutsideWidensAndOneInsideNarrows) {
  IntervalCalibration scale;
  update(scale, 5.0, {0.0, -1.0, 1.0});
  EXPECT_NEAR(scale.factor, std::exp(0.225), 1e-12);
  EXPECT_EQ(scale.inside, 0);
  update(scale, 0.5, {0.0, -1.0, 1.0});
  EXPECT_NEAR(scale.factor, std::exp(0.2), 1e-12);
  EXPECT_EQ(scale.inside, 1);
}

TEST(IntervalCalibration, StaysWithinItsBounds) {
  IntervalCalibration wide, narrow;
  for (int n = 0; n < 2000; ++n) {
    update(wide, 5.0, {0.0, -1.0, 1.0});
    update(narrow, 0.0, {0.0, -1.0, 1.0});
  }
  EXPECT_EQ(wide.factor, 50.0);
  EXPECT_EQ(narrow.factor, 0.1);
}

}  // namespace
}  // namespace battery_sof

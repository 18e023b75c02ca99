#include "recording/fit_mask.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using test::cleanDrive;

double chargeOf(const Series& series) {
  return 0.01 * std::accumulate(series.current.begin(), series.current.end(), 0.0);
}

Series clippedAt(double limit, Series series) {
  for (double& current : series.current) current = std::max(current, limit);
  return series;
}

TEST(ClippedCurrent, IsEstimatedToAThirdOfTheChargeThatWasCutOff) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Series truth = cleanDrive(seed), clipped = clippedAt(-150.0, truth);
    const Series estimated = withEstimatedCurrent(clipped, instrumentLimits(clipped));
    const double cut_off = chargeOf(clipped) - chargeOf(truth);
    ASSERT_GT(cut_off, 100.0) << seed;
    EXPECT_NEAR(chargeOf(clipped) - chargeOf(estimated), cut_off, 0.33 * cut_off) << seed;
  }
}

TEST(ClippedCurrent, IsNeverNearerToZeroThanTheLimitAndElsewhereTheCurrentStays) {
  const Series clipped = clippedAt(-150.0, cleanDrive());
  const Series estimated = withEstimatedCurrent(clipped, instrumentLimits(clipped));
  for (std::size_t k = 0; k < clipped.size(); ++k) {
    if (clipped.current[k] == -150.0) {
      ASSERT_LE(estimated.current[k], -150.0) << k;
    } else {
      ASSERT_EQ(estimated.current[k], clipped.current[k]) << k;
    }
  }
}

TEST(ClippedCurrent, OfADriveWithoutLimitsOrAtOneHertzStaysAsItIs) {
  const Series clean = cleanDrive();
  EXPECT_EQ(withEstimatedCurrent(clean, instrumentLimits(clean)).current, clean.current);
  const Series slow = test::everyNth(clippedAt(-150.0, clean), 100);
  InstrumentLimits limits = instrumentLimits(slow);
  limits.current_limits = {-150.0};
  EXPECT_EQ(withEstimatedCurrent(slow, limits).current, slow.current);
  EXPECT_TRUE(withEstimatedCurrent({}, {}).empty());
}

TEST(ClippedCurrent, HalfAMinuteIsMaskedWhereTheVoltageIsCutOffTooAndNothingWhereItIsNot) {
  Series series = clippedAt(-100.0, cleanDrive());
  InstrumentLimits limits = instrumentLimits(series);
  maskBehindUnknownCharge(series, limits);
  constexpr auto kBehind = static_cast<char>(SampleFault::kBehindClipped);
  EXPECT_EQ(std::count(limits.masked.begin(), limits.masked.end(), kBehind), 0);
  for (double& voltage : series.voltage) voltage = std::max(voltage, 12.0);
  limits = instrumentLimits(series);
  maskBehindUnknownCharge(series, limits);
  EXPECT_GT(std::count(limits.masked.begin(), limits.masked.end(), kBehind), 3000);
  const auto last = std::find(series.current.rbegin(), series.current.rend(), -100.0);
  const auto k = static_cast<std::size_t>(series.current.rend() - last) - 1;
  EXPECT_NE(limits.masked[std::min(k + 2900, series.size() - 1)], 0);
}

}  // namespace
}  // namespace battery_sof

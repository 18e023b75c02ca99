#include "recording/edges.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

/// A drive at 1 kHz whose current stamps are late by delay milliseconds, filtered to 100 Hz, with
/// noise.
Series driveWithLateCurrent(int delay, std::uint64_t seed = 1) {
  Series fast = test::driveSeries(test::driveProfile(400.0, seed));
  const std::vector<double> current = fast.current;
  for (int k = 0; k < static_cast<int>(current.size()); ++k) {
    const int from = std::min(std::max(k - delay, 0), static_cast<int>(current.size()) - 1);
    fast.current[k] = current[from];
  }
  Series slow = atDesignRate(fast);
  test::addNoise(slow, 0.1, 0.001, seed + 50);
  return slow;
}

TEST(EdgeResponse, FindsNoLagAndTheResistanceInAnAlignedDrive) {
  const auto response = edgeResponse(driveWithLateCurrent(0));
  ASSERT_TRUE(response.has_value());
  EXPECT_GE(response->edges, 20U);
  EXPECT_GT(response->correlation, 0.9);
  EXPECT_NEAR(response->resistance, 0.0055, 0.001);  // 5 mOhm and a part of the fast polarisation
  EXPECT_NEAR(response->lag, 0.0, 0.001);
}

/// A load of a fifth of an ampere shows the resistance as one of a hundred does.
TEST(EdgeResponse, FindsTheResistanceOfASmallLoad) {
  Series series;
  for (int k = 0; k < 2000; ++k) {
    const double i = (k / 200) % 2 == 0 ? 0.0 : -0.2;
    series.append({0.01 * k, i, 12.5 + 0.01 * i});
  }
  const auto response = edgeResponse(series);
  ASSERT_TRUE(response.has_value());
  EXPECT_NEAR(0.01, response->resistance, 1e-9);
  EXPECT_NEAR(1.0, response->correlation, 1e-9);
}

TEST(EdgeResponse, FindsLagsToAMillisecondInBothDirections) {
  for (const int delay : {-35, -20, -7, -3, 3, 7, 20, 35, 120}) {
    const auto response = edgeResponse(driveWithLateCurrent(delay));
    ASSERT_TRUE(response.has_value());
    EXPECT_NEAR(response->lag, -1e-3 * delay, 0.001 + 0.02e-3 * std::abs(delay)) << delay;
    EXPECT_NEAR(response->lag_first, response->lag_second, 0.002);
  }
}

TEST(EdgeResponse, CorrelationIsNegativeWhenTheSignIsTurnedRound) {
  Series series = test::cleanDrive();
  for (double& current : series.current) current = -current;
  EXPECT_LT(edgeResponse(series)->correlation, -0.9);
}

TEST(EdgeResponse, ClaimsNoFractionOfASampleBelowTwentyHertz) {
  const Series series = test::everyNth(test::driveSeries(test::driveProfile(600.0, 2)), 1000);
  EXPECT_EQ(edgeResponse(series)->lag, 0.0);
}

TEST(EdgeResponse, IsNothingWithoutAChangeOfCurrent) {
  Series series = test::cleanDrive();
  series.current.assign(series.size(), -7.0);
  EXPECT_FALSE(edgeResponse(series).has_value());
  EXPECT_FALSE(edgeResponse({}).has_value());
}

TEST(EdgeResponse, DoesNotReachAcrossGaps) {
  Series series = test::everyNth(test::driveSeries(test::driveProfile(600.0, 3)), 10);
  for (std::size_t k = series.size() / 2; k < series.size(); ++k) {
    series.time[k] += 600.0;
    series.voltage[k] -= 5.0;
  }
  EXPECT_NEAR(edgeResponse(series)->resistance, 0.0055, 0.001);
}

TEST(EdgeResponse, FindsTheResistanceOfARecordingAtAMegahertzWithoutSearchingAMillionLags) {
  Series series;
  for (int n = 0; n < 100000; ++n) {
    series.time.push_back(1e-6 * n);
    series.current.push_back(n % 40000 < 20000 ? -50.0 : 0.0);
    series.voltage.push_back(12.5 + 0.005 * series.current.back());
  }
  // 0.1 s is too little for an edge over 0.1 s; twice as much shows them.
  EXPECT_FALSE(edgeResponse(series).has_value());
  for (double& time : series.time) time *= 3.0;
  const auto response = edgeResponse(series);
  ASSERT_TRUE(response.has_value());
  EXPECT_NEAR(response->resistance, 0.005, 0.0005);
}

TEST(EdgeResponse, OfStampsThatHardlyDifferIsNothing) {
  Series series{{}, {}, {}, {}, {}};
  for (int n = 0; n < 100; ++n) {
    series.time.push_back(1e-12 * n);
    series.current.push_back(n % 10);
    series.voltage.push_back(12.0);
  }
  EXPECT_FALSE(edgeResponse(series).has_value());
}

}  // namespace
}  // namespace battery_sof

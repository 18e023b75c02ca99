#include "diagnosis/regimes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

using test::SyntheticBattery;

/// Samples every `interval` seconds of currents that are held for so many seconds.
Series heldCurrents(double interval, const std::vector<std::pair<double, double>>& parts,
                    double voltage = 12.5) {
  Series series;
  for (const auto& [current, seconds] : parts)
    for (long n = 0; n < std::lround(seconds / interval); ++n) {
      series.append({interval * static_cast<double>(series.size()), current, voltage});
    }
  return series;
}

std::vector<Regime> regimesOfWhole(const Series& series) {
  return regimesOf(series, {0, series.size()});
}

Regime regimeAt(const Series& series, double time) {
  return regimesOfWhole(series)[indexRange(series, time, series.time.back()).first];
}

std::map<Regime, double> shares(const InputSequence& inputs) {
  std::map<Regime, double> time;
  const std::vector<Regime> regimes = regimesOf(inputs);
  for (std::size_t n = 0; n < regimes.size(); ++n)
    time[regimes[n]] += inputs.samples[n].step.duration;
  const double span = inputs.samples.back().step.time - inputs.samples.front().step.time;
  for (auto& [regime, share] : time) share /= span;
  return time;
}

TEST(Regimes, EveryRegimeIsRecognisedByItsDefinition) {
  const Series series = heldCurrents(0.01, {{0.0, 5.0},
                                            {-25.0, 25.0},
                                            {-260.0, 1.0},
                                            {-10.0, 8.0},
                                            {20.0, 15.0},
                                            {0.1, 5.0},
                                            {20.0, 6.0}});
  EXPECT_EQ(regimeAt(series, 2.0), Regime::kFirstRest);
  EXPECT_EQ(regimeAt(series, 20.0), Regime::kLongDischarge);
  EXPECT_EQ(regimeAt(series, 30.1), Regime::kEdge);
  EXPECT_EQ(regimeAt(series, 30.5), Regime::kCrank);
  EXPECT_EQ(regimeAt(series, 35.0), Regime::kDischarge);
  EXPECT_EQ(regimeAt(series, 39.5), Regime::kLongCharge);
  EXPECT_EQ(regimeAt(series, 56.0), Regime::kPostChargeRest);
  EXPECT_EQ(regimeAt(series, 61.0), Regime::kShortCharge);
  EXPECT_EQ(regimeAt(heldCurrents(0.01, {{0.0, 5.0}, {1.0, 60.0}}, 14.4), 30.0),
            Regime::kHighVoltageCharge);
}

TEST(Regimes, ARestIsNotAfterADischargeThatNeverWas) {
  const Series series =
      heldCurrents(1.0, {{0.0, 9.0}, {31.0, 600.0}, {0.0, 60.0}, {-10.0, 60.0}, {0.0, 60.0}});
  EXPECT_EQ(regimeName(regimeAt(series, 3.0)), "rest before any load");
  EXPECT_EQ(regimeAt(series, 640.0), Regime::kPostChargeRest);
  EXPECT_EQ(regimeAt(series, 760.0), Regime::kPostDischargeRest);
}

TEST(Regimes, ASmallBatteryIsNotAtRestWhileItIsChargedAtATenthOfItsCurrent) {
  const Series series =
      heldCurrents(1.0, {{1.5, 600.0}, {0.15, 600.0}, {0.01, 60.0}, {-0.45, 3600.0}});
  EXPECT_EQ(regimeAt(series, 900.0), Regime::kShortCharge);
  EXPECT_EQ(regimeAt(series, 1240.0), Regime::kPostChargeRest);
  EXPECT_EQ(regimeAt(series, 3000.0), Regime::kLongDischarge);
}

TEST(Regimes, AnEdgeReachesAFewTenthsOfASecondAndNotBeyond) {
  const Series series = heldCurrents(0.01, {{0.0, 10.0}, {40.0, 5.0}});
  const auto regimes = regimesOf(inputSequence(series, {0, series.size()}));
  EXPECT_EQ(std::count(regimes.begin(), regimes.end(), Regime::kEdge), 30);
}

TEST(Regimes, OneSampleASecondMarksTheSampleBehindAJumpAndKeepsTheCrank) {
  const Series series =
      heldCurrents(1.0, {{0.0, 30.0}, {-20.0, 30.0}, {-240.0, 1.0}, {15.0, 30.0}, {70.0, 20.0}});
  const auto regimes = regimesOfWhole(series);
  EXPECT_EQ(regimes[60], Regime::kCrank);
  EXPECT_EQ(regimes[61], Regime::kEdge);
  EXPECT_EQ(regimes[91], Regime::kEdge);
  EXPECT_EQ(std::count(regimes.begin(), regimes.end(), Regime::kEdge), 2);
}

TEST(Regimes, ACompressedDriveSpendsItsTimeAsTheFullOneDoes) {
  const Series series = test::baseDrive(3, 300.0);
  const auto full = shares(inputSequence(series, {0, series.size()}));
  auto compressed = shares(compressedInputs(series, {0, series.size()}));
  EXPECT_GT(full.size(), 5u);
  for (const auto& [regime, share] : full)
    EXPECT_NEAR(compressed[regime], share, 0.02) << regimeName(regime);
}

TEST(Regimes, NoiseAroundZeroDoesNotCutARestUp) {
  Series series = heldCurrents(0.01, {{20.0, 5.0}, {0.35, 20.0}, {20.0, 5.0}});
  test::addNoise(series, 0.1, 0.0, 1);
  const InputSequence inputs = inputSequence(series, {0, series.size()});
  EXPECT_LE(episodesOf(inputs, regimesOfWhole(series)).size(), 8u);
}

TEST(Regimes, AGapEndsAnEpisodeAndMakesNoEdge) {
  Series series = heldCurrents(0.1, {{0.0, 10.0}, {50.0, 10.0}});
  for (std::size_t n = 100; n < series.size(); ++n) series.time[n] += 600.0;
  const InputSequence inputs = inputSequence(series, {0, series.size()});
  const auto episodes = episodesOf(inputs, regimesOf(inputs));
  ASSERT_EQ(episodes.size(), 2u);
  EXPECT_EQ(episodes[1].range.first, 100u);
  EXPECT_EQ(episodes[1].regime, Regime::kShortCharge);
}

}  // namespace
}  // namespace battery_sof

#include "prediction/scores.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace battery_sof {
namespace {

struct Measured {
  Series series;
  std::vector<char> voltage_controlled;
  IndexRange all() const { return {0, series.size()}; }
  MixedPrediction exact() const { return {series.current, {}, {}, series.voltage, {}, {}}; }
};

/// 20 s of load, 80 s of charge, over and over.
Measured measured(double interval, std::size_t samples) {
  Measured made;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = interval * static_cast<double>(k), phase = std::fmod(t + 1e-9, 100.0);
    const bool controlled = phase >= 20.0;
    made.series.append(
        {t,
         controlled ? 40.0 * std::exp(-(phase - 20.0) / 20.0) + 1.0 : -20.0 - std::fmod(phase, 5.0),
         controlled ? 14.0 : 12.0 + 0.01 * std::fmod(phase, 7.0)});
    made.voltage_controlled.push_back(controlled ? 1 : 0);
  }
  return made;
}

TEST(ScoreMixed, APerfectPredictionHasAFullShare) {
  const Measured made = measured(1.0, 300);
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, made.exact());
  EXPECT_DOUBLE_EQ(*scores.share_percent, 100.0);
  EXPECT_DOUBLE_EQ(*scores.current_share_percent, 100.0);
  EXPECT_DOUBLE_EQ(*scores.voltage_share_percent, 100.0);
  EXPECT_EQ(*scores.current_rmse, 0.0);
}

TEST(ScoreMixed, EachQuantitysMeanHasNoShare) {
  const Measured made = measured(1.0, 300);
  MixedPrediction predicted = made.exact();
  double current = 0.0, voltage = 0.0, charged = 0.0, loaded = 0.0;
  for (std::size_t k = 0; k < 300; ++k) {
    (made.voltage_controlled[k] ? charged : loaded) += 1.0;
    (made.voltage_controlled[k] ? current : voltage) +=
        made.voltage_controlled[k] ? made.series.current[k] : made.series.voltage[k];
  }
  predicted.current.assign(300, current / charged);
  predicted.voltage.assign(300, voltage / loaded);
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
  EXPECT_NEAR(*scores.share_percent, 0.0, 1e-9);
  EXPECT_NEAR(*scores.current_share_percent, 0.0, 1e-9);
  EXPECT_NEAR(*scores.voltage_share_percent, 0.0, 1e-9);
}

TEST(ScoreMixed, OnlyTheQuantityThatIsNotImposedCounts) {
  const Measured made = measured(1.0, 300);
  MixedPrediction predicted = made.exact();
  for (std::size_t k = 0; k < 300; ++k)
    (made.voltage_controlled[k] ? predicted.voltage[k] : predicted.current[k]) = 1e6;
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
  EXPECT_DOUBLE_EQ(*scores.share_percent, 100.0);
}

TEST(ScoreMixed, CombinedLiesBetweenTheTwoShares) {
  const Measured made = measured(1.0, 300);
  MixedPrediction predicted = made.exact();
  for (double& current : predicted.current) current += 5.0;
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
  EXPECT_NEAR(*scores.current_rmse, 5.0, 1e-9);
  EXPECT_GT(*scores.share_percent, *scores.current_share_percent);
  EXPECT_LT(*scores.share_percent, *scores.voltage_share_percent);
  const double miss = 1.0 - *scores.current_share_percent / 100.0;
  EXPECT_NEAR(*scores.share_percent, 100.0 * (1.0 - miss * std::sqrt(0.8)), 1e-9);
}

TEST(ScoreMixed, ChargesAreMeanCurrentsOverSecondsAtEveryRate) {
  for (const double interval : {1.0, 0.1}) {
    const auto samples = static_cast<std::size_t>(300.0 / interval);
    const Measured made = measured(interval, samples);
    MixedPrediction predicted = made.exact();
    for (double& current : predicted.current) current += 2.0;
    predicted.current_lower.assign(samples, 0.0);
    predicted.current_upper.assign(samples, 50.0);
    const MixedScores scores =
        scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
    ASSERT_EQ(scores.charges.size(), 6U);
    EXPECT_EQ(scores.charges[0].duration, 10.0);
    EXPECT_EQ(scores.charges[1].duration, 60.0);
    EXPECT_NEAR(scores.charges[0].time, 20.0, 1e-6);
    EXPECT_NEAR(scores.charges[0].measured, 1.0 + 4.0 * 20.0 * (1.0 - std::exp(-0.5)), 1.0);
    EXPECT_NEAR(scores.charges[0].expected.value, scores.charges[0].measured + 2.0, 1e-9);
    EXPECT_EQ(scores.charges[1].expected.upper, 50.0);
  }
}

TEST(ScoreMixed, WithoutAnImposedVoltageTheVoltageAloneIsScored) {
  Measured made = measured(1.0, 300);
  made.voltage_controlled.assign(300, 0);
  MixedPrediction predicted = made.exact();
  predicted.current.clear();
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
  EXPECT_FALSE(scores.current_share_percent);
  EXPECT_FALSE(scores.current_rmse);
  EXPECT_DOUBLE_EQ(*scores.share_percent, 100.0);
  EXPECT_TRUE(scores.charges.empty());
}

TEST(ScoreMixed, AQuantityWithoutPredictionLeavesNoCombinedShare) {
  const Measured made = measured(1.0, 300);
  MixedPrediction predicted = made.exact();
  predicted.current.clear();
  const MixedScores scores =
      scoreMixed(made.series, made.all(), made.voltage_controlled, predicted);
  EXPECT_FALSE(scores.share_percent);
  EXPECT_DOUBLE_EQ(*scores.voltage_share_percent, 100.0);
}

TEST(ScoreMixed, SizesThatDoNotFitAreRefused) {
  const Measured made = measured(1.0, 300);
  EXPECT_THROW(scoreMixed(made.series, {0, 200}, made.voltage_controlled, made.exact()),
               std::invalid_argument);
  EXPECT_THROW(scoreMixed(made.series, made.all(), {}, made.exact()), std::invalid_argument);
  EXPECT_THROW(scoreMixed(made.series, {5, 5}, made.voltage_controlled, {}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

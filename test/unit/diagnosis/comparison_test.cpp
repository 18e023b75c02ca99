#include "diagnosis/comparison.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "diagnosis/regimes.hpp"
#include "estimation/fit_quality.hpp"
#include "prediction/scores.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

IndexRange wholeOf(const Series& series) { return {0, series.size()}; }

/// A known model that begins at rest at the series' first sample.
FittedModel modelAtStart() {
  FittedModel model = test::knownModel();
  model.state = {};
  model.fit.window = {0.0, 0.0, 1};
  return model;
}

std::vector<double> shifted(std::vector<double> voltage, double by) {
  for (double& u : voltage) u += by;
  return voltage;
}

/// base with an error of so many volts in a regime.
std::vector<double> wrongIn(const Series& series, Regime regime, double error) {
  std::vector<double> voltage = series.voltage;
  const auto regimes = regimesOf(series, wholeOf(series));
  for (std::size_t n = 0; n < voltage.size(); ++n)
    if (regimes[n] == regime) voltage[n] += error;
  return voltage;
}

const RegimeComparison& of(const std::vector<RegimeComparison>& comparisons, Regime regime) {
  for (const RegimeComparison& comparison : comparisons)
    if (comparison.regime == regimeName(regime)) return comparison;
  throw std::runtime_error("no " + regimeName(regime));
}

TEST(ErrorMetrics, AreThoseOfAPredictionsScores) {
  const Series series = test::baseDrive(4, 240.0);
  const IndexRange range{6000, 24000};
  Series noisy = series;
  test::addNoise(noisy, 0.0, 0.02, 9);
  const ErrorMetrics metrics = errorMetrics(series, range, noisy.voltage);
  PredictedVoltage predicted;
  predicted.voltage.assign(noisy.voltage.begin() + 6000, noisy.voltage.end());
  predicted.lower = predicted.upper = predicted.voltage;
  const PredictionScores scores = scorePrediction(series, range, predicted);
  EXPECT_DOUBLE_EQ(metrics.q_dyn_percent, *scores.q_dyn_percent);
  EXPECT_DOUBLE_EQ(metrics.rmse, scores.rmse);
  EXPECT_DOUBLE_EQ(metrics.max_abs, scores.max_abs);
  ASSERT_TRUE(metrics.crank_mae.has_value());
  EXPECT_DOUBLE_EQ(*metrics.crank_mae, *scores.crank_mean_abs_error);
  EXPECT_EQ(metrics.cranks, scores.cranks.size());
}

TEST(ErrorMetrics, ChargeBiasIsPositiveWhereTheModelReadsTooLow) {
  const Series series = test::baseDrive(4, 120.0);
  const ErrorMetrics metrics =
      errorMetrics(series, wholeOf(series), shifted(series.voltage, -0.05));
  ASSERT_TRUE(metrics.charge_bias.has_value());
  EXPECT_NEAR(*metrics.charge_bias, 0.05, 1e-12);
}

TEST(ErrorMetrics, MaskedSamplesAreLeftOut) {
  Series series = test::baseDrive(4, 120.0);
  const std::vector<double> modelled = shifted(series.voltage, -0.01);
  std::vector<char> masked(series.size(), 0);
  for (std::size_t n = 3000; n < 3500; ++n) {
    series.voltage[n] = 20.0;
    masked[n] = 1;
  }
  const ErrorMetrics metrics = errorMetrics(series, wholeOf(series), modelled, masked);
  EXPECT_NEAR(metrics.rmse, 0.01, 1e-12);
  EXPECT_NEAR(metrics.max_abs, 0.01, 1e-12);
  EXPECT_NEAR(*metrics.charge_bias, 0.01, 1e-12);
  EXPECT_NEAR(*metrics.crank_mae, 0.01, 1e-12);
}

TEST(ErrorMetrics, ADriveWithoutChargesHasNoChargeBias) {
  Series series = test::baseDrive(4, 60.0);
  for (double& i : series.current) i = -std::abs(i) - 1.0;
  const ErrorMetrics metrics = errorMetrics(series, wholeOf(series), series.voltage);
  EXPECT_FALSE(metrics.charge_bias.has_value());
  EXPECT_THROW(errorMetrics(series, wholeOf(series), {1.0}), std::invalid_argument);
}

TEST(CompareRegimes, ARegimeThatImprovesIsToldFromThoseThatDoNot) {
  const Series series = test::baseDrive(4, 600.0);
  Series extended = series, base = series;
  base.voltage = wrongIn(series, Regime::kShortCharge, -0.05);
  test::addNoise(base, 0.0, 0.01, 5);
  test::addNoise(extended, 0.0, 0.01, 6);
  const auto comparisons = compareRegimes(series, wholeOf(series), base.voltage, extended.voltage);
  const RegimeComparison& charge = of(comparisons, Regime::kShortCharge);
  EXPECT_NEAR(charge.change, 0.01 - std::sqrt(0.05 * 0.05 + 0.01 * 0.01), 0.001);
  EXPECT_LT(charge.change_upper, -0.03);
  EXPECT_LE(charge.change_lower, charge.change);
  const RegimeComparison& discharge = of(comparisons, Regime::kDischarge);
  EXPECT_LT(discharge.change_lower, 0.0);
  EXPECT_GT(discharge.change_upper, 0.0);
  std::size_t samples = 0;
  for (const RegimeComparison& comparison : comparisons) samples += comparison.samples;
  EXPECT_EQ(samples, series.size());
}

TEST(CompareRegimes, EquallyGoodModelsRarelyDifferSignificantly) {
  const Series series = test::baseDrive(4, 600.0);
  int significant = 0, all = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Series base = series, extended = series;
    test::addNoise(base, 0.0, 0.01, 100 + seed);
    test::addNoise(extended, 0.0, 0.01, 200 + seed);
    for (const RegimeComparison& c :
         compareRegimes(series, wholeOf(series), base.voltage, extended.voltage)) {
      significant += c.change_lower > 0.0 || c.change_upper < 0.0;
      ++all;
    }
  }
  EXPECT_LT(static_cast<double>(significant) / all, 0.15);
}

TEST(ChargeCurrentError, TheModelsOwnVoltageAsksForItsOwnCurrent) {
  const Series series =
      test::answered(test::drivenBattery(), test::dataSetOneCurrent(240.0, 0.01, 4), 0.01, 0.0, 4);
  const auto error = chargeCurrentError(modelAtStart(), series, wholeOf(series));
  ASSERT_TRUE(error.has_value());
  EXPECT_LT(*error, 0.5);
}

TEST(ChargeCurrentError, AVoltageOffByFiftyMillivoltsAsksForAnotherCurrent) {
  Series series =
      test::answered(test::drivenBattery(), test::dataSetOneCurrent(240.0, 0.01, 4), 0.01, 0.0, 4);
  const double before = *chargeCurrentError(modelAtStart(), series, wholeOf(series));
  series.voltage = shifted(series.voltage, 0.05);
  EXPECT_GT(*chargeCurrentError(modelAtStart(), series, wholeOf(series)), before + 1.0);
}

TEST(ChargeCurrentError, ARangeLaterThanTheModelIsReachedThroughTheSamplesBetween) {
  const Series series =
      test::answered(test::drivenBattery(), test::dataSetOneCurrent(240.0, 0.01, 4), 0.01, 0.0, 4);
  const auto error = chargeCurrentError(modelAtStart(), series, {12000, 24000});
  ASSERT_TRUE(error.has_value());
  EXPECT_LT(*error, 0.5);
}

TEST(ChargeCurrentError, ARangeThatBeginsBeforeTheStateIsReachedFromTheFirstState) {
  const Series series =
      test::answered(test::drivenBattery(), test::dataSetOneCurrent(240.0, 0.01, 4), 0.01, 0.0, 4);
  FittedModel model = modelAtStart();
  model.state.time = 240.0;
  model.state.states[0] = 0.3;
  EXPECT_FALSE(chargeCurrentError(model, series, wholeOf(series)).has_value());
  model.fit.first_state = Eigen::VectorXd::Zero(1);
  EXPECT_LT(chargeCurrentError(model, series, wholeOf(series)).value(), 0.5);
}

TEST(ChargeCurrentError, ADriveWithoutChargesHasNone) {
  Series series = test::baseDrive(4, 60.0);
  for (double& i : series.current) i = -std::abs(i) - 1.0;
  EXPECT_FALSE(chargeCurrentError(modelAtStart(), series, wholeOf(series)).has_value());
}

TEST(CompareRegimes, AGapOfYearsHasNoBlocks) {
  Series series = test::baseDrive(4, 600.0);
  for (std::size_t n = series.size() / 2; n < series.size(); ++n) series.time[n] += 1e10;
  const auto comparisons = compareRegimes(series, wholeOf(series), series.voltage, series.voltage);
  std::size_t samples = 0;
  for (const RegimeComparison& comparison : comparisons) samples += comparison.samples;
  EXPECT_EQ(samples, series.size());
}

}  // namespace
}  // namespace battery_sof

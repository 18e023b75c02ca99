#include "battery_sof/naive/naive_predictor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "battery_sof/naive/charge_phases.hpp"
#include "battery_sof/recording/events.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

struct Driven {
  Series series;
  std::vector<char> imposes_voltage;
  IndexRange all() const { return {0, series.size()}; }
  void add(double interval, double current, double voltage, bool imposed) {
    series.time.push_back(series.empty() ? 0.0 : series.time.back() + interval);
    series.current.push_back(current);
    series.voltage.push_back(voltage);
    imposes_voltage.push_back(imposed ? 1 : 0);
  }
};

double chargeAtAge(double age) { return 2.0 + 30.0 * std::exp(-age / 12.0); }

/// Every two minutes 30 s at -20 A that end with a crank, then a charge that decays alike; v = 12.5
/// + 0.006 i under load.
Driven drive(int stops, double interval, double noise = 0.0) {
  Driven driven;
  test::Random random(9);
  for (int stop = 0; stop < stops; ++stop)
    for (double t = 0.0; t < 120.0 - 0.5 * interval; t += interval) {
      const bool imposed = t >= 30.0 - 1e-9;
      const bool cranks = !imposed && t >= 29.0 - 1e-9;
      const double load = cranks ? -240.0 - 5.0 * stop : -20.0;
      const double current = (imposed ? chargeAtAge(t - 30.0) : load) + noise * random.normal();
      driven.add(interval, current, imposed ? 14.0 : 12.5 + 0.006 * current, imposed);
    }
  return driven;
}

TEST(ChargePhases, BeginAtTheFirstChargedSampleAfterADischarge) {
  const Driven driven = drive(3, 1.0);
  EXPECT_EQ(chargeBeginnings(driven.series, driven.all(), driven.imposes_voltage), (std::vector<std::size_t>{30, 150, 270}));
  EXPECT_EQ(chargeBeginnings(driven.series, {40, 290}, driven.imposes_voltage), (std::vector<std::size_t>{150, 270}));
}

TEST(ChargePhases, TenSecondsAreTenSamplesAtOneHertzAndAThousandAtAHundred) {
  for (const double interval : {1.0, 0.01}) {
    const Driven driven = drive(1, interval);
    const auto first = chargeBeginnings(driven.series, driven.all(), driven.imposes_voltage).at(0);
    const auto samples = beginningOfCharge(driven.series, driven.all(), first, 10.0, driven.imposes_voltage);
    ASSERT_TRUE(samples);
    EXPECT_EQ(samples->size(), static_cast<std::size_t>(std::lround(10.0 / interval)));
  }
}

TEST(ChargePhases, AChargeCutShortHasNoBeginningToMeasure) {
  Driven driven = drive(1, 1.0);
  EXPECT_FALSE(beginningOfCharge(driven.series, {0, 35}, 30, 10.0, driven.imposes_voltage));
  for (std::size_t k = 34; k < 37; ++k) driven.imposes_voltage[k] = 0;
  EXPECT_FALSE(beginningOfCharge(driven.series, driven.all(), 30, 10.0, driven.imposes_voltage));
  EXPECT_TRUE(beginningOfCharge(driven.series, driven.all(), 30, 60.0, driven.imposes_voltage));
}

TEST(ChargePhases, SlowSamplingShowsNoTenSeconds) {
  Driven driven;
  for (int k = 0; k < 10; ++k) driven.add(60.0, k < 5 ? -20.0 : 10.0, 13.0, k >= 5);
  EXPECT_FALSE(beginningOfCharge(driven.series, driven.all(), 5, 10.0, driven.imposes_voltage));
}

TEST(FitNaive, OfAWindowThatTheCurrentDrivesIsTheSameFromItsCranks) {
  const Driven driven = drive(6, 1.0, 0.5);
  const IndexRange window{10, driven.series.size() - 5};
  const NaivePredictor by_mask = fitNaive(driven.series, window, std::vector<char>(driven.series.size(), 0));
  const NaivePredictor by_cranks = fitNaiveDrivenByCurrent(driven.series, window, detectCranks(driven.series, window, {}, 10.0));
  ASSERT_TRUE(by_cranks.voltage_from_current);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->slope, by_mask.voltage_from_current->slope);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->lower_error, by_mask.voltage_from_current->lower_error);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->std, by_mask.voltage_from_current->std);
  ASSERT_TRUE(by_cranks.cranks);
  EXPECT_EQ(by_cranks.cranks->events, 6U);
  EXPECT_EQ(by_mask.cranks->events, 6U);
  EXPECT_DOUBLE_EQ(by_cranks.cranks->intercept, by_mask.cranks->intercept);
  EXPECT_FALSE(by_cranks.current_from_voltage || by_cranks.phase || by_cranks.charge_10s);
  EXPECT_FALSE(by_mask.current_from_voltage || by_mask.phase || by_mask.charge_10s);
}

TEST(FitNaive, FindsTheLineOfTheLoads) {
  const Driven driven = drive(4, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  ASSERT_TRUE(naive.voltage_from_current);
  EXPECT_NEAR(naive.voltage_from_current->slope, 0.006, 1e-9);
  EXPECT_NEAR(naive.voltage_from_current->at(0.0), 12.5, 1e-9);
  EXPECT_EQ(naive.voltage_from_current->samples, 120U);
}

TEST(FitNaive, ALineOverOneVoltageIsTheMeanCurrent) {
  const Driven driven = drive(4, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  ASSERT_TRUE(naive.current_from_voltage);
  EXPECT_EQ(naive.current_from_voltage->slope, 0.0);
  EXPECT_GT(naive.current_from_voltage->std, 1.0);
}

TEST(FitNaive, ThePhaseIsTheMedianOfPastCharges) {
  for (const double interval : {1.0, 0.1}) {
    const Driven driven = drive(5, interval, 0.2);
    const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
    ASSERT_TRUE(naive.phase);
    EXPECT_EQ(naive.phase->charges, 5U);
    ASSERT_GE(naive.phase->current.size(), 90U);
    for (const std::size_t age : {5U, 20U, 60U}) EXPECT_NEAR(naive.phase->current[age], chargeAtAge(static_cast<double>(age)), 0.3);
  }
}

TEST(FitNaive, ThePhaseEndsWhereMostChargesHaveEnded) {
  Driven driven = drive(3, 1.0);
  for (std::size_t k = 60; k < 240; ++k)
    if (k % 120 >= 60) driven.imposes_voltage[k] = 0;
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  ASSERT_TRUE(naive.phase);
  EXPECT_EQ(naive.phase->current.size(), 30U);
}

TEST(FitNaive, AWindowWithNothingInItKnowsNothing) {
  const Driven driven = drive(1, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, {3, 3}, driven.imposes_voltage);
  EXPECT_FALSE(naive.current_from_voltage || naive.voltage_from_current || naive.phase || naive.cranks || naive.charge_10s ||
               naive.charge_60s);
  EXPECT_FALSE(naiveCrankMinimum(naive, -200.0));
  EXPECT_FALSE(naiveChargeCurrent(naive, 14.0, 10.0));
  EXPECT_TRUE(predictNaive(naive, driven.series, driven.all(), driven.imposes_voltage).current.empty());
}

TEST(FitNaive, AMaskOfAnotherSizeIsRefused) {
  const Driven driven = drive(1, 1.0);
  EXPECT_THROW(fitNaive(driven.series, driven.all(), {}), std::invalid_argument);
  EXPECT_THROW(fitNaive(driven.series, {0, 1000}, driven.imposes_voltage), std::invalid_argument);
}

TEST(PredictNaive, APhaseSeenBeforeIsPredictedExactly) {
  const Driven driven = drive(6, 1.0);
  const IndexRange later{360, 720};
  const NaivePredictor naive = fitNaive(driven.series, {0, 360}, driven.imposes_voltage);
  const NaiveSeries predicted = predictNaive(naive, driven.series, later, driven.imposes_voltage);
  ASSERT_EQ(predicted.current.size(), later.size());
  ASSERT_EQ(predicted.voltage.size(), later.size());
  for (std::size_t k = later.first; k < later.last; ++k) {
    const std::size_t n = k - later.first;
    if (driven.imposes_voltage[k])
      EXPECT_NEAR(predicted.current[n], driven.series.current[k], 1e-9);
    else
      EXPECT_NEAR(predicted.voltage[n], driven.series.voltage[k], 1e-9);
    EXPECT_LE(predicted.current_lower[n], predicted.current_upper[n]);
  }
}

TEST(PredictNaive, NineInTenFurtherCurrentsLieInTheirBounds) {
  const Driven driven = drive(20, 1.0, 0.5);
  const IndexRange later{1200, 2400};
  const NaivePredictor naive = fitNaive(driven.series, {0, 1200}, driven.imposes_voltage);
  const NaiveSeries predicted = predictNaive(naive, driven.series, later, driven.imposes_voltage);
  double inside = 0.0, samples = 0.0;
  for (std::size_t k = later.first; k < later.last; ++k) {
    if (!driven.imposes_voltage[k]) continue;
    const std::size_t n = k - later.first;
    const double current = driven.series.current[k];
    samples += 1.0;
    if (current >= predicted.current_lower[n] && current <= predicted.current_upper[n]) inside += 1.0;
  }
  EXPECT_NEAR(inside / samples, 0.9, 0.06);
}

TEST(NaiveCrankMinimum, LiesOnTheLineWhereCranksDo) {
  const Driven driven = drive(4, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  ASSERT_TRUE(naive.cranks);
  EXPECT_EQ(naive.cranks->events, 4U);
  EXPECT_NEAR(naive.cranks->last.current, -255.0, 1e-9);
  EXPECT_NEAR(naiveCrankMinimum(naive, -300.0)->value, 12.5 - 0.006 * 300.0, 1e-6);
}

TEST(NaiveCrankMinimum, FollowsRecentCranksBelowTheLine) {
  Driven driven = drive(8, 1.0);
  for (std::size_t k = 0; k < driven.series.size(); ++k)
    if (driven.series.current[k] < -200.0) driven.series.voltage[k] -= k > 480 ? 1.0 : 0.0;
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  const double last = naive.cranks->last.minimum;
  const auto minimum = naiveCrankMinimum(naive, naive.cranks->last.current);
  EXPECT_LT(std::abs(minimum->value - last), std::abs(naive.voltage_from_current->at(naive.cranks->last.current) - last));
  EXPECT_LT(minimum->lower, last);
}

TEST(NaiveCrankMinimum, WithoutCranksIsTheLoadsLine) {
  const Driven driven = drive(1, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, {0, 28}, driven.imposes_voltage);
  EXPECT_FALSE(naive.cranks);
  EXPECT_NEAR(naiveCrankMinimum(naive, -20.0)->value, 12.38, 1e-9);
}

TEST(NaiveCrankMinimum, FromLightLoadsAloneIsWiderThanALightLoad) {
  Driven driven;
  test::Random random(2);
  for (int k = 0; k < 60; ++k) {
    const double current = random.uniform(-20.0, -5.0);
    driven.add(1.0, current, 12.5 + 0.006 * current + 0.02 * random.normal(), false);
  }
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  const auto light = naiveCrankMinimum(naive, -12.0), crank = naiveCrankMinimum(naive, -300.0);
  EXPECT_GT(crank->upper - crank->lower, 4.0 * (light->upper - light->lower));
}

TEST(NaiveChargeCurrent, IsTheMeanOfPastChargesOverTheDuration) {
  const Driven driven = drive(5, 1.0);
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  ASSERT_TRUE(naive.charge_10s && naive.charge_60s);
  EXPECT_NEAR(naiveChargeCurrent(naive, 14.0, 10.0)->value, naive.charge_10s->median, 1e-9);
  EXPECT_NEAR(naiveChargeCurrent(naive, 14.0, 60.0)->value, naive.charge_60s->last, 1e-9);
  EXPECT_GT(naive.charge_10s->median, naive.charge_60s->median);
}

TEST(NaiveChargeCurrent, WithoutChargesIsTheLineOverVoltage) {
  Driven driven;
  for (int k = 0; k < 50; ++k) driven.add(1.0, 1.0 + 0.1 * k, 13.0 + 0.02 * k, true);
  const NaivePredictor naive = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  EXPECT_FALSE(naive.phase);
  EXPECT_NEAR(naiveChargeCurrent(naive, 13.5, 10.0)->value, 3.5, 1e-9);
  EXPECT_THROW(naiveChargeCurrent(naive, 13.5, 0.0), std::invalid_argument);
}

TEST(NaiveChargeCurrent, OneChargeHasTheLinesBoundsAndFewHaveWideOnes) {
  const Driven driven = drive(4, 1.0, 1.0);
  const NaivePredictor one = fitNaive(driven.series, {0, 120}, driven.imposes_voltage);
  const NaivePredictor few = fitNaive(driven.series, driven.all(), driven.imposes_voltage);
  EXPECT_EQ(one.charge_10s->events, 1U);
  EXPECT_EQ(one.charge_10s->upper_error, one.current_from_voltage->upper_error);
  EXPECT_GT(few.charge_10s->upper_error, 0.0);
  EXPECT_LT(few.charge_10s->upper_error, one.charge_10s->upper_error);
}

}  // namespace
}  // namespace battery_sof

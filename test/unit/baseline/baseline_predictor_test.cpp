#include "baseline/baseline_predictor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "recording/events.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

struct Driven {
  Series series;
  std::vector<char> voltage_controlled;
  IndexRange all() const { return {0, series.size()}; }
  void add(double interval, double current, double voltage, bool controlled) {
    series.append({series.empty() ? 0.0 : series.time.back() + interval, current, voltage});
    voltage_controlled.push_back(controlled ? 1 : 0);
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
      const bool controlled = t >= 30.0 - 1e-9;
      const bool cranks = !controlled && t >= 29.0 - 1e-9;
      const double load = cranks ? -240.0 - 5.0 * stop : -20.0;
      const double current = (controlled ? chargeAtAge(t - 30.0) : load) + noise * random.normal();
      driven.add(interval, current, controlled ? 14.0 : 12.5 + 0.006 * current, controlled);
    }
  return driven;
}

TEST(ChargePhases, BeginAtTheFirstChargedSampleAfterADischarge) {
  const Driven driven = drive(3, 1.0);
  EXPECT_EQ(chargeBeginnings(driven.series, driven.all(), driven.voltage_controlled),
            (std::vector<std::size_t>{30, 150, 270}));
  EXPECT_EQ(chargeBeginnings(driven.series, {40, 290}, driven.voltage_controlled),
            (std::vector<std::size_t>{150, 270}));
}

TEST(ChargePhases, TenSecondsAreTenSamplesAtOneHertzAndAThousandAtAHundred) {
  for (const double interval : {1.0, 0.01}) {
    const Driven driven = drive(1, interval);
    const auto first =
        chargeBeginnings(driven.series, driven.all(), driven.voltage_controlled).at(0);
    const auto samples =
        beginningOfCharge(driven.series, driven.all(), first, 10.0, driven.voltage_controlled);
    ASSERT_TRUE(samples);
    EXPECT_EQ(samples->size(), static_cast<std::size_t>(std::lround(10.0 / interval)));
  }
}

TEST(ChargePhases, AChargeCutShortHasNoBeginningToMeasure) {
  Driven driven = drive(1, 1.0);
  EXPECT_FALSE(beginningOfCharge(driven.series, {0, 35}, 30, 10.0, driven.voltage_controlled));
  for (std::size_t k = 34; k < 37; ++k) driven.voltage_controlled[k] = 0;
  EXPECT_FALSE(beginningOfCharge(driven.series, driven.all(), 30, 10.0, driven.voltage_controlled));
  EXPECT_TRUE(beginningOfCharge(driven.series, driven.all(), 30, 60.0, driven.voltage_controlled));
}

TEST(ChargePhases, SlowSamplingShowsNoTenSeconds) {
  Driven driven;
  for (int k = 0; k < 10; ++k) driven.add(60.0, k < 5 ? -20.0 : 10.0, 13.0, k >= 5);
  EXPECT_FALSE(beginningOfCharge(driven.series, driven.all(), 5, 10.0, driven.voltage_controlled));
}

TEST(FitBaseline, OfAWindowThatTheCurrentDrivesIsTheSameFromItsCranks) {
  const Driven driven = drive(6, 1.0, 0.5);
  const IndexRange window{10, driven.series.size() - 5};
  const BaselinePredictor by_mask =
      fitBaseline(driven.series, window, std::vector<char>(driven.series.size(), 0));
  const BaselinePredictor by_cranks = fitBaselineDrivenByCurrent(driven.series, window);
  ASSERT_TRUE(by_cranks.voltage_from_current);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->slope, by_mask.voltage_from_current->slope);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->error.lower,
                   by_mask.voltage_from_current->error.lower);
  EXPECT_DOUBLE_EQ(by_cranks.voltage_from_current->std, by_mask.voltage_from_current->std);
  ASSERT_TRUE(by_cranks.cranks);
  EXPECT_EQ(by_cranks.cranks->events, 6U);
  EXPECT_EQ(by_mask.cranks->events, 6U);
  EXPECT_DOUBLE_EQ(by_cranks.cranks->intercept, by_mask.cranks->intercept);
  EXPECT_FALSE(by_cranks.current_from_voltage || by_cranks.phase || by_cranks.charge_10s);
  EXPECT_FALSE(by_mask.current_from_voltage || by_mask.phase || by_mask.charge_10s);
}

TEST(FitBaseline, FindsTheLineOfTheLoads) {
  const Driven driven = drive(4, 1.0);
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  ASSERT_TRUE(baseline.voltage_from_current);
  EXPECT_NEAR(baseline.voltage_from_current->slope, 0.006, 1e-9);
  EXPECT_NEAR(baseline.voltage_from_current->at(0.0), 12.5, 1e-9);
  EXPECT_EQ(baseline.voltage_from_current->samples, 120U);
}

TEST(FitBaseline, ALineOverOneVoltageIsTheMeanCurrent) {
  const Driven driven = drive(4, 1.0);
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  ASSERT_TRUE(baseline.current_from_voltage);
  EXPECT_EQ(baseline.current_from_voltage->slope, 0.0);
  EXPECT_GT(baseline.current_from_voltage->std, 1.0);
}

TEST(FitBaseline, ThePhaseIsTheMedianOfPastCharges) {
  for (const double interval : {1.0, 0.1}) {
    const Driven driven = drive(5, interval, 0.2);
    const BaselinePredictor baseline =
        fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
    ASSERT_TRUE(baseline.phase);
    EXPECT_EQ(baseline.phase->charges, 5U);
    ASSERT_GE(baseline.phase->current.size(), 90U);
    for (const std::size_t age : {5U, 20U, 60U})
      EXPECT_NEAR(baseline.phase->current[age], chargeAtAge(static_cast<double>(age)), 0.3);
  }
}

TEST(FitBaseline, ThePhaseEndsWhereMostChargesHaveEnded) {
  Driven driven = drive(3, 1.0);
  for (std::size_t k = 60; k < 240; ++k)
    if (k % 120 >= 60) driven.voltage_controlled[k] = 0;
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  ASSERT_TRUE(baseline.phase);
  EXPECT_EQ(baseline.phase->current.size(), 30U);
}

TEST(FitBaseline, AWindowWithNothingInItKnowsNothing) {
  const Driven driven = drive(1, 1.0);
  const BaselinePredictor baseline = fitBaseline(driven.series, {3, 3}, driven.voltage_controlled);
  EXPECT_FALSE(baseline.current_from_voltage || baseline.voltage_from_current || baseline.phase ||
               baseline.cranks || baseline.charge_10s || baseline.charge_60s);
  EXPECT_FALSE(baselineCrankMinimum(baseline, -200.0));
  EXPECT_FALSE(baselineChargeCurrent(baseline, 14.0, 10.0));
  EXPECT_TRUE(predictBaseline(baseline, driven.series, driven.all(), driven.voltage_controlled)
                  .current.empty());
}

TEST(FitBaseline, AMaskOfAnotherSizeIsRefused) {
  const Driven driven = drive(1, 1.0);
  EXPECT_THROW(fitBaseline(driven.series, driven.all(), {}), std::invalid_argument);
  EXPECT_THROW(fitBaseline(driven.series, {0, 1000}, driven.voltage_controlled),
               std::invalid_argument);
}

TEST(PredictBaseline, APhaseSeenBeforeIsPredictedExactly) {
  const Driven driven = drive(6, 1.0);
  const IndexRange later{360, 720};
  const BaselinePredictor baseline =
      fitBaseline(driven.series, {0, 360}, driven.voltage_controlled);
  const MixedPrediction predicted =
      predictBaseline(baseline, driven.series, later, driven.voltage_controlled);
  ASSERT_EQ(predicted.current.size(), later.size());
  ASSERT_EQ(predicted.voltage.size(), later.size());
  for (std::size_t k = later.first; k < later.last; ++k) {
    const std::size_t n = k - later.first;
    if (driven.voltage_controlled[k])
      EXPECT_NEAR(predicted.current[n], driven.series.current[k], 1e-9);
    else
      EXPECT_NEAR(predicted.voltage[n], driven.series.voltage[k], 1e-9);
    EXPECT_LE(predicted.current_lower[n], predicted.current_upper[n]);
  }
}

TEST(PredictBaseline, NineInTenFurtherCurrentsLieInTheirBounds) {
  const Driven driven = drive(20, 1.0, 0.5);
  const IndexRange later{1200, 2400};
  const BaselinePredictor baseline =
      fitBaseline(driven.series, {0, 1200}, driven.voltage_controlled);
  const MixedPrediction predicted =
      predictBaseline(baseline, driven.series, later, driven.voltage_controlled);
  double inside = 0.0, samples = 0.0;
  for (std::size_t k = later.first; k < later.last; ++k) {
    if (!driven.voltage_controlled[k]) continue;
    const std::size_t n = k - later.first;
    const double current = driven.series.current[k];
    samples += 1.0;
    if (current >= predicted.current_lower[n] && current <= predicted.current_upper[n])
      inside += 1.0;
  }
  EXPECT_NEAR(inside / samples, 0.9, 0.06);
}

TEST(BaselineCrankMinimum, LiesOnTheLineWhereCranksDo) {
  const Driven driven = drive(4, 1.0);
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  ASSERT_TRUE(baseline.cranks);
  EXPECT_EQ(baseline.cranks->events, 4U);
  EXPECT_NEAR(baseline.cranks->last.current, -255.0, 1e-9);
  EXPECT_NEAR(baselineCrankMinimum(baseline, -300.0)->value, 12.5 - 0.006 * 300.0, 1e-6);
}

TEST(BaselineCrankMinimum, FollowsRecentCranksBelowTheLine) {
  Driven driven = drive(8, 1.0);
  for (std::size_t k = 0; k < driven.series.size(); ++k)
    if (driven.series.current[k] < -200.0) driven.series.voltage[k] -= k > 480 ? 1.0 : 0.0;
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  const double last = baseline.cranks->last.minimum;
  const auto minimum = baselineCrankMinimum(baseline, baseline.cranks->last.current);
  EXPECT_LT(std::abs(minimum->value - last),
            std::abs(baseline.voltage_from_current->at(baseline.cranks->last.current) - last));
  EXPECT_LT(minimum->lower, last);
}

TEST(BaselineCrankMinimum, WithoutCranksIsTheLoadsLine) {
  const Driven driven = drive(1, 1.0);
  const BaselinePredictor baseline = fitBaseline(driven.series, {0, 28}, driven.voltage_controlled);
  EXPECT_FALSE(baseline.cranks);
  EXPECT_NEAR(baselineCrankMinimum(baseline, -20.0)->value, 12.38, 1e-9);
}

TEST(BaselineCrankMinimum, FromLightLoadsAloneIsWiderThanALightLoad) {
  Driven driven;
  test::Random random(2);
  for (int k = 0; k < 60; ++k) {
    const double current = random.uniform(-20.0, -5.0);
    driven.add(1.0, current, 12.5 + 0.006 * current + 0.02 * random.normal(), false);
  }
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  const auto light = baselineCrankMinimum(baseline, -12.0),
             crank = baselineCrankMinimum(baseline, -300.0);
  EXPECT_GT(crank->upper - crank->lower, 4.0 * (light->upper - light->lower));
}

TEST(BaselineChargeCurrent, IsTheMeanOfPastChargesOverTheDuration) {
  const Driven driven = drive(5, 1.0);
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  ASSERT_TRUE(baseline.charge_10s && baseline.charge_60s);
  EXPECT_NEAR(baselineChargeCurrent(baseline, 14.0, 10.0)->value, baseline.charge_10s->median,
              1e-9);
  EXPECT_NEAR(baselineChargeCurrent(baseline, 14.0, 60.0)->value, baseline.charge_60s->last, 1e-9);
  EXPECT_GT(baseline.charge_10s->median, baseline.charge_60s->median);
}

TEST(BaselineChargeCurrent, WithoutChargesIsTheLineOverVoltage) {
  Driven driven;
  for (int k = 0; k < 50; ++k) driven.add(1.0, 1.0 + 0.1 * k, 13.0 + 0.02 * k, true);
  const BaselinePredictor baseline =
      fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  EXPECT_FALSE(baseline.phase);
  EXPECT_NEAR(baselineChargeCurrent(baseline, 13.5, 10.0)->value, 3.5, 1e-9);
  EXPECT_THROW(baselineChargeCurrent(baseline, 13.5, 0.0), std::invalid_argument);
}

TEST(BaselineChargeCurrent, OneChargeHasTheLinesBoundsAndFewHaveWideOnes) {
  const Driven driven = drive(4, 1.0, 1.0);
  const BaselinePredictor one = fitBaseline(driven.series, {0, 120}, driven.voltage_controlled);
  const BaselinePredictor few = fitBaseline(driven.series, driven.all(), driven.voltage_controlled);
  EXPECT_EQ(one.charge_10s->events, 1U);
  EXPECT_EQ(one.charge_10s->error.upper, one.current_from_voltage->error.upper);
  EXPECT_GT(few.charge_10s->error.upper, 0.0);
  EXPECT_LT(few.charge_10s->error.upper, one.charge_10s->error.upper);
}

}  // namespace
}  // namespace battery_sof

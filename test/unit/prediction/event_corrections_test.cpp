#include "prediction/event_corrections.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using namespace test;

constexpr Interval kModelled = {10.0, 9.8, 10.3};

PastEvent pastCrank(double time, double current, double measured, double modelled) {
  return {PastEvent::Kind::kCrank, time, 0.0, current, 0.0, 0.0, measured, modelled};
}

/// Ten seconds at a voltage.
PastEvent pastCharge(double time, double voltage, double first_voltage, double measured,
                     double modelled) {
  return {PastEvent::Kind::kCharge, time, 10.0, 0.0, voltage, first_voltage, measured, modelled};
}

/// Cranks of which the equations miss `bias` and noise; with a baseline line that misses nothing of
/// v = 12 + 0.01 i.
FittedModel cranked(std::size_t cranks, double bias, double noise = 0.0, bool line = false,
                    std::uint64_t seed = 2) {
  Random random(seed);
  FittedModel model = knownModel();
  for (std::size_t k = 0; k < cranks; ++k) {
    const double current = random.uniform(-240.0, -160.0), modelled = 12.0 + 0.01 * current;
    model.intervals.event_history.add(pastCrank(10.0 * static_cast<double>(k), current,
                                                modelled + bias + noise * random.normal(),
                                                modelled));
  }
  if (line) {
    model.fit.baseline.voltage_from_current.emplace();
    model.fit.baseline.voltage_from_current->intercept = 12.0;
    model.fit.baseline.voltage_from_current->slope = 0.01;
  }
  return model;
}

FittedModel charged(std::size_t charges, double bias, double noise = 0.0, double voltage = 14.0,
                    std::uint64_t seed = 3) {
  Random random(seed);
  FittedModel model = knownModel();
  for (std::size_t k = 0; k < charges; ++k) {
    const double modelled = random.uniform(8.0, 12.0);
    model.intervals.event_history.add(
        pastCharge(100.0 * static_cast<double>(k), voltage + random.uniform(-0.1, 0.1),
                   voltage - 0.3, modelled + bias + noise * random.normal(), modelled));
  }
  return model;
}

const ChargeBeginning kBeginning = {14.0, 13.7, 10.0};

bool same(const Interval& one, const Interval& other) {
  return one.value == other.value && one.lower == other.lower && one.upper == other.upper;
}

// ---------------------------------------------------------------------------------- cranks

TEST(CorrectCrankPrediction, WithoutAPastIsTheEquationsAnswer) {
  EXPECT_TRUE(same(correctCrankPrediction(knownModel(), -200.0, kModelled), kModelled));
}

TEST(CorrectCrankPrediction, TakesOffABiasThatPastCranksShow) {
  double before = 0.3;
  for (const std::size_t cranks : {1u, 2u, 5u, 20u}) {
    const Interval corrected = correctCrankPrediction(cranked(cranks, -0.3), -200.0, kModelled);
    const double left = std::abs(corrected.value - (kModelled.value - 0.3));
    EXPECT_LT(left, before) << cranks;  // the penalty weighs less and less
    before = left;
  }
  EXPECT_LT(before, 0.01);
}

TEST(CorrectCrankPrediction, OneCrankTakesOffItsBiasByTheRidgesShare) {
  FittedModel model = knownModel();
  model.intervals.event_history.add(pastCrank(1.0, -200.0, 9.0, 9.4));
  // At -200 A the features are [1, 0, 0]: w = -0.4 / (1 + 0.3).
  EXPECT_NEAR(correctCrankPrediction(model, -200.0, kModelled).value, 10.0 - 0.4 / 1.3, 1e-12);
  // The bounds go along: there are too few for an interval of their own.
  EXPECT_NEAR(correctCrankPrediction(model, -200.0, kModelled).lower, 9.8 - 0.4 / 1.3, 1e-12);
}

TEST(CorrectCrankPrediction, AsksTheNaiveLineOnlyFromFourCranksOn) {
  for (const std::size_t cranks : {3u, 4u}) {
    FittedModel with = cranked(cranks, 0.0), without = with;
    with.fit.baseline.voltage_from_current.emplace();
    with.fit.baseline.voltage_from_current->intercept = 8.0;  // misses all of them by 2 V
    const double apart = std::abs(correctCrankPrediction(with, -200.0, kModelled).value -
                                  correctCrankPrediction(without, -200.0, kModelled).value);
    if (cranks < 4)
      EXPECT_EQ(apart, 0.0);
    else
      EXPECT_GT(apart, 1e-3);
  }
}

TEST(CorrectCrankPrediction, IsTheMeanOfEquationsAndLineEachCorrected) {
  const FittedModel model = cranked(6, 0.0, 0.0, true);
  EXPECT_NEAR(correctCrankPrediction(model, -200.0, {10.4, 10.0, 10.8}).value, 0.5 * (10.4 + 10.0),
              1e-9);
}

TEST(CorrectCrankPrediction, TheSensorsEndOfRangeHasACorrectionOfItsOwn) {
  FittedModel model = knownModel();
  for (int k = 0; k < 10; ++k) {
    // clipped: more flows than is seen
    model.intervals.event_history.add(pastCrank(2.0 * k, -250.0, 9.0, 9.5));
    model.intervals.event_history.add(pastCrank(2.0 * k + 1.0, -200.0, 10.0, 10.0));
  }
  EXPECT_NEAR(correctCrankPrediction(model, -250.0, kModelled).value, 9.5, 0.03);
  EXPECT_NEAR(correctCrankPrediction(model, -200.0, kModelled).value, 10.0, 0.03);
}

/// Cranks measured whole just inside the range, and others that the sensor cut off at -250 A.
FittedModel crankedBeyondTheSensor() {
  Random random(4);
  FittedModel model = knownModel();
  model.fit.excited.sensor_min_current = -250.0;
  for (int k = 0; k < 8; ++k) {
    const double current = -235.0 - 2.0 * (k % 7);
    model.intervals.event_history.add(pastCrank(2.0 * k, current, 11.36 + 0.03 * random.normal(),
                                                11.3 + 0.004 * (current + 240.0)));
    model.intervals.event_history.add(
        pastCrank(2.0 * k + 1.0, -250.0, 10.5 + 0.3 * random.normal(), 11.26));
  }
  return model;
}

TEST(CorrectCrankPrediction, AtTheSensorsEndHoldsCranksOfExactlyThisCurrentAndThoseBeyond) {
  const FittedModel model = crankedBeyondTheSensor();
  const Interval at_end = correctCrankPrediction(model, -250.0, {11.26, 11.1, 11.4});
  EXPECT_GT(at_end.upper, 11.36);
  EXPECT_LT(at_end.lower, 10.3);
  EXPECT_NEAR(at_end.value, 10.5, 0.3);
}

TEST(CorrectCrankPrediction, AsTheSensorShowsItsEndIsThatOfCranksThatEndedThere) {
  const FittedModel model = crankedBeyondTheSensor();
  const Interval modelled{11.26, 11.1, 11.4},
      shown = correctCrankPrediction(model, -250.0, modelled, CurrentMeaning::kShown),
      asked = correctCrankPrediction(model, -250.0, modelled);
  EXPECT_EQ(shown.value, asked.value);
  EXPECT_EQ(shown.lower, asked.lower);
  EXPECT_LT(shown.upper, asked.upper) << "none that was measured whole is in it";
}

TEST(CorrectCrankPrediction, WhatWasCutOffSaysNothingOfCranksThatAreMeasuredWhole) {
  const FittedModel model = crankedBeyondTheSensor();
  const Interval whole = correctCrankPrediction(model, -240.0, {11.3, 11.1, 11.5});
  EXPECT_NEAR(whole.value, 11.36, 0.05);
  EXPECT_GT(whole.lower, 11.2);
  // Of more current than the sensor shows it is the model's that the whole ones correct.
  EXPECT_NEAR(correctCrankPrediction(model, -280.0, {11.1, 11.0, 11.2}).value, 11.15, 0.1);
}

TEST(CorrectCrankPrediction, ABoundThatIsViolatedCorrectsEveryCrank) {
  FittedModel model = knownModel();
  model.fit.excited.sensor_min_current = -250.0;
  for (int k = 0; k < 20; ++k) model.intervals.event_history.add(pastCrank(k, -250.0, 10.4, 10.0));
  EXPECT_NEAR(correctCrankPrediction(model, -200.0, kModelled).value, kModelled.value + 0.4, 0.1);
}

TEST(CorrectCrankPrediction, ItsIntervalHoldsNineOfTenNextCranks) {
  Random random(9);
  int inside = 0, cases = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const FittedModel model = cranked(3 + seed % 10, 0.2, 0.1, seed % 2 == 0, seed);
    const double current = random.uniform(-240.0, -160.0), modelled = 12.0 + 0.01 * current;
    const double measured = modelled + 0.2 + 0.1 * random.normal();
    const Interval corrected =
        correctCrankPrediction(model, current, {modelled, modelled - 0.01, modelled + 0.01});
    inside += measured > corrected.lower && measured < corrected.upper;
    ++cases;
  }
  // 90 % of 200: two standard deviations are 4 %; short pasts are widened.
  EXPECT_GT(inside, static_cast<int>(0.86 * cases));
  EXPECT_LT(inside, static_cast<int>(0.98 * cases));
}

TEST(CorrectCrankPrediction, ItsWidthGrowsWithTheScaleOfPastIntervals) {
  FittedModel model = cranked(10, 0.2, 0.1);
  const Interval one = correctCrankPrediction(model, -200.0, kModelled);
  model.intervals.calibrations.cranks.factor = 2.0;
  const Interval two = correctCrankPrediction(model, -200.0, kModelled);
  EXPECT_EQ(two.value, one.value);
  EXPECT_NEAR(two.upper - two.value, 2.0 * (one.upper - one.value), 1e-12);
}

// ---------------------------------------------------------------------------------- charges

TEST(CorrectChargePrediction, WithFewerThanThreePastChargesIsTheModelsAnswer) {
  for (const std::size_t charges : {0u, 1u, 2u})
    EXPECT_TRUE(
        same(correctChargePrediction(charged(charges, 3.0), kBeginning, kModelled), kModelled))
        << charges;
}

TEST(CorrectChargePrediction, ChargesAtOtherVoltagesAndDurationsSayNothing) {
  EXPECT_TRUE(
      same(correctChargePrediction(charged(10, 3.0, 0.0, 13.0), kBeginning, kModelled), kModelled));
  ChargeBeginning minute = kBeginning;
  minute.duration = 60.0;
  EXPECT_TRUE(same(correctChargePrediction(charged(10, 3.0), minute, kModelled), kModelled));
}

TEST(CorrectChargePrediction, TakesABiasOff) {
  const double corrected = correctChargePrediction(charged(20, 3.0), kBeginning, kModelled).value;
  EXPECT_GT(corrected, kModelled.value + 1.0);
  EXPECT_LT(corrected, kModelled.value + 3.5);
}

TEST(CorrectChargePrediction, LeavesAModelAloneThatMissesNothing) {
  const Interval corrected = correctChargePrediction(charged(20, 0.0), kBeginning, kModelled);
  EXPECT_NEAR(corrected.value, kModelled.value, 0.1);
  EXPECT_LT(corrected.upper - corrected.lower, kModelled.upper - kModelled.lower);
}

TEST(CorrectChargePrediction, AModelThatIsFarOffGivesWayToTheMedian) {
  FittedModel model = knownModel();
  Random random(4);
  for (int k = 0; k < 3; ++k)  // with three: model and median alone
    model.intervals.event_history.add(
        pastCharge(1.0 * k, 14.0, 13.7, 5.0 + 0.01 * k, random.uniform(15.0, 60.0)));
  EXPECT_NEAR(correctChargePrediction(model, kBeginning, {40.0, 30.0, 50.0}).value, 5.01, 0.5);
}

TEST(CorrectChargePrediction, ItsIntervalHoldsNineOfTenNextCharges) {
  Random random(10);
  int inside = 0, cases = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const FittedModel model = charged(3 + seed % 12, 1.0, 0.5, 14.0, seed);
    const double modelled = random.uniform(8.0, 12.0),
                 measured = modelled + 1.0 + 0.5 * random.normal();
    const Interval corrected =
        correctChargePrediction(model, kBeginning, {modelled, modelled, modelled});
    inside += measured > corrected.lower && measured < corrected.upper;
    ++cases;
  }
  EXPECT_GT(inside, static_cast<int>(0.84 * cases));
  EXPECT_LT(inside, static_cast<int>(0.99 * cases));
}

// ---------------------------------------------------------------------------------- evidence

TEST(ChargeEvidence, VouchesFromThreeChargesAlikeThatWereForeseenOn) {
  EXPECT_EQ(chargeEvidence({}, 14.0, 10.0).charges, 0);
  EXPECT_FALSE(chargeEvidence({}, 14.0, 10.0).is_supported);
  EXPECT_FALSE(chargeEvidence(charged(2, 0.1).intervals.event_history, 14.0, 10.0).is_supported);
  const ChargeEvidence evidence =
      chargeEvidence(charged(3, 0.1).intervals.event_history, 14.0, 10.0);
  EXPECT_EQ(evidence.charges, 3);
  EXPECT_NEAR(evidence.median_error, 0.1, 1e-9);
  EXPECT_GT(evidence.typical, 8.0);
  EXPECT_TRUE(evidence.is_supported);
}

TEST(ChargeEvidence, DoesNotVouchForErrorsAboveAQuarterOfTheCurrent) {
  EXPECT_TRUE(chargeEvidence(charged(10, 2.0).intervals.event_history, 14.0, 10.0).is_supported);
  EXPECT_FALSE(chargeEvidence(charged(10, 5.0).intervals.event_history, 14.0, 10.0).is_supported);
}

TEST(ChargeEvidence, OneAmpereIsAlwaysGoodEnough) {
  EventHistory event_history;
  for (int k = 0; k < 5; ++k) event_history.add(pastCharge(1.0 * k, 14.0, 14.0, 0.6, 1.4));
  EXPECT_TRUE(chargeEvidence(event_history, 14.0, 10.0).is_supported);
}

TEST(ChargeEvidence, CountsNoChargeAtAnotherVoltageOrOverAnotherTime) {
  const EventHistory event_history = charged(10, 0.1).intervals.event_history;
  EXPECT_EQ(chargeEvidence(event_history, 14.5, 10.0).charges, 0);
  EXPECT_EQ(chargeEvidence(event_history, 14.0, 60.0).charges, 0);
  EXPECT_EQ(chargeEvidence(event_history, 14.0, 19.0).charges, 10);
}

}  // namespace
}  // namespace battery_sof

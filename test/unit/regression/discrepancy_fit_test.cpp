#include "regression/discrepancy_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "regression/discrepancy_curve.hpp"
#include "support/composed.hpp"
#include "util/constants.hpp"

namespace battery_sof {
namespace {

using namespace test;

ModelPoint truePoint() { return pointOf(BatteryModel(), typicalPoint(BatteryModel())); }

/// The base circuit at 10 Hz, where every sample is a row of its own, with a millivolt of noise.
Series tenHertz(double duration, std::uint64_t seed) {
  return test::answered(drivenBattery(), dataSetOneCurrent(duration, 0.1, seed), 0.1, 0.001, seed);
}

/// Adds the square root of what ten seconds of charging leave: no column has that form [V].
Series withRootOfCharging(Series series, double strength) {
  double memory = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    memory += -std::expm1(-(series.time[n] - series.time[n - 1]) / 10.0) *
              (std::max(series.current[n], 0.0) - memory);
    series.voltage[n] += strength * std::sqrt(memory);
  }
  return series;
}

/// A drive with what the true base circuit leaves of it.
struct Learnt {
  explicit Learnt(const Series& series, double share = 1.0)
      : inputs(inputSequence(series, whole(series))),
        training(static_cast<std::size_t>(share * static_cast<double>(series.size()))),
        response(linearizationOf(BatteryModel(), truePoint(), inputs, training)),
        table(designMatrix(inputs, response, drivenBattery().beta)) {}

  InputSequence inputs;
  std::size_t training;
  Linearization response;
  DesignMatrix table;
};

/// A discrepancy with a table's regressors, all of one weight, that changes nothing of the base
/// circuit.
DiscrepancyModel discrepancyOf(const DesignMatrix& table, double weight) {
  DiscrepancyModel discrepancy;
  discrepancy.regressors = table.regressors;
  discrepancy.context = table.context;
  discrepancy.lower = table.lower;
  discrepancy.upper = table.upper;
  discrepancy.centre = table.centre;
  discrepancy.scale = table.scale;
  discrepancy.weight = Eigen::VectorXd::Constant(table.centre.size(), weight);
  discrepancy.base_change = Eigen::VectorXd::Zero(kBaseDirections);
  return discrepancy;
}

double rms(const Eigen::VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

/// A constant of many amperes is no regressor, although rounding moves it.
TEST(DesignMatrix, HasNoColumnThatDoesNotMove) {
  Series series;
  for (int k = 0; k < 200; ++k) series.append({0.1 * k, -30.0, 12.3});
  const Learnt learnt(series);
  EXPECT_TRUE(learnt.table.values.allFinite());
  for (Eigen::Index k = 0; k < learnt.table.scale.size(); ++k)
    EXPECT_GT(learnt.table.scale[k], 1e-9 * std::abs(learnt.table.upper[k])) << k;
}

// ---------------------------------------------------------------------------------------------
// the direction that is controlled

/// Half a minute of load, a minute of a source that holds and moves its voltage, at one sample a
/// second. The battery is the base circuit with a force [V] at its terminals.
struct Forced {
  Eigen::VectorXd discrepancy;
  Series series;
  std::vector<char> voltage_controlled;

  explicit Forced(std::size_t samples) : discrepancy(static_cast<Eigen::Index>(samples)) {
    Random random(3);
    Simulation battery(BatteryModel(), truePoint());
    double level = 0.0, held = 13.0, current = 0.0;
    for (std::size_t n = 0; n < samples; ++n) {
      if (n % 7 == 0) level = random.uniform(-0.002, 0.002);
      if (n % 11 == 0) held = random.uniform(12.85, 13.2);
      const auto time = static_cast<double>(n);
      const double added = n == 0 ? 0.0 : level;
      InputSample sample;
      sample.voltage_controlled = n % 90 >= 30;
      sample.step = n == 0 ? InputStep{} : inputStep(time - 1.0, current, time, -20.0, 10.0);
      if (n == 0) sample.step.held = sample.step.current = -20.0;
      sample.voltage = held - added;  // what the base circuit in it sees of the source
      const double compared = battery.follow(sample);
      current = sample.voltage_controlled ? sample.step.current - compared : -20.0;
      discrepancy[static_cast<Eigen::Index>(n)] = added;
      series.append({time, current, sample.voltage_controlled ? held : battery.voltage() + added});
      voltage_controlled.push_back(sample.voltage_controlled);
    }
  }
};

TEST(Answered, IsWhatABaseCircuitLeavesOfABatteryWithTheForceAtItsTerminals) {
  const Forced forced(1800);
  const InputSequence inputs =
      inputSequence(forced.series, whole(forced.series), {}, forced.voltage_controlled);
  const Linearization response =
      linearizationOf(BatteryModel(), truePoint(), inputs, inputs.samples.size());
  const Eigen::VectorXd answer = answered(response, forced.discrepancy);
  EXPECT_LT(rms(response.error - answer), 0.05 * rms(answer));
  EXPECT_GT(rms(response.error - forced.discrepancy), 0.25 * rms(answer))
      << "the double layer has no part in it";
}

TEST(Answered, IsTheForceItselfWhereTheCurrentDrives) {
  const Learnt estimated(tenHertz(60.0, 2));
  const Eigen::VectorXd discrepancy =
      Eigen::VectorXd::LinSpaced(estimated.response.error.size(), -0.01, 0.02);
  EXPECT_TRUE(answered(estimated.response, discrepancy) == discrepancy);
}

// ---------------------------------------------------------------------------------------------
// what a base circuit leaves

TEST(Linearization, OfTheTruthIsTheNoiseOnTheRowsOfATenthOfASecond) {
  const Series series = baseDrive(3, 60.0, 0.002);
  const InputSequence inputs = inputSequence(series, whole(series));
  const Linearization response =
      linearizationOf(BatteryModel(), truePoint(), inputs, inputs.samples.size());
  EXPECT_EQ(600, response.error.size());
  EXPECT_NEAR(0.002 / std::sqrt(10.0), rms(response.error), 1e-4);
}

TEST(Linearization, SensitivitiesAgreeWithDifferences) {
  const Series series = tenHertz(60.0, 2);
  const InputSequence inputs = inputSequence(series, whole(series));
  const Linearization response =
      linearizationOf(BatteryModel(), truePoint(), inputs, inputs.samples.size());
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    const double step = 1e-5;
    const auto errorAt = [&](double by) {
      ModelPoint at = truePoint();
      double& value = direction == kBaseRows ? at.state[0] : at.parameters[direction];
      value = direction == kRowC2 || direction == kRowBeta ? value * std::exp(by) : value + by;
      return linearizationOf(BatteryModel(), at, inputs, inputs.samples.size()).error;
    };
    const Eigen::VectorXd slope = -(errorAt(step) - errorAt(-step)) / (2.0 * step);
    EXPECT_LT(rms(slope - response.sensitivity.col(direction)), 1e-5 * rms(slope) + 1e-9)
        << direction;
  }
}

TEST(DesignMatrix, ColumnsOfTheTrainingPartHaveNoMeanAndUnitRms) {
  const Learnt estimated(tenHertz(300.0, 2));
  for (Eigen::Index k = 0; k < estimated.table.values.cols(); ++k) {
    EXPECT_NEAR(0.0, estimated.table.values.col(k).mean(), 1e-8) << k;
    EXPECT_NEAR(1.0, rms(estimated.table.values.col(k)), 1e-8) << k;
  }
}

TEST(DesignMatrix, WhatComesAfterTheTrainingPartChangesNothingInIt) {
  Series series = tenHertz(300.0, 2), other = series;
  for (std::size_t n = 2000; n < other.size(); ++n)
    other.current[n] = 3.0 * other.current[n] + 50.0;
  const Learnt one(series, 2.0 / 3.0), two(other, 2.0 / 3.0);
  ASSERT_EQ(one.table.values.cols(), two.table.values.cols());
  EXPECT_EQ(2000, one.response.training);
  EXPECT_TRUE(one.table.values.topRows(2000) == two.table.values.topRows(2000));
  EXPECT_FALSE(one.table.values.bottomRows(1000) == two.table.values.bottomRows(1000));
}

TEST(DesignMatrix, ColumnsStayInsideTheirTrainingRange) {
  Series series = tenHertz(300.0, 2);
  for (std::size_t n = 2000; n < series.size(); ++n) series.current[n] *= 5.0;
  const Learnt estimated(series, 2.0 / 3.0);
  for (Eigen::Index k = 0; k < estimated.table.values.cols(); ++k) {
    const RegressorKind kind = estimated.table.regressors[static_cast<std::size_t>(k)].kind;
    const Eigen::VectorXd column = estimated.table.values.col(k), training = column.head(2000);
    if (kind == RegressorKind::kCharge || kind == RegressorKind::kSlowCharge) continue;
    EXPECT_LE(column.maxCoeff(), training.maxCoeff()) << k;
    EXPECT_GE(column.minCoeff(), training.minCoeff()) << k;
  }
}

// ---------------------------------------------------------------------------------------------
// what is estimated

TEST(LeftOutErrors, OfTheBaseCircuitsOwnVoltageGainNothing) {
  const Learnt estimated(tenHertz(400.0, 4));
  const LeftOutErrors errors = leftOutErrors(estimated.response, estimated.table, 4, isTimeless);
  EXPECT_GT(errors.discrepancy, 0.95 * errors.base);
}

/// The first u_c2 is all but free when the first block is left out: what fits the others may be far
/// off there.
TEST(LeftOutErrors, OfTheFirstBlockAreNoLargerThanOfTheOthers) {
  for (const std::uint64_t seed : {5u, 6u, 7u, 12u}) {
    const Learnt estimated(tenHertz(400.0, seed));
    const LeftOutErrors errors = leftOutErrors(estimated.response, estimated.table, 4, isTimeless);
    EXPECT_LT(errors.base, 0.0012) << "seed " << seed;
    EXPECT_GT(errors.discrepancy, 0.95 * errors.base) << "seed " << seed;
  }
}

TEST(LeftOutErrors, OfAMemoryOfChargingThatNoColumnHasFallByMoreThanHalf) {
  const Learnt estimated(withRootOfCharging(tenHertz(400.0, 4), 0.02));
  const LeftOutErrors errors = leftOutErrors(estimated.response, estimated.table, 4, isTimeless);
  EXPECT_GT(errors.base, 0.01);
  EXPECT_LT(errors.discrepancy, 0.5 * errors.base);
  EXPECT_NEAR(rms(estimated.response.error), errors.in_sample, 1e-9);
}

TEST(FitDiscrepancy, PutsAMemoryOfChargingIntoTheFamilyOfAcceptance) {
  const Learnt estimated(withRootOfCharging(tenHertz(400.0, 4), 0.02));
  const DiscrepancyFit discrepancy = fitDiscrepancy(estimated.response, estimated.table);
  ASSERT_FALSE(discrepancy.mechanisms.empty());
  EXPECT_EQ("acceptance", mechanismId(discrepancy.mechanisms.front().mechanism));
  EXPECT_GT(discrepancy.gain, 6.0);
}

TEST(FitDiscrepancy, OfTheBaseCircuitsOwnVoltageFindsNoForce) {
  const Learnt estimated(tenHertz(400.0, 4));
  const DiscrepancyFit discrepancy = fitDiscrepancy(estimated.response, estimated.table);
  EXPECT_LT(discrepancy.gain, 3.0);
  EXPECT_LT(discrepancy.rms, 0.0002);
  EXPECT_NEAR(0.001, discrepancy.noise, 1e-4);
}

TEST(FitDiscrepancy, TakesOnlyTheColumnsThatAreWanted) {
  const Learnt estimated(withRootOfCharging(tenHertz(200.0, 4), 0.02));
  const DiscrepancyFit fit = fitDiscrepancy(estimated.response, estimated.table, isTimeless);
  EXPECT_LT(fit.discrepancy.regressors.size(), estimated.table.regressors.size());
  for (const Regressor& regressor : fit.discrepancy.regressors)
    EXPECT_TRUE(isTimeless(regressor)) << toString(regressor);
}

/// A resistance that grew by 3 mOhm over the first half of what is estimated from, slowly at first
/// and at last, and stays there.
TEST(FitDiscrepancy, HoldsWhatHasDriftedWhereTheTrainingPartLeftIt) {
  Series series = tenHertz(400.0, 4);
  for (std::size_t n = 0; n < series.size(); ++n)
    series.voltage[n] +=
        0.0015 * (1.0 - std::cos(kPi * std::min(series.time[n] / 150.0, 1.0))) * series.current[n];
  const Learnt estimated(series, 0.75);
  const auto missed = [&](const RegressorFilter& wanted) {
    return rms((estimated.response.error -
                fitDiscrepancy(estimated.response, estimated.table, wanted).predicted)
                   .tail(1000));
  };
  EXPECT_LT(missed(nullptr), 0.5 * missed(isTimeless));
}

// ---------------------------------------------------------------------------------------------
// used

TEST(WithDiscrepancy, IsWhatTheFitSaysOfEveryRowAlsoBeyondTheTrainingPart) {
  const Learnt estimated(withRootOfCharging(tenHertz(400.0, 4), 0.02), 0.75);
  const DiscrepancyFit fit = fitDiscrepancy(
      discrepancyLinearizationOf(BatteryModel(), truePoint(), estimated.inputs, estimated.training),
      estimated.table, isTimeless);
  const BatteryModel model =
      withDiscrepancy(BatteryModel(), std::make_shared<const DiscrepancyModel>(fit.discrepancy));
  const std::vector<double> voltage =
      voltages(model, pointOf(model, withFactors(model, truePoint().parameters)), estimated.inputs);
  const std::vector<double> base = voltages(BatteryModel(), truePoint(), estimated.inputs);
  ASSERT_EQ(voltage.size(), static_cast<std::size_t>(fit.predicted.size()));
  for (std::size_t n = 0; n < voltage.size(); ++n)
    ASSERT_NEAR(base[n] + fit.predicted[static_cast<Eigen::Index>(n)], voltage[n], 1e-9) << n;
}

TEST(DiscrepancyLinearizationOf, HardlyChangesTheSensitivities) {
  const Learnt estimated(tenHertz(300.0, 5));
  const Linearization taken =
      discrepancyLinearizationOf(BatteryModel(), truePoint(), estimated.inputs, estimated.training);
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    const Eigen::VectorXd exact = estimated.response.sensitivity.col(direction);
    EXPECT_LT(rms(taken.sensitivity.col(direction) - exact), 0.02 * rms(exact)) << direction;
  }
}

TEST(AnswersOf, AreZeroWithoutACurrent) {
  const Learnt estimated(tenHertz(300.0, 5));
  const std::vector<DiscrepancyAnswer> answers =
      answersOf(discrepancyOf(estimated.table, 0.001), 0.0, [](double) { return 100.0; });
  ASSERT_FALSE(answers.empty());
  for (const DiscrepancyAnswer& answer : answers) {
    EXPECT_NEAR(0.0, answer.charging, 1e-12) << answer.time;
    EXPECT_NEAR(0.0, answer.discharging, 1e-12) << answer.time;
  }
}

TEST(AnswersOf, AMemoryOfChargingRiseWhileChargingAndStayZeroWhileDischarging) {
  DiscrepancyModel discrepancy;
  discrepancy.regressors = {{RegressorKind::kChargeMemory, Mechanism::kAcceptance, 10.0}};
  discrepancy.context.interval = 0.1;
  discrepancy.context.span = 600.0;
  discrepancy.lower = Eigen::VectorXd::Constant(1, 0.0);
  discrepancy.upper = Eigen::VectorXd::Constant(1, 50.0);
  discrepancy.centre = Eigen::VectorXd::Constant(1, 4.0);
  discrepancy.scale = Eigen::VectorXd::Constant(1, 8.0);
  discrepancy.weight = Eigen::VectorXd::Constant(1, 0.02);
  for (const DiscrepancyAnswer& answer :
       answersOf(discrepancy, 20.0, [](double) { return 200.0; })) {
    EXPECT_NEAR(-0.02 / 8.0 * 20.0 * std::expm1(-answer.time / 10.0), answer.charging, 1e-12)
        << answer.time;
    EXPECT_EQ(0.0, answer.discharging);
  }
}

TEST(AnswersOf, EndAtHalfADayHoweverLongAGapTheRecordingHad) {
  DiscrepancyModel discrepancy;
  discrepancy.regressors = {{RegressorKind::kChargeMemory, Mechanism::kAcceptance, 10.0}};
  discrepancy.context.interval = 0.1;
  discrepancy.context.span = 2e9;
  for (Eigen::VectorXd* each : {&discrepancy.lower, &discrepancy.upper, &discrepancy.centre,
                                &discrepancy.scale, &discrepancy.weight})
    *each = Eigen::VectorXd::Constant(1, 1.0);
  const std::vector<DiscrepancyAnswer> answers =
      answersOf(discrepancy, 20.0, [](double) { return 1e9; });
  ASSERT_FALSE(answers.empty());
  EXPECT_LE(answers.back().time, 43200.0 + 1e-6);
}

}  // namespace
}  // namespace battery_sof

#include "battery_sof/learn/force_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "battery_sof/recording/pi.hpp"
#include "support/composed.hpp"

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
    memory += -std::expm1(-(series.time[n] - series.time[n - 1]) / 10.0) * (std::max(series.current[n], 0.0) - memory);
    series.voltage[n] += strength * std::sqrt(memory);
  }
  return series;
}

/// A drive with what the true base circuit leaves of it.
struct Learnt {
  explicit Learnt(const Series& series, double share = 1.0)
      : drive(fullDrive(series, whole(series))),
        training(static_cast<std::size_t>(share * static_cast<double>(series.size()))),
        response(baseResponse(BatteryModel(), truePoint(), drive, training)),
        table(forceTable(drive, response, drivenBattery().beta)) {}

  Drive drive;
  std::size_t training;
  BaseResponse response;
  ForceTable table;
};

/// A force with a table's columns, all of one weight, that changes nothing of the base circuit.
LearnedForce forceOf(const ForceTable& table, double weight) {
  LearnedForce force;
  force.columns = table.columns;
  force.context = table.context;
  force.lower = table.lower;
  force.upper = table.upper;
  force.centre = table.centre;
  force.scale = table.scale;
  force.weight = Eigen::VectorXd::Constant(table.centre.size(), weight);
  force.base_change = Eigen::VectorXd::Zero(kBaseDirections);
  return force;
}

double rms(const Eigen::VectorXd& x) { return std::sqrt(x.squaredNorm() / static_cast<double>(x.size())); }

// ---------------------------------------------------------------------------------------------
// the direction that is imposed

/// Half a minute of load, a minute of a source that holds and moves its voltage, at one sample a second. The battery is the base
/// circuit with a force [V] at its terminals.
struct Forced {
  Eigen::VectorXd force;
  Series series;
  std::vector<char> voltage_drives;

  explicit Forced(std::size_t samples) : force(static_cast<Eigen::Index>(samples)) {
    Random random(3);
    Simulation battery(BatteryModel(), truePoint());
    double level = 0.0, held = 13.0, current = 0.0;
    for (std::size_t n = 0; n < samples; ++n) {
      if (n % 7 == 0) level = random.uniform(-0.002, 0.002);
      if (n % 11 == 0) held = random.uniform(12.85, 13.2);
      const auto time = static_cast<double>(n);
      const double added = n == 0 ? 0.0 : level;
      DriveSample sample;
      sample.voltage_drives = n % 90 >= 30;
      sample.step = n == 0 ? DriveStep{} : driveStep(time - 1.0, current, time, -20.0, 10.0);
      if (n == 0) sample.step.held = sample.step.current = -20.0;
      sample.voltage = held - added;  // what the base circuit in it sees of the source
      const double compared = battery.follow(sample);
      current = sample.voltage_drives ? sample.step.current - compared : -20.0;
      force[static_cast<Eigen::Index>(n)] = added;
      series.time.push_back(time);
      series.current.push_back(current);
      series.voltage.push_back(sample.voltage_drives ? held : battery.voltage() + added);
      voltage_drives.push_back(sample.voltage_drives);
    }
  }
};

TEST(Answered, IsWhatABaseCircuitLeavesOfABatteryWithTheForceAtItsTerminals) {
  const Forced forced(1800);
  const Drive drive = fullDrive(forced.series, whole(forced.series), {}, forced.voltage_drives);
  const BaseResponse response = baseResponse(BatteryModel(), truePoint(), drive, drive.samples.size());
  const Eigen::VectorXd answer = answered(response, forced.force);
  EXPECT_LT(rms(response.error - answer), 0.05 * rms(answer));
  EXPECT_GT(rms(response.error - forced.force), 0.25 * rms(answer)) << "the double layer has no part in it";
}

TEST(Answered, IsTheForceItselfWhereTheCurrentDrives) {
  const Learnt learnt(tenHertz(60.0, 2));
  const Eigen::VectorXd force = Eigen::VectorXd::LinSpaced(learnt.response.error.size(), -0.01, 0.02);
  EXPECT_TRUE(answered(learnt.response, force) == force);
}

// ---------------------------------------------------------------------------------------------
// what a base circuit leaves

TEST(BaseResponse, OfTheTruthIsTheNoiseOnTheRowsOfATenthOfASecond) {
  const Series series = baseDrive(3, 60.0, 0.002);
  const Drive drive = fullDrive(series, whole(series));
  const BaseResponse response = baseResponse(BatteryModel(), truePoint(), drive, drive.samples.size());
  EXPECT_EQ(600, response.error.size());
  EXPECT_NEAR(0.002 / std::sqrt(10.0), rms(response.error), 1e-4);
}

TEST(BaseResponse, SensitivitiesAgreeWithDifferences) {
  const Series series = tenHertz(60.0, 2);
  const Drive drive = fullDrive(series, whole(series));
  const BaseResponse response = baseResponse(BatteryModel(), truePoint(), drive, drive.samples.size());
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    const double step = 1e-5;
    const auto errorAt = [&](double by) {
      ModelPoint at = truePoint();
      double& value = direction == kBaseRows ? at.state[0] : at.parameters[direction];
      value = direction == kRowC2 || direction == kRowBeta ? value * std::exp(by) : value + by;
      return baseResponse(BatteryModel(), at, drive, drive.samples.size()).error;
    };
    const Eigen::VectorXd slope = -(errorAt(step) - errorAt(-step)) / (2.0 * step);
    EXPECT_LT(rms(slope - response.sensitivity.col(direction)), 1e-5 * rms(slope) + 1e-9) << direction;
  }
}

TEST(ForceTable, ColumnsOfTheTrainingPartHaveNoMeanAndUnitRms) {
  const Learnt learnt(tenHertz(300.0, 2));
  for (Eigen::Index k = 0; k < learnt.table.values.cols(); ++k) {
    EXPECT_NEAR(0.0, learnt.table.values.col(k).mean(), 1e-8) << k;
    EXPECT_NEAR(1.0, rms(learnt.table.values.col(k)), 1e-8) << k;
  }
}

TEST(ForceTable, WhatComesAfterTheTrainingPartChangesNothingInIt) {
  Series series = tenHertz(300.0, 2), other = series;
  for (std::size_t n = 2000; n < other.size(); ++n) other.current[n] = 3.0 * other.current[n] + 50.0;
  const Learnt one(series, 2.0 / 3.0), two(other, 2.0 / 3.0);
  ASSERT_EQ(one.table.values.cols(), two.table.values.cols());
  EXPECT_EQ(2000, one.response.training);
  EXPECT_TRUE(one.table.values.topRows(2000) == two.table.values.topRows(2000));
  EXPECT_FALSE(one.table.values.bottomRows(1000) == two.table.values.bottomRows(1000));
}

TEST(ForceTable, ColumnsStayInsideTheirTrainingRange) {
  Series series = tenHertz(300.0, 2);
  for (std::size_t n = 2000; n < series.size(); ++n) series.current[n] *= 5.0;
  const Learnt learnt(series, 2.0 / 3.0);
  for (Eigen::Index k = 0; k < learnt.table.values.cols(); ++k) {
    const ForceKind kind = learnt.table.columns[static_cast<std::size_t>(k)].kind;
    const Eigen::VectorXd column = learnt.table.values.col(k), training = column.head(2000);
    if (kind == ForceKind::kCharge || kind == ForceKind::kSlowCharge) continue;
    EXPECT_LE(column.maxCoeff(), training.maxCoeff()) << k;
    EXPECT_GE(column.minCoeff(), training.minCoeff()) << k;
  }
}

// ---------------------------------------------------------------------------------------------
// what is learnt

TEST(LeftOutErrors, OfTheBaseCircuitsOwnVoltageGainNothing) {
  const Learnt learnt(tenHertz(400.0, 4));
  const LeftOutErrors errors = leftOutErrors(learnt.response, learnt.table, 4, isTimeless);
  EXPECT_GT(errors.force, 0.95 * errors.base);
}

/// The first u_c2 is all but free when the first block is left out: what fits the others may be far off there.
TEST(LeftOutErrors, OfTheFirstBlockAreNoLargerThanOfTheOthers) {
  for (const std::uint64_t seed : {5u, 6u, 7u, 12u}) {
    const Learnt learnt(tenHertz(400.0, seed));
    const LeftOutErrors errors = leftOutErrors(learnt.response, learnt.table, 4, isTimeless);
    EXPECT_LT(errors.base, 0.0012) << "seed " << seed;
    EXPECT_GT(errors.force, 0.95 * errors.base) << "seed " << seed;
  }
}

TEST(LeftOutErrors, OfAMemoryOfChargingThatNoColumnHasFallByMoreThanHalf) {
  const Learnt learnt(withRootOfCharging(tenHertz(400.0, 4), 0.02));
  const LeftOutErrors errors = leftOutErrors(learnt.response, learnt.table, 4, isTimeless);
  EXPECT_GT(errors.base, 0.01);
  EXPECT_LT(errors.force, 0.5 * errors.base);
}

TEST(LearnForce, PutsAMemoryOfChargingIntoTheFamilyOfAcceptance) {
  const Learnt learnt(withRootOfCharging(tenHertz(400.0, 4), 0.02));
  const ForceFit force = learnForce(learnt.response, learnt.table);
  ASSERT_FALSE(force.families.empty());
  EXPECT_EQ("acceptance", familyId(force.families.front().family));
  EXPECT_GT(force.gain, 6.0);
}

TEST(LearnForce, OfTheBaseCircuitsOwnVoltageFindsNoForce) {
  const Learnt learnt(tenHertz(400.0, 4));
  const ForceFit force = learnForce(learnt.response, learnt.table);
  EXPECT_LT(force.gain, 3.0);
  EXPECT_LT(force.rms, 0.0002);
  EXPECT_NEAR(0.001, force.noise, 1e-4);
}

TEST(LearnForce, TakesOnlyTheColumnsThatAreWanted) {
  const Learnt learnt(withRootOfCharging(tenHertz(200.0, 4), 0.02));
  const ForceFit fit = learnForce(learnt.response, learnt.table, isTimeless);
  EXPECT_LT(fit.force.columns.size(), learnt.table.columns.size());
  for (const ForceColumn& column : fit.force.columns) EXPECT_TRUE(isTimeless(column)) << describe(column);
}

/// A resistance that grew by 3 mOhm over the first half of what is learnt from, slowly at first and at last, and stays there.
TEST(LearnForce, HoldsWhatHasDriftedWhereTheTrainingPartLeftIt) {
  Series series = tenHertz(400.0, 4);
  for (std::size_t n = 0; n < series.size(); ++n)
    series.voltage[n] += 0.0015 * (1.0 - std::cos(kPi * std::min(series.time[n] / 150.0, 1.0))) * series.current[n];
  const Learnt learnt(series, 0.75);
  const auto missed = [&](const ColumnFilter& wanted) {
    return rms((learnt.response.error - learnForce(learnt.response, learnt.table, wanted).predicted).tail(1000));
  };
  EXPECT_LT(missed(nullptr), 0.5 * missed(isTimeless));
}

// ---------------------------------------------------------------------------------------------
// used

TEST(WithForce, IsWhatTheFitSaysOfEveryRowAlsoBeyondTheTrainingPart) {
  Learnt learnt(withRootOfCharging(tenHertz(400.0, 4), 0.02), 0.75);
  takeForceDirections(learnt.response, BatteryModel(), truePoint(), learnt.drive);
  const ForceFit fit = learnForce(learnt.response, learnt.table, isTimeless);
  const BatteryModel model = withForce(BatteryModel(), std::make_shared<const LearnedForce>(fit.force));
  const std::vector<double> voltage = voltages(model, pointOf(model, withFactors(model, truePoint().parameters)), learnt.drive);
  const std::vector<double> base = voltages(BatteryModel(), truePoint(), learnt.drive);
  ASSERT_EQ(voltage.size(), static_cast<std::size_t>(fit.predicted.size()));
  for (std::size_t n = 0; n < voltage.size(); ++n)
    ASSERT_NEAR(base[n] + fit.predicted[static_cast<Eigen::Index>(n)], voltage[n], 1e-9) << n;
}

TEST(TakeForceDirections, HardlyChangesTheSensitivities) {
  const Learnt learnt(tenHertz(300.0, 5));
  BaseResponse taken = learnt.response;
  takeForceDirections(taken, BatteryModel(), truePoint(), learnt.drive);
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    const Eigen::VectorXd exact = learnt.response.sensitivity.col(direction);
    EXPECT_LT(rms(taken.sensitivity.col(direction) - exact), 0.02 * rms(exact)) << direction;
  }
}

TEST(AnswersOf, AreZeroWithoutACurrent) {
  const Learnt learnt(tenHertz(300.0, 5));
  const std::vector<ForceAnswer> answers = answersOf(forceOf(learnt.table, 0.001), 0.0);
  ASSERT_FALSE(answers.empty());
  for (const ForceAnswer& answer : answers) {
    EXPECT_NEAR(0.0, answer.charging, 1e-12) << answer.time;
    EXPECT_NEAR(0.0, answer.discharging, 1e-12) << answer.time;
  }
}

TEST(AnswersOf, AMemoryOfChargingRiseWhileChargingAndStayZeroWhileDischarging) {
  LearnedForce force;
  force.columns = {{ForceKind::kChargeMemory, Family::kAcceptance, 10.0}};
  force.context.interval = 0.1;
  force.context.span = 600.0;
  force.lower = Eigen::VectorXd::Constant(1, 0.0);
  force.upper = Eigen::VectorXd::Constant(1, 50.0);
  force.centre = Eigen::VectorXd::Constant(1, 4.0);
  force.scale = Eigen::VectorXd::Constant(1, 8.0);
  force.weight = Eigen::VectorXd::Constant(1, 0.02);
  for (const ForceAnswer& answer : answersOf(force, 20.0)) {
    EXPECT_NEAR(-0.02 / 8.0 * 20.0 * std::expm1(-answer.time / 10.0), answer.charging, 1e-12) << answer.time;
    EXPECT_EQ(0.0, answer.discharging);
  }
}

TEST(AnswersOf, EndAtHalfADayHoweverLongAGapTheRecordingHad) {
  LearnedForce force;
  force.columns = {{ForceKind::kChargeMemory, Family::kAcceptance, 10.0}};
  force.context.interval = 0.1;
  force.context.span = 2e9;
  for (Eigen::VectorXd* each : {&force.lower, &force.upper, &force.centre, &force.scale, &force.weight})
    *each = Eigen::VectorXd::Constant(1, 1.0);
  const std::vector<ForceAnswer> answers = answersOf(force, 20.0);
  ASSERT_FALSE(answers.empty());
  EXPECT_LE(answers.back().time, 43200.0 + 1e-6);
}

}  // namespace
}  // namespace battery_sof

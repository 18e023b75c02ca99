#include "model/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/composed.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

namespace {

const std::vector<std::string> kFive = {"charge_acceptance", "gassing", "acid_transport", "cpe2",
                                        "current_dependent_resistance"};

}  // namespace

TEST(Simulation, OfTheBaseModelTakesItsExactStep) {
  const BatteryModel model;
  const Series series = baseDrive(3, 60.0, 0.0);
  const test::BaseStep step(drivenBattery());
  const InputSequence inputs = inputSequence(series, whole(series));
  const auto u = voltages(model, pointOf(model, typicalPoint(model)), inputs);
  double u_c2 = 0.0;
  for (std::size_t n = 1; n < series.size(); ++n) {
    u_c2 = step.advance(u_c2, 0.5 * (series.current[n - 1] + series.current[n]), 0.01);
    ASSERT_NEAR(u[n], test::terminalVoltage(drivenBattery(), series.current[n], u_c2), 1e-10);
  }
}

TEST(Simulation, GivesTheSameVoltageWithAndWithoutDerivatives) {
  const BatteryModel model(kFive);
  const Series series = livelyMinute(0.1);
  const InputSequence inputs = inputSequence(series, whole(series));
  const ModelPoint start = pointOf(model, typicalPoint(model));
  for (Eigen::Index tangents : {1, 8, 9, 16, 17, 24, 30, 48}) {
    Simulation plain(model, start);
    Simulation carried(
        model, start,
        Eigen::MatrixXd::Ones(model.parameterCount() + model.stateCount(), tangents) * 1e-3);
    for (const InputSample& sample : inputs.samples) {
      plain.advance(sample.step);
      carried.advance(sample.step);
      ASSERT_NEAR(plain.voltage(), carried.voltage(), 1e-10);
    }
  }
}

TEST(Simulation, TheSameDerivativesComeOutOfLanesThatAllReachTheDoubleLayer) {
  const std::vector<std::vector<std::string>> compositions = {
      {"charge_acceptance", "acid_transport", "current_dependent_resistance"},
      {"cpe2", "gassing", "acid_transport", "ocv_soc"},
      {"current_offset", "charge_transfer", "charge_acceptance", "acid_transport"},
      {"self_heating", "charge_acceptance", "acid_transport", "current_dependent_resistance"}};
  const Series series = livelyMinute(0.1);
  const InputSequence inputs = inputSequence(series, whole(series));
  for (const auto& effects : compositions) {
    const BatteryModel model(effects);
    const ModelPoint start = pointOf(model, typicalPoint(model));
    const Eigen::Index rows = model.parameterCount() + model.stateCount();
    const Eigen::Index tangents = std::min<Eigen::Index>(rows, Simulation::kMaxTangents);
    // Mirrored at (1, ..., 1): every lane holds a share of everything.
    const Eigen::MatrixXd mirror =
        Eigen::MatrixXd::Identity(tangents, tangents) -
        Eigen::MatrixXd::Constant(tangents, tangents, 2.0 / static_cast<double>(tangents));
    Eigen::MatrixXd seeds = Eigen::MatrixXd::Identity(rows, tangents);
    for (Eigen::Index j = 0; j < model.parameterCount(); ++j)
      seeds.row(j) *= std::abs(start.parameters[j]) + 1e-3;
    Simulation apart(model, start, seeds), mixed(model, start, seeds * mirror);
    for (const InputSample& sample : inputs.samples) {
      apart.advance(sample.step);
      mixed.advance(sample.step);
      const Eigen::VectorXd expected = mirror * apart.voltageDerivatives();
      ASSERT_NEAR((expected - mixed.voltageDerivatives()).cwiseAbs().maxCoeff(), 0.0,
                  1e-9 * (1.0 + expected.cwiseAbs().maxCoeff()))
          << effects.front();
    }
  }
}

TEST(Simulation, WhatFadesAwayEndsAtZeroInsteadOfSlowingTheProcessor) {
  const BatteryModel model({"charge_acceptance", "acid_transport"});
  const Eigen::Index rows = model.parameterCount() + model.stateCount();
  Simulation simulation(model, pointOf(model, typicalPoint(model)),
                        Eigen::MatrixXd::Identity(rows, rows));
  for (int n = 1; n <= 60000; ++n) {
    InputStep step;
    step.time = n;
    step.duration = 1.0;
    step.held = step.current = n % 2 == 0 ? 5.0 : -5.0;
    simulation.advance(step);
  }
  const Eigen::ArrayXXd slopes = simulation.stateDerivatives().array().abs();
  EXPECT_TRUE((slopes == 0.0 || slopes >= std::numeric_limits<double>::min()).all());
}

TEST(Simulation, ACopyGoesItsOwnWay) {
  const BatteryModel model(kFive);
  Simulation one(model, pointOf(model, typicalPoint(model)));
  InputStep step;
  step.duration = step.time = 5.0;
  step.held = step.current = 30.0;
  one.advance(step);
  Simulation other = one;
  const double before = one.voltage();
  step.time = 10.0;
  step.held = step.current = -200.0;
  other.advance(step);
  EXPECT_EQ(one.voltage(), before);
  EXPECT_LT(other.voltage(), before - 0.5);
  one.advance(step);
  EXPECT_EQ(one.voltage(), other.voltage());
}

TEST(Simulation, AtAHeldVoltageEndsEveryStepAtThatVoltage) {
  const BatteryModel model(kFive);
  Simulation simulation(model, pointOf(model, typicalPoint(model)));
  double before = 1e9;
  for (int k = 0; k < 60; ++k) {
    const double i = simulation.advanceAtVoltage(14.2, 0.5, 1000.0);
    EXPECT_NEAR(simulation.voltage(), 14.2, 1e-7);
    EXPECT_LT(i, before);
    EXPECT_GT(i, 0.0);
    before = i;
  }
}

TEST(Simulation, AtAHeldVoltageKeepsTheCurrentLimit) {
  const BatteryModel model;
  Simulation simulation(model, pointOf(model, typicalPoint(model)));
  EXPECT_EQ(simulation.advanceAtVoltage(14.2, 1.0, 20.0), 20.0);
  EXPECT_LT(simulation.voltage(), 14.2);
}

TEST(Simulation, CurrentAtAHeldVoltageCarriesItsDerivatives) {
  const BatteryModel model({"charge_acceptance", "acid_transport"});
  const Eigen::VectorXd p = typicalPoint(model);
  const Eigen::Index rows = model.parameterCount() + model.stateCount();
  const auto last = [&](const Eigen::VectorXd& q) {
    Simulation simulation(model, pointOf(model, q));
    double i = 0.0;
    for (int k = 0; k < 20; ++k) i = simulation.advanceAtVoltage(14.0, 0.5, 500.0);
    return i;
  };
  Simulation carried(model, pointOf(model, p),
                     Eigen::MatrixXd::Identity(rows, model.parameterCount()));
  for (int k = 0; k < 20; ++k) carried.advanceAtVoltage(14.0, 0.5, 500.0);
  for (Eigen::Index j = 0; j < model.parameterCount(); ++j) {
    Eigen::VectorXd up = p, down = p;
    const double h = 1e-4 * std::abs(p[j]);
    up[j] += h;
    down[j] -= h;
    const double difference = (last(up) - last(down)) / (2.0 * h);
    EXPECT_NEAR(carried.currentDerivatives()[j], difference, 2e-3 * std::abs(difference) + 1e-3)
        << model.parameters()[static_cast<std::size_t>(j)].name;
  }
}

TEST(Simulation, RefusesWhatDoesNotFitWithWhatWasExpected) {
  const BatteryModel model;
  ModelPoint start = pointOf(model, typicalPoint(model));
  start.state.resize(3);
  start.state.setZero();
  EXPECT_THROW(Simulation(model, start), std::invalid_argument);
  start = pointOf(model, typicalPoint(model));
  start.parameters[kRowBeta] = NAN;
  EXPECT_THROW(Simulation(model, start), std::invalid_argument);
  start = pointOf(model, typicalPoint(model));
  EXPECT_THROW(Simulation(model, start, Eigen::MatrixXd::Zero(6, 49)), std::invalid_argument);
  EXPECT_THROW(Simulation(model, start, Eigen::MatrixXd::Zero(5, 2)), std::invalid_argument);
  Simulation simulation(model, start);
  EXPECT_THROW(simulation.advanceAtVoltage(NAN, 1.0, 10.0), std::invalid_argument);
  EXPECT_THROW(simulation.advanceAtVoltage(14.0, 0.0, 10.0), std::invalid_argument);
}

// Kinetics that fade put the layer at a thousand volts.
TEST(Simulation, OfParametersThatDriftForADayEndsWithFiniteNumbers) {
  for (const char* beside : {"cpe2", "gassing", "charge_acceptance"}) {
    const BatteryModel model({"parameter_drift", beside});
    Eigen::VectorXd p = typicalPoint(model);
    for (const char* name : {"resistance_drift", "c2_drift", "beta_drift"})
      p[*model.parameterRow(name)] = -2.0;
    Simulation simulation(model, pointOf(model, p));
    InputStep day;
    day.time = day.duration = 86400.0;
    day.held = day.current = -0.4;
    simulation.advance(day);
    EXPECT_TRUE(std::isfinite(simulation.voltage())) << beside;
  }
}

TEST(Simulation, ADriftOfTheParametersSettlesWithinHours) {
  const BatteryModel model({"parameter_drift"});
  const auto resistanceAfter = [&](double hours, double drift) {
    ModelPoint start = pointOf(model, typicalPoint(model));
    start.parameters[*model.parameterRow("resistance_drift")] = drift;
    Simulation simulation(model, start);
    simulation.hold(0.0, 3600.0 * hours);
    const double rest = simulation.voltage();
    simulation.hold(-10.0, 1e-6);
    return (rest - simulation.voltage()) / 10.0;
  };
  const double first = resistanceAfter(0.0, 0.1);
  EXPECT_NEAR(resistanceAfter(0.5, 0.1) / first, std::exp(0.05), 0.004);  // as at the beginning
  EXPECT_NEAR(resistanceAfter(100.0, 0.1) / first, std::exp(0.4), 1e-3);
  EXPECT_NEAR(resistanceAfter(100.0, -2.0) / first, std::exp(-8.0), 1e-3);
}

namespace {

/// Voltages at minutes of hours under loads that begin at 0, 1 and 2 h, in rows of `interval` [s].
std::vector<double> voltagesUnderLoads(const BatteryModel& model, double interval) {
  constexpr double kMinute = 60.0;
  ModelPoint start = pointOf(model, typicalPoint(model));
  Simulation simulation(model, start);
  std::vector<double> all;
  for (double load : {-4.0, -25.0, 3.0})
    for (int minute = 0; minute < 60; ++minute) {
      const int rows = static_cast<int>(std::lround(kMinute / interval));
      // a sensor's noise: a hundredth of the load
      for (int n = 0; n < rows; ++n) simulation.hold(load * (1.0 + 0.01 * (minute % 2)), interval);
      all.push_back(simulation.voltage());
    }
  return all;
}

}  // namespace

TEST(Simulation, MinutesUnderTheSameCurrentEndWhereTheyDoInFineSteps) {
  for (const std::vector<std::string>& effects :
       {std::vector<std::string>{"sulphate_history", "charge_acceptance"},
        {"self_heating", "charge_acceptance"},
        {"parameter_drift", "gassing"}}) {
    const BatteryModel model(effects);
    const std::vector<double> at_minute = voltagesUnderLoads(model, 60.0),
                              finely = voltagesUnderLoads(model, 0.2);
    double worst = 0.0;
    for (std::size_t n = 0; n < finely.size(); ++n)
      worst = std::max(worst, std::abs(at_minute[n] - finely[n]));
    EXPECT_LT(worst, 5e-5) << effects.front();
  }
}

TEST(Simulation, BehindAHeldVoltageStepsAreFineAgainUnderTheCurrentOfBefore) {
  const BatteryModel model({"sulphate_history", "charge_acceptance"});
  // By a charger that is simulated, and by one whose voltage was measured.
  for (const bool is_measured : {false, true}) {
    const auto voltageAfter = [&](double interval) {
      ModelPoint start = pointOf(model, typicalPoint(model));
      Simulation simulation(model, start);
      const auto load = [&](double duration) {
        for (double t = 0.0; t < duration; t += interval) simulation.hold(-20.0, interval);
      };
      load(7200.0);
      for (int n = 0; n < 1200; ++n) {
        if (!is_measured)
          simulation.advanceAtVoltage(14.0, 1.0, 100.0);
        else
          simulation.followVoltage({simulation.time() + 1.0, 1.0, 0.0, 0.0}, 14.0);
      }
      load(60.0);
      return simulation.voltage();
    };
    EXPECT_NEAR(voltageAfter(60.0), voltageAfter(0.2), 5e-5) << is_measured;
  }
}

namespace {

/// A current that steps every few seconds, linear between samples `interval` apart.
Series steppingCurrent(double interval) {
  const std::vector<double> knots = {0.0,  20.6, 48.0, 48.0, 48.0, 25.0,  -13.0, -13.0, 4.4,  22.0,
                                     22.0, 11.6, 0.0,  0.0,  0.0,  -30.0, -6.0,  -6.0,  60.0, 60.0};
  Series series;
  const auto per_second = static_cast<std::size_t>(std::lround(1.0 / interval));
  for (std::size_t n = 0; n <= (knots.size() - 1) * per_second; ++n) {
    const std::size_t k = std::min(n / per_second, knots.size() - 2);
    const double share = static_cast<double>(n - k * per_second) / static_cast<double>(per_second);
    series.append(
        {static_cast<double>(n) * interval, knots[k] + share * (knots[k + 1] - knots[k]), 12.6});
  }
  return series;
}

}  // namespace

namespace {

/// A battery whose double layer is fast beside a second while it charges.
ModelPoint fastPointOf(const BatteryModel& model) {
  ModelPoint point = pointOf(model, typicalPoint(model));
  point.parameters[kRowC2] = 380.0;
  point.parameters[kRowBeta] = 35.0;
  return point;
}

/// How far the voltages at seconds are from those in steps of a hundredth, at most [V].
double missedBy(const BatteryModel& model, const InputSequence& slow) {
  const Series series = steppingCurrent(0.01);
  const auto at_second = voltages(model, fastPointOf(model), slow);
  const auto at_hundredth =
      voltages(model, fastPointOf(model), inputSequence(series, whole(series)));
  double worst = 0.0;
  for (std::size_t n = 0; n < at_second.size(); ++n)
    worst = std::max(worst, std::abs(at_second[n] - at_hundredth[100 * n]));
  return worst;
}

}  // namespace

TEST(Simulation, ASecondsRampOfTheCurrentEndsWhereItDoesInFineSteps) {
  const Series series = steppingCurrent(1.0);
  for (const std::vector<std::string>& effects :
       {std::vector<std::string>{}, {"charge_acceptance", "gassing"}, {"cpe2"}})
    EXPECT_LT(missedBy(BatteryModel(effects), inputSequence(series, whole(series))), 1e-3);
}

TEST(Simulation, HeldAtItsMeanASecondsRampWouldBeMissedByMillivolts) {
  const Series series = steppingCurrent(1.0);
  InputSequence held = inputSequence(series, whole(series));
  for (InputSample& sample : held.samples) sample.step.slope = 0.0;
  const double missed = missedBy(BatteryModel(), held);
  EXPECT_GT(missed, 0.005);
  RecordProperty("missed_mv", std::to_string(1e3 * missed));
}

TEST(Simulation, AShiftedRampKeepsItsCharge) {
  const BatteryModel model({"time_skew"});
  const Series slow = steppingCurrent(1.0), fine = steppingCurrent(0.01);
  ModelPoint start = pointOf(model, typicalPoint(model));
  start.parameters[*model.parameterRow("channel_skew")] = 0.3;
  const auto at_second = voltages(model, start, inputSequence(slow, whole(slow)));
  const auto at_hundredth = voltages(model, start, inputSequence(fine, whole(fine)));
  for (std::size_t n = 1; n < at_second.size(); ++n)
    EXPECT_NEAR(at_second[n], at_hundredth[100 * n], 0.01) << n << " s";
}

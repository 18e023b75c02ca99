// The two ends of a battery's charge: the acid that is used up, and the sulphate that is.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "model/simulation.hpp"
#include "support/composed.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

namespace {

Eigen::VectorXd withValue(const BatteryModel& model, Eigen::VectorXd parameters,
                          const std::string& name, double value) {
  parameters[*model.parameterRow(name)] = value;
  return parameters;
}

/// What end_of_discharge takes of the voltage after a discharge by 10 A of 85 Ah, and after a rest
/// of three hours on top of it [V]. @param pore_delay [s].
std::vector<double> takenByTheEnd(double pore_delay) {
  const BatteryModel line({"ocv_soc"}), bent({"ocv_soc", "end_of_discharge"});
  Eigen::VectorXd p = line.typicalParameters(), q = bent.typicalParameters();
  for (const auto& [name, value] :
       {std::pair<const char*, double>{"u_dc", 12.9}, {"ocv_slope", 0.014}}) {
    p = withValue(line, p, name, value);
    q = withValue(bent, q, name, value);
  }
  q = withValue(bent, q, "exhaustion_voltage", 11.36);
  q = withValue(bent, q, "pore_delay", pore_delay);
  Simulation as_a_line(line, pointOf(line, p)), as_bent(bent, pointOf(bent, q));
  std::vector<double> taken;
  const auto pass = [&](double current, double duration) {
    for (double t = 0.0; t < duration; t += 60.0)
      for (Simulation* one : {&as_a_line, &as_bent}) one->hold(current, 60.0);
    taken.push_back(as_a_line.voltage() - as_bent.voltage());
  };
  pass(-10.0, 8.5 * 3600.0);
  pass(0.0, 3.0 * 3600.0);
  return taken;
}

TEST(EndOfDischarge, ARestBringsBackWhatThePoresLackedAndNotWhatWasDrawn) {
  const std::vector<double> at_once = takenByTheEnd(100.0), behind = takenByTheEnd(5000.0);
  EXPECT_GT(behind[0], at_once[0] + 0.1);    // under the load the pores are ahead
  EXPECT_NEAR(behind[1], at_once[1], 1e-3);  // at rest both have what is left between the plates
  EXPECT_NEAR(at_once[1], at_once[0], 0.02);
  EXPECT_GT(at_once[1], 0.1);
}

/// Current at a held voltage after some hours, of a battery that lacks 10 Ah [A].
std::vector<double> currentsAt(double voltage, double overcharge_current) {
  const BatteryModel model({"ocv_soc", "acceptance_soc"});
  Eigen::VectorXd p = withValue(model, model.typicalParameters(), "acceptance_fall", 10.0);
  p = withValue(model, p, "overcharge_current", overcharge_current);
  p = withValue(model, p, "u_dc", 12.6);
  p = withValue(model, p, "ocv_slope", 0.0);
  auto point = pointOf(model, p);
  point.state[model.firstState(1)] = 10.0;
  Simulation simulation(model, point);
  std::vector<double> currents;
  for (int hour = 0; hour < 8; ++hour) {
    double charge = 0.0;
    for (int n = 0; n < 360; ++n) charge += simulation.advanceAtVoltage(voltage, 10.0, 1e3);
    currents.push_back(simulation.advanceAtVoltage(voltage, 1.0, 1e3));
    EXPECT_TRUE(std::isfinite(charge));
  }
  return currents;
}

TEST(AcceptanceSoc, UnderAHeldVoltageTheCurrentFadesAsTheSquareOfWhatIsLeft) {
  const std::vector<double> currents = currentsAt(14.4, 0.0);
  // i = S^2 / K and dS/dt = -i: 1 / sqrt(i) rises by 1 / sqrt(K) an hour.
  for (std::size_t hour = 3; hour < currents.size(); ++hour)
    EXPECT_NEAR(1.0 / std::sqrt(currents[hour]) - 1.0 / std::sqrt(currents[hour - 1]),
                1.0 / std::sqrt(10.0), 0.02)
        << hour;
}

TEST(AcceptanceSoc, WhatIsLeftInTheEndIsTheOvercharge) {
  const std::vector<double> without = currentsAt(14.4, 0.0), with = currentsAt(14.4, 0.5);
  EXPECT_GT(with.back(), without.back() + 0.2);
  EXPECT_LT(with.back(), without.back() + 0.6);
}

TEST(AcceptanceSoc, AForcedCurrentEndsInGassingAndLeavesTheOpenCircuitVoltageWhereItIs) {
  const BatteryModel model({"ocv_soc", "acceptance_soc"});
  Eigen::VectorXd p = withValue(model, model.typicalParameters(), "overcharge_current", 0.5);
  p = withValue(model, p, "ocv_slope", 0.02);
  auto point = pointOf(model, p);
  point.state[model.firstState(1)] = 1.0;
  Simulation simulation(model, point);
  for (int n = 0; n < 3600; ++n) simulation.hold(2.0, 10.0);
  EXPECT_LT(simulation.voltage(), 17.0);
  const double overcharge = simulation.state()[model.firstState(1) + 1];
  EXPECT_GT(overcharge, 18.0);  // of 20 Ah
  EXPECT_LT(overcharge, 20.0);
}

/// What the surface charge adds to the voltage [V] after each of: an hour's charge of 10 Ah, a rest of
/// `rest` [s], and 1 Ah drawn at `load` [A].
std::vector<double> surfaceVoltages(double rest, double load) {
  const BatteryModel with({"ocv_soc", "acceptance_soc", "surface_charge"}),
      less({"ocv_soc", "acceptance_soc"});
  Eigen::VectorXd p = withValue(with, with.typicalParameters(), "surface_voltage", 0.25);
  p = withValue(with, p, "surface_decay_time", 2e4);
  Simulation one(with, pointOf(with, p)), other(less, pointOf(less, less.typicalParameters()));
  std::vector<double> added;
  for (const auto& [current, duration] :
       {std::pair<double, double>{10.0, 3600.0}, {0.0, rest}, {-load, 3600.0 / load}}) {
    for (Simulation* simulation : {&one, &other}) simulation->hold(current, duration);
    added.push_back(one.voltage() - other.voltage());
  }
  return added;
}

TEST(SurfaceCharge, IsTakenByTheFirstAmpereHourAtAnyCurrentAndByHoursOfRest) {
  const std::vector<double> at_once = surfaceVoltages(1.0, 20.0);
  EXPECT_NEAR(at_once[0], 0.25, 0.01);
  EXPECT_NEAR(at_once[1], at_once[0], 1e-4);
  EXPECT_NEAR(at_once[2], 0.25 * std::exp(-1.0), 0.01);
  EXPECT_NEAR(surfaceVoltages(1.0, 40.0)[2], at_once[2], 0.002);
  EXPECT_NEAR(surfaceVoltages(2e4, 20.0)[1], at_once[0] * std::exp(-1.0), 1e-3);
}

}  // namespace

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/composed.hpp"
#include "support/made_force.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// Moves on under one held current.
void hold(Simulation& simulation, double current, double duration) {
  DriveStep step;
  step.time = simulation.time() + duration;
  step.duration = duration;
  step.held = step.current = current;
  simulation.advance(step);
}

Drive lively() {
  const Series series = livelyMinute(0.1);
  return fullDrive(series, whole(series));
}

/// Base parameters and factors one after the other, then u_c2 at the start.
Eigen::MatrixXd everyDirection(const BatteryModel& model) {
  return Eigen::MatrixXd::Identity(model.parameterCount() + model.stateCount(), model.parameterCount() + 1);
}

/// Where no column has a kink.
ModelPoint startOf(const BatteryModel& model) {
  ModelPoint start = pointOf(model, typicalPoint(model));
  start.state[0] = 0.01;
  return start;
}

ModelPoint moved(const ModelPoint& start, Eigen::Index direction, double by) {
  ModelPoint at = start;
  (direction < start.parameters.size() ? at.parameters[direction] : at.state[direction - start.parameters.size()]) += by;
  return at;
}

double stepOf(const ModelPoint& start, Eigen::Index direction) {
  return direction < start.parameters.size() ? 1e-5 * std::max(0.01, std::abs(start.parameters[direction])) : 1e-6;
}

TEST(LearnedEffect, StandsInACompositionWithAFactorAFamily) {
  const BatteryModel model = madeForceModel({"gassing"});
  EXPECT_EQ((std::vector<std::string>{"gassing", "learned"}), model.effects());
  ASSERT_TRUE(model.parameterRow("learned_acceptance"));
  EXPECT_EQ(1.0, model.typicalParameters()[*model.parameterRow("learned_acceptance")]);
  EXPECT_FALSE(model.parameterRow("learned_ageing")) << "no column of it";
}

TEST(LearnedEffect, NeedsItsForceAndAForceItsName) {
  EXPECT_THROW(BatteryModel({"learned"}), std::invalid_argument);
  EXPECT_THROW(BatteryModel({"gassing"}, std::make_shared<const LearnedForce>(madeForce())), std::invalid_argument);
  LearnedForce odd = madeForce();
  odd.scale[3] = 0.0;
  EXPECT_THROW(BatteryModel({"learned"}, std::make_shared<const LearnedForce>(odd)), std::invalid_argument);
  odd = madeForce();
  odd.weight[0] = std::nan("");
  EXPECT_THROW(BatteryModel({"learned"}, std::make_shared<const LearnedForce>(odd)), std::invalid_argument);
}

TEST(LearnedEffect, OfFactorsZeroAndNoChangeOfTheCircuitIsTheBaseCircuit) {
  LearnedForce force = madeForce();
  force.base_change.setZero();
  const BatteryModel model({"learned"}, std::make_shared<const LearnedForce>(force)), base;
  Eigen::VectorXd parameters = typicalPoint(model);
  parameters.tail(model.parameterCount() - kBaseRows).setZero();
  EXPECT_EQ(voltages(base, pointOf(base, typicalPoint(base)), lively()), voltages(model, pointOf(model, parameters), lively()));
}

TEST(LearnedEffect, AddsItsColumnsTimesTheirWeights) {
  const BatteryModel model = madeForceModel(), base;
  LearnedForce force = madeForce();
  const Drive drive = lively();
  Simulation with(model, pointOf(model, typicalPoint(model))), without(base, pointOf(base, typicalPoint(base)));
  ForceMemory memory(force.columns, force.context);
  Eigen::VectorXd values(force.weight.size());
  LearnedForce circuit = force;
  circuit.weight.setZero();
  const BatteryModel changed({"learned"}, std::make_shared<const LearnedForce>(circuit));
  Simulation of_circuit(changed, pointOf(changed, typicalPoint(changed)));
  for (const DriveSample& sample : drive.samples) {
    with.advance(sample.step);
    without.advance(sample.step);
    of_circuit.advance(sample.step);
    memory.advance({sample.step.duration, sample.step.current, sample.step.held, false, without.state()[0], sample.step.time}, values);
    const double expected = ((values - force.centre).cwiseQuotient(force.scale)).dot(force.weight);
    ASSERT_NEAR(of_circuit.voltage() + expected, with.voltage(), 1e-10) << sample.step.time;
  }
}

TEST(LearnedEffect, DerivativesAgreeWithDifferencesUnderACurrent) {
  for (const std::vector<std::string>& effects : {std::vector<std::string>{}, std::vector<std::string>{"charge_acceptance", "ocv_soc"}}) {
    const BatteryModel model = madeForceModel(effects);
    const ModelPoint start = startOf(model);
    Simulation carried(model, start, everyDirection(model));
    std::vector<Eigen::VectorXd> slopes;
    for (const DriveSample& sample : lively().samples) {
      carried.advance(sample.step);
      slopes.push_back(carried.voltageDerivatives());
    }
    for (Eigen::Index direction = 0; direction <= model.parameterCount(); ++direction) {
      const double step = stepOf(start, direction);
      const auto up = voltages(model, moved(start, direction, step), lively()),
                 down = voltages(model, moved(start, direction, -step), lively());
      double largest = 0.0;
      for (std::size_t n = 0; n < up.size(); ++n) largest = std::max(largest, std::abs(slopes[n][direction]));
      for (std::size_t n = 0; n < up.size(); ++n)
        ASSERT_NEAR((up[n] - down[n]) / (2.0 * step), slopes[n][direction], 1e-4 * largest + 1e-9) << direction << " at sample " << n;
    }
  }
}

TEST(LearnedEffect, DerivativesOfTheCurrentAgreeWithDifferencesBehindASource) {
  for (const std::vector<std::string>& effects : {std::vector<std::string>{}, std::vector<std::string>{"fresh_sulphate"}}) {
    const BatteryModel model = madeForceModel(effects);
    const ModelPoint start = startOf(model);
    const auto currents = [&](Simulation simulation, std::vector<Eigen::VectorXd>* slopes) {
      std::vector<double> found;
      hold(simulation, -20.0, 10.0);
      for (int n = 0; n < 20; ++n) {
        found.push_back(simulation.advanceAtVoltage(13.2 + 0.02 * (n % 3), 0.5, 1e4));
        if (slopes) slopes->push_back(simulation.currentDerivatives());
      }
      return found;
    };
    std::vector<Eigen::VectorXd> slopes;
    currents(Simulation(model, start, everyDirection(model)), &slopes);
    for (Eigen::Index direction = 0; direction <= model.parameterCount(); ++direction) {
      const double step = stepOf(start, direction);
      const auto up = currents(Simulation(model, moved(start, direction, step)), nullptr),
                 down = currents(Simulation(model, moved(start, direction, -step)), nullptr);
      double largest = 0.0;
      for (std::size_t n = 0; n < up.size(); ++n) largest = std::max(largest, std::abs(slopes[n][direction]));
      for (std::size_t n = 0; n < up.size(); ++n)
        ASSERT_NEAR((up[n] - down[n]) / (2.0 * step), slopes[n][direction], 1e-3 * largest + 1e-12 / step)
            << (effects.empty() ? "base" : effects.front()) << " " << direction << " at step " << n;
    }
  }
}

TEST(LearnedEffect, CarriedOnFromItsMemoryGivesTheSameVoltages) {
  const BatteryModel model = madeForceModel();
  const Drive drive = lively();
  const auto through = voltages(model, pointOf(model, typicalPoint(model)), drive);
  Simulation first(model, pointOf(model, typicalPoint(model)));
  for (std::size_t n = 0; n < 250; ++n) first.advance(drive.samples[n].step);
  ModelPoint here{typicalPoint(model), first.state(), first.time(), 0.0, first.forceMemory()};
  Simulation second(model, here);
  for (std::size_t n = 250; n < drive.samples.size(); ++n) {
    second.advance(drive.samples[n].step);
    ASSERT_NEAR(through[n], second.voltage(), 1e-12) << n;
  }
  here.force_memory.pop_back();
  EXPECT_THROW(Simulation(model, here), std::invalid_argument);
}

TEST(LearnedEffect, IsHeldInsideWhatItWasLearntOnAndSaysByHowMuch) {
  LearnedForce force = madeForce();
  force.columns = {{ForceKind::kCompressed, Family::kStructure, 0.0, 5.0}};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  force.lower = one(std::asinh(-10.0));
  force.upper = one(std::asinh(10.0));
  force.centre = one(0.0);
  force.scale = one(2.0);
  force.weight = one(0.01);
  force.base_change.setZero();
  force.parts = {{Family::kStructure, 0.1}};
  const BatteryModel model({"learned"}, std::make_shared<const LearnedForce>(force)), base;
  const auto added = [&](double current, double* beyond) {
    Simulation with(model, pointOf(model, typicalPoint(model))), without(base, pointOf(base, typicalPoint(base)));
    hold(with, current, 1.0);
    hold(without, current, 1.0);
    *beyond = with.beyondLearned();
    return with.voltage() - without.voltage();
  };
  double beyond = 0.0;
  EXPECT_NEAR(0.005 * std::asinh(8.0), added(40.0, &beyond), 1e-10);
  EXPECT_EQ(0.0, beyond);
  EXPECT_NEAR(-0.005 * std::asinh(10.0), added(-400.0, &beyond), 1e-10);
  EXPECT_NEAR(0.005 * (std::asinh(80.0) - std::asinh(10.0)), beyond, 1e-10);
}

TEST(LearnedEffect, AChangeOfTheCircuitIsThatOfItsParametersWhereItIsSmall) {
  const BatteryModel base;
  const Drive drive = lively();
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    LearnedForce force = madeForce();
    force.weight.setZero();
    const double by = direction < 2 ? 1e-4 : 1e-3;
    force.base_change = by * Eigen::VectorXd::Unit(kBaseDirections, direction);
    const BatteryModel model({"learned"}, std::make_shared<const LearnedForce>(force));
    ModelPoint changed = pointOf(base, typicalPoint(base));
    if (direction == kBaseDirections - 1)
      changed.state[0] += by;
    else if (direction == kRowC2 || direction == kRowBeta)
      changed.parameters[direction] *= std::exp(by);
    else
      changed.parameters[direction] += by;
    const auto expected = voltages(base, changed, drive), alone = voltages(base, pointOf(base, typicalPoint(base)), drive);
    const auto found = voltages(model, pointOf(model, typicalPoint(model)), drive);
    double largest = 0.0;
    for (std::size_t n = 0; n < found.size(); ++n) largest = std::max(largest, std::abs(expected[n] - alone[n]));
    for (std::size_t n = 0; n < found.size(); ++n) ASSERT_NEAR(expected[n], found[n], 0.02 * largest) << direction << " at sample " << n;
  }
}

TEST(LearnedEffect, RestedMemoryLetsMemoriesFadeAndKeepsTheChargeCounted) {
  const BatteryModel model = madeForceModel();
  Simulation simulation(model, pointOf(model, typicalPoint(model)));
  for (const DriveSample& sample : lively().samples) simulation.advance(sample.step);
  const std::vector<double> before = simulation.forceMemory(), rested = restedMemory(*model.force(), before);
  ASSERT_EQ(before.size(), rested.size());
  for (std::size_t k = 0; k < model.force()->columns.size(); ++k)
    if (model.force()->columns[k].kind == ForceKind::kChargeMemory) {
      EXPECT_NEAR(0.0, rested[k], 1e-6);
    }
  EXPECT_EQ(before[model.force()->columns.size()], rested[model.force()->columns.size()]) << "charge counted";
}

}  // namespace
}  // namespace battery_sof

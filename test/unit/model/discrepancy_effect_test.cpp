#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/composed.hpp"
#include "support/made_discrepancy.hpp"

namespace battery_sof {
namespace {

using namespace test;

InputSequence lively() {
  const Series series = livelyMinute(0.1);
  return inputSequence(series, whole(series));
}

/// Base parameters and factors one after the other, then u_c2 at the start.
Eigen::MatrixXd everyDirection(const BatteryModel& model) {
  return Eigen::MatrixXd::Identity(model.parameterCount() + model.stateCount(),
                                   model.parameterCount() + 1);
}

/// Where no regressor has a kink.
ModelPoint startOf(const BatteryModel& model) {
  ModelPoint start = pointOf(model, typicalPoint(model));
  start.state[0] = 0.01;
  return start;
}

ModelPoint moved(const ModelPoint& start, Eigen::Index direction, double by) {
  ModelPoint at = start;
  (direction < start.parameters.size() ? at.parameters[direction]
                                       : at.state[direction - start.parameters.size()]) += by;
  return at;
}

double stepOf(const ModelPoint& start, Eigen::Index direction) {
  return direction < start.parameters.size()
             ? 1e-5 * std::max(0.01, std::abs(start.parameters[direction]))
             : 1e-6;
}

TEST(DiscrepancyEffect, StandsInACompositionWithAFactorAFamily) {
  const BatteryModel model = madeModelWithDiscrepancy({"gassing"});
  EXPECT_EQ((std::vector<std::string>{"gassing", "discrepancy"}), model.effects());
  ASSERT_TRUE(model.parameterRow("discrepancy_acceptance"));
  EXPECT_EQ(1.0, model.typicalParameters()[*model.parameterRow("discrepancy_acceptance")]);
  EXPECT_FALSE(model.parameterRow("discrepancy_ageing")) << "no column of it";
}

TEST(DiscrepancyEffect, NeedsItsForceAndAForceItsName) {
  EXPECT_THROW(BatteryModel({"discrepancy"}), std::invalid_argument);
  EXPECT_THROW(
      BatteryModel({"gassing"}, std::make_shared<const DiscrepancyModel>(madeDiscrepancyModel())),
      std::invalid_argument);
  DiscrepancyModel odd = madeDiscrepancyModel();
  odd.scale[3] = 0.0;
  EXPECT_THROW(BatteryModel({"discrepancy"}, std::make_shared<const DiscrepancyModel>(odd)),
               std::invalid_argument);
  odd = madeDiscrepancyModel();
  odd.weight[0] = std::nan("");
  EXPECT_THROW(BatteryModel({"discrepancy"}, std::make_shared<const DiscrepancyModel>(odd)),
               std::invalid_argument);
}

TEST(DiscrepancyEffect, OfFactorsZeroAndNoChangeOfTheCircuitIsTheBaseCircuit) {
  DiscrepancyModel discrepancy = madeDiscrepancyModel();
  discrepancy.base_change.setZero();
  const BatteryModel model({"discrepancy"}, std::make_shared<const DiscrepancyModel>(discrepancy)),
      base;
  Eigen::VectorXd parameters = typicalPoint(model);
  parameters.tail(model.parameterCount() - kBaseRows).setZero();
  EXPECT_EQ(voltages(base, pointOf(base, typicalPoint(base)), lively()),
            voltages(model, pointOf(model, parameters), lively()));
}

TEST(DiscrepancyEffect, AddsItsColumnsTimesTheirWeights) {
  const BatteryModel model = madeModelWithDiscrepancy(), base;
  DiscrepancyModel discrepancy = madeDiscrepancyModel();
  const InputSequence inputs = lively();
  Simulation with(model, pointOf(model, typicalPoint(model))),
      without(base, pointOf(base, typicalPoint(base)));
  RegressorMemory memory(discrepancy.regressors, discrepancy.context);
  Eigen::VectorXd values(discrepancy.weight.size());
  DiscrepancyModel circuit = discrepancy;
  circuit.weight.setZero();
  const BatteryModel changed({"discrepancy"}, std::make_shared<const DiscrepancyModel>(circuit));
  Simulation of_circuit(changed, pointOf(changed, typicalPoint(changed)));
  for (const InputSample& sample : inputs.samples) {
    with.advance(sample.step);
    without.advance(sample.step);
    of_circuit.advance(sample.step);
    memory.advance({sample.step.duration, sample.step.current, sample.step.held, false,
                    without.state()[0], sample.step.time},
                   values);
    const double expected =
        ((values - discrepancy.centre).cwiseQuotient(discrepancy.scale)).dot(discrepancy.weight);
    ASSERT_NEAR(of_circuit.voltage() + expected, with.voltage(), 1e-10) << sample.step.time;
  }
}

TEST(DiscrepancyEffect, DerivativesAgreeWithDifferencesUnderACurrent) {
  for (const std::vector<std::string>& effects :
       {std::vector<std::string>{}, std::vector<std::string>{"charge_acceptance", "ocv_soc"}}) {
    const BatteryModel model = madeModelWithDiscrepancy(effects);
    const ModelPoint start = startOf(model);
    Simulation carried(model, start, everyDirection(model));
    std::vector<Eigen::VectorXd> slopes;
    for (const InputSample& sample : lively().samples) {
      carried.advance(sample.step);
      slopes.push_back(carried.voltageDerivatives());
    }
    for (Eigen::Index direction = 0; direction <= model.parameterCount(); ++direction) {
      const double step = stepOf(start, direction);
      const auto up = voltages(model, moved(start, direction, step), lively()),
                 down = voltages(model, moved(start, direction, -step), lively());
      double largest = 0.0;
      for (std::size_t n = 0; n < up.size(); ++n)
        largest = std::max(largest, std::abs(slopes[n][direction]));
      for (std::size_t n = 0; n < up.size(); ++n)
        ASSERT_NEAR((up[n] - down[n]) / (2.0 * step), slopes[n][direction], 1e-4 * largest + 1e-9)
            << direction << " at sample " << n;
    }
  }
}

TEST(DiscrepancyEffect, DerivativesOfTheCurrentAgreeWithDifferencesBehindASource) {
  for (const std::vector<std::string>& effects :
       {std::vector<std::string>{}, std::vector<std::string>{"fresh_sulphate"}}) {
    const BatteryModel model = madeModelWithDiscrepancy(effects);
    const ModelPoint start = startOf(model);
    const auto currents = [&](Simulation simulation, std::vector<Eigen::VectorXd>* slopes) {
      std::vector<double> found;
      simulation.hold(-20.0, 10.0);
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
      for (std::size_t n = 0; n < up.size(); ++n)
        largest = std::max(largest, std::abs(slopes[n][direction]));
      for (std::size_t n = 0; n < up.size(); ++n)
        ASSERT_NEAR((up[n] - down[n]) / (2.0 * step), slopes[n][direction],
                    1e-3 * largest + 1e-12 / step)
            << (effects.empty() ? "base" : effects.front()) << " " << direction << " at step " << n;
    }
  }
}

TEST(DiscrepancyEffect, CarriedOnFromItsMemoryGivesTheSameVoltages) {
  const BatteryModel model = madeModelWithDiscrepancy();
  const InputSequence inputs = lively();
  const auto through = voltages(model, pointOf(model, typicalPoint(model)), inputs);
  Simulation first(model, pointOf(model, typicalPoint(model)));
  for (std::size_t n = 0; n < 250; ++n) first.advance(inputs.samples[n].step);
  ModelPoint here{typicalPoint(model), first.state(), first.time(), 0.0, first.regressorMemory()};
  Simulation second(model, here);
  for (std::size_t n = 250; n < inputs.samples.size(); ++n) {
    second.advance(inputs.samples[n].step);
    ASSERT_NEAR(through[n], second.voltage(), 1e-12) << n;
  }
  here.regressor_memory.pop_back();
  EXPECT_THROW(Simulation(model, here), std::invalid_argument);
}

TEST(DiscrepancyEffect, IsHeldInsideWhatItWasLearntOnAndSaysByHowMuch) {
  DiscrepancyModel discrepancy = madeDiscrepancyModel();
  discrepancy.regressors = {{RegressorKind::kCompressed, Mechanism::kStructure, 0.0, 5.0}};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  discrepancy.lower = one(std::asinh(-10.0));
  discrepancy.upper = one(std::asinh(10.0));
  discrepancy.centre = one(0.0);
  discrepancy.scale = one(2.0);
  discrepancy.weight = one(0.01);
  discrepancy.base_change.setZero();
  discrepancy.parts = {{Mechanism::kStructure, 0.1}};
  const BatteryModel model({"discrepancy"}, std::make_shared<const DiscrepancyModel>(discrepancy)),
      base;
  const auto added = [&](double current, double* beyond) {
    Simulation with(model, pointOf(model, typicalPoint(model))),
        without(base, pointOf(base, typicalPoint(base)));
    with.hold(current, 1.0);
    without.hold(current, 1.0);
    *beyond = with.beyondIdentified();
    return with.voltage() - without.voltage();
  };
  double beyond = 0.0;
  EXPECT_NEAR(0.005 * std::asinh(8.0), added(40.0, &beyond), 1e-10);
  EXPECT_EQ(0.0, beyond);
  EXPECT_NEAR(-0.005 * std::asinh(10.0), added(-400.0, &beyond), 1e-10);
  EXPECT_NEAR(0.005 * (std::asinh(80.0) - std::asinh(10.0)), beyond, 1e-10);
}

TEST(DiscrepancyEffect, AChangeOfTheCircuitIsThatOfItsParametersWhereItIsSmall) {
  const BatteryModel base;
  const InputSequence inputs = lively();
  for (Eigen::Index direction = 0; direction < kBaseDirections; ++direction) {
    DiscrepancyModel discrepancy = madeDiscrepancyModel();
    discrepancy.weight.setZero();
    const double by = direction < 2 ? 1e-4 : 1e-3;
    discrepancy.base_change = by * Eigen::VectorXd::Unit(kBaseDirections, direction);
    const BatteryModel model({"discrepancy"},
                             std::make_shared<const DiscrepancyModel>(discrepancy));
    ModelPoint changed = pointOf(base, typicalPoint(base));
    if (direction == kBaseDirections - 1)
      changed.state[0] += by;
    else if (direction == kRowC2 || direction == kRowBeta)
      changed.parameters[direction] *= std::exp(by);
    else
      changed.parameters[direction] += by;
    const auto expected = voltages(base, changed, inputs),
               alone = voltages(base, pointOf(base, typicalPoint(base)), inputs);
    const auto found = voltages(model, pointOf(model, typicalPoint(model)), inputs);
    double largest = 0.0;
    for (std::size_t n = 0; n < found.size(); ++n)
      largest = std::max(largest, std::abs(expected[n] - alone[n]));
    for (std::size_t n = 0; n < found.size(); ++n)
      ASSERT_NEAR(expected[n], found[n], 0.02 * largest) << direction << " at sample " << n;
  }
}

TEST(DiscrepancyEffect, RestedMemoryLetsMemoriesFadeAndKeepsTheChargeCounted) {
  const BatteryModel model = madeModelWithDiscrepancy();
  Simulation simulation(model, pointOf(model, typicalPoint(model)));
  for (const InputSample& sample : lively().samples) simulation.advance(sample.step);
  const std::vector<double> before = simulation.regressorMemory(),
                            rested = restedMemory(*model.discrepancy(), before);
  ASSERT_EQ(before.size(), rested.size());
  for (std::size_t k = 0; k < model.discrepancy()->regressors.size(); ++k)
    if (model.discrepancy()->regressors[k].kind == RegressorKind::kChargeMemory) {
      EXPECT_NEAR(0.0, rested[k], 1e-6);
    }
  EXPECT_EQ(before[model.discrepancy()->regressors.size()],
            rested[model.discrepancy()->regressors.size()])
      << "charge counted";
}

}  // namespace
}  // namespace battery_sof

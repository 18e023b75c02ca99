#include "diagnosis/row_simulation.hpp"

#include <gtest/gtest.h>

#include "support/composed.hpp"
#include "util/constants.hpp"

namespace battery_sof {
namespace {

using namespace test;

CompositionPoint pointAtRest(const BatteryModel& model) {
  return {typicalPoint(model), model.restState()};
}

/// A drive at 100 Hz, or at one sample a second where a source controls the voltage every other
/// half minute.
struct Rows {
  explicit Rows(bool slow)
      : Rows(dataSetOneCurrent(slow ? 240.0 : 60.0, slow ? 1.0 : 0.01, 6), slow) {}
  Rows(const std::vector<double>& current, bool slow) {
    series = test::answered(drivenBattery(), current, slow ? 1.0 : 0.01, 0.001, 6);
    std::vector<char> drives(series.size(), 0);
    for (std::size_t n = 0; slow && n < drives.size(); ++n) drives[n] = n % 60 >= 30;
    inputs = inputSequence(series, whole(series), {}, drives);
    const CompositionPoint base = pointAtRest(BatteryModel());
    response = linearizationOf(BatteryModel(), {base.parameters, base.state, 0.0, 0.0}, inputs,
                               inputs.samples.size());
  }

  RowSimulation simulation() const {
    return RowSimulation(inputs, response, pointAtRest(BatteryModel()));
  }

  Series series;
  InputSequence inputs;
  Linearization response;
};

TEST(RowSimulation, OfTheBaseCircuitLeavesWhatTheFullRateLeaves) {
  for (const bool slow : {false, true}) {
    const Rows rows(slow);
    const RowErrors errors = rows.simulation().errors(BatteryModel(), pointAtRest(BatteryModel()));
    ASSERT_EQ(rows.response.error.size(), errors.error.size());
    EXPECT_LT((errors.error - rows.response.error).cwiseAbs().maxCoeff(), 1e-12) << slow;
  }
}

/// A crank of which a slow sampling saw nothing leaves fresh sulphate: a source then charges more.
TEST(RowSimulation, KeepsWhatASlowSamplingMissedOfACrank) {
  const BatteryModel model(withNeeds("fresh_sulphate"));
  Rows rows(true);
  const Eigen::VectorXd seen = rows.simulation().errors(model, pointAtRest(model)).error;
  rows.inputs.samples[95].step.missed = MissedCrank::kCharge;
  const Eigen::VectorXd missed = rows.simulation().errors(model, pointAtRest(model)).error;
  const auto change = [&](Eigen::Index row) { return std::abs(missed[row] - seen[row]); };
  EXPECT_EQ(0.0, change(94));
  ASSERT_TRUE(rows.response.voltage_controlled[100]);
  EXPECT_GT(change(100), 1e-4);  // [V]
}

/// The current creeps by 1.3 A a row, so only row 100 is simulated at full rate: a load is switched
/// on in it. 100 ms later are 6 mV, and three samples of row 101 are without the load: 50 mV.
TEST(RowSimulation, ShiftsTheMeanOfARowAsTheFullRateIsShifted) {
  std::vector<double> current;
  for (int n = 0; n < 2000; ++n)
    current.push_back(20.0 * std::sin(2.0 * kPi * 0.01 * n / 10.0) - (n < 1003 ? 0.0 : 30.0));
  const Rows rows(current, false);
  const BatteryModel model({"time_skew"});
  CompositionPoint point = pointAtRest(model);
  point.parameters[kBaseRows] = 0.1;
  const Linearization full = linearizationOf(model, {point.parameters, point.state, 0.0, 0.0},
                                             rows.inputs, rows.inputs.samples.size());
  const Eigen::VectorXd shifted = rows.simulation().errors(model, point).error;
  ASSERT_EQ(rows.inputs.samples.size(), 10u * static_cast<std::size_t>(shifted.size()));
  const Eigen::VectorXd moved = (full.error - rows.response.error).cwiseAbs();
  EXPECT_GT(moved[50], 6e-3);
  EXPECT_GT(moved[101], 0.04);
  EXPECT_LT((shifted - full.error).segment(5, shifted.size() - 10).cwiseAbs().maxCoeff(), 5e-4);
}

TEST(RowSimulation, OfAnEffectThatVanishesIsThatOfTheBaseCircuit) {
  const Rows rows(false);
  // the last acts at edges: another grid
  for (const char* id : {"ocv_soc", "acid_transport", "time_skew"}) {
    const BatteryModel model(withNeeds(id));
    CompositionPoint point = pointAtRest(model);
    for (Eigen::Index j = kBaseRows; j < model.parameterCount(); ++j) {
      const ParameterInfo& info = model.parameters()[static_cast<std::size_t>(j)];
      if (info.vanishes_at) point.parameters[j] = *info.vanishes_at;
    }
    const RowErrors errors = rows.simulation().errors(model, point);
    ASSERT_EQ(rows.response.error.size(), errors.error.size()) << id;
    EXPECT_LT((errors.error - rows.response.error).cwiseAbs().maxCoeff(), 1e-9) << id;
  }
}

TEST(RowSimulation, LanesAgreeWithDifferencesInBothDirections) {
  for (const bool slow : {false, true}) {
    const Rows rows(slow);
    const RowSimulation simulation = rows.simulation();
    const BatteryModel model({"charge_acceptance", "ocv_soc"});
    const CompositionPoint point = pointAtRest(model);
    const Eigen::Index count = model.parameterCount() + model.stateCount();
    const RowErrors with = simulation.errors(model, point, Eigen::MatrixXd::Identity(count, count));
    ASSERT_EQ(count, with.sensitivity.cols());
    for (Eigen::Index tangent = 0; tangent < count; ++tangent) {
      CompositionPoint up = point, down = point;
      const bool is_parameter = tangent < model.parameterCount();
      const double value =
          is_parameter ? point.parameters[tangent] : point.state[tangent - model.parameterCount()];
      const double step = 1e-6 * std::max(std::abs(value), is_parameter ? 1e-3 : 1e-2);
      (is_parameter ? up.parameters[tangent] : up.state[tangent - model.parameterCount()]) += step;
      (is_parameter ? down.parameters[tangent] : down.state[tangent - model.parameterCount()]) -=
          step;
      const Eigen::VectorXd slope =
          -(simulation.errors(model, up).error - simulation.errors(model, down).error) /
          (2.0 * step);
      EXPECT_LT((slope - with.sensitivity.col(tangent)).norm(), 1e-3 * slope.norm() + 1e-8)
          << "lane " << tangent << (slow ? ", both ways" : "");
    }
  }
}

TEST(RowSimulation, LanesDoNotChangeTheErrors) {
  const Rows rows(true);
  const BatteryModel model({"charge_acceptance"});
  const CompositionPoint point = pointAtRest(model);
  const Eigen::Index count = model.parameterCount() + model.stateCount();
  const RowErrors with = rows.simulation().errors(model, point,
                                                  Eigen::MatrixXd::Identity(count, count)),
                  without = rows.simulation().errors(model, point);
  EXPECT_LT((with.error - without.error).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace battery_sof

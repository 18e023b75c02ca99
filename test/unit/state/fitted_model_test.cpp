#include "state/fitted_model.hpp"

#include <gtest/gtest.h>

#include "estimation/fit_quality.hpp"
#include "estimation/identification.hpp"
#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

Eigen::MatrixXd randomCovariance(Eigen::Index size, Eigen::Index rank, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd A(size, rank);
  for (Eigen::Index j = 0; j < size; ++j)
    for (Eigen::Index k = 0; k < rank; ++k) A(j, k) = random.normal() * std::pow(10.0, j % 5 - 3.0);
  return A * A.transpose();
}

/// A composition at its magnitudes with a covariance, standing at 100 s.
FittedModel modelOf(const std::vector<std::string>& effects) {
  const Series series = livelyMinute(0.1);
  FittedModel model =
      unfitted(series, whole(series), BatteryModel(effects), FitStatus::kConverged, "");
  const BatteryModel composition(effects);
  const Eigen::VectorXd p = typicalPoint(composition);
  model.fit.parameters = baseParameters(p);
  for (Eigen::Index j = 0; j < p.size(); ++j)
    model.fit.estimates[static_cast<std::size_t>(j)].value = p[j];
  Eigen::VectorXd std(composition.parameterCount() + composition.stateCount());
  for (Eigen::Index j = 0; j < p.size(); ++j)
    std[j] =
        0.01 * std::max(std::abs(p[j]),
                        std::abs(composition.parameters()[static_cast<std::size_t>(j)].magnitude));
  std.tail(composition.stateCount()).setConstant(0.002);
  model.fit.covariance = std.cwiseAbs2().asDiagonal();
  model.state.time = 100.0;
  model.fit.scores.rmse = 0.002;
  return model;
}

TEST(CovarianceFactor, TimesItsTransposeIsTheCovariance) {
  for (Eigen::Index rank : {1, 3, 8, 12}) {
    const Eigen::MatrixXd V = randomCovariance(12, rank, 10 + static_cast<std::uint64_t>(rank));
    const Eigen::MatrixXd L = covarianceFactor(V);
    EXPECT_EQ(L.cols(), rank);
    for (Eigen::Index j = 0; j < 12; ++j)
      for (Eigen::Index k = 0; k < 12; ++k)
        EXPECT_NEAR((L * L.transpose())(j, k), V(j, k), 1e-8 * std::sqrt(V(j, j) * V(k, k)));
  }
}

TEST(CovarianceFactor, LeavesOutWhatIsKnownExactly) {
  Eigen::MatrixXd V = randomCovariance(6, 6, 3);
  V.row(2).setZero();
  V.col(2).setZero();
  const Eigen::MatrixXd L = covarianceFactor(V);
  EXPECT_EQ(L.cols(), 5);
  EXPECT_EQ(L.row(2).norm(), 0.0);
  EXPECT_EQ(covarianceFactor(Eigen::MatrixXd::Zero(6, 6)).cols(), 0);
}

TEST(CovarianceFactor, NeverHasMoreColumnsThanASimulationCarries) {
  EXPECT_EQ(covarianceFactor(Eigen::MatrixXd::Identity(70, 70)).cols(), Simulation::kMaxTangents);
}

TEST(PointOf, BringsParametersStatesAndTheTimeDriftsCountFrom) {
  FittedModel model = modelOf({"acid_transport", "ocv_soc"});
  model.state.states = Eigen::Vector4d(0.07, 5.0, -3.0, 0.2);
  model.fit.window.from = 7.0;
  const ModelPoint point = pointOf(model);
  const BatteryModel composition = compositionOf(model.fit);
  EXPECT_EQ(point.parameters, typicalPoint(composition));
  EXPECT_EQ(point.state, Eigen::Vector4d(0.07, 5.0, -3.0, 0.2));
  EXPECT_EQ(point.time, 100.0);
  EXPECT_EQ(point.reference_time, 7.0);
}

TEST(Rested, PutsEveryStateAtRestAndKnowsItThere) {
  for (const EffectInfo& info : effectCatalogue()) {
    FittedModel model = modelOf(withNeeds(info.id));
    model.state.states.array() += 0.1;
    const FittedModel at_rest = rested(model);
    const BatteryModel composition = compositionOf(model.fit);
    EXPECT_EQ(pointOf(at_rest).state, composition.restState()) << info.id;
    EXPECT_EQ(at_rest.state.current, 0.0);
    EXPECT_EQ(at_rest.state.time, model.state.time);
    const Eigen::Index parameters = composition.parameterCount();
    EXPECT_EQ(at_rest.fit.covariance.bottomRows(composition.stateCount()).norm(), 0.0);
    EXPECT_EQ(at_rest.fit.covariance.topLeftCorner(parameters, parameters),
              model.fit.covariance.topLeftCorner(parameters, parameters));
  }
}

TEST(Rested, GoesOnWithTheVoltageOfABatteryThatRested) {
  for (const EffectInfo& info : effectCatalogue()) {
    FittedModel model = modelOf(withNeeds(info.id));
    model.fit.window.from = model.state.time;  // nothing has drifted yet
    Simulation simulation = simulationOf(rested(model));
    InputStep step;
    step.duration = 0.01;
    step.time = model.state.time + step.duration;
    simulation.advance(step);
    // Side currents and offsets that flow at rest take a few millivolts at most.
    EXPECT_NEAR(simulation.voltage(), model.fit.parameters.u_dc, 0.01) << info.id;
  }
}

TEST(TakeState, PutsStateAndItsCovarianceWhereTheSimulationStands) {
  const FittedModel before = modelOf({"acid_transport", "ocv_soc"});
  FittedModel after = before;
  Simulation simulation = uncertainSimulationOf(before);
  InputStep step;
  step.duration = 60.0;
  step.time = 160.0;
  step.held = step.current = -30.0;
  simulation.advance(step);
  takeState(after, simulation, -30.0);
  EXPECT_EQ(after.state.time, 160.0);
  EXPECT_EQ(after.state.current, -30.0);
  EXPECT_NEAR(after.state.states[3], before.state.states[3] - 0.5, 1e-12) << "30 A for a minute";

  // The same by differences: every direction of the old covariance, moved along.
  const Eigen::Index size = before.fit.covariance.rows(), parameters = size - 4;
  const Eigen::VectorXd std = before.fit.covariance.diagonal().cwiseSqrt();
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const auto moved = [&](double by) {
      ModelPoint point = pointOf(before);
      (j < parameters ? point.parameters[j] : point.state[j - parameters]) += by;
      Simulation other(compositionOf(before.fit), point);
      other.advance(step);
      return other.state();
    };
    const double h = 0.1 * std[j];
    T.col(j).tail(4) = (moved(h) - moved(-h)) / (2.0 * h);
  }
  const Eigen::MatrixXd expected = T * before.fit.covariance * T.transpose();
  for (Eigen::Index j = 0; j < size; ++j)
    for (Eigen::Index k = 0; k < size; ++k)
      EXPECT_NEAR(after.fit.covariance(j, k), expected(j, k),
                  1e-3 * std::sqrt(expected(j, j) * expected(k, k)) + 1e-15);
}

TEST(TakeState, OfASimulationWithoutLanesLeavesTheCovarianceAlone) {
  const FittedModel before = modelOf({"ocv_soc"});
  FittedModel after = before;
  Simulation simulation = simulationOf(before);
  InputStep step;
  step.duration = 10.0;
  step.time = 110.0;
  step.held = step.current = 20.0;
  simulation.advance(step);
  takeState(after, simulation, 20.0);
  EXPECT_EQ(after.fit.covariance, before.fit.covariance);
  EXPECT_GT(after.state.states[0], 0.0);
}

TEST(CarryState, OfACompositionGoesThroughEverySampleToTheLast) {
  const Series series = baseDrive(4, 60.0);
  for (const std::vector<std::string>& ids :
       {std::vector<std::string>{"acid_transport"}, {"charge_acceptance", "cpe2"}}) {
    FittedModel model = modelOf(ids);
    model.state.time = series.time[1000];
    model.state.current = series.current[1000];
    Simulation by_hand = simulationOf(model);
    for (std::size_t n = 1001; n <= 3000; ++n)
      by_hand.advance(inputStep(series.time[n - 1], series.current[n - 1], series.time[n],
                                series.current[n], gapThreshold(series)));
    carryState(model, series, 3000);
    EXPECT_EQ(model.state.time, series.time[3000]);
    EXPECT_TRUE(pointOf(model).state.isApprox(by_hand.state(), 1e-10));
    EXPECT_THROW(carryState(model, series, 10), std::invalid_argument);
  }
}

}  // namespace
}  // namespace battery_sof

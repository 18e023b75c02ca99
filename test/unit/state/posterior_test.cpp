#include "state/posterior.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/fit_quality.hpp"
#include "support/composed.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using test::uncertainModel;

constexpr double kHalfDay = 43200.0;

double stdOf(const FittedModel& model, int row) {
  return std::sqrt(model.fit.covariance(row, row));
}

TEST(Parked, WidensWithTimeUpToALimit) {
  const FittedModel model = uncertainModel(0.02);
  const FittedModel hour = parked(model, 3600.0, std::nullopt),
                    day = parked(model, 86400.0, std::nullopt),
                    month = parked(model, 30.0 * 86400.0, std::nullopt);
  for (int row = 0; row < kBaseRows; ++row) {
    EXPECT_GT(stdOf(hour, row), stdOf(model, row)) << row;
    EXPECT_GT(stdOf(day, row), stdOf(hour, row)) << row;
    EXPECT_LT(stdOf(month, row), 1.5 * stdOf(day, row)) << row;
  }
}

TEST(Parked, WidensWithTheDifferenceOfTemperatureEitherWay) {
  FittedModel model = uncertainModel(0.02);
  model.fit.excited.temperature = 293.15;
  const FittedModel same = parked(model, kHalfDay, 293.15),
                    warmer = parked(model, kHalfDay, 308.15),
                    colder = parked(model, kHalfDay, 278.15);
  for (int row = 0; row < kBaseRows; ++row) {
    EXPECT_GT(stdOf(warmer, row), stdOf(same, row)) << row;
    EXPECT_DOUBLE_EQ(stdOf(warmer, row), stdOf(colder, row)) << row;
  }
  const double of_r = std::sqrt(std::pow(stdOf(warmer, kRowRDischarge), 2) -
                                std::pow(stdOf(same, kRowRDischarge), 2));
  EXPECT_NEAR(of_r / model.fit.parameters.r_discharge, 0.15, 1e-9) << "1 % for each of 15 K";
  EXPECT_EQ(warmer.fit.excited.temperature, 308.15) << "what is known holds there now";
}

TEST(Parked, ForgetsEventsOfATemperatureFarAway) {
  FittedModel model = uncertainModel(0.02);
  model.fit.excited.temperature = 293.15;
  model.intervals.event_history.add({});
  EXPECT_EQ(1u, parked(model, kHalfDay, 284.15).intervals.event_history.cranks.size());
  EXPECT_EQ(1u, parked(model, kHalfDay, std::nullopt).intervals.event_history.cranks.size());
  EXPECT_TRUE(parked(model, kHalfDay, 253.15).intervals.event_history.cranks.empty());
}

TEST(Parked, WithoutATemperatureIsTheSameAsWithoutADifference) {
  FittedModel model = uncertainModel(0.02);
  const FittedModel unknown = parked(model, kHalfDay, 308.15);
  EXPECT_FALSE(unknown.fit.excited.temperature);
  model.fit.excited.temperature = 293.15;
  const FittedModel unmeasured = parked(model, kHalfDay, std::nullopt);
  EXPECT_EQ(unmeasured.fit.excited.temperature, 293.15);
  EXPECT_TRUE(unknown.fit.covariance.isApprox(unmeasured.fit.covariance));
}

TEST(TakeIn, MovesStatesByTheKalmanGainAndLeavesTheCovarianceOfTheRest) {
  const BatteryModel composition({"acid_transport", "ocv_hysteresis"});
  FittedModel model =
      unfitted(test::baseDrive(8, 20.0), {0, 1000}, composition, FitStatus::kConverged, "");
  const Eigen::Index parameters = composition.parameterCount(), states = composition.stateCount();
  ASSERT_GT(states, 1);
  Innovation innovation;
  innovation.factor = Eigen::MatrixXd::Zero(parameters + states, states);
  innovation.factor.bottomRows(states).diagonal().setConstant(0.1);
  innovation.modelled = Eigen::VectorXd::LinSpaced(states, 0.5, 1.0);
  innovation.std_error = 0.5;
  innovation.error = 0.3;
  const Eigen::VectorXd& h = innovation.modelled;
  const Eigen::VectorXd gain = 0.1 * h / (h.squaredNorm() + 0.25);
  const FittedModel before = model;
  const double left = takeIn(model, innovation);
  EXPECT_NEAR(left, 0.3 - 0.3 * h.squaredNorm() / (h.squaredNorm() + 0.25), 1e-12);
  for (Eigen::Index k = 0; k < states; ++k)
    EXPECT_NEAR(model.state.states[k] - before.state.states[k], 0.3 * gain[k], 1e-12) << k;
  const Eigen::MatrixXd rest =
      0.01 * Eigen::MatrixXd::Identity(states, states) - 0.1 * gain * h.transpose();
  EXPECT_TRUE(model.fit.covariance.bottomRightCorner(states, states).isApprox(rest));
}

double largestOf(const std::vector<double>& errors) {
  Surprise surprise;
  for (const double error : errors) surprise.add(error);
  return surprise.largest;
}

TEST(Surprise, ErrorsOnOneSideAddUpAndOthersDoNot) {
  EXPECT_DOUBLE_EQ(largestOf({2.2, 2.2, 2.2}), 2.2 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(largestOf({-2.2, -2.2, -2.2}), 2.2 * std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(largestOf({2.2, -2.2, 2.2}), 2.2);
  EXPECT_DOUBLE_EQ(largestOf({-5.0, 5.0}), 5.0) << "what was seen stays";
  EXPECT_DOUBLE_EQ(largestOf({0.0, 0.0, 0.0, 9.0}), 0.0) << "the beginning of a trip alone counts";
}

TEST(CarryCranks, AWindowWithoutCranksKeepsTheRangeWithTheDifferenceAsError) {
  FittedModel before = uncertainModel(0.02), fit = before;
  before.fit.excited.min_current = -250.0;
  before.fit.scores.cranks = 7;
  before.fit.scores.crank_error_std = 0.3;
  fit.fit.excited.min_current = -90.0;
  fit.fit.scores.cranks = 0;
  fit.fit.parameters.r_discharge += 0.0016;  // 0.4 V at 250 A
  carryCranks(fit.fit, before.fit);
  EXPECT_EQ(fit.fit.excited.min_current, -250.0);
  EXPECT_NEAR(fit.fit.scores.crank_error_std, 0.5, 1e-12);
  EXPECT_EQ(fit.fit.scores.cranks, 7);
}

TEST(CarryCranks, AWindowsOwnCranksCountAlone) {
  FittedModel before = uncertainModel(0.02), fit = before;
  before.fit.excited.min_current = -250.0;
  before.fit.scores.cranks = 7;
  fit.fit.excited.min_current = -180.0;
  fit.fit.scores.cranks = 1;
  fit.fit.scores.crank_error_std = 0.1;
  carryCranks(fit.fit, before.fit);
  EXPECT_EQ(fit.fit.excited.min_current, -180.0);
  EXPECT_EQ(fit.fit.scores.crank_error_std, 0.1);
  before.fit.scores.cranks = 0;
  fit.fit.scores.cranks = 0;
  carryCranks(fit.fit, before.fit);
  EXPECT_EQ(fit.fit.excited.min_current, -180.0) << "no crank was seen before either";
}

}  // namespace
}  // namespace battery_sof

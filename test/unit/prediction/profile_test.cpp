#include "prediction/questions.hpp"
#include "prediction/scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/identification.hpp"
#include "state/state_tracker.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

const FittedModel& model() {
  static const FittedModel fitted = [] {
    const Series series = test::baseDrive(1);
    return identify(series, {0, series.size()});
  }();
  return fitted;
}

TEST(SimulateProfile, ContinuesFromTheSavedState) {
  const ProfileAnswer answer =
      simulateProfile(model(), {0.0, 1.0, 2.0}, {model().state.current, -20.0, -20.0});
  EXPECT_EQ(answer.code, AnswerCode::kOk);
  EXPECT_TRUE(answer.valid);
  ASSERT_EQ(answer.predicted.voltage.size(), 3u);
  EXPECT_NEAR(
      answer.predicted.voltage[0],
      test::terminalVoltage(model().fit.parameters, model().state.current, model().state.states[0]),
      1e-12);
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_LT(answer.predicted.lower[n], answer.predicted.voltage[n]);
    EXPECT_GT(answer.predicted.upper[n], answer.predicted.voltage[n]);
  }
}

TEST(SimulateProfile, RefusesProfilesThatMakeNoSenseAndSaysWhere) {
  const double nan = std::nan("");
  const auto message = [&](std::vector<double> time, std::vector<double> current) {
    const ProfileAnswer answer = simulateProfile(model(), time, current);
    EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery);
    EXPECT_TRUE(answer.predicted.voltage.empty());
    return answer.message;
  };
  EXPECT_NE(message({0.0, 1.0}, {1.0}).find("expected as many"), std::string::npos);
  EXPECT_NE(message({}, {}).find("empty"), std::string::npos);
  EXPECT_NE(message({0.0, nan}, {1.0, 1.0}).find("time[1]"), std::string::npos);
  EXPECT_NE(message({0.0, 1.0}, {1.0, nan}).find("current[1]"), std::string::npos);
  EXPECT_NE(message({-1.0, 1.0}, {1.0, 1.0}).find("time[0]"), std::string::npos);
  EXPECT_NE(message({0.0, 2.0, 1.0}, {1.0, 1.0, 1.0}).find("time[2]"), std::string::npos);
  EXPECT_NE(message({0.0, 3.2e7}, {1.0, 1.0}).find("time[1]"), std::string::npos);
  EXPECT_NE(message({0.0}, {1e6}).find("current[0]"), std::string::npos);
}

TEST(SimulateProfile, RefusesTimesCloserThanAnythingMoves) {
  for (const std::vector<double>& time :
       {std::vector<double>{5e-324, 1e-323}, {0.0, 1e-310, 1.0}, {1.0, 1.0 + 1e-9}}) {
    const ProfileAnswer answer =
        simulateProfile(model(), time, std::vector<double>(time.size(), -20.0));
    EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery);
    EXPECT_NE(answer.message.find("after the one before, expected at least 1e-07 s"),
              std::string::npos)
        << answer.message;
  }
  EXPECT_TRUE(simulateProfile(model(), {1e-6, 2e-6}, {-20.0, -20.0}).valid);
}

TEST(SimulateProfile, AnIntervalTooShortToDivideIsPassedAtOnce) {
  Simulation simulation = simulationOf(model());
  InputStep step = inputStep(0.0, -20.0, 5e-324, 20.0, 5.0);
  EXPECT_EQ(step.rampPieces(), 1);
  simulation.advance(step);
  EXPECT_TRUE(std::isfinite(simulation.state()[0]));
}

TEST(SimulateProfile, BreaksOffWhenItIsToldToAndSaysHowFarItCame) {
  int asked = 0;
  const ProfileAnswer answer = simulateProfile(
      model(), {1.0, 2.0, 3.0, 4.0}, {-20.0, -20.0, -20.0, -20.0},
      [&](double share) { return ++asked == 3 && share == 0.5 ? "time was up" : ""; });
  EXPECT_EQ(answer.code, AnswerCode::kInvalidQuery);
  EXPECT_EQ(answer.message, "stopped after 2 of 4 samples: time was up");
  EXPECT_TRUE(answer.predicted.voltage.empty());
}

TEST(SimulateProfile, IsNotValidBeyondTheExcitedCurrents) {
  const ProfileAnswer answer = simulateProfile(model(), {1.0}, {-1500.0});
  EXPECT_EQ(answer.code, AnswerCode::kExtrapolation);
  EXPECT_FALSE(answer.valid);
  EXPECT_EQ(answer.predicted.voltage.size(), 1u);
}

TEST(PredictSeries, FollowsTheDriveThatFollowsTheWindow) {
  const Series series = test::baseDrive(2, 600.0);
  const FittedModel fitted = identify(series, {0, 24000});
  const IndexRange later = {24000, series.size()};
  const PredictionScores scores =
      scorePrediction(series, later, predictSeries(fitted, series, later).voltages());
  EXPECT_GT(*scores.q_dyn_percent, 98.0);
  EXPECT_LT(scores.rmse, 0.003);
  EXPECT_NEAR(scores.coverage_90, 0.90, 0.02);
  ASSERT_FALSE(scores.cranks.empty());
  EXPECT_LT(*scores.crank_mean_abs_error, 0.01);
  for (const auto& crank : scores.cranks) EXPECT_LT(crank.current, -150.0);
}

TEST(PredictSeries, UsesOnlyTheCurrentInsideALaterRange) {
  Series series = test::baseDrive(2, 300.0);
  const FittedModel fitted = identify(series, {0, 24000});
  const auto before = predictSeries(fitted, series, {24000, 30000}).voltage;
  for (std::size_t n = 24000; n < 30000; ++n) series.voltage[n] = 0.0;
  EXPECT_EQ(predictSeries(fitted, series, {24000, 30000}).voltage, before);
}

TEST(PredictSeries, GoesOnFromTheSavedStateWhereTheRangeBeginsAtIt) {
  const Series series = test::baseDrive(2, 300.0);
  IdentifyOptions options;
  options.effects = {"ocv_soc"};
  const FittedModel fitted = identify(series, {6000, 24000}, options);
  const FollowedPrediction at = predictSeries(fitted, series, {23999, 30000}),
                           behind = predictSeries(fitted, series, {24000, 30000});
  for (std::size_t n = 0; n < behind.voltage.size(); n += 500)
    EXPECT_NEAR(behind.voltage[n], at.voltage[n + 1], 1e-9) << n;
}

TEST(PredictSeries, OfNothingIsNothing) {
  EXPECT_TRUE(predictSeries(model(), test::baseDrive(1, 10.0), {5, 5}).voltage.empty());
}

TEST(ScorePrediction, RefusesAPredictionOfAnotherLength) {
  const Series series = test::baseDrive(1, 10.0);
  EXPECT_THROW(scorePrediction(series, {0, 100}, PredictedVoltage{}), std::invalid_argument);
}

TEST(StateTracker, EqualsCarryingTheStateOffline) {
  const Series series = test::baseDrive(8, 300.0);
  const FittedModel fitted = identify(series, {0, 24000});
  FittedModel offline = fitted;
  carryState(offline, series, series.size() - 1);
  StateTracker tracker(fitted, gapThreshold(series));
  for (std::size_t n = 24000; n < series.size(); ++n)
    tracker.follow(series.time[n], series.current[n], series.voltage[n]);
  const FittedModel online = tracker.modelNow();
  EXPECT_DOUBLE_EQ(online.state.states[0], offline.state.states[0]);
  EXPECT_DOUBLE_EQ(online.state.time, offline.state.time);
  EXPECT_TRUE(online.fit.covariance.isApprox(offline.fit.covariance, 1e-9));
  EXPECT_NEAR(tracker.last()->voltage, series.voltage.back(), 0.02);
}

TEST(StateTracker, RestsAcrossAGapAndRefusesToGoBack) {
  StateTracker tracker(model(), 5.0);
  tracker.follow(model().state.time + 1000.0, -20.0, 12.0);
  EXPECT_NEAR(tracker.state().states[0], 0.0, 1e-3);
  EXPECT_THROW(tracker.follow(model().state.time, 0.0, 12.0), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

#include "prediction/scores.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "prediction/event_watch.hpp"
#include "state/state_tracker.hpp"
#include "support/known_model.hpp"
#include "support/start_stop.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// Half of a start-stop drive fitted, the rest to be predicted.
class BothWays : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const BatteryModel composition({"fresh_sulphate"});
    StartStopOptions options;
    options.duration = 1800.0;
    options.current_noise = 0.1;
    options.voltage_noise = 0.01;
    inputs_ = new StartStopDrive(startStopDrive(composition, freshBattery(composition), options));
    IdentifyOptions identification;
    identification.source = knownSource(*inputs_);
    identification.effects = {"fresh_sulphate"};
    model_ = new FittedModel(identify(inputs_->series, {0, half()}, identification));
  }
  static void TearDownTestSuite() {
    delete inputs_;
    delete model_;
  }
  static std::size_t half() { return inputs_->series.size() / 2; }
  static IndexRange rest() { return {half(), inputs_->series.size()}; }

  static StartStopDrive* inputs_;
  static FittedModel* model_;
};
StartStopDrive* BothWays::inputs_ = nullptr;
FittedModel* BothWays::model_ = nullptr;

TEST_F(BothWays, PredictsTheNextQuarterOfAnHourOfItsOwnBattery) {
  const FollowedPrediction predicted = predictSeries(*model_, inputs_->series, rest());
  const BothWaysScores scores = scoreBothWays(*model_, inputs_->series, rest(), predicted);
  ASSERT_TRUE(scores.mixed.share_percent);
  EXPECT_GT(*scores.mixed.share_percent, 85.0);
  EXPECT_GT(*scores.mixed.current_share_percent, 80.0);
  EXPECT_GT(*scores.mixed.voltage_share_percent, 90.0);
  ASSERT_TRUE(scores.crank_mean_abs_error);
  EXPECT_LT(*scores.crank_mean_abs_error, 0.15);
  EXPECT_GE(scores.cranks.size(), 5u);
  EXPECT_GE(scores.mixed.charges.size(), 5u);
}

TEST_F(BothWays, WhatDrivesIsAsMeasuredAndHasNoWidth) {
  const FollowedPrediction predicted = predictSeries(*model_, inputs_->series, rest());
  ASSERT_EQ(predicted.voltage_controlled.size(), rest().size());
  ASSERT_EQ(predicted.current.size(), rest().size());
  std::size_t sources = 0;
  for (std::size_t k = 0; k < rest().size(); ++k) {
    const std::size_t n = rest().first + k;
    if (predicted.voltage_controlled[k]) {
      ++sources;
      EXPECT_EQ(predicted.voltage[k], predicted.voltage_lower[k]);
      EXPECT_EQ(predicted.voltage[k], predicted.voltage_upper[k]);
      EXPECT_LT(predicted.current_lower[k], predicted.current_upper[k]);
    } else {
      EXPECT_EQ(predicted.current[k], inputs_->series.current[n]);
      EXPECT_EQ(predicted.current_lower[k], predicted.current_upper[k]);
      EXPECT_LT(predicted.voltage_lower[k], predicted.voltage_upper[k]);
    }
  }
  EXPECT_GT(sources, rest().size() / 2);
}

TEST_F(BothWays, UsesOnlyWhatDrivesOfTheRangeAndNothingThatComesLater) {
  const IndexRange part{half(), half() + 300};
  const FollowedPrediction before = predictSeries(*model_, inputs_->series, part);
  Series later = inputs_->series;
  for (std::size_t n = part.last + 1; n < later.size(); ++n) {
    later.voltage[n] -= 1.0;
    later.current[n] *= -2.0;
  }
  EXPECT_EQ(predictSeries(*model_, later, part).current, before.current);
  EXPECT_EQ(predictSeries(*model_, later, part).voltage, before.voltage);
  // The answers in the range itself: the current of a source moves a little, the voltage under
  // load, too.
  Series answers = inputs_->series;
  for (std::size_t n = part.first; n < part.last; ++n)
    if (before.voltage_controlled[n - part.first] && answers.current[n] > 1.0 &&
        answers.current[n - 1] > 1.0 && answers.current[n + 1] > 1.0)
      answers.current[n] += 0.4;
  const FollowedPrediction with = predictSeries(*model_, answers, part);
  ASSERT_EQ(with.voltage_controlled, before.voltage_controlled);
  for (std::size_t k = 0; k < part.size(); ++k)
    if (before.voltage_controlled[k]) {
      EXPECT_NEAR(with.current[k], before.current[k], 1e-6) << k;
    }
}

TEST_F(BothWays, WithoutASourceIsThePredictionFromTheCurrent) {
  const FittedModel model = drivenByCurrent(*model_);
  const FollowedPrediction predicted = predictSeries(model, inputs_->series, rest());
  EXPECT_TRUE(std::none_of(predicted.voltage_controlled.begin(), predicted.voltage_controlled.end(),
                           [](char c) { return c; }));
  Simulation simulation = simulationOf(model);
  const InputSequence inputs = inputSequence(inputs_->series, {half() - 1, rest().last});
  for (std::size_t k = 0; k < rest().size(); ++k) {
    simulation.advance(inputs.samples[k + 1].step);
    ASSERT_NEAR(predicted.voltage[k], simulation.voltage(), 1e-9);
    ASSERT_EQ(predicted.current[k], inputs_->series.current[half() + k]);
  }
}

TEST_F(BothWays, AVoltageThatIsBehindIsPredictedAsItIsShown) {
  FittedModel model = *model_;
  model.fit.residual_regression = {};
  const FollowedPrediction prompt = predictSeries(model, inputs_->series, rest());
  // The same drive as a channel shows it that is a sample late.
  Series late = inputs_->series;
  for (std::size_t n = late.size(); n-- > 1;) late.voltage[n] = late.voltage[n - 1];
  model.fit.voltage_lag = 1;
  const FollowedPrediction shown = predictSeries(model, late, rest());
  ASSERT_EQ(shown.voltage.size(), prompt.voltage.size());
  int alike = 0;
  for (std::size_t k = 1; k < rest().size(); ++k)
    alike += std::abs(shown.voltage[k] - prompt.voltage[k - 1]) < 0.02;
  // All but where the judgement of a late voltage is another.
  EXPECT_GT(alike, static_cast<int>(0.95 * static_cast<double>(rest().size())));
}

TEST_F(BothWays, AnExactPredictionHasAFullShareAndExactEvents) {
  FollowedPrediction exact;
  for (std::size_t n = rest().first; n < rest().last; ++n) {
    exact.voltage_controlled.push_back(inputs_->controlled[n]);
    exact.voltage.push_back(inputs_->series.voltage[n]);
    exact.current.push_back(inputs_->series.current[n]);
  }
  exact.equations_voltage = exact.voltage_lower = exact.voltage_upper = exact.voltage;
  exact.current_lower = exact.current_upper = exact.current;
  FittedModel model = *model_;
  model.intervals.event_history = {};
  const BothWaysScores scores = scoreBothWays(model, inputs_->series, rest(), exact);
  EXPECT_DOUBLE_EQ(*scores.mixed.share_percent, 100.0);
  EXPECT_DOUBLE_EQ(*scores.crank_mean_abs_error, 0.0);
  for (const EventComparison& charge : scores.mixed.charges)
    EXPECT_DOUBLE_EQ(charge.expected.value, charge.measured);
}

TEST_F(BothWays, PastCranksCorrectThePredictedOnes) {
  FollowedPrediction low = predictSeries(*model_, inputs_->series, rest());
  FittedModel baseline_model = *model_;
  baseline_model.fit.baseline.voltage_from_current.reset();
  FittedModel ignorant = baseline_model;
  ignorant.intervals.event_history = {};
  // Equations that read every crank 0.4 V too low, in the past as now.
  for (double& u : low.equations_voltage) u -= 0.4;
  for (PastEvent& crank : baseline_model.intervals.event_history.cranks) crank.modelled -= 0.4;
  const double corrected =
      *scoreBothWays(baseline_model, inputs_->series, rest(), low).crank_mean_abs_error;
  EXPECT_GT(*scoreBothWays(ignorant, inputs_->series, rest(), low).crank_mean_abs_error, 0.3);
  EXPECT_LT(corrected, 0.15);
}

TEST_F(BothWays, WhatIsExpectedOfACrankLiesInsideItsOwnInterval) {
  FollowedPrediction predicted = predictSeries(*model_, inputs_->series, rest());
  FittedModel ignorant = *model_;
  ignorant.intervals.event_history = {};
  ignorant.fit.baseline.voltage_from_current.reset();
  // What the residual regression adds takes the whole away from the equations.
  for (double& u : predicted.equations_voltage) u -= 3.0;
  const BothWaysScores scores = scoreBothWays(ignorant, inputs_->series, rest(), predicted);
  ASSERT_FALSE(scores.cranks.empty());
  for (const EventComparison& crank : scores.cranks) {
    EXPECT_LE(crank.expected.lower, crank.expected.value);
    EXPECT_GE(crank.expected.upper, crank.expected.value);
  }
}

TEST_F(BothWays, TheNaivePredictorsAreScoredOnTheSameSamples) {
  const std::vector<char> mask(inputs_->controlled.begin() + static_cast<std::ptrdiff_t>(half()),
                               inputs_->controlled.end());
  const BothWaysScores baseline =
      scoreBaseline(model_->fit.baseline, inputs_->series, rest(), mask);
  const BothWaysScores model = scoreBothWays(*model_, inputs_->series, rest(),
                                             predictSeries(*model_, inputs_->series, rest()));
  ASSERT_TRUE(baseline.mixed.share_percent);
  EXPECT_LT(*baseline.mixed.share_percent, *model.mixed.share_percent);
  EXPECT_EQ(baseline.cranks.size(), model.cranks.size());
  EXPECT_FALSE(scoreBaseline({}, inputs_->series, rest(), mask).mixed.share_percent);
}

TEST_F(BothWays, TheLiveTrackerIsWhereCarryingTheStateOfflinePutsIt) {
  FittedModel offline = *model_;
  StateTracker tracker(*model_, gapThreshold(inputs_->series));
  // Judgements of a live source begin with the model: offline ones look back a little. A sample
  // settles with the one behind it.
  std::vector<char> live;
  for (std::size_t n = half(); n < inputs_->series.size(); ++n) {
    if (!tracker.follow(inputs_->series.time[n], inputs_->series.current[n],
                        inputs_->series.voltage[n]))
      continue;
    const double current = inputs_->series.current[n - 1];
    live.push_back(tracker.last()->voltage_controlled);
    if (tracker.last()->voltage_controlled) {
      EXPECT_NEAR(tracker.error(), 0.01 * (current - tracker.last()->current), 1e-12);
    } else {
      EXPECT_EQ(tracker.last()->current, current);
      EXPECT_NEAR(tracker.error(), inputs_->series.voltage[n - 1] - tracker.last()->voltage, 1e-12);
    }
  }
  ASSERT_EQ(live.size(), rest().size() - 1);
  carryState(offline, inputs_->series, inputs_->series.size() - 1);
  const FittedModel now = tracker.modelNow();
  const FollowedPrediction predicted = predictSeries(*model_, inputs_->series, rest());
  std::size_t alike = 0;
  for (std::size_t k = 0; k < live.size(); ++k)
    alike += static_cast<bool>(live[k]) == static_cast<bool>(predicted.voltage_controlled[k]);
  EXPECT_GT(static_cast<double>(alike) / static_cast<double>(live.size()), 0.99);
  EXPECT_EQ(now.state.time, offline.state.time);
  EXPECT_NEAR(now.state.states[0], offline.state.states[0], 1e-3);
  for (Eigen::Index j = 0; j < now.state.states.size(); ++j)
    EXPECT_NEAR(now.state.states[j], offline.state.states[j],
                0.01 * (1.0 + std::abs(offline.state.states[j])));
}

}  // namespace
}  // namespace battery_sof

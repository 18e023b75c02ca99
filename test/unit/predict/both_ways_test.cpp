#include "battery_sof/predict/both_ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "battery_sof/predict/charge_watch.hpp"
#include "battery_sof/predict/state_tracker.hpp"
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
    drive_ = new StartStopDrive(startStopDrive(composition, freshBattery(composition), options));
    IdentifyOptions identification;
    identification.source = knownSource(*drive_);
    identification.effects = {"fresh_sulphate"};
    model_ = new FittedModel(identify(drive_->series, {0, half()}, identification));
  }
  static void TearDownTestSuite() {
    delete drive_;
    delete model_;
  }
  static std::size_t half() { return drive_->series.size() / 2; }
  static IndexRange rest() { return {half(), drive_->series.size()}; }

  static StartStopDrive* drive_;
  static FittedModel* model_;
};
StartStopDrive* BothWays::drive_ = nullptr;
FittedModel* BothWays::model_ = nullptr;

TEST_F(BothWays, PredictsTheNextQuarterOfAnHourOfItsOwnBattery) {
  const FollowedPrediction predicted = predictMixed(*model_, drive_->series, rest());
  const BothWaysScores scores = scoreBothWays(*model_, drive_->series, rest(), predicted);
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
  const FollowedPrediction predicted = predictMixed(*model_, drive_->series, rest());
  ASSERT_EQ(predicted.voltage_drives.size(), rest().size());
  ASSERT_EQ(predicted.current.size(), rest().size());
  std::size_t sources = 0;
  for (std::size_t k = 0; k < rest().size(); ++k) {
    const std::size_t n = rest().first + k;
    if (predicted.voltage_drives[k]) {
      ++sources;
      EXPECT_EQ(predicted.voltage[k], predicted.voltage_lower[k]);
      EXPECT_EQ(predicted.voltage[k], predicted.voltage_upper[k]);
      EXPECT_LT(predicted.current_lower[k], predicted.current_upper[k]);
    } else {
      EXPECT_EQ(predicted.current[k], drive_->series.current[n]);
      EXPECT_EQ(predicted.current_lower[k], predicted.current_upper[k]);
      EXPECT_LT(predicted.voltage_lower[k], predicted.voltage_upper[k]);
    }
  }
  EXPECT_GT(sources, rest().size() / 2);
}

TEST_F(BothWays, UsesOnlyWhatDrivesOfTheRangeAndNothingThatComesLater) {
  const IndexRange part{half(), half() + 300};
  const FollowedPrediction before = predictMixed(*model_, drive_->series, part);
  Series later = drive_->series;
  for (std::size_t n = part.last + 1; n < later.size(); ++n) {
    later.voltage[n] -= 1.0;
    later.current[n] *= -2.0;
  }
  EXPECT_EQ(predictMixed(*model_, later, part).current, before.current);
  EXPECT_EQ(predictMixed(*model_, later, part).voltage, before.voltage);
  // The answers in the range itself: the current of a source moves a little, the voltage under load, too.
  Series answers = drive_->series;
  for (std::size_t n = part.first; n < part.last; ++n)
    if (before.voltage_drives[n - part.first] && answers.current[n] > 1.0 && answers.current[n - 1] > 1.0 && answers.current[n + 1] > 1.0)
      answers.current[n] += 0.4;
  const FollowedPrediction with = predictMixed(*model_, answers, part);
  ASSERT_EQ(with.voltage_drives, before.voltage_drives);
  for (std::size_t k = 0; k < part.size(); ++k)
    if (before.voltage_drives[k]) {
      EXPECT_NEAR(with.current[k], before.current[k], 1e-6) << k;
    }
}

TEST_F(BothWays, WithoutASourceIsThePredictionFromTheCurrent) {
  FittedModel model = *model_;
  model.fit.source.reset();
  model.fit.learned = {};
  const FollowedPrediction mixed = predictMixed(model, drive_->series, rest());
  const PredictedVoltage plain = predictSeries(model, drive_->series, rest());
  EXPECT_TRUE(std::none_of(mixed.voltage_drives.begin(), mixed.voltage_drives.end(), [](char c) { return c; }));
  for (std::size_t k = 0; k < rest().size(); ++k) ASSERT_NEAR(mixed.voltage[k], plain.voltage[k], 1e-9);
}

TEST_F(BothWays, OfNothingIsNothing) { EXPECT_TRUE(predictMixed(*model_, drive_->series, {5, 5}).voltage.empty()); }

TEST_F(BothWays, AVoltageThatIsBehindIsPredictedAsItIsShown) {
  FittedModel model = *model_;
  model.fit.learned = {};
  const FollowedPrediction prompt = predictMixed(model, drive_->series, rest());
  // The same drive as a channel shows it that is a sample late.
  Series late = drive_->series;
  for (std::size_t n = late.size(); n-- > 1;) late.voltage[n] = late.voltage[n - 1];
  model.fit.voltage_lag = 1;
  const FollowedPrediction shown = predictMixed(model, late, rest());
  ASSERT_EQ(shown.voltage.size(), prompt.voltage.size());
  int alike = 0;
  for (std::size_t k = 1; k < rest().size(); ++k) alike += std::abs(shown.voltage[k] - prompt.voltage[k - 1]) < 0.02;
  // All but where the judgement of a late voltage is another.
  EXPECT_GT(alike, static_cast<int>(0.95 * static_cast<double>(rest().size())));
}

TEST_F(BothWays, AnExactPredictionHasAFullShareAndExactEvents) {
  FollowedPrediction exact;
  for (std::size_t n = rest().first; n < rest().last; ++n) {
    exact.voltage_drives.push_back(drive_->imposed[n]);
    exact.voltage.push_back(drive_->series.voltage[n]);
    exact.current.push_back(drive_->series.current[n]);
  }
  exact.equations_voltage = exact.voltage_lower = exact.voltage_upper = exact.voltage;
  exact.current_lower = exact.current_upper = exact.current;
  FittedModel model = *model_;
  model.intervals.experience = {};
  const BothWaysScores scores = scoreBothWays(model, drive_->series, rest(), exact);
  EXPECT_DOUBLE_EQ(*scores.mixed.share_percent, 100.0);
  EXPECT_DOUBLE_EQ(*scores.crank_mean_abs_error, 0.0);
  for (const ChargeScore& charge : scores.mixed.charges) EXPECT_DOUBLE_EQ(charge.predicted.value, charge.measured);
}

TEST_F(BothWays, PastCranksCorrectThePredictedOnes) {
  FollowedPrediction low = predictMixed(*model_, drive_->series, rest());
  FittedModel naive_model = *model_;
  naive_model.fit.naive.voltage_from_current.reset();
  FittedModel ignorant = naive_model;
  ignorant.intervals.experience = {};
  // Equations that read every crank 0.4 V too low, in the past as now.
  for (double& u : low.equations_voltage) u -= 0.4;
  for (PastCrank& crank : naive_model.intervals.experience.cranks) crank.modelled -= 0.4;
  const double corrected = *scoreBothWays(naive_model, drive_->series, rest(), low).crank_mean_abs_error;
  EXPECT_GT(*scoreBothWays(ignorant, drive_->series, rest(), low).crank_mean_abs_error, 0.3);
  EXPECT_LT(corrected, 0.15);
}

TEST_F(BothWays, TheNaivePredictorsAreScoredOnTheSameSamples) {
  const std::vector<char> mask(drive_->imposed.begin() + static_cast<std::ptrdiff_t>(half()), drive_->imposed.end());
  const BothWaysScores naive = scoreNaive(model_->fit.naive, drive_->series, rest(), mask);
  const BothWaysScores model = scoreBothWays(*model_, drive_->series, rest(), predictMixed(*model_, drive_->series, rest()));
  ASSERT_TRUE(naive.mixed.share_percent);
  EXPECT_LT(*naive.mixed.share_percent, *model.mixed.share_percent);
  EXPECT_EQ(naive.cranks.size(), model.cranks.size());
  const PredictedVoltage line = naiveVoltage(model_->fit.naive, drive_->series, rest());
  ASSERT_EQ(line.voltage.size(), rest().size());
  EXPECT_NEAR(line.voltage[3], model_->fit.naive.voltage_from_current->at(drive_->series.current[half() + 3]), 1e-12);
  EXPECT_TRUE(naiveVoltage({}, drive_->series, rest()).voltage.empty());
  EXPECT_FALSE(scoreNaive({}, drive_->series, rest(), mask).mixed.share_percent);
}

TEST_F(BothWays, TheLiveTrackerIsWhereCarryingTheStateOfflinePutsIt) {
  FittedModel offline = *model_;
  StateTracker tracker(*model_, gapThreshold(drive_->series));
  // Judgements of a live source begin with the model: offline ones look back a little. A sample settles with the one behind it.
  std::vector<char> live;
  for (std::size_t n = half(); n < drive_->series.size(); ++n) {
    if (!tracker.follow(drive_->series.time[n], drive_->series.current[n], drive_->series.voltage[n])) continue;
    const double current = drive_->series.current[n - 1];
    live.push_back(tracker.last().voltage_drives);
    if (tracker.last().voltage_drives) {
      EXPECT_NEAR(tracker.error(), 0.01 * (current - tracker.last().current), 1e-12);
    } else {
      EXPECT_EQ(tracker.last().current, current);
      EXPECT_NEAR(tracker.error(), drive_->series.voltage[n - 1] - tracker.last().voltage, 1e-12);
    }
  }
  ASSERT_EQ(live.size(), rest().size() - 1);
  carryState(offline, drive_->series, drive_->series.size() - 1);
  const FittedModel now = tracker.modelNow();
  const FollowedPrediction predicted = predictMixed(*model_, drive_->series, rest());
  std::size_t alike = 0;
  for (std::size_t k = 0; k < live.size(); ++k) alike += static_cast<bool>(live[k]) == static_cast<bool>(predicted.voltage_drives[k]);
  EXPECT_GT(static_cast<double>(alike) / static_cast<double>(live.size()), 0.99);
  EXPECT_EQ(now.state.time, offline.state.time);
  EXPECT_NEAR(now.state.u_c2, offline.state.u_c2, 1e-3);
  for (std::size_t j = 0; j < now.state.further.size(); ++j)
    EXPECT_NEAR(now.state.further[j], offline.state.further[j], 0.01 * (1.0 + std::abs(offline.state.further[j])));
}

}  // namespace
}  // namespace battery_sof

#include <gtest/gtest.h>

#include "estimation/fit_quality.hpp"
#include "estimation/identification.hpp"
#include "estimation/window.hpp"
#include "prediction/online_session.hpp"
#include "prediction/questions.hpp"
#include "state/state_estimator.hpp"
#include "state/state_tracker.hpp"
#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// A composition at its magnitudes, one per cent uncertain, its state at rest at a sample of the
/// recording.
FittedModel standingAt(const std::vector<std::string>& effects, const Series& series,
                       std::size_t n) {
  FittedModel model =
      unfitted(series, {0, n + 1}, BatteryModel(effects), FitStatus::kConverged, "");
  const BatteryModel composition(effects);
  Eigen::VectorXd p = typicalPoint(composition);
  if (const auto row = composition.parameterRow("contact_time")) p[*row] = series.time[n] + 20.0;
  model.fit.parameters = baseParameters(p);
  Eigen::VectorXd std = Eigen::VectorXd::Constant(p.size() + composition.stateCount(), 0.002);
  for (Eigen::Index j = 0; j < p.size(); ++j) {
    model.fit.estimates[static_cast<std::size_t>(j)].value = p[j];
    const ParameterInfo& info = composition.parameters()[static_cast<std::size_t>(j)];
    std[j] = info.held ? 0.0 : 0.01 * std::abs(info.magnitude);
  }
  model.fit.covariance = std.cwiseAbs2().asDiagonal();
  model.fit.scores.rmse = 0.002;
  return model;
}

class LiveEffect : public ::testing::TestWithParam<std::string> {};

TEST_P(LiveEffect, TrackedSampleBySampleIsWhereCarryingTheStateOfflinePutsIt) {
  Series series = baseDrive(8, 60.0);
  for (std::size_t n = 4000; n < series.size(); ++n) series.time[n] += 30.0;  // the recorder slept
  FittedModel offline = standingAt(withNeeds(GetParam()), series, 1000);
  StateTracker tracker(offline, gapThreshold(series));
  for (std::size_t n = 1001; n < series.size(); ++n)
    tracker.follow(series.time[n], series.current[n], series.voltage[n]);
  carryState(offline, series, series.size() - 1);
  const FittedModel live = tracker.modelNow();
  EXPECT_EQ(live.state.time, offline.state.time);
  EXPECT_EQ(live.state.states, offline.state.states);
  EXPECT_EQ(live.state.states, tracker.state().states);
  EXPECT_TRUE(live.fit.covariance.isApprox(offline.fit.covariance, 1e-12));
  EXPECT_GT(live.fit.covariance.trace(), 0.0);
}

TEST_P(LiveEffect, StateSetFromAMeasuredVoltageReadsThatVoltage) {
  const Series series = baseDrive(8, 20.0);
  FittedModel model = standingAt(withNeeds(GetParam()), series, 1000);
  const double measured = 12.345;
  setStateFromVoltage(model, series.time[1500], -20.0, measured);
  Simulation here = simulationOf(model);
  InputStep now;
  now.time = series.time[1500];
  now.held = now.current = -20.0;
  here.advance(now);
  EXPECT_NEAR(here.voltage(), measured, 1e-9);
}

TEST_P(LiveEffect, ACrankIsTheProfileOfItsCurrentAtTheTimesThatAreLookedAt) {
  const FittedModel model = standingAt(withNeeds(GetParam()), baseDrive(8, 20.0), 1000);
  CrankingQuery held;
  held.i_load = -20.0;
  held.t_stop = 30.0;
  held.i_cranking = -200.0;
  held.t_cranking = 0.8;
  CrankingQuery profile = held;
  profile.crank = {{0.0, 0.04, 0.16, 0.4, 0.8}, std::vector<double>(5, -200.0)};
  const CrankingAnswer of_held = predictCranking(model, held),
                       of_profile = predictCranking(model, profile);
  ASSERT_TRUE(of_held.u_min && of_profile.u_min) << of_held.message;
  EXPECT_NEAR(of_held.u_min->value, of_profile.u_min->value, 2e-3);
}

std::vector<std::string> allIds() {
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue()) ids.push_back(info.id);
  return ids;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, LiveEffect, ::testing::ValuesIn(allIds()),
                         [](const auto& instance) { return instance.param; });

TEST(OnlineSession, WithEffectsGivesTheSameAnswersAsTheOfflineFunctions) {
  const std::vector<std::string> effects = {"acid_transport", "current_dependent_resistance"};
  const Series series = recordingOf(effects, 330.0);
  SessionOptions options;
  options.identify.effects = effects;
  options.identify.more_starts = 0;
  OnlineSession session(options);
  std::optional<double> identified;
  for (std::size_t n = 0; n < series.size(); ++n) {
    session.push({series.time[n], series.current[n], series.voltage[n], {}});
    if (const auto job = session.takeDueJob()) {
      const IdentificationOutcome outcome = session.finish(runIdentification(*job));
      ASSERT_TRUE(outcome.accepted) << outcome.message;
      if (!identified) identified = series.time[n];
    }
  }
  ASSERT_TRUE(identified);

  const WindowChoice choice = chooseWindow(series, {0, firstAfter(series, *identified)});
  ASSERT_TRUE(choice.range);
  FittedModel model = identify(series, *choice.range, options.identify);
  fitErrors(model, series, *choice.range);
  carryState(model, series, series.size() - 1);
  // the session has learned from the cranks it saw
  model.intervals.calibrations.cranks = session.calibrations().cranks;
  CrankingQuery query;
  query.i_load = -25.0;
  query.t_stop = 20.0;
  query.i_cranking = -200.0;
  const CrankingAnswer offline = predictCranking(model, query),
                       live = session.live().predictCranking(query);
  ASSERT_TRUE(offline.u_min && live.u_min);
  EXPECT_NEAR(live.u_min->value, offline.u_min->value, 1e-9);
  EXPECT_NEAR(live.u_min->lower, offline.u_min->lower, 1e-9);
  EXPECT_NEAR(live.u_min->upper, offline.u_min->upper, 1e-9);
  EXPECT_EQ(live.message, offline.message);
}

}  // namespace
}  // namespace battery_sof

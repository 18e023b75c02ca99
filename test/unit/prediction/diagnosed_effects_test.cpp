#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prediction/online_session.hpp"
#include "support/composed.hpp"
#include "support/drive_with_discrepancy.hpp"

namespace battery_sof {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<std::string> kMissing = {"current_dependent_resistance"};
const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};

/// Plays a recording through a session; an identification comes back `late` samples after its job.
struct Player {
  OnlineSession& session;
  std::size_t late = 0;
  std::vector<double> taken = {};  ///< [s], stamps of the jobs
  std::vector<EventComparison> cranks = {};
  std::optional<IdentificationResult> pending = {};
  std::size_t due = 0;

  void play(const Series& series, std::size_t first, std::size_t last) {
    for (std::size_t n = first; n < last; ++n) {
      const SessionEvents events =
          session.push({series.time[n], series.current[n], series.voltage[n], {}});
      cranks.insert(cranks.end(), events.cranks.begin(), events.cranks.end());
      if (const auto job = session.takeDueJob()) {
        taken.push_back(series.time[n]);
        pending = runIdentification(*job);
        due = n + late;
      }
      if (pending && n >= due) {
        session.finish(*pending);
        pending.reset();
      }
    }
  }
};

SessionOptions options() {
  SessionOptions options;
  options.identify_period = 200.0;
  options.identify.more_starts = 0;
  return options;
}

TEST(SessionOfDiagnosedEffects, CompositionThatTheBatteryHasIsFittedAndPredictsBetter) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession own(options()), told(options());
  Player without{own}, with{told};
  for (Player* player : {&without, &with}) player->play(series, 0, 5200);
  told.fitWith(kMissing);
  for (Player* player : {&without, &with}) player->play(series, 5200, series.size());
  EXPECT_THAT(told.status().effects, ElementsAre(kMissing[0])) << told.status().reason;
  EXPECT_THAT(own.status().effects, IsEmpty());
  EXPECT_LT(100.0 - *told.status().backtest.q_dyn_percent,
            0.5 * (100.0 - *own.status().backtest.q_dyn_percent));
  EXPECT_EQ(told.model()->fit.effects, kMissing);
  EXPECT_TRUE(told.live().predictCranking(kQuery).u_min);
}

TEST(SessionOfDiagnosedEffects, OfferedCompositionIsFittedAtOnceButNotBeforeItsMoment) {
  const Series series = recordingOf(kMissing, 420.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 5200);
  ASSERT_EQ(player.taken.size(), 1u);
  session.fitWith(kMissing, 350.0);
  session.fitWith(kMissing, 380.0);  // the same again changes nothing
  player.play(series, 5200, series.size());
  ASSERT_EQ(player.taken.size(), 2u);
  EXPECT_NEAR(player.taken[1], 350.0, 0.1);
}

TEST(SessionOfDiagnosedEffects, HowLongIdentificationsTakeChangesAnswersByTheirCalibrationAlone) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession prompt(options()), late(options());
  Player first{prompt}, second{late, 800};
  for (Player* player : {&first, &second}) {
    player->session.fitWith(kMissing, 300.0);
    player->play(series, 0, series.size());
  }
  EXPECT_EQ(first.taken, second.taken);
  ASSERT_EQ(first.cranks.size(), second.cranks.size());
  for (std::size_t k = 0; k < first.cranks.size(); ++k)
    EXPECT_EQ(first.cranks[k].time, second.cranks[k].time);
  EXPECT_THAT(prompt.status().effects, ElementsAre(kMissing[0]));
  EXPECT_EQ(prompt.status().effects, late.status().effects);
  // Intervals are calibrated by the answers that were given, which differ meanwhile.
  EXPECT_NEAR(prompt.live().predictCranking(kQuery).u_min->value,
              late.live().predictCranking(kQuery).u_min->value, 0.01);
}

TEST(SessionOfDiagnosedEffects, AnotherCompositionTakesThePlaceOfTheOneBefore) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession session(options());
  Player player{session};
  session.fitWith(kMissing);
  player.play(series, 0, 11000);
  ASSERT_THAT(session.status().effects, ElementsAre(kMissing[0]));
  session.fitWith({"current_dependent_resistance", "acid_transport"});
  player.play(series, 11000, 11100);
  EXPECT_THAT(session.status().effects,
              ElementsAre("current_dependent_resistance", "acid_transport"));
}

TEST(SessionOfDiagnosedEffects,
     RefusedFitLeavesTheModelInUseAndGoesBackToTheSessionsOwnComposition) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 5200);
  session.fitWith(kMissing);
  IdentificationResult result = runIdentification(*session.takeDueJob());
  result.model->fit.status = FitStatus::kNotExcited;
  EXPECT_FALSE(session.finish(result).accepted);
  EXPECT_THAT(session.status().effects, IsEmpty());
  EXPECT_THAT(session.takeJob()->identify.effects, IsEmpty());
}

TEST(SessionOfDiagnosedEffects, EstimatedDiscrepancyIsFittedAndKeptForTheNextTrip) {
  const Series series = withMemoryOfCharging(900.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 9000);
  session.fitWith({kDiscrepancyEffect}, 0.0, discrepancyLearntFrom(series, 9000));
  player.play(series, 9000, series.size());
  EXPECT_THAT(session.status().effects, ElementsAre(kDiscrepancyEffect)) << session.status().reason;
  EXPECT_TRUE(session.live().predictCranking(kQuery).u_min);
  EXPECT_THROW(session.fitWith({kDiscrepancyEffect}), std::invalid_argument) << "no discrepancy";
  OnlineSession next(options());
  next.restore(*session.modelToSave());
  Series later = series;
  for (double& time : later.time) time += 3600.0;
  Player{next}.play(later, 0, 600);
  EXPECT_THAT(next.status().effects, ElementsAre(kDiscrepancyEffect)) << next.status().reason;
  EXPECT_TRUE(next.live().predictCranking(kQuery).u_min);
}

TEST(SessionOfDiagnosedEffects, ClockThatJumpsBackKeepsTheComposition) {
  const Series series = recordingOf(kMissing, 600.0);
  OnlineSession session(options());
  Player player{session};
  session.fitWith(kMissing);
  player.play(series, 0, series.size());
  ASSERT_THAT(session.status().effects, ElementsAre(kMissing[0]));
  player.play(series, 0, 600);
  EXPECT_EQ(session.counts().clock_restarts, 1u);
  EXPECT_THAT(session.status().effects, ElementsAre(kMissing[0]));
  EXPECT_EQ(session.takeJob()->identify.effects, kMissing);
}

TEST(SessionOfDiagnosedEffects, WhatCannotBeComposedIsRefusedByItsName) {
  OnlineSession session;
  EXPECT_THROW(session.fitWith({}), std::invalid_argument);
  EXPECT_THROW(session.fitWith({"perpetual_motion"}), std::invalid_argument);
  SessionOptions paper;
  paper.identify.start = FitStart::kPaper;
  EXPECT_THROW(OnlineSession(paper).fitWith(kMissing), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prediction/online_session.hpp"
#include "support/composed.hpp"
#include "support/drive_with_discrepancy.hpp"

namespace battery_sof {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<std::string> kMissing = {"current_dependent_resistance"};
const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};

/// Plays a recording through a session; an identification comes back `late` samples after its job.
struct Player {
  OnlineSession& session;
  std::size_t late = 0;
  std::vector<double> taken = {};  ///< [s], stamps of the jobs
  std::vector<EventComparison> cranks = {};
  std::vector<bool> extended_answered = {};
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
      extended_answered.push_back(session.doesExtendedAnswer());
    }
  }
};

SessionOptions options() {
  SessionOptions options;
  options.identify_period = 200.0;
  options.identify.more_starts = 0;
  return options;
}

TEST(ExtendedSession, CompositionThatTheBatteryHasAnswersAndPredictsBetter) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 5200);
  session.extendWith(kMissing);
  EXPECT_THAT(session.status().extension, HasSubstr("is to be fitted"));
  player.play(series, 5200, series.size());
  const SessionStatus status = session.status();
  EXPECT_TRUE(session.doesExtendedAnswer()) << status.extension;
  EXPECT_THAT(status.effects, ElementsAre(kMissing[0]));
  EXPECT_THAT(status.extension, HasSubstr("the model with current_dependent_resistance answers"));
  ASSERT_TRUE(status.selector);
  EXPECT_LT(status.selector->extended_rmse, 0.5 * status.selector->base_rmse);
  EXPECT_EQ(session.model()->fit.effects, kMissing);
  EXPECT_TRUE(session.live().predictCranking(kQuery).u_min);
}

TEST(ExtendedSession, CompositionThatTheBatteryLacksDoesNotAnswer) {
  const Series series = recordingOf({}, 900.0);
  OnlineSession session(options());
  Player player{session};
  session.extendWith(kMissing);
  player.play(series, 0, series.size());
  EXPECT_EQ(std::count(player.extended_answered.begin(), player.extended_answered.end(), true), 0);
  EXPECT_THAT(session.status().extension, HasSubstr("the base model answers: over"));
  EXPECT_TRUE(session.model()->fit.effects.empty());
}

TEST(ExtendedSession, OfferedCompositionIsFittedAtOnceButNotBeforeItsMoment) {
  const Series series = recordingOf(kMissing, 420.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 5200);
  ASSERT_EQ(player.taken.size(), 1u);
  session.extendWith(kMissing, 350.0);
  session.extendWith(kMissing, 380.0);  // the same again changes nothing
  player.play(series, 5200, series.size());
  ASSERT_EQ(player.taken.size(), 2u);
  EXPECT_NEAR(player.taken[1], 350.0, 0.1);
}

TEST(ExtendedSession, HowLongIdentificationsTakeChangesAnswersByTheirCalibrationAlone) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession prompt(options()), late(options());
  Player first{prompt}, second{late, 800};
  for (Player* player : {&first, &second}) {
    player->session.extendWith(kMissing, 300.0);
    player->play(series, 0, series.size());
  }
  EXPECT_EQ(first.taken, second.taken);
  ASSERT_EQ(first.cranks.size(), second.cranks.size());
  for (std::size_t k = 0; k < first.cranks.size(); ++k)
    EXPECT_EQ(first.cranks[k].time, second.cranks[k].time);
  EXPECT_TRUE(prompt.doesExtendedAnswer());
  EXPECT_EQ(prompt.status().extension, late.status().extension);
  // Intervals are calibrated by the answers that were given, which differ meanwhile.
  EXPECT_NEAR(prompt.live().predictCranking(kQuery).u_min->value,
              late.live().predictCranking(kQuery).u_min->value, 0.01);
}

TEST(ExtendedSession, AnotherCompositionTakesThePlaceWhenItFitsAsWell) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession session(options());
  Player player{session};
  session.extendWith(kMissing);
  player.play(series, 0, 11000);
  ASSERT_TRUE(session.doesExtendedAnswer());
  session.extendWith({"current_dependent_resistance", "acid_transport"});
  player.play(series, 11000, 11100);
  EXPECT_THAT(session.status().effects,
              ElementsAre("current_dependent_resistance", "acid_transport"));
}

TEST(ExtendedSession, AnotherCompositionThatFitsWorseLeavesTheOneBeforeInUse) {
  const Series series = recordingOf(kMissing, 700.0);
  OnlineSession session(options());
  Player player{session};
  session.extendWith(kMissing);
  player.play(series, 0, 11000);
  ASSERT_TRUE(session.doesExtendedAnswer());
  session.extendWith({"gassing"});
  player.play(series, 11000, 11100);
  EXPECT_THAT(session.status().effects, ElementsAre(kMissing[0]));
  EXPECT_THAT(session.status().extension,
              HasSubstr("the fit with gassing was refused: on the most recent"));
}

TEST(ExtendedSession, WhatWasLearntAnswersWhereItErrsLess) {
  const Series series = withMemoryOfCharging(900.0);
  OnlineSession session(options());
  Player player{session};
  player.play(series, 0, 9000);
  session.extendWith({kDiscrepancyEffect}, 0.0, discrepancyLearntFrom(series, 9000));
  player.play(series, 9000, series.size());
  const SessionStatus status = session.status();
  EXPECT_TRUE(session.doesExtendedAnswer()) << status.extension;
  EXPECT_THAT(status.effects, ElementsAre(kDiscrepancyEffect));
  ASSERT_TRUE(status.selector);
  EXPECT_LT(status.selector->extended_rmse, 0.5 * status.selector->base_rmse);
  EXPECT_TRUE(session.live().predictCranking(kQuery).u_min);
  EXPECT_THROW(session.extendWith({kDiscrepancyEffect}), std::invalid_argument) << "no force";
}

TEST(ExtendedSession, ClockThatJumpsBackKeepsWhoAnswers) {
  const Series series = recordingOf(kMissing, 600.0);
  OnlineSession session(options());
  Player player{session};
  session.extendWith(kMissing);
  player.play(series, 0, series.size());
  ASSERT_TRUE(session.doesExtendedAnswer());
  player.play(series, 0, 600);
  EXPECT_EQ(session.counts().clock_restarts, 1u);
  EXPECT_TRUE(session.doesExtendedAnswer());
  EXPECT_LT(session.status().selector->duration, 31.0);
}

TEST(ExtendedSession, WhatCannotBeComposedIsRefusedByItsName) {
  OnlineSession session;
  EXPECT_THROW(session.extendWith({}), std::invalid_argument);
  EXPECT_THROW(session.extendWith({"perpetual_motion"}), std::invalid_argument);
  SessionOptions paper;
  paper.identify.start = FitStart::kPaper;
  EXPECT_THROW(OnlineSession(paper).extendWith(kMissing), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

#include "battery_sof/session.hpp"

#include <gtest/gtest.h>

#include "state/fitted_model.hpp"
#include "support/composed.hpp"

namespace battery_sof {
namespace {

using namespace test;

/// A session that was given a drive of 100 Hz, and identified whenever that was due.
Session driven(const Series& series, const SessionSettings& settings = {}) {
  Session session(settings);
  for (std::size_t n = 0; n < series.size(); ++n) {
    session.push({series.time[n], series.current[n], series.voltage[n], std::nullopt});
    session.identifyWhenDue();
  }
  return session;
}

CrankingQuery nextCrank() {
  CrankingQuery query;
  query.i_load = -15.0;
  query.t_stop = 60.0;
  query.i_cranking = -150.0;
  query.t_cranking = 0.5;
  query.u_required = 7.2;
  return query;
}

TEST(Session, AnswersWithinItsFirstSecondsBeforeAnythingIsFitted) {
  Session session;
  EXPECT_FALSE(session.model());
  EXPECT_EQ(session.predictCranking(nextCrank()).code, AnswerCode::kNoModel);
  for (int n = 0; n < 300; ++n) session.push({0.01 * n, -10.0, 12.5, std::nullopt});
  ASSERT_TRUE(session.model());
  EXPECT_EQ(session.model()->fitted().fit.window.samples, 0u);
  EXPECT_TRUE(session.predictCranking(nextCrank()).u_min);
  EXPECT_FALSE(session.identifyWhenDue());
  EXPECT_NE(session.reason(), "");
}

TEST(Session, AnswersAsTheModelThatItHandsOver) {
  const Session session = driven(baseDrive(8, 400.0));
  const auto model = session.model();
  ASSERT_TRUE(model && model->usable());
  EXPECT_GT(model->fitted().fit.window.samples, 1000u) << session.reason();
  const CrankingAnswer here = session.predictCranking(nextCrank()),
                       there = predictCranking(*model, nextCrank());
  ASSERT_TRUE(here.u_min && there.u_min);
  EXPECT_NEAR(here.u_min->value, there.u_min->value, 1e-9);
  EXPECT_NEAR(here.u_min->lower, there.u_min->lower, 1e-9);
  const StopTimeAnswer stop = session.predictStopTime({-15.0, -150.0, 0.5, 7.2});
  EXPECT_EQ(stop.t_stop.has_value(), here.u_min->lower > 7.2);
  EXPECT_TRUE(session.predictChargeAcceptance({14.0, 10.0, 80.0}).i_boost);
}

TEST(Session, GoesOnWithTheModelOfTheDriveBefore) {
  const Series drive = baseDrive(8, 400.0);
  const Session before = driven(drive);
  Session next;
  next.restore(before.model().value());
  const double hour = drive.time.back() + 3600.0;
  for (int n = 0; n < 200; ++n) next.push({hour + 0.01 * n, 0.0, 12.6, std::nullopt});
  ASSERT_TRUE(next.model());
  EXPECT_EQ(next.model()->fitted().fit.window.to, before.model()->fitted().fit.window.to);
}

TEST(Session, TakesItsSettingsOrSaysWhichIsWrong) {
  SessionSettings settings;
  settings.series_blocks = 2.0;
  Session session = driven(baseDrive(8, 10.0), settings);
  EXPECT_EQ(session.model()->fitted().fit.series_blocks, 2.0);
  settings.series_blocks = -1.0;
  EXPECT_THROW(Session{settings}, std::invalid_argument);
  settings = {};
  settings.capacity = 0.0;
  EXPECT_THROW(Session{settings}, std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

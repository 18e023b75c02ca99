#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prediction/online_session.hpp"
#include "support/known_model.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};
constexpr double kStart = 1000.0;  // [s]

/// A session with a saved model in use, a minute into a drive.
class WrongClock : public ::testing::Test {
 protected:
  WrongClock() : inputs_(test::baseDrive(3, 120.0)) {
    FittedModel saved = test::uncertainModel(0.02);
    saved.state.time = saved.fit.window.to = kStart - 10.0;
    saved.fit.window.from = kStart - 110.0;
    session_.restore(saved);
    pushUntil(6000);
  }

  RawSample sampleAt(std::size_t n, double shift = 0.0) const {
    return {kStart + inputs_.time[n] + shift, inputs_.current[n], inputs_.voltage[n], {}};
  }
  void pushUntil(std::size_t end) {
    for (; next_ < end; ++next_) session_.push(sampleAt(next_));
  }

  Series inputs_;
  OnlineSession session_;
  std::size_t next_ = 0;
};

TEST_F(WrongClock, TwoStrayFramesOfTheFutureTakeNeitherModelNorBufferAway) {
  ASSERT_FALSE(session_.whyNoModel());
  OnlineSession other = session_;
  const std::size_t buffered = session_.series().size();
  for (std::size_t n = 0; n < 2; ++n) session_.push(sampleAt(next_ + n, 1e9));
  pushUntil(6100);
  for (std::size_t n = 6000; n < 6100; ++n) other.push(sampleAt(n));
  ASSERT_FALSE(session_.whyNoModel()) << *session_.whyNoModel();
  EXPECT_EQ(session_.series().size(), buffered + 100);
  EXPECT_EQ(session_.series().time, other.series().time);
  EXPECT_EQ(session_.live().predictCranking(kQuery).u_min->value,
            other.live().predictCranking(kQuery).u_min->value);
}

TEST_F(WrongClock, TwentySecondsOfZeroBasedStampsAreForgotten) {
  const std::size_t buffered = session_.series().size();
  for (std::size_t n = 0; n < 2000; ++n) session_.push(sampleAt(n, -kStart));
  pushUntil(6100);
  ASSERT_FALSE(session_.whyNoModel()) << *session_.whyNoModel();
  EXPECT_EQ(session_.series().size(), buffered + 100);
  EXPECT_NEAR(*session_.status().model_age, kStart + 61.0 - (kStart - 10.0), 0.1);
}

TEST_F(WrongClock, AJobOfBeforeIsDroppedAndAnotherCanBeTaken) {
  const auto job = session_.takeJob();
  ASSERT_TRUE(job);
  for (std::size_t n = 0; n < 2; ++n) session_.push(sampleAt(next_ + n, 1e9));
  pushUntil(6100);
  EXPECT_FALSE(session_.finish(IdentificationResult()).accepted);
  EXPECT_TRUE(session_.takeJob());
}

TEST_F(WrongClock, CountsNeverFall) {
  const std::size_t accepted = session_.counts().accepted;
  for (std::size_t n = 0; n < 50; ++n) session_.push(sampleAt(next_ + n, 1e9));
  const std::size_t meanwhile = session_.counts().accepted;
  pushUntil(6010);
  EXPECT_GE(meanwhile, accepted);
  EXPECT_GE(session_.counts().accepted, meanwhile);
}

TEST_F(WrongClock, AStampThatIsNoTimeIsRefusedAtOnceAndForWhatItIs) {
  session_.push(sampleAt(next_, 1e15));
  EXPECT_EQ(session_.counts().rejected.out_of_range, 1u);
  EXPECT_EQ(session_.counts().rejectedTotal(), 1u);
}

TEST_F(WrongClock, AClockThatStaysWhereItJumpedToIsBelieved) {
  for (std::size_t n = 0; n < 11000; ++n) session_.push(sampleAt(n, -kStart));
  EXPECT_LT(*session_.newestTime(), kStart);
  EXPECT_EQ(session_.series().time.front(), 0.0);
}

TEST_F(WrongClock, BeginningAnewForgetsTheModelAndKeepsTheCounts) {
  const std::size_t accepted = session_.counts().accepted;
  session_.beginAnew();
  EXPECT_TRUE(session_.whyNoModel());
  EXPECT_TRUE(session_.series().empty());
  EXPECT_EQ(session_.counts().accepted, accepted);
  pushUntil(6500);
  EXPECT_GT(session_.series().size(), 300u);
}

TEST(SavedModel, SurvivesAFirstStampOfZero) {
  FittedModel saved = test::uncertainModel(0.02);
  saved.state.time = saved.fit.window.to = 1.7e9;
  saved.fit.window.from = 1.7e9 - 100.0;
  OnlineSession session;
  session.restore(saved);
  session.push({0.0, -5.0, 12.5, {}});
  for (int n = 0; n < 300; ++n) session.push({1.7e9 + 10.0 + 0.01 * n, -5.0, 12.5, {}});
  ASSERT_FALSE(session.whyNoModel()) << *session.whyNoModel();
  EXPECT_THAT(session.status().reason, HasSubstr("the saved model is in use"));
}

TEST(SavedModel, RefusedByAWrongClockIsJudgedAgainWhenTheClockIsRight) {
  FittedModel saved = test::uncertainModel(0.02);
  saved.state.time = saved.fit.window.to = 1.7e9;
  saved.fit.window.from = 1.7e9 - 100.0;
  OnlineSession session;
  session.restore(saved);
  for (int n = 0; n < 500; ++n) session.push({0.01 * n, -5.0, 12.5, {}});
  EXPECT_EQ(session.status().basis, AnswerBasis::kPopulation);
  EXPECT_THAT(session.status().reason, HasSubstr("ahead of the first sample"));
  for (int n = 0; n < 300; ++n) session.push({1.7e9 + 10.0 + 0.01 * n, -5.0, 12.5, {}});
  EXPECT_EQ(session.status().basis, AnswerBasis::kPreviousTrip) << session.status().reason;
}

TEST(SavedModel, ThatWaitsIsNotCalledUnidentified) {
  OnlineSession session;
  session.restore(test::knownModel());
  EXPECT_EQ(session.whyNoModel().value_or(""), "the saved model is waiting for the first sample");
  EXPECT_THAT(session.live().predictCranking(kQuery).message, Not(HasSubstr("nothing identified")));
}

TEST(SessionStatus, HasAReasonBeforeAnyWindowWasLookedAt) {
  OnlineSession session;
  for (int n = 0; n < 300; ++n) session.push({0.01 * n, -5.0, 12.5, {}});
  EXPECT_EQ(session.status().state, SessionState::kReady);
  EXPECT_THAT(session.status().reason,
              HasSubstr("answers rest on what is known of lead-acid batteries"));
}

TEST(SessionStatus, SamplesThatAreAllRefusedAreToldByReason) {
  OnlineSession session;
  for (int n = 0; n < 20000; ++n) session.push({0.0, -5.0, 12.5, {}});
  EXPECT_EQ(session.status().state, SessionState::kNoSample);
  EXPECT_THAT(session.status().reason,
              HasSubstr("no usable sample yet, 19999 rejected (19999 duplicate stamp)"));
}

}  // namespace
}  // namespace battery_sof

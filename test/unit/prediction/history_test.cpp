#include "prediction/history.hpp"

#include <gtest/gtest.h>

#include "support/known_model.hpp"

namespace battery_sof {
namespace {

/// A history at ten samples a second, of which the first second is taken.
class MarkedHistory : public ::testing::Test {
 protected:
  MarkedHistory() : history_({SampleStream(100.0), ModelMonitor({})}) { pushUntil(10.0); }

  void pushUntil(double end, double shift = 0.0) {
    for (; time_ < end; time_ += 0.1) {
      history_.now().stream.push({time_ + shift, -10.0, 12.4, {}});
      history_.now().driving += 0.1;
    }
  }

  History history_;
  double time_ = 0.0;  // [s]
};

TEST_F(MarkedHistory, RewoundItKnowsWhatItKnewAtTheMarkAndHasCountedAllSince) {
  history_.mark(Mark::kBeforeClockJump);
  const Series before = history_.now().stream.series();
  const double driven = history_.now().driving;
  pushUntil(20.0, 1e6);
  const std::size_t accepted = history_.now().stream.counts().accepted;
  history_.rewindTo(Mark::kBeforeClockJump);
  EXPECT_EQ(history_.now().stream.series().time, before.time);
  EXPECT_EQ(history_.now().driving, driven);
  EXPECT_EQ(history_.now().stream.counts().accepted, accepted);
  EXPECT_EQ(history_.now().stream.counts().clock_restarts, 1u);
  EXPECT_FALSE(history_.has(Mark::kBeforeClockJump));
}

TEST_F(MarkedHistory, AJobTakenSinceCountsAsTakenAtTheMarkAndOneFromBeforeAsItWas) {
  const double driven = history_.now().driving;
  history_.mark(Mark::kJobTaken);
  pushUntil(20.0);
  history_.mark(Mark::kBeforeClockJump);
  history_.rewindTo(Mark::kBeforeClockJump);
  EXPECT_EQ(history_.at(Mark::kJobTaken).driving, driven);
  history_.rewindTo(Mark::kBeginning);
  EXPECT_EQ(history_.at(Mark::kJobTaken).driving, 0.0);
  EXPECT_FALSE(history_.continuesFrom(*history_.take(Mark::kJobTaken)));
  EXPECT_FALSE(history_.has(Mark::kJobTaken));
}

TEST_F(MarkedHistory, AReplayedModelStandsWhereOneStandsThatFollowedAllAlong) {
  FittedModel model = test::uncertainModel(0.02);
  model.state.time = time_;
  ModelMonitor followed({});
  followed.install(model, 5.0);
  const ModelMonitor marked = followed;
  const double from = time_;
  pushUntil(30.0);
  const Series& series = history_.now().stream.series();
  for (std::size_t n = firstAfter(series, from); n < series.size(); ++n)
    followed.follow(series[n], history_.now().stream.maxGap());
  EXPECT_TRUE(history_.replay(marked));
  EXPECT_EQ(history_.now().monitor.now().state.time, series.time.back());
  EXPECT_EQ(history_.now().monitor.now().state.states, followed.now().state.states);
}

TEST_F(MarkedHistory, AModelWhoseNumbersEndWhileItIsReplayedIsToldOf) {
  ModelMonitor marked({});
  marked.install(test::overflowingModel(time_), 5.0);
  pushUntil(20.0);
  EXPECT_TRUE(history_.replay(marked));
  pushUntil(90.0);
  EXPECT_FALSE(history_.replay(marked));
}

}  // namespace
}  // namespace battery_sof

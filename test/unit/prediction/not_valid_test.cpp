/// Streams that support no valid answer, whatever the model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "prediction/online_session.hpp"
#include "prediction/stream_watch.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const CrankingQuery kQuery{-25.0, 20.0, -200.0, 0.5, 7.2};

/// How often a session's standing question was answered, once a second.
struct Asked {
  int answered = 0, valid = 0;
};

/// Changes a sample on its way into a session.
using Change = std::function<RawSample(RawSample)>;

Asked played(OnlineSession& session, const Series& series, const Change& change = nullptr) {
  Asked asked;
  double due = series.time.front();
  for (std::size_t n = 0; n < series.size(); ++n) {
    RawSample sample{series.time[n], series.current[n], series.voltage[n], {}};
    session.push(change ? change(sample) : sample);
    if (series.time[n] < due) continue;
    due += 1.0;
    const CrankingAnswer answer = session.live().predictCranking(kQuery);
    if (answer.u_min) ++asked.answered;
    if (answer.valid) ++asked.valid;
  }
  return asked;
}

/// Two minutes at 20 Hz.
Series inputs(double duration = 120.0) {
  return test::answered(test::drivenBattery(), test::dataSetOneCurrent(duration, 0.05, 3), 0.05,
                        0.002, 3);
}

SessionOptions rowOf(double series_blocks) {
  SessionOptions options;
  options.series_blocks = series_blocks;
  return options;
}

TEST(NotValid, ASoundStreamGivesNoReason) {
  OnlineSession session;
  const Asked asked = played(session, inputs());
  EXPECT_FALSE(session.whyNotValid());
  EXPECT_GT(asked.valid, 60);
  EXPECT_EQ(session.status().not_valid, "");
}

// ----------------------------------------------------------------------------------------------------
// another number of blocks

class OtherBlocks : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(OtherBlocks, NothingIsValidFromTheFirstSampleOnAndTheReasonNamesTheNumber) {
  const auto [said, real] = GetParam();
  OnlineSession session(rowOf(said));
  const auto in_row = [real = real](RawSample sample) {
    if (sample.time < 2.0) sample.current = 0.0;  // a first rest
    sample.voltage *= real;
    return sample;
  };
  const Asked asked = played(session, inputs(), in_row);
  EXPECT_GT(asked.answered, 100);
  EXPECT_EQ(asked.valid, 0);
  EXPECT_THAT(session.whyNotValid().value_or(""), HasSubstr(format("(series_blocks %g)", real)));
  const CrankingAnswer answer = session.live().predictCranking(kQuery);
  EXPECT_EQ(answer.code, AnswerCode::kExtrapolation);
  EXPECT_THAT(answer.message, StartsWith("not valid: " + session.whyNotValid().value_or("?")));
  EXPECT_FALSE(session.live().predictChargeAcceptance({real * 14.0, 10.0, 100.0}).valid);
  EXPECT_FALSE(session.live().predictStopTime({-20.0, -200.0, 0.5, real * 7.2}).valid);
  EXPECT_FALSE(session.live().simulateProfile({0.0, 1.0}, {-10.0, -10.0}).valid);
  for (const CrankingAnswer& one : session.live().mapCranking(kQuery, {-20.0}, {1.0, 2.0}).answers)
    EXPECT_FALSE(one.valid);
  EXPECT_THAT(session.status().reason, HasSubstr(session.whyNotValid().value_or("?")));
  EXPECT_FALSE(session.modelToSave());
}

INSTANTIATE_TEST_SUITE_P(NotValid, OtherBlocks,
                         ::testing::Values(std::make_pair(1.0, 2.0), std::make_pair(2.0, 1.0),
                                           std::make_pair(1.0, 4.0), std::make_pair(4.0, 2.0),
                                           std::make_pair(2.0, 4.0), std::make_pair(1.0, 0.5)));

class RightBlocks : public ::testing::TestWithParam<double> {};

TEST_P(RightBlocks, NothingIsSaidOfTheNumberThatIsSet) {
  OnlineSession session(rowOf(GetParam()));
  played(session, inputs(), [](RawSample sample) {
    sample.voltage *= GetParam();
    return sample;
  });
  EXPECT_FALSE(session.whyNotValid());
  EXPECT_TRUE(session.modelToSave());
}

INSTANTIATE_TEST_SUITE_P(NotValid, RightBlocks, ::testing::Values(0.5, 1.0, 2.0, 4.0));

TEST(NotValid, ACrankDeepDownIsNoOtherNumberOfBlocks) {
  StreamWatch watch;
  double time = 0.0;
  const auto hold = [&](double seconds, double current, double voltage) {
    for (int n = 0; n < static_cast<int>(seconds); ++n)
      watch.accept({++time, current, voltage}, 10.0);
  };
  hold(60, -1.0, 12.4);
  hold(30, -300.0, 7.0);
  hold(60, 40.0, 14.4);
  EXPECT_FALSE(watch.whyNotValid(""));
}

TEST(NotValid, OneWrongFirstSampleIsForgottenTenSecondsLater) {
  StreamWatch watch;
  watch.accept({0.0, 0.0, 0.0}, 10.0);
  EXPECT_THAT(watch.whyNotValid("").value_or(""), HasSubstr("the voltage, 0.00 V"));
  for (double time = 1.0; time < 13.0; time += 1.0) watch.accept({time, -1.0, 12.5}, 10.0);
  EXPECT_FALSE(watch.whyNotValid(""));
}

// ----------------------------------------------------------------------------------------------------
// most of it refused

TEST(NotValid, ACurrentInMilliamperesAnswersNothingValid) {
  OnlineSession session;
  const Asked asked = played(session, inputs(300.0), [](RawSample sample) {
    sample.current *= 1000.0;
    return sample;
  });
  EXPECT_GT(session.counts().rejected.out_of_range, session.counts().accepted);
  EXPECT_LE(asked.valid, 1);
  EXPECT_THAT(session.whyNotValid().value_or(""),
              AllOf(HasSubstr("were rejected"), HasSubstr("out of range"), HasSubstr("A and V")));
}

TEST(NotValid, AMinorityThatIsMissingChangesNothing) {
  OnlineSession session;
  long n = 0;
  const Asked asked = played(session, inputs(), [&n](RawSample sample) {
    if (++n % 3 == 0) sample.voltage = kNan;
    return sample;
  });
  EXPECT_FALSE(session.whyNotValid());
  EXPECT_GT(asked.valid, 60);
}

TEST(NotValid, AStreamThatTurnsBadIsNoticedAfterAGapAndBelievedAgainWithTheNextSample) {
  OnlineSession session;
  std::vector<bool> valid;
  const Series series = inputs(180.0);
  for (std::size_t n = 0; n < series.size(); ++n) {
    RawSample sample{series.time[n], series.current[n], series.voltage[n], {}};
    if (sample.time >= 100.0 && sample.time < 120.0) sample.current = kNan;
    session.push(sample);
    if (sample.time > 106.0 && sample.time < 120.0) {
      EXPECT_THAT(session.whyNotValid().value_or(""), HasSubstr("every sample of the last"))
          << sample.time;
    }
    if (sample.time < 104.0 || sample.time > 121.0) {
      EXPECT_FALSE(session.whyNotValid()) << sample.time;
    }
  }
}

TEST(NotValid, SamplesThatComeTwiceAreNoFault) {
  OnlineSession session;
  const Series series = inputs(60.0);
  for (std::size_t n = 0; n < series.size(); ++n)
    for (int copy = 0; copy < 3; ++copy)
      session.push({series.time[n], series.current[n], series.voltage[n], {}});
  EXPECT_EQ(session.counts().rejected.duplicate_stamp, 2 * series.size());
  EXPECT_FALSE(session.whyNotValid());
}

TEST(NotValid, TheReasonWithoutASampleCountsEveryRejectedOne) {
  OnlineSession session;
  for (int n = 0; n < 300; ++n) session.push({100.0 * n, -5.0, 12.5, {}});
  const std::size_t rejected = session.counts().rejectedTotal();
  EXPECT_GT(rejected, 290u);
  EXPECT_THAT(session.status().reason + toString(session.counts().rejected),
              HasSubstr(format("%zu rejected (%zu stamp ahead)", rejected, rejected)));
}

// ----------------------------------------------------------------------------------------------------
// frozen channels

TEST(NotValid, AVoltageThatSticksAnswersNothingValidUntilItMovesAgain) {
  OnlineSession session;
  double held = 0.0;
  int valid_late = 0, asked_late = 0, valid_behind = 0, asked_behind = 0;
  const Series series = inputs(900.0);
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double time = series.time[n];
    if (time < 300.0) held = series.voltage[n];
    const double voltage = time < 300.0 || time >= 600.0 ? series.voltage[n] : held;
    session.push({time, series.current[n], voltage, {}});
    if (n % 20 != 0) continue;
    const bool is_valid = !session.whyNotValid();
    if (time >= 330.0 && time < 600.0) ++asked_late, valid_late += is_valid;
    if (time >= 602.0) ++asked_behind, valid_behind += is_valid;
  }
  EXPECT_EQ(valid_late, 0) << "of " << asked_late;
  EXPECT_EQ(valid_behind, asked_behind);
}

TEST(NotValid, AChannelThatRepeatsWhileTheModelMissesTheVoltageIsDoubtedUntilItMoves) {
  StreamWatch watch;
  Series series;
  const auto play = [&](double from, double to, bool stuck, bool missed) {
    for (double time = from; time < to; time += 0.1) {
      const double load = std::fmod(time, 6.0) < 3.0 ? -10.0 : -40.0;
      const Sample sample{time, load, stuck ? 12.4 : 12.5 + 0.005 * load + 1e-4 * time};
      series.append(sample);
      watch.accept(sample, 5.0);
      if (missed) watch.doubt(series, 5.0);
      watch.look(series, 5.0);
    }
    return watch.whyNotValid("").value_or("");
  };
  EXPECT_EQ(play(0.0, 60.0, false, true), "") << "nothing repeats";
  EXPECT_EQ(play(60.0, 68.0, true, false), "") << "no model misses it";
  EXPECT_THAT(play(68.0, 69.0, true, true), HasSubstr("since the model missed it"));
  EXPECT_NE(play(69.0, 72.0, true, false), "") << "the model has learnt what is stuck";
  EXPECT_EQ(play(72.0, 73.0, false, false), "");
}

// ----------------------------------------------------------------------------------------------------
// what is kept for the next trip

TEST(ModelToSave, WhatWasLearntOnAShortTripIsWhatTheNextOneBeginsFrom) {
  OnlineSession first;
  played(first, inputs(100.0));
  ASSERT_EQ(first.status().basis, AnswerBasis::kPopulation) << "too short for a window";
  const std::optional<FittedModel> saved = first.modelToSave();
  ASSERT_TRUE(saved);
  OnlineSession next, without;
  next.restore(*saved);
  Series later = inputs(5.0);
  for (double& time : later.time) time += 100000.0;
  played(next, later);
  played(without, later);
  EXPECT_EQ(next.status().basis, AnswerBasis::kPreviousTrip);
  const auto width = [](const OnlineSession& session) {
    const Interval u_min = *session.live().predictCranking(kQuery).u_min;
    return u_min.upper - u_min.lower;
  };
  EXPECT_LT(width(next), 0.8 * width(without));
  EXPECT_EQ(next.calibrations().cranks.factor, first.calibrations().cranks.factor);
}

TEST(ModelToSave, NothingIsKeptBeforeTheFirstSample) {
  OnlineSession session;
  EXPECT_FALSE(session.modelToSave());
}

TEST(ModelToSave, AModelThatTheClockRefusedIsNotReplacedByWhatIsKnownOfAllBatteries) {
  OnlineSession first;
  Series late = inputs(100.0);
  for (double& time : late.time) time += 1e9;
  played(first, late);
  OnlineSession next;
  next.restore(*first.modelToSave());
  played(next, inputs(60.0));  // the clock begins at 0
  EXPECT_EQ(next.status().basis, AnswerBasis::kPopulation);
  EXPECT_FALSE(next.modelToSave());
}

}  // namespace
}  // namespace battery_sof

#include "prediction/scores.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimation/identification.hpp"
#include "prediction/online_session.hpp"
#include "recording/series_blocks.hpp"
#include "support/base_drive.hpp"

/// A battery that is said to be a series string: what a row of n is asked is answered as of one,
/// with n times the voltage.
namespace battery_sof {
namespace {

using ::testing::HasSubstr;
using namespace test;

FittedModel fitted() {
  const Series series = baseDrive(7);
  FittedModel model = identify(series, {0, series.size()}, {});
  fitErrors(model, series, {0, series.size()});
  return model;
}

FittedModel rowOf(FittedModel model, double series_blocks) {
  model.fit.series_blocks = series_blocks;
  return model;
}

void expectTimes(double series_blocks, const Interval& row, const Interval& one) {
  EXPECT_EQ(row.value, series_blocks * one.value);
  EXPECT_EQ(row.lower, series_blocks * one.lower);
  EXPECT_EQ(row.upper, series_blocks * one.upper);
}

TEST(RowsOfBlocks, AreMultiplesOfHalfABlock) {
  for (const double series_blocks : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0})
    EXPECT_TRUE(areSeriesBlocks(series_blocks)) << series_blocks;
  for (const double series_blocks :
       {0.0, -1.0, 0.3, 2.25, 6.5, 1e300, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(areSeriesBlocks(series_blocks)) << series_blocks;
}

/// Powers of two: what is scaled by them is so to the last bit.
class SeriesBlocks : public ::testing::TestWithParam<double> {
 protected:
  const double blocks_ = GetParam();
  const FittedModel one_ = fitted(), row_ = rowOf(one_, blocks_);
};

TEST_P(SeriesBlocks, CranksWithAsManyTimesTheVoltage) {
  const CrankingQuery crank{-20.0, 30.0, -200.0, 0.8, 7.2};
  CrankingQuery of_row = crank;
  of_row.u_required = blocks_ * *crank.u_required;
  const CrankingAnswer one = predictCranking(one_, crank), row = predictCranking(row_, of_row);
  ASSERT_TRUE(one.u_min && row.u_min) << row.message;
  expectTimes(blocks_, *row.u_min, *one.u_min);
  EXPECT_EQ(row.capable, one.capable);
  EXPECT_EQ(row.valid, one.valid) << row.message;
  EXPECT_THAT(row.message, HasSubstr(format("lowest voltage %.2f V", row.u_min->value)));
}

TEST_P(SeriesBlocks, StopsAsLong) {
  for (const double u_required : {7.2, 11.0, 12.5}) {
    StopTimeQuery query;
    query.i_load = -20.0;
    query.i_cranking = -200.0;
    query.u_required = u_required;
    const StopTimeAnswer one = predictStopTime(one_, query);
    query.u_required = blocks_ * u_required;
    const StopTimeAnswer row = predictStopTime(row_, query);
    ASSERT_TRUE(one.t_stop && row.t_stop);
    expectTimes(1.0, *row.t_stop, *one.t_stop);
    EXPECT_EQ(row.outcome, one.outcome);
    EXPECT_EQ(row.valid, one.valid) << row.message;
  }
}

TEST_P(SeriesBlocks, TakesAsMuchChargeAtAsManyTimesTheVoltage) {
  for (const double u_boost : {13.1, 16.0}) {
    const auto one = predictChargeAcceptance(one_, {u_boost, 10.0, 200.0});
    const auto row = predictChargeAcceptance(row_, {blocks_ * u_boost, 10.0, 200.0});
    ASSERT_TRUE(one.i_boost && row.i_boost);
    expectTimes(1.0, *row.i_boost, *one.i_boost);
    EXPECT_EQ(row.valid, one.valid) << row.message;
  }
  const auto high = predictChargeAcceptance(row_, {blocks_ * 16.0, 10.0, 200.0});
  EXPECT_THAT(high.message,
              HasSubstr(format("it goes to %.2f V but the window's highest voltage was %.2f V",
                               blocks_ * 16.0, blocks_ * one_.fit.excited.max_voltage)));
}

TEST_P(SeriesBlocks, FollowsAProfileAndARecordingWithAsManyTimesTheVoltage) {
  const ProfileAnswer one = simulateProfile(one_, {0.0, 1.0, 5.0}, {0.0, -50.0, 30.0});
  const ProfileAnswer row = simulateProfile(row_, {0.0, 1.0, 5.0}, {0.0, -50.0, 30.0});
  ASSERT_EQ(row.predicted.voltage.size(), 3u);
  for (std::size_t n = 0; n < 3; ++n)
    expectTimes(blocks_, {row.predicted.voltage[n], row.predicted.lower[n], row.predicted.upper[n]},
                {one.predicted.voltage[n], one.predicted.lower[n], one.predicted.upper[n]});

  const Series drive = baseDrive(8, 60.0);
  const RangePrediction of_one = predictRange(one_, drive, {0, drive.size()});
  const RangePrediction of_row =
      predictRange(row_, perBlock(drive, 1.0 / blocks_), {0, drive.size()});
  EXPECT_EQ(of_row.course.voltage.back(), blocks_ * of_one.course.voltage.back());
  EXPECT_EQ(of_row.course.voltage_lower.back(), blocks_ * of_one.course.voltage_lower.back());
  EXPECT_EQ(of_row.report.from_current.rmse, blocks_ * of_one.report.from_current.rmse);
  EXPECT_EQ(of_row.report.from_current.q_dyn_percent, of_one.report.from_current.q_dyn_percent);
  ASSERT_FALSE(of_one.report.from_current.cranks.empty());
  EXPECT_EQ(of_row.report.from_current.cranks[0].measured,
            blocks_ * of_one.report.from_current.cranks[0].measured);
}

/// A session that has followed a drive and identified on the spot.
struct Session {
  explicit Session(double series_blocks) : session(optionsOf(series_blocks)) {
    const Series series = baseDrive(9, 320.0);
    for (std::size_t n = 0; n < series.size(); ++n) {
      const SessionEvents ended =
          session.push({series.time[n], series.current[n], series_blocks * series.voltage[n], {}});
      cranks.insert(cranks.end(), ended.cranks.begin(), ended.cranks.end());
      if (const auto job = session.takeDueJob()) outcome = session.finish(runIdentification(*job));
    }
  }
  static SessionOptions optionsOf(double series_blocks) {
    SessionOptions options;
    options.series_blocks = series_blocks;
    return options;
  }

  OnlineSession session;
  std::vector<EventComparison> cranks;
  IdentificationOutcome outcome;
};

TEST_P(SeriesBlocks, IsFollowedBySessionsWithAsManyTimesTheVoltage) {
  const Session one(1.0), row(blocks_);
  ASSERT_TRUE(one.outcome.accepted && row.outcome.accepted) << row.outcome.message;
  EXPECT_EQ(row.outcome.model->fit.series_blocks, blocks_);
  EXPECT_EQ(row.outcome.model->fit.parameters.r_discharge,
            one.outcome.model->fit.parameters.r_discharge)
      << "of one block";
  CrankingQuery crank{-20.0, 30.0, -200.0, 0.8, 7.2};
  const CrankingAnswer of_one = one.session.live().predictCranking(crank);
  crank.u_required = blocks_ * 7.2;
  const CrankingAnswer of_row = row.session.live().predictCranking(crank);
  ASSERT_TRUE(of_one.u_min && of_row.u_min);
  expectTimes(blocks_, *of_row.u_min, *of_one.u_min);
  EXPECT_EQ(of_row.capable, of_one.capable);
  EXPECT_EQ(of_row.code, of_one.code);
  ASSERT_EQ(row.cranks.size(), one.cranks.size());
  ASSERT_FALSE(one.cranks.empty());
  EXPECT_EQ(row.cranks[0].measured, blocks_ * one.cranks[0].measured);
  expectTimes(blocks_, row.cranks[0].expected, one.cranks[0].expected);
  EXPECT_EQ(*row.session.status().expected->voltage,
            blocks_ * *one.session.status().expected->voltage);
  EXPECT_EQ(row.session.status().window_quality, one.session.status().window_quality);
}

TEST_P(SeriesBlocks, OfAnotherNumberIsNotRestored) {
  const Session before(blocks_);
  const auto restoredBy = [&](double series_blocks) {
    OnlineSession session(Session::optionsOf(series_blocks));
    session.restore(*before.outcome.model);
    for (int n = 0; n < 200; ++n) session.push({320.0 + 0.01 * n, -5.0, series_blocks * 12.6, {}});
    return session.status();
  };
  EXPECT_EQ(restoredBy(blocks_).basis, AnswerBasis::kPreviousTrip);
  EXPECT_EQ(restoredBy(1.0).basis, AnswerBasis::kPopulation);
  EXPECT_THAT(restoredBy(1.0).reason,
              HasSubstr(format("it is of %g blocks of 12 V, but series_blocks is 1", blocks_)));
}

INSTANTIATE_TEST_SUITE_P(OfSixToFortyEightVolts, SeriesBlocks, ::testing::Values(0.5, 2.0, 4.0));

TEST(SessionOfARow, IsRefusedForANumberThatIsNone) {
  EXPECT_THROW(OnlineSession(Session::optionsOf(0.3)), std::invalid_argument);
  EXPECT_THROW(OnlineSession(Session::optionsOf(0.0)), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

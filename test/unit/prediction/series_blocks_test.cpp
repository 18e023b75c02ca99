#include <gtest/gtest.h>

#include "estimation/identification.hpp"
#include "prediction/questions.hpp"
#include "recording/series_blocks.hpp"
#include "support/base_drive.hpp"

/// Blocks in series share the current: every voltage is as many times as large.
namespace battery_sof {
namespace {

using namespace test;

Series inSeries(Series series, double series_blocks) {
  for (double& voltage : series.voltage) voltage *= series_blocks;
  return series;
}

FittedModel fittedTo(double series_blocks) {
  const Series series = inSeries(baseDrive(7), series_blocks);
  return identify(series, {0, series.size()}, {});
}

TEST(BlocksInSeries, AreCountedByTheVoltageAtRest) {
  for (const double each : {11.3, 12.0, 12.8, 13.2})
    for (const double series_blocks : {1.0, 2.0, 4.0})
      EXPECT_EQ(seriesBlocksAt(series_blocks * each), series_blocks) << series_blocks * each;
  EXPECT_EQ(seriesBlocksAt(6.4), 1.0);
}

class SeriesOfBlocks : public ::testing::TestWithParam<double> {};

TEST_P(SeriesOfBlocks, IsIdentifiedWithAsManyTimesTheResistance) {
  const double series_blocks = GetParam();
  const Fit one = fittedTo(1.0).fit, row = fittedTo(series_blocks).fit;
  ASSERT_TRUE(isUsable(row)) << row.message;
  EXPECT_NEAR(row.parameters.r_discharge, series_blocks * one.parameters.r_discharge,
              1e-4 * series_blocks * one.parameters.r_discharge);
  EXPECT_NEAR(row.parameters.r_charge, series_blocks * one.parameters.r_charge,
              1e-4 * series_blocks * one.parameters.r_charge);
  EXPECT_NEAR(row.parameters.c2, one.parameters.c2 / series_blocks,
              1e-3 * one.parameters.c2 / series_blocks);
  EXPECT_NEAR(row.parameters.beta, one.parameters.beta / series_blocks,
              1e-3 * one.parameters.beta / series_blocks);
  EXPECT_NEAR(row.parameters.u_dc, series_blocks * one.parameters.u_dc, 1e-4 * series_blocks);
  EXPECT_NEAR(row.window_quality, one.window_quality, 1e-3);
}

TEST_P(SeriesOfBlocks, AnswersWithAsManyTimesTheVoltage) {
  const double series_blocks = GetParam();
  const FittedModel one = fittedTo(1.0), row = fittedTo(series_blocks);
  const CrankingQuery crank{-20.0, 30.0, -200.0, 0.8, 7.2};
  CrankingQuery crank_of_row = crank;
  crank_of_row.u_required = series_blocks * *crank.u_required;
  const CrankingAnswer small = predictCranking(one, crank),
                       large = predictCranking(row, crank_of_row);
  ASSERT_TRUE(small.u_min && large.u_min);
  EXPECT_NEAR(large.u_min->value, series_blocks * small.u_min->value, 1e-3 * series_blocks);
  EXPECT_NEAR(large.u_min->lower, series_blocks * small.u_min->lower, 5e-3 * series_blocks);
  EXPECT_EQ(large.capable, small.capable);
  EXPECT_EQ(large.valid, small.valid) << large.message;
}

TEST_P(SeriesOfBlocks, TakesTheSameChargeAtAsManyTimesTheVoltage) {
  const double series_blocks = GetParam();
  const FittedModel one = fittedTo(1.0), row = fittedTo(series_blocks);
  const auto small = predictChargeAcceptance(one, {13.1, 10.0, 200.0}),
             large = predictChargeAcceptance(row, {series_blocks * 13.1, 10.0, 200.0});
  ASSERT_TRUE(small.i_boost && large.i_boost);
  EXPECT_NEAR(large.i_boost->value, small.i_boost->value, 0.1);
  EXPECT_EQ(large.valid, small.valid) << large.message;
}

INSTANTIATE_TEST_SUITE_P(OfTwoAndFour, SeriesOfBlocks, ::testing::Values(2.0, 4.0));

}  // namespace
}  // namespace battery_sof

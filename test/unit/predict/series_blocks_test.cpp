#include <gtest/gtest.h>

#include "battery_sof/identify/identification.hpp"
#include "battery_sof/predict/charge_acceptance.hpp"
#include "battery_sof/predict/cranking.hpp"
#include "battery_sof/predict/stop_time.hpp"
#include "battery_sof/recording/blocks.hpp"
#include "support/base_drive.hpp"

/// Blocks in a row share the current: every voltage is as many times as large.
namespace battery_sof {
namespace {

using namespace test;

Series inSeries(Series series, double blocks) {
  for (double& voltage : series.voltage) voltage *= blocks;
  return series;
}

FittedModel fittedTo(double blocks) {
  const Series series = inSeries(baseDrive(7), blocks);
  return identify(series, {0, series.size()}, {});
}

TEST(BlocksInSeries, AreCountedByTheVoltageAtRest) {
  for (const double each : {11.3, 12.0, 12.8, 13.2})
    for (const double blocks : {1.0, 2.0, 4.0}) EXPECT_EQ(blocksInSeries(blocks * each), blocks) << blocks * each;
  EXPECT_EQ(blocksInSeries(6.4), 1.0);
}

class SeriesOfBlocks : public ::testing::TestWithParam<double> {};

TEST_P(SeriesOfBlocks, IsIdentifiedWithAsManyTimesTheResistance) {
  const double blocks = GetParam();
  const Fit one = fittedTo(1.0).fit, row = fittedTo(blocks).fit;
  ASSERT_TRUE(isUsable(row)) << row.message;
  EXPECT_NEAR(row.parameters.r_discharge, blocks * one.parameters.r_discharge, 1e-4 * blocks * one.parameters.r_discharge);
  EXPECT_NEAR(row.parameters.r_charge, blocks * one.parameters.r_charge, 1e-4 * blocks * one.parameters.r_charge);
  EXPECT_NEAR(row.parameters.c2, one.parameters.c2 / blocks, 1e-3 * one.parameters.c2 / blocks);
  EXPECT_NEAR(row.parameters.beta, one.parameters.beta / blocks, 1e-3 * one.parameters.beta / blocks);
  EXPECT_NEAR(row.parameters.u_dc, blocks * one.parameters.u_dc, 1e-4 * blocks);
  EXPECT_NEAR(row.suitability, one.suitability, 1e-3);
}

TEST_P(SeriesOfBlocks, AnswersWithAsManyTimesTheVoltage) {
  const double blocks = GetParam();
  const FittedModel one = fittedTo(1.0), row = fittedTo(blocks);
  const CrankingQuery crank{-20.0, 30.0, -200.0, 0.8, 7.2};
  CrankingQuery crank_of_row = crank;
  crank_of_row.u_required = blocks * *crank.u_required;
  const CrankingAnswer small = predictCranking(one, crank), large = predictCranking(row, crank_of_row);
  ASSERT_TRUE(small.u_min && large.u_min);
  EXPECT_NEAR(large.u_min->value, blocks * small.u_min->value, 1e-3 * blocks);
  EXPECT_NEAR(large.u_min->lower, blocks * small.u_min->lower, 5e-3 * blocks);
  EXPECT_EQ(large.capable, small.capable);
  EXPECT_EQ(large.valid, small.valid) << large.message;
}

TEST_P(SeriesOfBlocks, TakesTheSameChargeAtAsManyTimesTheVoltage) {
  const double blocks = GetParam();
  const FittedModel one = fittedTo(1.0), row = fittedTo(blocks);
  const auto small = predictChargeAcceptance(one, {13.1, 10.0, 200.0}), large = predictChargeAcceptance(row, {blocks * 13.1, 10.0, 200.0});
  ASSERT_TRUE(small.i_boost && large.i_boost);
  EXPECT_NEAR(large.i_boost->value, small.i_boost->value, 0.1);
  EXPECT_EQ(large.valid, small.valid) << large.message;
}

INSTANTIATE_TEST_SUITE_P(OfTwoAndFour, SeriesOfBlocks, ::testing::Values(2.0, 4.0));

}  // namespace
}  // namespace battery_sof

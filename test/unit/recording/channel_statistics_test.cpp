#include "recording/channel_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

std::vector<double> noise(std::size_t count, double deviation, std::uint64_t seed = 1) {
  test::Random random(seed);
  std::vector<double> values(count);
  for (double& value : values) value = deviation * random.normal();
  return values;
}

TEST(FindStep, RecoversTheStepOfAQuantisedChannelWithinTwoPercent) {
  for (const double step : {0.001, 0.0039, 0.02, 0.025, 0.1, 0.25}) {
    std::vector<double> values = noise(5000, 4.0 * step);
    test::quantise(values, step);
    ASSERT_TRUE(findStep(values).has_value()) << step;
    EXPECT_NEAR(*findStep(values), step, 0.02 * step);
  }
}

TEST(FindStep, SurvivesThePrintedDigitsOfTheFile) {
  std::vector<double> values = noise(5000, 0.5);
  test::quantise(values, 0.0625);
  test::quantise(values, 0.001);
  ASSERT_TRUE(findStep(values).has_value());
  EXPECT_NEAR(*findStep(values), 0.0625, 0.001);
}

TEST(FindStep, ContinuousChannelHasNone) {
  EXPECT_FALSE(findStep(noise(5000, 0.3)).has_value());
  EXPECT_FALSE(findStep(test::cleanDrive().voltage).has_value());
}

TEST(FindStep, CurrentThatStepsBetweenAFewSetPointsHasNone) {
  std::vector<double> values;
  for (int k = 0; k < 300; ++k) values.push_back(10.0 * (k % 4));
  EXPECT_FALSE(findStep(values).has_value());
}

TEST(FindVoltageStep, IsSeenThroughAnOhmicPartThatWasAddedAfterwards) {
  Series series;
  series.current = noise(5000, 0.2, 2);
  series.voltage = noise(5000, 0.1, 3);
  test::quantise(series.current, 0.1);
  test::quantise(series.voltage, 0.025);
  for (std::size_t k = 0; k < series.current.size(); ++k)
    series.voltage[k] += 0.0021 * series.current[k];
  ASSERT_TRUE(findVoltageStep(series).has_value());
  EXPECT_NEAR(*findVoltageStep(series), 0.025, 1e-4);
}

TEST(FindVoltageStep, ContinuousVoltageHasNoneThoughTheCurrentRepeats) {
  Series series;
  series.current = noise(5000, 0.2, 2);
  series.voltage = noise(5000, 0.1, 3);
  test::quantise(series.current, 0.1);
  EXPECT_FALSE(findVoltageStep(series).has_value());
}

TEST(NoiseLevel, IsTheDeviationOfWhiteNoiseWhateverEdgesThereAre) {
  std::vector<double> values = noise(20000, 0.05);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] += k / 100 % 2 == 0 ? -200.0 : 50.0;
  EXPECT_NEAR(noiseLevel(values, std::nullopt), 0.05, 0.002);
}

TEST(NoiseLevel, IsNotBelowThatOfTheQuantisation) {
  EXPECT_DOUBLE_EQ(noiseLevel({1.0, 1.0, 1.0}, 0.1), 0.1 / std::sqrt(12.0));
  EXPECT_EQ(noiseLevel({1.0, 1.0, 1.0}, std::nullopt), 0.0);
  EXPECT_EQ(noiseLevel({1.0}, std::nullopt), 0.0);
}

TEST(ConstantRuns, AreAsLongAsTheValueRepeatsWithinTheBounds) {
  const std::vector<double> values{1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0};
  const auto runs = constantRuns(values, {{1, 8}}, 2);
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[0].first, 1U);
  EXPECT_EQ(runs[0].last, 3U);
  EXPECT_EQ(runs[2].last, 8U);
  EXPECT_EQ(constantRuns(values, {{0, 8}}, 3).size(), 2U);
}

TEST(CountReversals, CountsTurnsOfMovesBeyondTheThresholdOnly) {
  const std::vector<double> values{0.0, 1.0, 0.0, 0.1, 0.0, 1.0, 2.0, 3.0, 1.0};
  EXPECT_EQ(countReversals(values, {0, 9}, 1, 0.5), 3U);
  EXPECT_EQ(countReversals(values, {4, 8}, 1, 0.5), 0U);
  EXPECT_EQ(countReversals(values, {0, 2}, 1, 0.5), 0U);
}

TEST(Quantile, IsTheNearestRankedValue) {
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 0.0), 1.0);
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 1.0), 3.0);
  EXPECT_EQ(quantile({}, 0.5), 0.0);
}

}  // namespace
}  // namespace battery_sof

#include "estimation/window.hpp"

#include <gtest/gtest.h>

#include "estimation/base_normal_equations.hpp"
#include "support/base_drive.hpp"

namespace battery_sof {
namespace {

TEST(DefaultWindowLength, IsThePapersFourMinutesOrNineHundredSamples) {
  EXPECT_DOUBLE_EQ(defaultWindowLength(test::baseDrive(1, 10.0)), 240.0);
  const Series slow =
      test::answered(test::drivenBattery(), std::vector<double>(100, -1.0), 1.0, 0.0, 1);
  EXPECT_DOUBLE_EQ(defaultWindowLength(slow), 900.0);
}

TEST(WindowQuality, IsHigherForADriveThanForARest) {
  const Series drive = test::baseDrive(1, 60.0);
  const Series rest =
      test::answered(test::drivenBattery(), std::vector<double>(6000, -1.0), 0.01, 0.002, 1);
  EXPECT_GT(windowExcitation(drive, {0, 6000}), 0.5);
  EXPECT_LT(windowExcitation(rest, {0, 6000}), 0.1);
}

TEST(WindowQuality, StaysLowWithoutAnyCharging) {
  auto current = test::dataSetOneCurrent(120.0, 0.01, 4);
  for (double& i : current) i = std::min(i, -1.0);
  const Series series = test::answered(test::drivenBattery(), current, 0.01, 0.002, 4);
  EXPECT_LT(windowExcitation(series, {0, series.size()}), 0.18);
}

TEST(WindowQuality, DoesNotLookAtTheVoltage) {
  Series series = test::baseDrive(1, 60.0);
  const double before = windowExcitation(series, {0, 6000});
  for (double& u : series.voltage) u = 12.0;
  EXPECT_DOUBLE_EQ(windowExcitation(series, {0, 6000}), before);
}

TEST(ChooseWindow, PrefersTheStretchThatExcitesTheBattery) {
  auto current = std::vector<double>(100000, -2.0);
  const auto drive = test::dataSetOneCurrent(240.0, 0.01, 3);
  std::copy(drive.begin(), drive.end(), current.begin() + 30000);  // 300 to 540 s
  const Series series = test::answered(test::drivenBattery(), current, 0.01, 0.002, 3);
  const WindowChoice choice = chooseWindow(series, {0, series.size()});
  ASSERT_TRUE(choice.range);
  EXPECT_GE(series.time[choice.range->first], 240.0);
  EXPECT_LE(series.time[choice.range->last - 1], 640.0);
  EXPECT_NEAR(series.time[choice.range->last - 1] - series.time[choice.range->first], 240.0, 0.02);
  EXPECT_GT(choice.excitation, 0.5);
}

/// The only crank lies in the first four minutes; later ones have the better changes of current.
TEST(ChooseWindow, HoldsTheLargestDischargeWhereThatCostsLittle) {
  auto current = test::dataSetOneCurrent(900.0, 0.01, 6);
  for (std::size_t n = 0; n < current.size(); ++n)
    if (n < 10000 || n >= 10100) current[n] = std::max(current[n], -60.0);
  for (std::size_t n = 10000; n < 10100; ++n) current[n] = -280.0;
  const Series series = test::answered(test::drivenBattery(), current, 0.01, 0.002, 6);
  const WindowChoice choice = chooseWindow(series, {0, series.size()});
  ASSERT_TRUE(choice.range);
  EXPECT_EQ(excitedRange(series, *choice.range).min_current, -280.0);
}

TEST(ChooseWindow, TakesTheLatestOfWindowsThatAreEquallyGood) {
  const Series series = test::baseDrive(5, 900.0);
  const WindowChoice choice = chooseWindow(series, {0, series.size()});
  ASSERT_TRUE(choice.range);
  EXPECT_GT(series.time[choice.range->last - 1], 700.0);
}

TEST(ChooseWindow, KeepsClearOfGaps) {
  Series series = test::baseDrive(5, 600.0);
  for (std::size_t n = 40000; n < series.size(); ++n) series.time[n] += 100.0;
  const WindowChoice choice = chooseWindow(series, {0, series.size()});
  ASSERT_TRUE(choice.range);
  EXPECT_TRUE(choice.range->last <= 40000 || choice.range->first >= 40000);
}

TEST(ChooseWindow, StaysInsideTheSearchedStretch) {
  const Series series = test::baseDrive(5, 900.0);
  const WindowChoice choice = chooseWindow(series, indexRange(series, 100.0, 400.0));
  ASSERT_TRUE(choice.range);
  EXPECT_GE(series.time[choice.range->first], 100.0);
  EXPECT_LE(series.time[choice.range->last - 1], 400.0);
}

TEST(ChooseWindow, TakesAShortRecordingWhole) {
  const Series series = test::baseDrive(5, 60.0);
  const WindowChoice choice = chooseWindow(series, {0, series.size()});
  ASSERT_TRUE(choice.range);
  EXPECT_EQ(choice.range->size(), series.size());
}

TEST(ChooseWindow, SaysWhatIsMissingWhenThereIsNoWindow) {
  EXPECT_FALSE(chooseWindow(Series{}, {}).range);
  const WindowChoice choice = chooseWindow(test::baseDrive(5, 0.095), {0, 10});
  EXPECT_FALSE(choice.range);
  EXPECT_NE(choice.message.find("10 samples"), std::string::npos);
}

TEST(ExcitedRange, HoldsTheExtremesAndTheTimeSpentEachWay) {
  Series series;
  series.time = {0.0, 1.0, 2.0, 3.0};
  series.current = {-10.0, -10.0, 20.0, 20.0};
  series.voltage = {12.0, 12.1, 13.0, 13.2};
  series.temperature_time = {0.0};
  series.temperature = {300.0};
  const ExcitedRange excited = excitedRange(series, {0, 4});
  EXPECT_DOUBLE_EQ(excited.min_current, -10.0);
  EXPECT_DOUBLE_EQ(excited.max_current, 20.0);
  EXPECT_DOUBLE_EQ(excited.max_voltage, 13.2);
  EXPECT_DOUBLE_EQ(excited.discharge_time, 1.0);
  EXPECT_DOUBLE_EQ(excited.charge_time, 2.0);
  EXPECT_DOUBLE_EQ(*excited.temperature, 300.0);
}

TEST(ExcitedRange, AddsUpIntervalsAndRunsAsTheirDefinitionSays) {
  test::Random random(4);
  for (int round = 0; round < 30; ++round) {
    Series series;
    double level = 0.0;
    for (int k = 0; k < 500; ++k) {
      if (random.uniform(0.0, 1.0) < 0.1)
        level = random.uniform(0.0, 1.0) < 0.3 ? 0.0 : random.uniform(-2.0, 2.0);
      series.append({(series.empty() ? 0.0 : series.time.back()) +
                         (random.uniform(0.0, 1.0) < 0.02 ? 30.0 : 1.0),
                     level, 12.0 + 0.1 * random.normal()});
    }
    double time[2] = {0.0, 0.0}, run[2] = {0.0, 0.0}, longest[2] = {0.0, 0.0};
    std::vector<double> charge{0.0};  // [As]
    const IndexRange range{7, 480};
    for (std::size_t n = range.first + 1; n < range.last; ++n) {
      const double between = series.time[n] - series.time[n - 1];
      charge.push_back(
          charge.back() +
          (between > 10.0 ? 0.0 : between * 0.5 * (series.current[n - 1] + series.current[n])));
      for (const int way : {0, 1}) {
        const double i = way == 0 ? series.current[n] : -series.current[n];
        const double interval = series.time[n] - series.time[n - 1];
        const bool joined = interval <= 10.0;
        time[way] += joined && i > 0.0 ? interval : 0.0;
        run[way] = joined && i > 0.5 ? run[way] + interval : 0.0;
        longest[way] = std::max(longest[way], run[way]);
      }
    }
    const auto [lowest, highest] = std::minmax_element(charge.begin(), charge.end());
    const ExcitedRange excited = excitedRange(series, range, 10.0);
    EXPECT_NEAR(excited.charge_time, time[0], 1e-9);
    EXPECT_NEAR(excited.discharge_time, time[1], 1e-9);
    EXPECT_NEAR(excited.longest_charge, longest[0], 1e-9);
    EXPECT_NEAR(excited.longest_discharge, longest[1], 1e-9);
    EXPECT_NEAR(excited.charge_swing, (*highest - *lowest) / 3600.0, 1e-9);
  }
}

TEST(WindowExcitation, AsksForNoWeights) {
  const Series series = test::baseDrive(6, 100.0);
  const std::vector<char> masked(series.size(), 1);
  const IndexRange range{17, series.size()};
  const WindowSamples samples{series, range, {10.0, -20.0}, 5.0, masked};
  EXPECT_DOUBLE_EQ(windowExcitation(samples), windowExcitation(series, range));
}

}  // namespace
}  // namespace battery_sof

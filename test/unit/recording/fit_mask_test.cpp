#include "recording/fit_mask.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "battery_sof/csv.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using test::addNoise;
using test::cleanDrive;
using test::driveProfile;
using test::driveSeries;
using test::everyNth;

std::size_t countMasked(const InstrumentLimits& limits) {
  return std::count_if(limits.masked.begin(), limits.masked.end(),
                       [](char fault) { return fault != 0; });
}

std::size_t countOf(const InstrumentLimits& limits, SampleFault fault) {
  return std::count(limits.masked.begin(), limits.masked.end(), static_cast<char>(fault));
}

void expectNothingMasked(const Series& series, const std::string& what) {
  const InstrumentLimits limits = instrumentLimits(series);
  EXPECT_EQ(limits.masked.size(), series.size()) << what;
  EXPECT_EQ(countMasked(limits), 0U) << what;
}

/// The first sample from index on in which more than 40 A flow, and a tenth of a second later too.
std::size_t firstLoad(const Series& series, std::size_t index) {
  while (std::min(std::abs(series.current[index]), std::abs(series.current[index + 10])) < 40.0) {
    ++index;
  }
  return index;
}

// ---------------------------------------------------------------------------------------------
// nothing to mask

TEST(FitMask, MasksNothingInACleanDrive) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    expectNothingMasked(cleanDrive(seed), "seed " + std::to_string(seed));
  }
}

TEST(FitMask, MasksNothingInACleanDriveWithoutNoiseAtAnyRateAndQuantised) {
  for (const std::size_t n : {1, 10, 20, 100, 1000}) {
    Series series = everyNth(driveSeries(driveProfile(1200.0, 3)), n);
    expectNothingMasked(series, "every " + std::to_string(n) + " ms");
    test::quantise(series.current, 0.1);
    test::quantise(series.voltage, 0.025);
    expectNothingMasked(series, "quantised, every " + std::to_string(n) + " ms");
  }
}

TEST(FitMask, MasksNothingInANoisyQuantisedDriveWhereBothChannelsRepeatByChance) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Series series = cleanDrive(seed);
    addNoise(series, 0.5, 0.01, seed);
    test::quantise(series.current, 0.1);
    test::quantise(series.voltage, 0.002);
    expectNothingMasked(series, "seed " + std::to_string(seed));
  }
}

TEST(FitMask, MasksNeitherACurrentThatASourceHoldsNorAVoltageThatARegulatorHolds) {
  std::vector<double> profile(120000, 0.0);
  for (int k = 0; k < 20; ++k) {
    profile.insert(profile.end(), 8000, -20.0 - 0.1 * k);
    profile.insert(profile.end(), 1000, -250.0);
    profile.insert(profile.end(), 15000, 80.0);
  }
  for (const std::size_t n : {1, 10, 1000}) {
    const Series series = everyNth(driveSeries(profile), n);
    expectNothingMasked(series, "every " + std::to_string(n) + " ms");
  }
}

TEST(FitMask, MasksNothingInARestWithoutNoiseBetweenNoisyLoads) {
  Series series = cleanDrive(2);
  std::fill(series.current.begin() + 30000, series.current.begin() + 30200, 0.0);
  std::fill(series.voltage.begin() + 30000, series.voltage.begin() + 30200, 12.61);
  expectNothingMasked(series, "rest");
}

TEST(FitMask, OfAnEmptySeriesAndOfASingleSampleHoldsNothing) {
  EXPECT_TRUE(instrumentLimits({}).masked.empty());
  Series series;
  series.time = {1.0};
  series.current = {-5.0};
  series.voltage = {12.5};
  expectNothingMasked(series, "single sample");
}

// ---------------------------------------------------------------------------------------------
// something to mask

TEST(FitMask, MasksEverySampleAtAProvenLimitOfTheCurrentAndNoOther) {
  Series series = cleanDrive();
  for (double& current : series.current) current = std::max(current, -150.0);
  const InstrumentLimits limits = instrumentLimits(series);
  for (std::size_t k = 0; k < series.size(); ++k) {
    ASSERT_EQ(limits.masked[k] != 0, series.current[k] == -150.0) << k;
  }
  EXPECT_GT(countOf(limits, SampleFault::kClipped), 100U);
  EXPECT_EQ(countOf(limits, SampleFault::kClipped), countMasked(limits));
}

TEST(FitMask, MasksEverySampleAtAProvenLimitOfTheVoltageAndNoOther) {
  Series series = cleanDrive();
  for (double& voltage : series.voltage) voltage = std::max(voltage, 11.3);
  const InstrumentLimits limits = instrumentLimits(series);
  for (std::size_t k = 0; k < series.size(); ++k) {
    ASSERT_EQ(limits.masked[k] != 0, series.voltage[k] == 11.3) << k;
  }
  EXPECT_GT(countOf(limits, SampleFault::kClipped), 100U);
}

TEST(FitMask, MasksAFrozenChannelForAsLongAsItIsFrozen) {
  for (const auto channel : {&Series::current, &Series::voltage}) {
    Series series = cleanDrive();
    std::vector<double>& values = series.*channel;
    std::fill(values.begin() + 25000, values.begin() + 30000, values[25000]);
    const InstrumentLimits limits = instrumentLimits(series);
    EXPECT_EQ(countMasked(limits), 5000U);
    EXPECT_EQ(std::count(limits.masked.begin() + 25000, limits.masked.begin() + 30000,
                         static_cast<char>(SampleFault::kStuck)),
              5000);
  }
}

TEST(FitMask, MasksRepeatedMessagesButNotTheMeasurementTheyRepeat) {
  Series series = cleanDrive(5);
  const std::vector<std::size_t> starts{firstLoad(series, 20000), firstLoad(series, 30000),
                                        firstLoad(series, 40000)};
  for (const std::size_t first : starts) {
    std::fill_n(series.current.begin() + first, 4, series.current[first]);
    std::fill_n(series.voltage.begin() + first, 4, series.voltage[first]);
  }
  const InstrumentLimits limits = instrumentLimits(series);
  EXPECT_EQ(countOf(limits, SampleFault::kRepeated), 9U);
  EXPECT_EQ(countMasked(limits), 9U);
  for (const std::size_t first : starts) {
    EXPECT_EQ(limits.masked[first], 0);
    EXPECT_EQ(limits.masked[first + 3], static_cast<char>(SampleFault::kRepeated));
    EXPECT_EQ(limits.masked[first + 4], 0);
  }
}

TEST(FitMask, MasksRepeatedMessagesThoughTheNoiseIsLessThanAStep) {
  Series series = cleanDrive(5);
  addNoise(series, 0.03, 0.001, 5);
  test::quantise(series.current, 0.05);
  test::quantise(series.voltage, 0.001);
  const std::size_t first = firstLoad(series, 30000);
  std::fill_n(series.current.begin() + first, 40, series.current[first]);
  std::fill_n(series.voltage.begin() + first, 40, series.voltage[first]);
  const InstrumentLimits limits = instrumentLimits(series);
  EXPECT_GE(countOf(limits, SampleFault::kRepeated), 39U);
  EXPECT_LE(countOf(limits, SampleFault::kRepeated), 41U);
}

TEST(FitMask, ASampleHasItsFirstFault) {
  Series series = cleanDrive();
  for (double& current : series.current) current = std::max(current, -150.0);
  std::fill(series.current.begin() + 25000, series.current.begin() + 30000, -150.0);
  EXPECT_GT(countOf(instrumentLimits(series), SampleFault::kClipped), 5000U);
}

TEST(FitMask, DoesNotMaskAValueThatWasEnteredBecauseItMayBeRight) {
  Series series = cleanDrive();
  std::fill(series.current.begin(), series.current.begin() + 11500, -10.0);
  EXPECT_EQ(countMasked(instrumentLimits(series)), 0U);
}

TEST(FitMask, LaterSamplesAreJudgedByTheLimitsThatEarlierOnesShowed) {
  Series series = cleanDrive();
  const std::size_t known = series.size() / 2;
  for (double& current : series.current) current = std::max(current, -150.0);
  const auto later = series.voltage.begin() + static_cast<std::ptrdiff_t>(known);
  std::for_each(later, series.voltage.end(), [](double& u) { u = std::max(u, 11.3); });
  std::fill(later + 1000, later + 6000, later[1000]);
  InstrumentLimits limits = instrumentLimits(slice(series, {0, known}));
  const std::vector<char> before = limits.masked;
  extendByKnownLimits(series, limits);
  ASSERT_EQ(limits.masked.size(), series.size());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), limits.masked.begin()));
  std::size_t cut_off = 0;
  for (std::size_t k = known; k < series.size(); ++k) {
    ASSERT_EQ(limits.masked[k] != 0, series.current[k] == -150.0) << k;
    cut_off += limits.masked[k] != 0;
  }
  EXPECT_GT(cut_off, 100U);
}

// ---------------------------------------------------------------------------------------------
// quantisation

TEST(FitMask, RoundingAddsTheDeviationOfAUniformError) {
  const Series exact = cleanDrive();
  EXPECT_EQ(instrumentLimits(exact).voltage_lsb_std, 0.0);
  Series rounded = exact;
  test::quantise(rounded.current, 0.5);
  test::quantise(rounded.voltage, 0.005);
  const InstrumentLimits limits = instrumentLimits(rounded);
  double squares = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    squares += std::pow(rounded.voltage[k] - exact.voltage[k], 2);
  }
  const double deviation = std::sqrt(squares / static_cast<double>(exact.size()));
  EXPECT_NEAR(limits.voltage_lsb_std, deviation, 0.1 * deviation);
}

// ---------------------------------------------------------------------------------------------
// real recordings

class RealFitMask : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "no recordings in ../shared/data";
  }

  static Series seriesOf(const std::string& name, const CsvColumns& columns) {
    return readCsv(std::filesystem::path(kFolder) / name, columns).series;
  }

  static constexpr const char* kFolder = BATTERY_SOF_SOURCE_DIR "/../shared/data";
  const CsvColumns car_{"t_s", "current_A", "voltage_V", std::string("temp_C"), false};
};

TEST_F(RealFitMask, MasksInAStartStopDriveTheSamplesAtMinus250AmperesAndTheFrozenCurrent) {
  const std::size_t frozen[] = {95, 178};
  for (const int drive : {1, 2}) {
    const Series series = seriesOf("startstop_car/drive_" + std::to_string(drive) + ".csv", car_);
    const InstrumentLimits limits = instrumentLimits(series);
    const auto at_limit = std::count(series.current.begin(), series.current.end(), -250.0);
    EXPECT_EQ(countOf(limits, SampleFault::kClipped), static_cast<std::size_t>(at_limit));
    EXPECT_EQ(countOf(limits, SampleFault::kStuck), frozen[drive - 1]);
    EXPECT_EQ(countOf(limits, SampleFault::kRepeated), 0U);
    EXPECT_LT(countMasked(limits), series.size() / 50);
    EXPECT_NEAR(limits.voltage_lsb_std, 0.025 / std::sqrt(12.0), 1e-4);
  }
}

TEST_F(RealFitMask, MasksTheSameWithTwoMilliohmsMore) {
  for (const std::string drive : {"drive_1", "drive_2", "other_car_1"}) {
    Series series = seriesOf("startstop_car/" + drive + ".csv", car_);
    const InstrumentLimits limits = instrumentLimits(series);
    for (std::size_t k = 0; k < series.size(); ++k) series.voltage[k] += 0.002 * series.current[k];
    const InstrumentLimits with_more = instrumentLimits(series);
    EXPECT_EQ(limits.masked, with_more.masked) << drive;
    EXPECT_NEAR(limits.voltage_lsb_std, with_more.voltage_lsb_std, 1e-5) << drive;
  }
}

TEST_F(RealFitMask, MasksNothingInTheOtherRecordings) {
  expectNothingMasked(seriesOf("startstop_car/other_car_1.csv", car_), "other car");
  expectNothingMasked(seriesOf("frc_robot/match.csv", {"t_s", "current_A_minus_sum_of_channels",
                                                       "voltage_V_roborio", std::nullopt, false}),
                      "robot");
  expectNothingMasked(seriesOf("agm_bench/full_cycle.csv", {"t_s", "current_A", "voltage_V",
                                                            std::string("battery_temp_C"), false}),
                      "bench");
  expectNothingMasked(seriesOf("solar_vrla/ten_days.csv",
                               {"time", "current", "voltage", std::string("temperature"), true}),
                      "solar");
  expectNothingMasked(seriesOf("leaf_cell/hppc_25c.csv",
                               {"Time(s)", "Current(A)", "Voltage(V)", std::nullopt, false}),
                      "cell");
}

}  // namespace
}  // namespace battery_sof

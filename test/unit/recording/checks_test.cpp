#include "recording/checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "battery_sof/csv.hpp"
#include "battery_sof/sample_list.hpp"
#include "recording/channel_shift.hpp"
#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

using test::addNoise;
using test::cleanDrive;
using test::driveProfile;
using test::driveSeries;
using test::everyNth;
using test::toRecording;
using ::testing::HasSubstr;

std::vector<Finding> findingsOf(const Series& series, const std::string& id) {
  std::vector<Finding> found;
  for (const Finding& finding : checkRecording(toRecording(series)).findings) {
    if (finding.id == id) found.push_back(finding);
  }
  return found;
}

std::string idsOf(const Series& series) {
  std::string ids;
  for (const Finding& finding : checkRecording(toRecording(series)).findings) {
    ids += finding.id + " (" + finding.what + ") ";
  }
  return ids;
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A drive at one sample a second from a sensor like a car's: steps of 0.1 A and 25 mV.
Series slowCarDrive(double duration, std::uint64_t seed) {
  Series series = everyNth(driveSeries(driveProfile(duration, seed)), 1000);
  test::quantise(series.current, 0.1);
  test::quantise(series.voltage, 0.025);
  return series;
}

// ---------------------------------------------------------------------------------------------
// clean recordings

TEST(Checks, NothingIsFoundInACleanDrive) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    EXPECT_EQ(idsOf(cleanDrive(seed)), "") << "seed " << seed;
  }
}

TEST(Checks, NothingIsFoundInACleanDriveWithoutNoiseWithoutFilterOrAtOneKilohertz) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Series fast = driveSeries(driveProfile(600.0, seed));
    EXPECT_EQ(idsOf(fast), "") << "1 kHz, seed " << seed;
    EXPECT_EQ(idsOf(atDesignRate(fast)), "") << "filtered, seed " << seed;
    EXPECT_EQ(idsOf(everyNth(fast, 10)), "") << "unfiltered, seed " << seed;
    EXPECT_EQ(idsOf(everyNth(fast, 20)), "") << "50 Hz, seed " << seed;
  }
}

TEST(Checks, OnlyRateAndQuantisationAreFoundInASlowCarDrive) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const Finding& finding :
         checkRecording(toRecording(slowCarDrive(3600.0, seed))).findings) {
      EXPECT_TRUE(finding.id == "rate" || finding.id == "quantisation") << finding.what;
    }
  }
}

TEST(Checks, CurrentThatASourceHoldsAndVoltageThatACycleLimitsAreNeitherClippedNorStuck) {
  test::SyntheticBattery battery;
  Series series;
  const auto hold = [&](double wished, double seconds) {
    for (int k = 0; k < seconds; ++k) {
      double current = wished;
      const double voltage = battery.step(current, 1.0);
      series.append({static_cast<double>(series.size()), current, voltage});
    }
  };
  hold(0.0, 600.0);
  hold(-10.0, 10800.0);
  hold(30.0, 9000.0);
  for (int k = 0; k < 20; ++k) {
    hold(-200.0, 10.0);
    hold(0.0, 300.0);
    hold(40.0, 10.0);
  }
  for (const double noise : {0.0, 0.01}) {
    addNoise(series, noise, 0.05 * noise, 4);
    EXPECT_TRUE(findingsOf(series, "clipping").empty()) << idsOf(series);
    EXPECT_TRUE(findingsOf(series, "stuck").empty()) << idsOf(series);
  }
}

TEST(Checks, CranksThatTrulyReachOneAndTheSamePeakAreNotClipped) {
  std::vector<double> profile(120000, 0.0);
  for (int k = 0; k < 30; ++k) {
    profile.insert(profile.end(), 8000, -20.0 - 0.1 * k);
    profile.insert(profile.end(), 1000, -250.0);
    profile.insert(profile.end(), 15000, 30.0 + k);
  }
  for (const std::size_t n : {1, 10, 1000}) {
    EXPECT_TRUE(findingsOf(everyNth(driveSeries(profile), n), "clipping").empty()) << n;
  }
}

TEST(Checks, RecordingWithoutASampleIsRefused) {
  EXPECT_THROW(checkRecording({}), std::invalid_argument);
}

TEST(Checks, SingleSampleIsLintedToo) {
  Series series;
  series.time = {1.0};
  series.current = {-5.0};
  series.voltage = {12.5};
  EXPECT_EQ(checkRecording(toRecording(series)).samples, 1U);
}

TEST(Checks, ReportHoldsTheBasicNumbers) {
  const Series series = cleanDrive();
  const CheckReport report = checkRecording(toRecording(series));
  EXPECT_EQ(report.samples, series.size());
  EXPECT_EQ(report.from, series.time.front());
  EXPECT_EQ(report.to, series.time.back());
  EXPECT_NEAR(report.median_interval, 0.01, 1e-9);
  EXPECT_FALSE(report.voltage_lsb.has_value());
  EXPECT_FALSE(report.current_lsb.has_value());
}

TEST(Checks, ProblemsComeBeforeWarningsAndWarningsBeforeNotes) {
  Series series = slowCarDrive(1800.0, 5);
  for (double& current : series.current) current = -current;
  const auto findings = checkRecording(toRecording(series)).findings;
  ASSERT_GE(findings.size(), 3U);
  EXPECT_TRUE(std::is_sorted(findings.begin(), findings.end(),
                             [](const auto& a, const auto& b) { return a.severity > b.severity; }));
}

// ---------------------------------------------------------------------------------------------
// clipping

TEST(ClippingCheck, FindsCranksCutOffByTheCurrentSensor) {
  Series series = cleanDrive();
  for (double& current : series.current) current = std::max(current, -150.0);
  const auto found = findingsOf(series, "clipping");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_DOUBLE_EQ(*found[0].value, -150.0);
  EXPECT_EQ(found[0].unit, "A");
  EXPECT_GE(found[0].at.size(), 3U);
}

TEST(ClippingCheck, FindsCranksCutOffByTheVoltageSensor) {
  Series series = cleanDrive();
  for (double& voltage : series.voltage) voltage = std::max(voltage, 11.3);
  const auto found = findingsOf(series, "clipping");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_DOUBLE_EQ(*found[0].value, 11.3);
  EXPECT_EQ(found[0].unit, "V");
}

TEST(ClippingCheck, FindsBothLimitsWhereBothChannelsAreCutOffAtOnce) {
  Series series = cleanDrive();
  for (double& current : series.current) current = std::max(current, -100.0);
  for (double& voltage : series.voltage) voltage = std::max(voltage, 12.0);
  const auto found = findingsOf(series, "clipping");
  ASSERT_EQ(found.size(), 2U) << idsOf(series);
  EXPECT_DOUBLE_EQ(*found[0].value, -100.0);
  EXPECT_DOUBLE_EQ(*found[1].value, 12.0);
  EXPECT_TRUE(findingsOf(series, "stuck").empty()) << idsOf(series);
}

TEST(ClippingCheck, FindsBothLimitsWhereTheNoiseIsLessThanAStep) {
  Series series = cleanDrive(3);
  addNoise(series, 0.03, 0.001, 3);
  for (double& current : series.current) current = std::max(current, -100.0);
  for (double& voltage : series.voltage) voltage = std::max(voltage, 12.0);
  test::quantise(series.current, 0.05);
  test::quantise(series.voltage, 0.001);
  EXPECT_EQ(findingsOf(series, "clipping").size(), 2U) << idsOf(series);
}

TEST(ClippingCheck, NoLimitIsFoundInANoisyDriveAtAnyStep) {
  for (const double coarse : {0.2, 1.0, 10.0}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Series series = cleanDrive(seed);
      addNoise(series, 0.05, 0.001, seed);
      test::quantise(series.current, 0.1 * coarse);
      test::quantise(series.voltage, 0.002 * coarse);
      EXPECT_TRUE(findingsOf(series, "clipping").empty()) << idsOf(series);
    }
  }
}

TEST(ClippingCheck, CurrentsThatSomebodyEnteredAmongMeasuredOnesAreNotClipped) {
  test::Random random(7);
  std::vector<double> profile(120000, 0.0);
  for (int k = 0; k < 60; ++k) {
    profile.insert(profile.end(), 5000, random.uniform(-60.0, 60.0));
    if (k % 20 == 0) profile.insert(profile.end(), 15000, -100.0);
  }
  Series series = everyNth(driveSeries(profile), 10);
  addNoise(series, 0.05, 0.001, 2);
  for (double& current : series.current)
    if (current < -90.0) current = -100.0;
  EXPECT_TRUE(findingsOf(series, "clipping").empty()) << idsOf(series);
}

TEST(ClippingCheck, FindsSingleSamplesAtOneHertzThatAllReadTheSameLimit) {
  Series series = slowCarDrive(7200.0, 6);
  test::Random random(9);
  for (std::size_t k = 130; k < series.size(); k += 50) {
    const double peak = random.uniform(-420.0, -130.0);
    series.voltage[k] = 12.2 + 0.006 * peak;
    series.current[k] = 0.1 * std::round(10.0 * peak);
  }
  EXPECT_TRUE(findingsOf(series, "clipping").empty()) << idsOf(series);
  for (double& current : series.current) current = std::max(current, -250.0);
  const auto found = findingsOf(series, "clipping");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_DOUBLE_EQ(*found[0].value, -250.0);
  EXPECT_GT(found[0].samples, 20U);
}

// ---------------------------------------------------------------------------------------------
// quantisation

TEST(QuantisationCheck, FindsTheStepsWithinTwoPercent) {
  Series series = cleanDrive();
  test::quantise(series.current, 0.5);
  test::quantise(series.voltage, 0.02);
  const CheckReport report = checkRecording(toRecording(series));
  ASSERT_TRUE(report.current_lsb && report.voltage_lsb);
  EXPECT_NEAR(*report.current_lsb, 0.5, 0.01);
  EXPECT_NEAR(*report.voltage_lsb, 0.02, 0.0004);
  EXPECT_EQ(findingsOf(series, "quantisation").size(), 2U);
}

TEST(QuantisationCheck, FineStepsAreReportedButAreNoFinding) {
  Series series = cleanDrive();
  test::quantise(series.voltage, 0.001);
  EXPECT_NEAR(checkRecording(toRecording(series)).voltage_lsb.value_or(0.0), 0.001, 2e-5);
  EXPECT_TRUE(findingsOf(series, "quantisation").empty());
}

// ---------------------------------------------------------------------------------------------
// sign, skew, offset

TEST(SignCheck, FindsDischargeCountedAsPositiveAtAnyRate) {
  for (const std::size_t n : {1, 10, 100, 1000}) {
    Series series = everyNth(driveSeries(driveProfile(1800.0, 7)), n);
    EXPECT_TRUE(findingsOf(series, "sign").empty()) << n;
    for (double& current : series.current) current = -current;
    const auto found = findingsOf(series, "sign");
    ASSERT_EQ(found.size(), 1U) << n;
    EXPECT_EQ(found[0].severity, Severity::kProblem);
    EXPECT_TRUE(says(found[0].meaning, "--discharge-positive"));
  }
}

TEST(SignCheck, FindsChannelsThatDoNotBelongTogether) {
  Series series = cleanDrive(1);
  const Series other = cleanDrive(2);
  series.time.resize(std::min(series.size(), other.size()));
  series.current.resize(series.size());
  series.voltage.assign(other.voltage.begin(), other.voltage.begin() + series.size());
  const auto found = findingsOf(series, "sign");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_TRUE(says(found[0].what, "does not follow"));
}

Series withLateCurrent(const Series& series, int delay) {
  Series shifted = series;
  for (int k = 0; k < static_cast<int>(series.size()); ++k) {
    const int from = std::min(std::max(k - delay, 0), static_cast<int>(series.size()) - 1);
    shifted.current[k] = series.current[from];
  }
  return shifted;
}

TEST(SkewCheck, FindsShiftsOfTwentyAndOfFiveMillisecondsAtOneHundredHertz) {
  const Series fast = driveSeries(driveProfile(600.0, 8));
  for (const int delay : {-20, -5, 5, 20}) {
    Series series = atDesignRate(withLateCurrent(fast, delay));
    addNoise(series, 0.1, 0.001, 11);
    const auto found = findingsOf(series, "skew");
    ASSERT_EQ(found.size(), 1U) << delay << ": " << idsOf(series);
    EXPECT_NEAR(*found[0].value, -1e-3 * delay, 0.0015);
    EXPECT_TRUE(says(found[0].what, delay > 0 ? "current comes" : "voltage comes"));
  }
}

TEST(SkewCheck, IsGoneOnceTheCurrentIsMovedByWhatItReadsWhicheverChannelWasLate) {
  const Series fast = driveSeries(driveProfile(600.0, 8));
  for (const int delay : {-47, 20, 47}) {
    Series series = atDesignRate(withLateCurrent(fast, delay));
    addNoise(series, 0.1, 0.001, 11);
    const auto found = findingsOf(series, "skew");
    ASSERT_EQ(found.size(), 1U) << delay;
    EXPECT_TRUE(says(found[0].meaning, "sof convert IN OUT --shift-current " +
                                           std::string(delay > 0 ? "-0.0" : "0.0")))
        << found[0].meaning;
    const Series moved = withShiftedCurrent(series, *found[0].value);
    EXPECT_TRUE(findingsOf(moved, "skew").empty()) << delay;
    EXPECT_GT(moved.size(), series.size() - 10);
  }
}

TEST(SkewCheck, FindsAShiftByAWholeSampleAtOneHertz) {
  const Series series = everyNth(driveSeries(driveProfile(3600.0, 9)), 1000);
  EXPECT_TRUE(findingsOf(series, "skew").empty());
  const auto found = findingsOf(withLateCurrent(series, 1), "skew");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_DOUBLE_EQ(*found[0].value, -1.0);
  EXPECT_TRUE(findingsOf(withShiftedCurrent(withLateCurrent(series, 1), -1.0), "skew").empty());
}

TEST(OffsetCheck, FindsACurrentThatIsNotZeroAtRestAndSaysThatAConsumerLooksTheSame) {
  for (const double offset : {-1.0, -0.3, 0.3, 1.0}) {
    Series series = cleanDrive();
    for (double& current : series.current) current += offset;
    const auto found = findingsOf(series, "offset");
    ASSERT_EQ(found.size(), 1U) << offset << ": " << idsOf(series);
    EXPECT_NEAR(*found[0].value, offset, 0.02);
    EXPECT_EQ(found[0].severity, Severity::kNote);
    EXPECT_TRUE(says(found[0].meaning, "cannot tell"));
  }
}

TEST(OffsetCheck, IsNotJudgedWithoutARest) {
  Series series = cleanDrive();
  series = slice(series, indexRange(series, 130.0, 600.0));
  const auto not_judged = checkRecording(toRecording(series)).not_judged;
  ASSERT_EQ(not_judged.size(), 1U);
  EXPECT_TRUE(says(not_judged[0], "offset: no rest"));
}

// ---------------------------------------------------------------------------------------------
// stuck values

void freeze(std::vector<double>& values, std::size_t first, std::size_t last) {
  std::fill(values.begin() + first, values.begin() + last, values[first]);
}

TEST(StuckCheck, FindsAFrozenCurrentWhileTheVoltageGoesOn) {
  Series series = cleanDrive();
  freeze(series.current, 25000, 30000);
  const auto found = findingsOf(series, "stuck");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_TRUE(says(found[0].what, "current repeats one value"));
  EXPECT_NEAR(*found[0].value, 50.0, 0.1);
  EXPECT_NEAR(found[0].at.front(), 250.0, 0.1);
}

TEST(StuckCheck, FindsAFrozenVoltageWhileTheCurrentGoesOn) {
  Series series = cleanDrive();
  freeze(series.voltage, 25000, 30000);
  const auto found = findingsOf(series, "stuck");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_TRUE(says(found[0].what, "voltage repeats one value"));
}

TEST(StuckCheck, FindsAFrozenCurrentAtOneHertz) {
  Series series = slowCarDrive(3600.0, 12);
  freeze(series.current, 1000, 1100);
  EXPECT_EQ(findingsOf(series, "stuck").size(), 1U) << idsOf(series);
}

TEST(StuckCheck, FindsACurrentThatWasEnteredAmongMeasuredOnes) {
  Series series = cleanDrive();
  std::fill(series.current.begin(), series.current.begin() + 11500, -10.0);
  const auto found = findingsOf(series, "stuck");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_TRUE(says(found[0].what, "exactly -10 A"));
  EXPECT_EQ(found[0].severity, Severity::kNote);
}

/// Repeats samples in both channels, `length` of them from every `spacing`-th on.
void repeatMessages(Series& series, std::size_t spacing, std::size_t length) {
  for (std::size_t first = 13000; first + spacing < series.size(); first += spacing) {
    freeze(series.current, first, first + length);
    freeze(series.voltage, first, first + length);
  }
}

TEST(StuckCheck, FindsRepeatedMessagesThoughTheNoiseIsLessThanAStepAndWarnsOfMany) {
  Series noisy = cleanDrive(4);
  addNoise(noisy, 0.03, 0.001, 4);
  test::quantise(noisy.current, 0.05);
  test::quantise(noisy.voltage, 0.001);
  EXPECT_TRUE(findingsOf(noisy, "stuck").empty()) << idsOf(noisy);
  for (const std::size_t length : {15U, 150U}) {
    Series series = noisy;
    repeatMessages(series, 3000, length);
    const auto found = findingsOf(series, "stuck");
    ASSERT_EQ(found.size(), 1U) << idsOf(series);
    EXPECT_TRUE(says(found[0].what, "both repeat"));
    EXPECT_EQ(found[0].severity, length == 150U ? Severity::kWarning : Severity::kNote);
  }
}

TEST(StuckCheck, ValuesThatStandStillInCoarseStepsAreNotRepeatedMessages) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Series series = cleanDrive(seed);
    addNoise(series, 0.05, 0.001, seed);
    test::quantise(series.current, 0.8);
    test::quantise(series.voltage, 0.015);
    EXPECT_TRUE(findingsOf(series, "stuck").empty()) << idsOf(series);
  }
}

// ---------------------------------------------------------------------------------------------
// aliasing

/// A sine [amplitude] of one frequency [Hz], added to a channel.
void addTone(const Series& series, std::vector<double>& values, double amplitude,
             double frequency) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += amplitude * std::sin(2.0 * 3.14159265358979 * frequency * series.time[k]);
  }
}

TEST(AliasingCheck, FindsRippleOfTheVoltageThatFoldsDownWithoutAFilterAndNotWithOne) {
  Series fast = driveSeries(driveProfile(600.0, 20));
  addTone(fast, fast.voltage, 0.02, 313.0);
  Series unfiltered = everyNth(fast, 10);
  addNoise(unfiltered, 0.1, 0.001, 21);
  const auto found = findingsOf(unfiltered, "aliasing");
  ASSERT_EQ(found.size(), 1U) << idsOf(unfiltered);
  EXPECT_EQ(found[0].unit, "Hz");
  EXPECT_NEAR(*found[0].value, 13.0, 0.01);
  EXPECT_EQ(found[0].severity, Severity::kWarning);
  EXPECT_TRUE(says(found[0].what, "13 Hz (amplitude 20 mV)")) << found[0].what;
  EXPECT_TRUE(says(found[0].meaning, "a real load"));
  Series filtered = atDesignRate(fast);
  addNoise(filtered, 0.1, 0.001, 21);
  EXPECT_TRUE(findingsOf(filtered, "aliasing").empty());
}

TEST(AliasingCheck, FindsTonesOfTwoMillivoltsAndLeavesThoseOfHalfAMillivolt) {
  for (const double frequency : {5.3, 12.34, 31.0, 44.4}) {
    Series weak = cleanDrive(3), clear = weak;
    addTone(weak, weak.voltage, 0.0005, frequency);
    EXPECT_TRUE(findingsOf(weak, "aliasing").empty()) << frequency;
    addTone(clear, clear.voltage, 0.002, frequency);
    const auto found = findingsOf(clear, "aliasing");
    ASSERT_EQ(found.size(), 1U) << frequency;
    EXPECT_NEAR(*found[0].value, frequency, 0.4);
  }
}

TEST(AliasingCheck, TonesInProportionInBothChannelsAreNotFound) {
  for (const double frequency : {7.0, 313.0}) {
    for (const double amplitude : {0.5, 5.0}) {
      std::vector<double> profile = driveProfile(600.0, 22);
      for (std::size_t k = 0; k < profile.size(); ++k) {
        profile[k] += amplitude * std::sin(2.0 * 3.14159265358979 * frequency * 1e-3 * k);
      }
      Series series = everyNth(driveSeries(profile), 10);
      addNoise(series, 0.1, 0.001, 23);
      EXPECT_TRUE(findingsOf(series, "aliasing").empty()) << frequency << " Hz " << amplitude;
    }
  }
}

TEST(AliasingCheck, LoadThatSwitchesRegularlyThroughANonlinearBatteryIsNotAliasing) {
  for (const int period : {140, 333, 1000}) {
    std::vector<double> profile;
    for (int k = 0; k < 600000; ++k) profile.push_back(k % period < period / 2 ? -40.0 : 35.0);
    for (int k = 0; k < 600000; k += 60000) std::fill_n(profile.begin() + k, 1000, -250.0);
    Series series = everyNth(driveSeries(profile), 10);
    for (std::size_t k = 0; k < series.size(); ++k) {
      const double current = series.current[k];
      series.voltage[k] += 0.003 * std::max(current, 0.0) + 0.1 * std::asinh(current / 10.0);
    }
    EXPECT_TRUE(findingsOf(series, "aliasing").empty()) << period << " ms, exact";
    addNoise(series, 0.1, 0.001, 24);
    EXPECT_TRUE(findingsOf(series, "aliasing").empty()) << period << " ms, noisy";
  }
}

TEST(AliasingCheck, ToneOfUnsteadyFrequencyIsNotFound) {
  Series series = cleanDrive(4);
  double phase = 0.0;
  test::Random random(25);
  for (std::size_t k = 0; k < series.size(); ++k) {
    phase += 2.0 * 3.14159265358979 * 0.123 + 0.3 * random.normal();
    series.voltage[k] += 0.01 * std::sin(phase);
  }
  EXPECT_TRUE(findingsOf(series, "aliasing").empty());
}

TEST(AliasingCheck, IsNotJudgedInAShortRecording) {
  Series series = cleanDrive();
  series = slice(series, {12000, 13500});
  const auto not_judged = checkRecording(toRecording(series)).not_judged;
  EXPECT_TRUE(std::any_of(not_judged.begin(), not_judged.end(), [](const std::string& line) {
    return says(line, "aliasing: only 5 blocks of 256");
  }));
}

// ---------------------------------------------------------------------------------------------
// time

TEST(RateCheck, SaysWhatASlowRateHides) {
  const Series fast = driveSeries(driveProfile(1800.0, 13));
  const auto at_ten = findingsOf(everyNth(fast, 100), "rate");
  ASSERT_EQ(at_ten.size(), 1U);
  EXPECT_EQ(at_ten[0].severity, Severity::kNote);
  const auto at_one = findingsOf(everyNth(fast, 1000), "rate");
  ASSERT_EQ(at_one.size(), 1U);
  EXPECT_EQ(at_one[0].severity, Severity::kWarning);
}

TEST(RateCheck, FindsARecordingLoggedAtSeveralRates) {
  const Series fast = driveSeries(driveProfile(1200.0, 14));
  Series series = everyNth(slice(fast, {0, 600000}), 100);
  const Series slow = everyNth(slice(fast, {600000, 1200000}), 1000);
  series.time.insert(series.time.end(), slow.time.begin(), slow.time.end());
  series.current.insert(series.current.end(), slow.current.begin(), slow.current.end());
  series.voltage.insert(series.voltage.end(), slow.voltage.begin(), slow.voltage.end());
  const auto found = findingsOf(series, "rate");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(says(found[1].what, "between 0.1 s and 1 s"));
}

TEST(RateCheck, FindsACurrentThatIsUpdatedMoreSeldomThanItIsLogged) {
  Series series = everyNth(driveSeries(driveProfile(600.0, 15)), 20);
  test::Random random(16);
  double load = 0.0;
  for (std::size_t k = 6000; k < series.size(); ++k) {
    if (random.uniform(0.0, 1.0) < 0.1) load = random.uniform(-60.0, 0.0);
    series.current[k] += load;
    series.voltage[k] += 0.005 * load;
  }
  addNoise(series, 0.1, 0.001, 17);
  EXPECT_TRUE(findingsOf(series, "rate").empty()) << idsOf(series);
  for (std::size_t k = 0; k < series.size(); ++k) series.current[k] = series.current[k - k % 4];
  const auto found = findingsOf(series, "rate");
  ASSERT_EQ(found.size(), 1U) << idsOf(series);
  EXPECT_TRUE(says(found[0].what, "every 4 samples (0.08 s)"));
}

TEST(GapCheck, CountsGapsAndTheTimeLost) {
  Series series = cleanDrive();
  for (std::size_t k = 20000; k < series.size(); ++k) series.time[k] += 90.0;
  for (std::size_t k = 40000; k < series.size(); ++k) series.time[k] += 30.0;
  const auto found = findingsOf(series, "gaps");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].samples, 2U);
  EXPECT_NEAR(*found[0].value, 120.0, 0.1);
  EXPECT_NEAR(found[0].at[0], 200.0, 0.1);
  EXPECT_EQ(found[0].severity, Severity::kWarning);
}

TEST(GapCheck, TakesManyGapsOfOneLengthForASlowerLoggingRate) {
  Series series = cleanDrive();
  for (std::size_t k = 0; k < series.size(); ++k) series.time[k] += 60.0 * (k / 2000);
  const auto found = findingsOf(series, "gaps");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GE(found[0].samples, 20U);
  EXPECT_EQ(found[0].severity, Severity::kNote);
  EXPECT_TRUE(says(found[0].meaning, "a slower logging rate"));
}

TEST(ClockCheck, RepeatsWhatTheIntakeCounted) {
  Recording recording = toRecording(cleanDrive());
  recording.rejected.duplicate_stamp = 3;
  recording.rejected.clock_step_back = 2;
  recording.largest_step_back = 3600.0;
  recording.offered += 5;
  const auto findings = checkRecording(recording).findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "clock");
  EXPECT_EQ(findings[0].samples, 5U);
  EXPECT_EQ(findings[0].severity, Severity::kWarning);
  EXPECT_TRUE(says(findings[0].what, "by up to 3600 s"));
}

TEST(MissingCheck, RepeatsWhatTheIntakeRefused) {
  Recording recording = toRecording(cleanDrive());
  recording.rejected.missing_value = 4;
  recording.rejected.not_finite = 1;
  recording.rejected.out_of_range = 2;
  recording.offered += 7;
  const auto findings = checkRecording(recording).findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "missing");
  EXPECT_EQ(findings[0].samples, 7U);
  EXPECT_TRUE(says(findings[0].what, "4 without current or voltage, 1 infinite, 2 outside"));
}

/// Without every sample of which the test is true.
template <typename Test>
Series without(const Series& series, Test test) {
  Series kept;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (test(k)) continue;
    kept.append(series[k]);
  }
  return kept;
}

TEST(MissingCheck, ARecordingOfWhichMostIsBeyondABatteryIsAProblemThatNamesTheUnits) {
  std::vector<RawSample> samples;
  for (int n = 0; n < 1000; ++n) {
    const double current = n % 10 == 0 ? 0.0 : 20e3 * std::sin(0.1 * n);  // mA
    samples.push_back({0.1 * n, current, 12.5 + 1e-7 * current, {}});
  }
  const Recording recording = recordingOf("ma.csv", samples);
  ASSERT_GT(recording.rejected.out_of_range, 500u);
  const std::string problems = format(findProblems(recording));
  EXPECT_THAT(problems, HasSubstr("of 1000 refused"));
  EXPECT_THAT(problems, HasSubstr("in A and voltages in V"));
}

TEST(TemperatureCheck, CountsTemperaturesThatNoBatteryHas) {
  std::vector<RawSample> samples;
  for (int n = 0; n < 100; ++n)
    samples.push_back({0.1 * n, -5.0 - n % 7, 12.5, n < 30 ? 1e9 : 300.0});
  const CheckReport report = checkRecording(recordingOf("hot.csv", samples));
  const auto found = std::find_if(report.findings.begin(), report.findings.end(),
                                  [](const Finding& one) { return one.id == "temperature"; });
  ASSERT_NE(found, report.findings.end());
  EXPECT_EQ(found->samples, 30u);
}

TEST(MissingCheck, CountsTheSamplesThatARegularGridLacksAndWarnsOfMany) {
  for (const double share : {0.002, 0.02, 0.1}) {
    test::Random random(5);
    const Series series =
        without(cleanDrive(), [&](std::size_t) { return random.uniform(0.0, 1.0) < share; });
    const auto found = findingsOf(series, "missing");
    ASSERT_EQ(found.size(), 1U) << idsOf(series);
    EXPECT_NEAR(*found[0].value, 100.0 * share, 10.0 * share + 0.02);
    EXPECT_EQ(found[0].severity, share < 0.005 ? Severity::kNote : Severity::kWarning);
  }
}

TEST(MissingCheck, GapsAndSlowerRatesAreNotLostSamples) {
  const Series clean = cleanDrive();
  EXPECT_TRUE(
      findingsOf(without(clean, [](std::size_t k) { return k % 1000 < 300; }), "missing").empty());
  EXPECT_TRUE(
      findingsOf(without(clean, [](std::size_t k) { return k > 30000 && k % 4 != 0; }), "missing")
          .empty());
  const Series slow = without(slowCarDrive(3600.0, 3), [](std::size_t k) { return k % 300 < 40; });
  EXPECT_TRUE(findingsOf(slow, "missing").empty()) << idsOf(slow);
}

// ---------------------------------------------------------------------------------------------
// window quality

TEST(VoltageLevelCheck, FindsACellAndSaysWhichRangeWasExpected) {
  Series series = cleanDrive();
  for (double& voltage : series.voltage) voltage -= 9.3;
  const auto found = findingsOf(series, "voltage_level");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].severity, Severity::kProblem);
  EXPECT_NEAR(*found[0].value, 3.3, 0.3);
  EXPECT_TRUE(says(found[0].meaning, "not a 12 V lead-acid block"));
  EXPECT_TRUE(says(found[0].meaning, "between 10.5 V and 15.5 V"));
}

TEST(VoltageLevelCheck, GuessesBlocksInSeries) {
  Series series = cleanDrive();
  for (double& voltage : series.voltage) voltage *= 2.0;
  const auto found = findingsOf(series, "voltage_level");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(says(found[0].meaning, "2 blocks of 12 V in series (--series-blocks 2)"));
}

TEST(VoltageLevelCheck, GuessesABatteryOfSixVolts) {
  Series series = cleanDrive();
  for (double& voltage : series.voltage) voltage *= 0.5;
  const auto found = findingsOf(series, "voltage_level");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(says(found[0].meaning, "a battery of 6 V (--series-blocks 0.5)"));
}

TEST(ExcitationCheck, FindsAConstantCurrentUnderWhichTheVoltageStandsStillWithAndWithoutNoise) {
  for (const double noise : {0.0, 0.1}) {
    Series series = driveSeries(std::vector<double>(600000, -5.0));
    std::fill(series.voltage.begin(), series.voltage.end(), 12.4);
    addNoise(series, noise, 0.01 * noise, 17);
    const CheckReport report = checkRecording(toRecording(series));
    ASSERT_EQ(report.findings.size(), 1U) << idsOf(series);
    EXPECT_EQ(report.findings[0].id, "excitation");
    EXPECT_EQ(report.findings[0].severity, Severity::kProblem);
    EXPECT_EQ(report.not_judged.size(), 4U);
  }
}

/// A bench: 10 A drawn without a flicker for an hour, every 5 s, after a rest; steps of 1 mV.
Series heldDischarge(std::size_t rest) {
  Series series;
  for (std::size_t k = 0; k < rest + 720; ++k) {
    const double time = 5.0 * static_cast<double>(k);
    const double drawn = k < rest ? 0.0 : 10.0 * (time - 5.0 * static_cast<double>(rest));
    const double flicker = 0.004 * static_cast<double>((k * k / 3) % 2);
    const double current = k < rest ? 0.0 : -10.0;
    series.append({time, current, 12.8 + 0.02 * current - 1e-5 * drawn + flicker});
  }
  test::quantise(series.voltage, 0.001);
  return series;
}

TEST(ExcitationCheck, ACurrentThatABenchHoldsIsNoProblemWhileTheVoltageMoves) {
  const auto findings = findingsOf(heldDischarge(0), "excitation");
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().severity, Severity::kWarning);
  EXPECT_TRUE(says(findings.front().what, "held at one value, -10 A")) << findings.front().what;
  EXPECT_TRUE(findProblems(heldDischarge(0)).empty());
}

TEST(ExcitationCheck, ACurrentThatABenchHoldsIsNeitherClippedNorStuck) {
  for (const std::size_t rest : {0U, 100U, 360U}) {
    EXPECT_TRUE(findingsOf(heldDischarge(rest), "clipping").empty()) << rest;
    EXPECT_TRUE(findingsOf(heldDischarge(rest), "stuck").empty()) << rest;
  }
}

TEST(ExcitationCheck, FindsThatTheBatteryIsNeverChargedOrNeverDischarged) {
  std::vector<double> profile = driveProfile(600.0, 18);
  for (double& current : profile) current = std::min(current, 0.0);
  const auto uncharged = findingsOf(everyNth(driveSeries(profile), 10), "excitation");
  ASSERT_EQ(uncharged.size(), 1U);
  EXPECT_TRUE(says(uncharged[0].what, "never charged"));
  for (double& current : profile) current = std::abs(current) / 10.0;
  const auto undischarged = findingsOf(everyNth(driveSeries(profile), 10), "excitation");
  ASSERT_EQ(undischarged.size(), 1U);
  EXPECT_TRUE(says(undischarged[0].what, "never discharged"));
}

TEST(ExcitationCheck, NotesThatThereIsNoEngineStart) {
  std::vector<double> profile = driveProfile(600.0, 19);
  for (double& current : profile) current = std::max(current, -60.0);
  const auto found = findingsOf(everyNth(driveSeries(profile), 10), "excitation");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(says(found[0].what, "-60 A"));
  EXPECT_EQ(found[0].severity, Severity::kNote);
}

TEST(DescribeSeverity, NamesEverySeverity) {
  EXPECT_EQ(toString(Severity::kNote), "note");
  EXPECT_EQ(toString(Severity::kWarning), "warning");
  EXPECT_EQ(toString(Severity::kProblem), "problem");
}

// ---------------------------------------------------------------------------------------------
// real recordings

class RealChecks : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "no recordings in ../shared/data";
  }

  /// The findings as "id:severity id:severity ...", in their order.
  static std::string findings(const std::string& name, const CsvColumns& columns) {
    std::string text;
    for (const Finding& finding :
         checkRecording(readCsv(std::filesystem::path(kFolder) / name, columns)).findings) {
      text += (text.empty() ? "" : " ") + finding.id + ":" + toString(finding.severity);
    }
    return text;
  }

  static constexpr const char* kFolder = BATTERY_SOF_SOURCE_DIR "/../shared/data";
  const CsvColumns car_{"t_s", "current_A", "voltage_V", std::string("temp_C"), false};
};

TEST_F(RealChecks, StartStopDrivesAreClippedAtAFullScaleAndFreezeWhileTheCarSleeps) {
  EXPECT_EQ(findings("startstop_car/drive_1.csv", car_),
            "rate:warning stuck:warning clipping:warning clock:note gaps:note quantisation:note "
            "quantisation:note");
  EXPECT_EQ(findings("startstop_car/drive_2.csv", car_),
            "rate:warning stuck:warning clipping:warning clock:warning gaps:note "
            "quantisation:note quantisation:note");
}

TEST_F(RealChecks, OtherCarReadsVoltageOneSampleAfterCurrent) {
  EXPECT_EQ(findings("startstop_car/other_car_1.csv", car_),
            "rate:warning skew:warning clock:warning gaps:note quantisation:note "
            "quantisation:note");
}

TEST_F(RealChecks, RobotHasASlowLateUnipolarCurrent) {
  EXPECT_EQ(findings("frc_robot/match.csv", {"t_s", "current_A_minus_sum_of_channels",
                                             "voltage_V_roborio", std::nullopt, false}),
            "excitation:warning rate:warning skew:warning quantisation:note offset:note");
}

TEST_F(RealChecks, BenchCycleHasADischargeThatWasEntered) {
  EXPECT_EQ(findings("agm_bench/full_cycle.csv",
                     {"t_s", "current_A", "voltage_V", std::string("battery_temp_C"), false}),
            "deep_discharge:warning rate:warning excitation:note stuck:note");
}

TEST_F(RealChecks, SolarRecordingReadWithTheWrongSignIsAProblem) {
  CsvColumns columns{"time", "current", "voltage", std::string("temperature"), true};
  EXPECT_EQ(findings("solar_vrla/ten_days.csv", columns),
            "deep_discharge:warning rate:warning excitation:note clock:note");
  columns.discharge_positive = false;
  EXPECT_EQ(findings("solar_vrla/ten_days.csv", columns).substr(0, 12), "sign:problem");
}

TEST_F(RealChecks, LithiumCellIsNotATwelveVoltBlock) {
  EXPECT_EQ(findings("leaf_cell/hppc_25c.csv",
                     {"Time(s)", "Current(A)", "Voltage(V)", std::nullopt, false}),
            "voltage_level:problem rate:warning excitation:note rate:note gaps:note");
}

// ---------------------------------------------------------------------------------------------
// problems

TEST(TimeUnitCheck, FindsMillisecondsReadAsSecondsAtAnyRate) {
  for (const std::size_t stride : {1u, 10u, 100u}) {
    Series series = everyNth(cleanDrive(3), stride);
    EXPECT_TRUE(findingsOf(series, "time_unit").empty()) << stride;
    for (double& time : series.time) time *= 1e3;
    const std::vector<Finding> found = findingsOf(series, "time_unit");
    ASSERT_EQ(found.size(), 1u) << stride;
    EXPECT_EQ(found[0].severity, Severity::kProblem);
    EXPECT_TRUE(says(found[0].meaning, "--time-unit ms")) << found[0].meaning;
  }
}

/// A minute at 100 Hz with one engine start, whose rush takes a tenth of a second.
Series minuteWithACrank() {
  Series series;
  for (int k = 0; k < 6000; ++k) {
    const int since = k - 1000;
    const bool turns = since >= 0 && since < 80;
    const double current = !turns ? -8.0 : -150.0 - 200.0 * std::exp(-0.05 * since);
    series.append({0.01 * k, current, 12.6 + 0.005 * current});
  }
  return series;
}

TEST(TimeUnitCheck, WarnsOfAnEngineStartThatTakesMinutes) {
  Series series = minuteWithACrank();
  EXPECT_TRUE(findingsOf(series, "time_unit").empty());
  for (double& time : series.time) time *= 1e3;
  const std::vector<Finding> found = findingsOf(series, "time_unit");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::kWarning);
  EXPECT_TRUE(says(found[0].meaning, "--time-unit ms")) << found[0].meaning;
  EXPECT_EQ(found[0].at, std::vector<double>{10000.0});
}

TEST(TimeUnitCheck, LeavesLongLoadsOfAStartersCurrentInSlowRows) {
  for (const double interval : {10.0, 20.0, 30.0, 60.0}) {
    Series series;
    for (int k = 0; k < 600; ++k) {
      const double current = k % 300 >= 100 && k % 300 < 106 ? -170.0 : k % 300 == 200 ? -250.0 : 5;
      series.append({interval * k, current, 12.8 + 0.005 * current});
    }
    EXPECT_TRUE(findingsOf(series, "time_unit").empty()) << interval;
  }
}

TEST(TimeUnitCheck, LeavesWeeksWithAnOffsetOfTheCurrent) {
  Series series;
  for (int k = 0; k < 40 * 1440; ++k)  // 40 days, a sample a minute
    series.append({60.0 * k, 0.15 + 4.0 * std::sin(0.01 * k), 12.7 + 0.02 * std::sin(0.01 * k)});
  EXPECT_TRUE(findingsOf(series, "time_unit").empty());
}

TEST(VoltageLevelCheck, SaysThatANegativeVoltageHasItsSignFlippedAndNothingOfTheCurrents) {
  Series series = cleanDrive(2);
  for (double& voltage : series.voltage) voltage = -voltage;
  const std::vector<Finding> problems = findProblems(series);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].id, "voltage_level");
  EXPECT_TRUE(says(format(problems), "its sign is flipped")) << format(problems);
}

TEST(FindProblems, AreThoseOfTheWholeCheck) {
  Series flipped = cleanDrive(2);
  EXPECT_TRUE(findProblems(flipped).empty());
  EXPECT_TRUE(findProblems(Series()).empty());
  for (double& current : flipped.current) current = -current;
  ASSERT_EQ(findProblems(flipped).size(), 1u);
  EXPECT_EQ(findProblems(flipped)[0].what, findingsOf(flipped, "sign").at(0).what);
}

}  // namespace
}  // namespace battery_sof

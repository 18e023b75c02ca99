#include "recording/frozen_channels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "battery_sof/csv.hpp"

namespace battery_sof {
namespace {

using ::testing::HasSubstr;

constexpr double kCapacity = 50.0;  // [Ah]
constexpr double kMaxGap = 5.0;     // [s]

/// How a stream was found at each of its seconds.
struct Looked {
  int looks = 0, frozen = 0;
  std::string last;
};

/// Looks once a second from a time on, as a session does.
Looked look(const Series& series, double from, double max_gap = kMaxGap) {
  Looked looked;
  Series past;
  double due = from;
  for (std::size_t k = 0; k < series.size(); ++k) {
    past.append(series[k]);
    if (series.time[k] < due) continue;
    due = series.time[k] + 1.0;
    looked.last = frozenChannels(past, kCapacity, max_gap).value_or("");
    ++looked.looks;
    if (!looked.last.empty()) ++looked.frozen;
  }
  return looked;
}

/// A car in the city: a load, a crank, then charges and discharges; the voltage in steps.
Series drive(double duration, double interval, double step, double current_step = 0.1) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  Series series;
  double level = 20.0, until = 0.0, slow = 0.0;
  for (long n = 0; n < std::lround(duration / interval); ++n) {
    const double t = static_cast<double>(n) * interval, phase = std::fmod(t, 40.0);
    if (t >= until) {
      level = std::uniform_real_distribution<double>(-30.0, 60.0)(random);
      until = t + std::uniform_real_distribution<double>(2.0, 8.0)(random);
    }
    double current = phase < 12.0 ? -25.0 : phase < 13.0 ? -220.0 : level;
    current += 0.2 * noise(random);
    slow += interval * (current / 1100.0 - slow / 20.0);
    const double voltage = 12.6 + 0.006 * current + slow + 0.003 * noise(random);
    series.append({t, current_step * std::round(current / current_step),
                   step > 0.0 ? step * std::round(voltage / step) : voltage});
  }
  return series;
}

class OfAStep : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(OfAStep, ADriveIsNeverFrozen) {
  const auto [interval, step] = GetParam();
  EXPECT_EQ(look(drive(900.0, interval, step), 10.0).frozen, 0);
}

TEST_P(OfAStep, AVoltageThatSticksIsFoundWithinTwoMinutes) {
  const auto [interval, step] = GetParam();
  Series series = drive(900.0, interval, step);
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series.time[k] >= 600.0) series.voltage[k] = series.voltage[k - 1];
  const Looked found = look(series, 601.0);
  EXPECT_GE(found.frozen, found.looks - 120);
  EXPECT_THAT(found.last, HasSubstr("the voltage is stuck"));
}

TEST_P(OfAStep, AVoltageThatNeverMovedIsFoundWithinThreeMinutes) {
  const auto [interval, step] = GetParam();
  Series series = drive(400.0, interval, step);
  for (double& voltage : series.voltage) voltage = 12.6;
  const Looked found = look(series, 10.0);
  EXPECT_GE(found.frozen, found.looks - 180);
}

TEST_P(OfAStep, ACurrentThatSticksIsFoundWithinThreeMinutes) {
  const auto [interval, step] = GetParam();
  Series series = drive(900.0, interval, step);
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series.time[k] >= 600.0) series.current[k] = series.current[k - 1];
  const Looked found = look(series, 601.0);
  EXPECT_GE(found.frozen, found.looks - 180);
  EXPECT_THAT(found.last, HasSubstr("the current is stuck"));
}

TEST_P(OfAStep, BothChannelsThatStickUnderLoadAreFoundWithinThreeMinutes) {
  const auto [interval, step] = GetParam();
  Series series = drive(1200.0, interval, step);
  const std::size_t first = firstAfter(series, 885.0);  // a load of 25 A
  for (std::size_t k = first; k < series.size(); ++k) {
    series.current[k] = series.current[first];
    series.voltage[k] = series.voltage[first];
  }
  const Looked found = look(series, 886.0);
  EXPECT_GE(found.frozen, found.looks - 180);
  EXPECT_THAT(found.last, HasSubstr("both channels are stuck"));
}

TEST_P(OfAStep, WhatMovesAgainIsNoLongerFrozen) {
  const auto [interval, step] = GetParam();
  Series series = drive(900.0, interval, step);
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series.time[k] >= 300.0 && series.time[k] < 600.0)
      series.voltage[k] = series.voltage[k - 1];
  EXPECT_GT(look(series, 301.0).frozen, 0);
  EXPECT_EQ(look(series, 615.0).frozen, 0);
}

INSTANTIATE_TEST_SUITE_P(FrozenChannels, OfAStep,
                         ::testing::Values(std::make_pair(0.05, 0.0), std::make_pair(0.05, 0.005),
                                           std::make_pair(1.0, 0.005), std::make_pair(1.0, 0.025)));

TEST(FrozenChannels, ARestWithAQuietSensorIsNone) {
  Series series = drive(900.0, 1.0, 0.025);
  const double voltage = 12.55;
  while (series.time.back() < 4500.0) series.append({series.time.back() + 1.0, 0.0, voltage});
  EXPECT_EQ(look(series, 10.0).frozen, 0);
}

TEST(FrozenChannels, ADischargeWithAnEnteredCurrentIsNone) {
  Series series;
  for (int n = 0; n < 7000; ++n) {
    const double voltage = 12.8 - 0.0002 * n;
    series.append({5.0 * n, -10.0, 0.001 * std::round(voltage / 0.001)});
  }
  EXPECT_EQ(look(series, 10.0, 50.0).frozen, 0);
}

TEST(FrozenChannels, ASourceThatHoldsTheVoltageWhileTheCurrentSettlesIsNone) {
  Series series = drive(700.0, 1.0, 0.025);
  for (int n = 1; n < 3000; ++n) {
    const double current = 40.0 * std::exp(-n / 600.0) + 2.0;
    series.append({700.0 + n, 0.1 * std::round(current / 0.1), 14.2});
  }
  EXPECT_EQ(look(series, 10.0).frozen, 0);
}

// ---------------------------------------------------------------------------------------------
// real recordings

class RealFrozenChannels : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "no recordings in ../shared/data";
  }

  /// Looks as a session does that keeps half an hour.
  static Looked looked(const std::string& name, const CsvColumns& columns = {}) {
    const Series series = readCsv(std::filesystem::path(kFolder) / name, columns).series;
    const double max_gap = gapThreshold(series);
    Looked looked;
    Series past;
    for (std::size_t k = 0; k < series.size(); ++k) {
      past.append(series[k]);
      if (past.time.back() - past.time.front() > 2250.0)
        past.dropFirst(firstAfter(past, past.time.back() - 1800.0));
      ++looked.looks;
      if (frozenChannels(past, kCapacity, max_gap)) ++looked.frozen;
    }
    return looked;
  }

  static constexpr const char* kFolder = BATTERY_SOF_SOURCE_DIR "/../shared/data";
  const CsvColumns car_{"t_s", "current_A", "voltage_V", std::string("temp_C"), false};
};

TEST_F(RealFrozenChannels, OfADriveOnlyTheCurrentThatReallyStoodStillIsFound) {
  const int frozen = looked("startstop_car/drive_1.csv", car_).frozen;
  EXPECT_GT(frozen, 0) << "twice, for 51 and 42 s";
  EXPECT_LT(frozen, 95);
}

TEST_F(RealFrozenChannels, InTheOtherRecordingsNothingIsFrozen) {
  for (const char* car : {"startstop_car/drive_2.csv", "startstop_car/other_car_1.csv"})
    EXPECT_EQ(looked(car, car_).frozen, 0) << car;
  for (const char* plain : {"small_car/trip.csv", "ev_12v/load.csv", "ageing_bench/cycles.csv"})
    EXPECT_EQ(looked(plain).frozen, 0) << plain;
  EXPECT_EQ(looked("agm_bench/full_cycle.csv",
                   {"t_s", "current_A", "voltage_V", std::string("battery_temp_C"), false})
                .frozen,
            0);
  EXPECT_EQ(looked("solar_vrla/ten_days.csv",
                   {"time", "current", "voltage", std::string("temperature"), true})
                .frozen,
            0);
}

TEST(RepeatingChannels, AreThoseThatStandStillWhileTheOtherOneMoves) {
  Series stuck_voltage, stuck_current, held;
  for (int n = 0; n < 200; ++n) {
    const double time = 0.1 * n, load = (n / 30) % 2 == 0 ? -10.0 : -40.0;
    stuck_voltage.append({time, load, 12.4});
    stuck_current.append({time, -10.0, 12.5 + 0.01 * load});
    held.append({time, -10.0, 12.5 - 1e-4 * n});  // a bench holds the current
  }
  const auto of = [](const Series& series) {
    return repeatingChannels(series, kCapacity, kMaxGap);
  };
  EXPECT_TRUE(of(stuck_voltage).voltage && !of(stuck_voltage).current);
  EXPECT_TRUE(of(stuck_current).current && !of(stuck_current).voltage);
  EXPECT_FALSE(of(held).current || of(held).voltage);
}

}  // namespace
}  // namespace battery_sof

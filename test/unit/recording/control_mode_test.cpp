#include "recording/control_mode.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

void add(Series& series, double interval, double current, double voltage) {
  series.append({series.empty() ? 0.0 : series.time.back() + interval, current, voltage});
}

/// Wanted currents, a value for every interval, through a battery whose charging voltage ends
/// at 14.4 V.
Series played(const std::vector<double>& wanted, double interval) {
  test::SyntheticBattery battery;
  test::Random random(7);
  Series series;
  for (double current : wanted) {
    const double voltage = battery.step(current, interval),
                 shown = voltage + 0.001 * random.normal();
    add(series, interval, current + 0.01 * random.normal(), shown);
  }
  return series;
}

struct Car {
  Series series;
  std::vector<char> engine_runs;
};

/// Stops of 20 s at -20 A, cranks, and drives of 100 s in which a source sets the voltage and the
/// battery takes little.
Car startStopCar(double interval, double current_noise = 0.1) {
  test::Random random(3);
  Car car;
  double set_point = 13.8;
  for (double t = 0.0; t < 1800.0; t += interval) {
    const double phase = std::fmod(t, 120.0);
    const bool runs = phase >= 21.0;
    const double load = phase >= 20.0 ? -250.0 : -20.0 - 5.0 * std::sin(t / 3.0);
    if (random.uniform(0.0, 1.0) < interval / 15.0) set_point = random.uniform(13.0, 14.4);
    const double taken = 0.8 + 40.0 * std::exp(-(phase - 21.0) / 8.0);
    add(car.series, interval, (runs ? taken : load) + current_noise * random.normal(),
        (runs ? set_point : 12.4 + 0.008 * load) + 0.012 * random.normal());
    car.engine_runs.push_back(runs ? 1 : 0);
  }
  return car;
}

double agreement(const std::vector<char>& one, const std::vector<char>& other) {
  std::size_t equal = 0;
  for (std::size_t k = 0; k < one.size(); ++k) equal += one[k] == other[k] ? 1 : 0;
  return static_cast<double>(equal) / static_cast<double>(one.size());
}

std::vector<char> watched(const Series& series, const ControlModeRule& rule) {
  ControlModeDetector watch(rule);
  std::vector<char> imposes;
  for (std::size_t k = 0; k < series.size(); ++k)
    imposes.push_back(watch.add(series.time[k], series.current[k], series.voltage[k]) ? 1 : 0);
  return imposes;
}

/// 30 A until 14.4 V, that voltage for 40 minutes, an hour's rest.
Series benchCharge(double interval) {
  const auto samples = [&](double hours) {
    return static_cast<std::size_t>(hours * 3600.0 / interval);
  };
  std::vector<double> wanted(samples(0.2), -10.0);
  wanted.insert(wanted.end(), samples(3.0), 30.0);
  wanted.insert(wanted.end(), samples(1.0), 0.0);
  return played(wanted, interval);
}

TEST(DetectControlMode, DischargesAndRestsAloneHaveNoSource) {
  std::vector<double> wanted(200, 0.0);
  for (int k = 0; k < 500; ++k) wanted.push_back(k % 20 < 8 ? -80.0 : -2.0);
  const ControlModes source = detectControlMode(played(wanted, 0.1));
  EXPECT_FALSE(source.seen);
  EXPECT_EQ(source.share, 0.0);
  EXPECT_EQ(std::count(source.voltage_controlled.begin(), source.voltage_controlled.end(), 0), 700);
  EXPECT_FALSE(source.rule.present);
}

/// Half an hour at 13.700 V that takes `taken` [A], then six hours at -0.9 A.
Series floatThenDischarge(double taken) {
  test::Random random(5);
  Series series;
  for (int n = 0; n < 23400; ++n) {
    const bool is_float = n < 1800;
    const double falling = 12.9 - 1.1 * (n - 1800) / 21600.0;
    const double current = (is_float ? taken : -0.9) + 5e-4 * random.normal();
    series.append({1.0 * n, 0.001 * std::round(1000.0 * current),
                   (is_float ? 13.7 : falling) + 5e-4 * random.normal()});
  }
  return series;
}

TEST(DetectControlMode,
     AFullBatteryAtAFloatChargerHasASourceWhateverItTakesAndHoweverLongItIsUsed) {
  for (const double taken : {0.0, 0.005, 0.05}) {
    const Series series = floatThenDischarge(taken);
    for (const std::size_t last : {std::size_t{3600}, series.size()}) {
      const ControlModes source = detectControlMode(slice(series, {0, last}));
      EXPECT_TRUE(source.seen) << taken << " A, " << last << " samples";
      EXPECT_NEAR(source.share, 1800.0 / static_cast<double>(last), 0.002) << taken;
      EXPECT_NE(source.summary.find("A source holds the voltage"), std::string::npos);
    }
  }
}

TEST(DetectControlMode, ARestThatRelaxesFromAChargeBeforeTheRecordingHasNoSource) {
  test::Random random(6);
  Series series;
  for (int n = 0; n < 7200; ++n)
    series.append({1.0 * n, (n < 3600 ? 0.0 : -0.9) + 5e-4 * random.normal(),
                   12.9 + 0.9 * std::exp(-n / 900.0) + 5e-4 * random.normal()});
  EXPECT_FALSE(detectControlMode(series).seen);
}

TEST(DetectControlMode, AnEmptySeriesHasNoSource) {
  const ControlModes source = detectControlMode({});
  EXPECT_FALSE(source.seen);
  EXPECT_TRUE(source.totals.empty());
}

TEST(DetectControlMode, InACarTheVoltageIsImposedWhileTheEngineRuns) {
  for (const double interval : {1.0, 0.1, 0.01}) {
    const Car car = startStopCar(interval);
    const ControlModes source = detectControlMode(car.series);
    EXPECT_TRUE(source.seen);
    EXPECT_GT(agreement(source.voltage_controlled, car.engine_runs), 0.99) << interval << " s";
    EXPECT_EQ(source.rule.charge_begins, ControlMode::kVoltage);
  }
}

TEST(DetectControlMode, ANoisierCurrentSensorLowersTheLeastCurrent) {
  const double fine = detectControlMode(startStopCar(1.0, 0.1).series).rule.min_current;
  const double coarse = detectControlMode(startStopCar(1.0, 2.0).series).rule.min_current;
  EXPECT_LT(coarse, fine - 1.0);
  EXPECT_LT(fine, 0.0);
  EXPECT_GT(coarse, -20.0);
}

TEST(DetectControlMode, AChargersConstantCurrentAndConstantVoltageAreToldApart) {
  for (const double interval : {1.0, 5.0, 60.0}) {
    const Series series = benchCharge(interval);
    const ControlModes source = detectControlMode(series);
    std::vector<char> truth(series.size(), 0);
    for (std::size_t k = 0; k < series.size(); ++k)
      truth[k] = series.voltage[k] > 14.39 && series.current[k] > 1.0 && series.current[k] < 29.5;
    EXPECT_GT(agreement(source.voltage_controlled, truth), 0.95) << interval << " s";
    EXPECT_GT(source.share, 0.1);
  }
}

TEST(DetectControlMode, ARestAfterAChargerIsCurrentImposed) {
  const Series series = benchCharge(5.0);
  const ControlModes source = detectControlMode(series);
  EXPECT_EQ(source.voltage_controlled.back(), 0);
  const auto is_apart = [](const ControlModeTotals& totals) {
    return totals.reason == toString(ControlModeReason::kRestApart);
  };
  EXPECT_EQ(std::count_if(source.totals.begin(), source.totals.end(), is_apart), 1);
}

TEST(DetectControlMode, AProfilePlayedToABatteryIsCurrentImposedWhateverItsCurrents) {
  test::Random random(5);
  std::vector<double> wanted;
  for (int k = 0; k < 400; ++k) wanted.insert(wanted.end(), 50, random.uniform(-50.0, 40.0));
  const ControlModes source = detectControlMode(played(wanted, 0.01));
  EXPECT_TRUE(source.seen);
  EXPECT_EQ(source.share, 0.0);
  EXPECT_EQ(source.rule.charge_begins, ControlMode::kCurrent);
}

TEST(DetectControlMode, AVoltageHeldInDischargeToo) {
  Car car = startStopCar(1.0);
  test::Random random(11);
  for (std::size_t k = 0; k < car.series.size(); ++k) {
    if (car.series.current[k] < -60.0 || car.series.current[k] > -3.0) continue;
    car.series.current[k] = random.uniform(-45.0, -4.0);
    car.series.voltage[k] = 12.45 + 0.012 * random.normal();
  }
  // Heavy loads that no source carries, to know the battery by.
  for (std::size_t k = 5; k < car.series.size(); k += 60) {
    car.series.current[k] = -120.0 - static_cast<double>(k % 7) * 10.0;
    car.series.voltage[k] = 12.4 + 0.008 * car.series.current[k];
  }
  const ControlModes source = detectControlMode(car.series);
  EXPECT_LT(source.rule.min_current, -50.0);
  EXPECT_GT(source.share, 0.9);
}

TEST(DetectControlMode, EverySampleIsInOneReasonsTotalsAndNoTimeSpansAGap) {
  Car car = startStopCar(1.0);
  for (std::size_t k = 700; k < car.series.size(); ++k) car.series.time[k] += 3600.0;
  const ControlModes source = detectControlMode(car.series);
  std::size_t samples = 0;
  for (const ControlModeTotals& totals : source.totals) samples += totals.samples;
  EXPECT_EQ(samples, car.series.size());
  for (const ControlledTime& time : source.times) {
    const IndexRange range = indexRange(car.series, time.from, time.to);
    EXPECT_TRUE(range.first >= 700 || range.last <= 700);
    for (std::size_t k = range.first; k + 1 < range.last; ++k)
      EXPECT_TRUE(source.voltage_controlled[k]) << k;
  }
}

TEST(ControlModeDetector, JudgesACarAsTheWholeRecordingDoes) {
  const Car car = startStopCar(1.0);
  const ControlModes source = detectControlMode(car.series);
  EXPECT_EQ(watched(car.series, source.rule), source.voltage_controlled);
}

TEST(ControlModeDetector, LearnsOfAConstantVoltageOnlyAfterItHasSeenIt) {
  const Series series = benchCharge(5.0);
  const ControlModes source = detectControlMode(series);
  const auto live = watched(series, source.rule);
  EXPECT_GT(agreement(live, source.voltage_controlled), 0.9);
  EXPECT_NE(live, source.voltage_controlled);
}

TEST(ControlModeDetector, WithoutASourceEveryCurrentIsImposed) {
  ControlModeDetector watch{ControlModeRule{}};
  EXPECT_FALSE(watch.add(0.0, 30.0, 14.4));
  EXPECT_EQ(watch.reason(), ControlModeReason::kNoSource);
}

TEST(ControlModeDetector, ForgetsAConstantCurrentOverAGap) {
  ControlModeRule rule;
  rule.present = true;
  rule.current_noise = 0.01;
  rule.voltage_noise = 0.001;
  ControlModeDetector watch(rule);
  bool imposes = true;
  for (int k = 0; k < 20; ++k) imposes = watch.add(k, 30.0, 13.0 + 0.01 * k);
  EXPECT_FALSE(imposes);
  EXPECT_TRUE(watch.add(1000.0, 30.0, 13.5));
}

TEST(ControlModeDetector, RefusesWhatIsNotANumber) {
  ControlModeDetector watch{ControlModeRule{}};
  EXPECT_THROW(watch.add(0.0, std::numeric_limits<double>::quiet_NaN(), 12.0),
               std::invalid_argument);
  ControlModeRule rule;
  rule.voltage_noise = -1.0;
  EXPECT_THROW(ControlModeDetector{rule}, std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

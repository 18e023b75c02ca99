#include "simulator/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "simulator/scenario_file.hpp"
#include "support/circuit_truth.hpp"

namespace battery_sof_simulator {
namespace {

Scenario shipped(const std::string& name, std::uint64_t seed = 1) {
  Scenario scenario =
      loadScenario(std::string(BATTERY_SOF_SOURCE_DIR) + "/config/scenarios/" + name + ".yaml");
  scenario.seed = seed;
  return scenario;
}

/// Stretches below `current`, and their begins [s].
std::vector<double> fallsBelow(const std::vector<double>& currents, double current) {
  std::vector<double> begins;
  bool below = false;
  for (std::size_t n = 0; n < currents.size(); ++n) {
    if (!below && currents[n] < current)
      begins.push_back(static_cast<double>(n) * FullBattery::kStep);
    below = below ? currents[n] < 0.5 * current : currents[n] < current;
  }
  return begins;
}

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
    worst = std::max(worst, std::abs(a[n] - b[n]));
  return worst;
}

/// Largest change of SOC since the start, up and down.
double excursion(const Truth& truth) {
  const auto [low, high] = std::minmax_element(truth.soc.begin(), truth.soc.end());
  return std::max(*high - truth.soc.front(), truth.soc.front() - *low);
}

double longestAbove(const std::vector<double>& currents, double current) {
  std::size_t run = 0, longest = 0;
  for (double i : currents) longest = std::max(longest, run = i > current ? run + 1 : 0);
  return static_cast<double>(longest) * FullBattery::kStep;
}

void expectBalanced(const Balance& b, double soc_at_start, double soc_at_end) {
  const double taken = 3600.0 * 50.0 * (soc_at_end - soc_at_start);
  EXPECT_NEAR(b.charge_in, taken + b.gas_charge, 1e-4);
  EXPECT_NEAR(b.chargeError(), 0.0, 1e-6);
  EXPECT_LT(std::abs(b.energyError()), 1e-7 * b.throughput);
}

/// simulate() has the truth's ledger.
void expectSimulated(const Scenario& scenario, const Truth& truth, std::size_t samples) {
  const Simulation drive = simulate(scenario);
  EXPECT_EQ(drive.samples.size(), samples);
  EXPECT_EQ(drive.balance.charge_in, truth.balance.charge_in);
  EXPECT_EQ(drive.balance.gas_charge, truth.balance.gas_charge);
  EXPECT_EQ(drive.soc_at_end, truth.soc.back());
  expectBalanced(drive.balance, drive.soc_at_start, drive.soc_at_end);
}

TEST(DataSet1, HasFourteenPulsesAndStaysWithinOnePercentAndTheVoltageLimit) {
  for (std::uint64_t seed : {1, 2}) {
    const Scenario scenario = shipped("data_set_1", seed);
    const Truth truth = truthOf(scenario);
    if (seed == 1) expectSimulated(scenario, truth, 360000);
    expectBalanced(truth.balance, truth.soc.front(), truth.soc.back());
    EXPECT_EQ(truth.current.size(), 3600001u);
    EXPECT_EQ(fallsBelow(truth.current, -140.0).size(), 14u);
    EXPECT_GT(*std::min_element(truth.current.begin(), truth.current.end()), -300.1);
    EXPECT_LT(excursion(truth), 0.01);
    EXPECT_LE(*std::max_element(truth.voltage.begin(), truth.voltage.end()),
              scenario.voltage_limit + 1e-5);
    EXPECT_LT(longestAbove(truth.current, 0.0), 9.2);
  }
}

TEST(DataSet2, HasLongChargesInItsSecondHalfAndEndsIn130AmpereDischarge) {
  for (std::uint64_t seed : {1, 2}) {
    const Scenario scenario = shipped("data_set_2", seed);
    const Truth truth = truthOf(scenario);
    const auto& current = truth.current;
    if (seed == 1) expectSimulated(scenario, truth, 360000);
    expectBalanced(truth.balance, truth.soc.front(), truth.soc.back());
    const std::vector<double> first(current.begin(), current.begin() + 1800000);
    const std::vector<double> second(current.begin() + 1810000, current.begin() + 3530000);
    EXPECT_LT(longestAbove(first, 0.0), 9.2);
    EXPECT_GT(longestAbove(second, 20.0), 30.0);
    EXPECT_NEAR(current[3595000], -130.0, 0.1);
    EXPECT_NEAR(current[3560000], -45.0, 1e-9);
    EXPECT_LT(longestAbove({current.begin() + 3540500, current.begin() + 3594000}, -44.0), 1e-9);
    EXPECT_LT(excursion(truth), 0.0101);
    EXPECT_LE(*std::max_element(truth.voltage.begin(), truth.voltage.end()),
              scenario.voltage_limit + 1e-5);
  }
}

TEST(DataSet3, HasFiveCranksInSixMinutesAndAboutOneAmpereHourUnder14Point2Volt) {
  for (std::uint64_t seed : {1, 2}) {
    const Scenario scenario = shipped("data_set_3", seed);
    const Truth truth = truthOf(scenario);
    expectSimulated(scenario, truth, 120000);
    const auto cranks = fallsBelow(truth.current, -100.0);
    EXPECT_EQ(std::count_if(cranks.begin(), cranks.end(), [](double t) { return t < 360.0; }), 5);
    EXPECT_GT(cranks.size(), 8u);
    EXPECT_NEAR(truth.balance.charge_in / 3600.0, 1.0, 0.5);
    const double highest = *std::max_element(truth.voltage.begin(), truth.voltage.end());
    EXPECT_LE(highest, 14.2 + 1e-5);
    EXPECT_GT(highest, 14.1);
  }
}

TEST(Simulation, SameSeedGivesTheSameRecordingAndAnotherSeedAnother) {
  SimulationOptions minute;
  minute.cut_after = 60.0;
  const auto a = simulate(shipped("city_drive", 7), minute).samples;
  const auto b = simulate(shipped("city_drive", 7), minute).samples;
  const auto c = simulate(shipped("city_drive", 8), minute).samples;
  ASSERT_EQ(a.size(), 6000u);
  double other = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    ASSERT_EQ(a[n].current, b[n].current);
    ASSERT_EQ(a[n].voltage, b[n].voltage);
    other = std::max(other, std::abs(a[n].current - c[n].current));
  }
  EXPECT_GT(other, 5.0);
}

TEST(Simulation, CutDriveIsTheBeginningOfTheWholeOne) {
  SimulationOptions minutes;
  minutes.cut_after = 240.0;
  const auto cut = simulate(shipped("data_set_3"), minutes).samples;
  const auto whole = simulate(shipped("data_set_3")).samples;
  for (std::size_t n = 0; n < cut.size(); ++n) ASSERT_EQ(cut[n].voltage, whole[n].voltage) << n;
}

TEST(Simulation, HalvingTheStepChangesTheVoltageByLessThanHalfAMillivolt) {
  // Data set 2 up to its first long charges; the others repeat themselves.
  const std::pair<const char*, double> drives[] = {
      {"data_set_1", 600.0}, {"data_set_2", 2100.0}, {"data_set_3", 1200.0}, {"city_drive", 300.0}};
  for (const auto& [name, length] : drives) {
    const Scenario scenario = shipped(name);
    const Truth coarse = truthOf(scenario, 1, length), fine = truthOf(scenario, 2, length);
    ASSERT_EQ(coarse.voltage.size(), fine.voltage.size());
    EXPECT_LT(largestDifference(coarse.voltage, fine.voltage), 5e-4) << name;
  }
}

TEST(Simulation, ListedPhasesHoldAVoltageAndThenRest) {
  Scenario scenario = parseScenario(
      "{duration_s: 400, soc: 0.8, effects: {gassing: tafel, charge_acceptance: true}, profile: "
      "{kind: phases, phases: "
      "[{duration_s: 20, current_a: -20, to_current_a: -40}, {duration_s: 300, current_a: 80, "
      "voltage_limit_v: 14.4}, "
      "{duration_s: 1, current_a: 0}]}}",
      "test");
  const Truth truth = truthOf(scenario);
  EXPECT_NEAR(truth.current[10000], -30.0, 0.01);
  EXPECT_NEAR(truth.voltage[319000], 14.4, 1e-5);
  EXPECT_LT(truth.current[319000], 79.0);
  EXPECT_EQ(truth.current[400000], 0.0);
  EXPECT_GT(truth.balance.gas_charge, 0.0);
  expectSimulated(scenario, truth, 40000);
}

TEST(Simulation, SelfHeatingWarmsTheBatteryByTenthsOfAKelvinInTwentyMinutes) {
  Scenario scenario = shipped("data_set_3");
  scenario.effects.self_heating = true;
  const Simulation drive = simulate(scenario);
  EXPECT_GT(drive.temperature.back(), 20.2);
  EXPECT_LT(drive.temperature.back(), 21.5);
  EXPECT_EQ(drive.temperature.size(), drive.samples.size());
}

TEST(Simulation, ReportsProgressOnceASimulatedMinute) {
  SimulationOptions options;
  options.cut_after = 180.5;
  std::vector<double> times;
  options.progress = [&](double time) { times.push_back(time); };
  simulate(shipped("city_drive"), options);
  ASSERT_EQ(times.size(), 3u);
  EXPECT_NEAR(times[2], 180.0, 0.01);
}

TEST(Simulation, AnInsertPlaysItsPhasesAndTheProfileGoesOn) {
  Scenario scenario = shipped("data_set_1");
  scenario.duration = 120.0;
  scenario.inserts = {{30.0, {{40.0, 0.0, 0.0}}}};
  const auto currents = truthOf(scenario).current;
  const auto longest = [&](double from, double to) {
    std::size_t run = 0, most = 0;
    for (auto n = static_cast<std::size_t>(from * 1e3); n < static_cast<std::size_t>(to * 1e3); ++n)
      most = std::max(most, run = currents[n] == 0.0 ? run + 1 : 0);
    return static_cast<double>(most) * FullBattery::kStep;
  };
  EXPECT_LT(longest(0.0, 30.0), 10.0);
  EXPECT_NEAR(longest(30.0, 90.0), 40.0, 4.5);
  EXPECT_LT(longest(90.0, 120.0), 10.0);
}

}  // namespace
}  // namespace battery_sof_simulator

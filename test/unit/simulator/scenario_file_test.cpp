#include "simulator/scenario_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

namespace battery_sof_simulator {
namespace {

namespace fs = std::filesystem;

std::string refusalOf(const std::string& text) {
  try {
    parseScenario(text, "wrong.yaml");
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ScenarioFile, EveryShippedScenarioLoads) {
  int count = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(BATTERY_SOF_SOURCE_DIR) / "config" / "scenarios")) {
    EXPECT_NO_THROW(EXPECT_EQ(loadScenario(entry.path()).name, entry.path().stem()))
        << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

TEST(ScenarioFile, WhatIsLeftOutKeepsItsDefault) {
  const Scenario scenario = parseScenario("profile: {kind: alternating, pulse_count: 3}", "test");
  EXPECT_EQ(scenario.duration, Scenario{}.duration);
  EXPECT_EQ(scenario.battery.beta_per_v, BatteryParameters{}.beta_per_v);
  const auto& turns = std::get<AlternatingOptions>(scenario.profile);
  EXPECT_EQ(turns.pulses.count, 3);
  EXPECT_EQ(turns.charge_a.high, 42.0);
}

TEST(ScenarioFile, GivenValuesArriveWhereTheyBelong) {
  const Scenario s = parseScenario(
      "{name: x, seed: 18446744073709551615, duration_s: 12, voltage_limit_v: 13.9, soc: 0.6, "
      "temperature_degc: -5,\n"
      " battery: {i0_a: 2.0}, effects: {gassing: tafel, cpe1: false}, acquisition: "
      "{voltage_white_v: 0.5},\n"
      " profile: {kind: long_charges, charge_a: [1, 2], final_peak_a: 99}}",
      "test");
  EXPECT_EQ(s.seed, 18446744073709551615ULL);
  EXPECT_EQ(s.start.temperature, -5.0);
  EXPECT_EQ(s.battery.i0_a, 2.0);
  EXPECT_EQ(s.effects.gassing, GassingLaw::kTafel);
  EXPECT_FALSE(s.effects.cpe1);
  EXPECT_EQ(s.acquisition.voltage_noise.white, 0.5);
  const auto& charges = std::get<LongChargesOptions>(s.profile);
  EXPECT_EQ(charges.turns.charge_a.high, 2.0);
  EXPECT_EQ(charges.final_peak_a, 99.0);
}

TEST(ScenarioFile, AdditionsAndInsertsArriveWhereTheyBelong) {
  const Scenario s = parseScenario(
      "{additions: {parameter_drift: true, drifting: u0, acid_1_ohm: 0.001},\n"
      " acquisition: {current_limit_a: 200},\n"
      " inserts: [{at_s: 30, phases: [{duration_s: 60, current_a: 0}]}],\n"
      " profile: {kind: city_drive}}",
      "test");
  EXPECT_TRUE(s.additions.parameter_drift);
  EXPECT_EQ(s.additions.drifting, DriftingParameter::kU0);
  EXPECT_EQ(s.additions.acid_1_ohm, 0.001);
  EXPECT_EQ(s.acquisition.current_limit_a, 200.0);
  ASSERT_EQ(s.inserts.size(), 1u);
  EXPECT_EQ(s.inserts[0].at, 30.0);
  EXPECT_EQ(s.inserts[0].phases.at(0).duration, 60.0);
}

TEST(ScenarioFile, AllFaultsAreListedAtOnce) {
  const std::string message = refusalOf(
      "{durations_s: 5, duration_s: -1, soc: 80, seed: -3, battery: {beta: 20, alpha: 2, i0_a: "
      "much},\n"
      " effects: {gassing: yes, cpe1: perhaps}, acquisition: {cutoff_hz: .nan},\n"
      " profile: {kind: city_drive, stop_s: [9, 3], crank_a: 5, rest_s: [1, 2]}}");
  for (const char* piece :
       {"wrong.yaml", "durations_s is not a known key", "duration_s is -1", "soc is 80",
        "seed is \"-3\"", "battery.beta is not a known key", "battery.alpha is 2",
        "battery.i0_a is \"much\"", "effects.gassing is \"yes\"", "effects.cpe1 is \"perhaps\"",
        "acquisition.cutoff_hz is nan", "profile.stop_s begins above its end",
        "profile.crank_a is something else, expected two numbers",
        "profile.rest_s is not a known key"})
    EXPECT_NE(message.find(piece), std::string::npos) << piece << "\nnot in: " << message;
}

TEST(ScenarioFile, EachOfTheseIsRefusedWithItsReason) {
  const std::map<std::string, std::string> wrong = {
      {"", "expected a map"},
      {"[1, 2]", "expected a map"},
      {"{a: [", "not readable as YAML"},
      {"{duration_s: 10}", "profile.kind is missing"},
      {"profile: {kind: motorway}", "profile.kind is motorway"},
      {"profile: alternating", "profile is \"alternating\", expected a map"},
      {"{profile: {kind: alternating}, battery: 3}", "battery is \"3\", expected a map"},
      {"profile: {kind: alternating, pulse_count: 2.5}",
       "profile.pulse_count is \"2.5\", expected a whole number"},
      {"{profile: {kind: alternating}, seed: 1, seed: 2}", "seed is given twice"},
      {"profile: {kind: phases}", "expected a list of phases"},
      {"profile: {kind: phases, phases: [{duration_s: 1}]}",
       "profile.phases[0].current_a is missing"},
      {"profile: {kind: phases, phases: [{current_a: 1, duration_s: 0}]}",
       "phases[0].duration_s is 0"},
      {"profile: {kind: long_charges, final_hold_s: 60}", "final_hold_s is not below final_s"},
      {"{profile: {kind: alternating}, acquisition: {sample_rate_hz: 300}}",
       "1000 divided by a whole number"},
      {"{profile: {kind: alternating}, battery: {r1_charge_ohm: 0.05, r1_transition_a: 1}}",
       "falls while its current"},
      {"{profile: {kind: alternating}, additions: {drifting: soc}}",
       "additions.drifting is \"soc\", expected r_ohmic, r1, cpe2_capacitance or u0"},
      {"{profile: {kind: alternating}, additions: {acid_1_time_s: 0}}",
       "additions.acid_1_time_s is 0"},
      {"{profile: {kind: alternating}, inserts: 3}", "inserts is \"3\", expected a list"},
      {"{profile: {kind: alternating}, inserts: [{at_s: -1, phases: []}]}",
       "inserts[0].at_s is -1"},
      {"{profile: {kind: alternating}, acquisition: {voltage_floor_v: 15, voltage_ceiling_v: 9}}",
       "voltage_floor_v is not below voltage_ceiling_v"},
  };
  for (const auto& [text, reason] : wrong)
    EXPECT_NE(refusalOf(text).find(reason), std::string::npos)
        << text << "\ngave: " << refusalOf(text);
}

TEST(ScenarioFile, AFileThatIsNotThereIsNamed) {
  EXPECT_THROW(loadScenario("no such scenario.yaml"), ScenarioError);
  EXPECT_THROW(loadScenario(fs::temp_directory_path()), ScenarioError);
}

}  // namespace
}  // namespace battery_sof_simulator

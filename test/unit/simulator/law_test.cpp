#include "simulator/generator/law_scenario.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "simulator/generator/series.hpp"
#include "support/circuit_truth.hpp"
#include "support/drawn_scenarios.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = LawBattery::kStep;

Scenario plainScenario(double duration = 60.0) {
  Scenario s;
  s.seed = 5;
  s.duration = duration;
  s.effects = plainCircuit();
  s.profile = AlternatingOptions{};
  return s;
}

Circumstances usual() {
  Circumstances drive;
  drive.duration = 60.0;
  drive.onset_low_v = 12.72;
  drive.onset_high_v = 12.75;
  return drive;
}

Law drawn(const LawForm& form) {
  Dice dice(3, 1);
  return form.draw(dice, usual());
}

std::vector<LawForm> lawsOf(const std::string& mechanism) {
  std::vector<LawForm> forms;
  for (const LawForm& form : lawForms())
    if (form.mechanism == mechanism) forms.push_back(form);
  return forms;
}

/// All laws that are physics.
std::vector<LawForm> physics() {
  std::vector<LawForm> forms;
  for (const LawForm& form : lawForms())
    if (form.mechanism != "instrument") forms.push_back(form);
  return forms;
}

/// The law's voltage under currents that are held for a while each, at the end of each [V].
std::vector<double> heldVoltages(const Law& law, const std::vector<double>& currents,
                                 double seconds) {
  Law::State state = law.rested;
  LawInstant now;
  std::vector<double> voltages;
  for (double current : currents) {
    now.current = current;
    for (long n = 0; n < std::lround(seconds / kStep); ++n) {
      state = law.advance(state, now);
      now.time += kStep;
      now.charge += current * kStep;
    }
    voltages.push_back(law.voltage(state, now));
  }
  return voltages;
}

Order orderOf(const ScenarioKind& kind, std::uint64_t seed) {
  Order order = orderOf(kind, seed, 240.0);
  order.rate = 10.0;
  return order;
}

double rmsAboutMean(const std::vector<double>& values) {
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / values.size();
  double square = 0.0;
  for (double value : values) square += (value - mean) * (value - mean);
  return std::sqrt(square / values.size());
}

TEST(Laws, EveryMechanismHasThreeOrMore) {
  std::map<std::string, int> laws;
  for (const ScenarioKind& kind : scenarioKinds()) ++laws[kind.mechanism];
  for (const char* mechanism : {"acceptance", "side_reactions", "acid", "open_circuit", "structure",
                                "ageing", "instrument"})
    EXPECT_GE(laws[mechanism], 3) << mechanism;
}

TEST(Laws, WithoutStrengthEachIsTheBaseCircuitBitForBit) {
  const Scenario scenario = plainScenario();
  const Truth truth = truthOf(scenario);
  for (const auto& form : physics()) {
    const Law law = drawn(form);
    const Course none = drivenCourse(scenario, &law, 0.0);
    ASSERT_EQ(none.current, truth.current) << form.id;
    ASSERT_EQ(none.voltage, truth.voltage) << form.id;
  }
}

TEST(Laws, WithStrengthEachMovesTheVoltage) {
  const Scenario scenario = plainScenario();
  const Course none = drivenCourse(scenario, nullptr, 0.0);
  for (const auto& form : physics()) {
    const Law law = drawn(form);
    const Course with = controlledCourse(scenario, &law, 1.0, none.current);
    std::vector<double> moved;
    for (std::size_t n = 0; n < with.voltage.size(); ++n)
      moved.push_back(with.voltage[n] - none.voltage[n]);
    EXPECT_GT(rmsAboutMean(moved), 0.1e-3) << form.id;
    EXPECT_LT(rmsAboutMean(moved), 0.3) << form.id;
  }
}

TEST(Laws, AcceptanceCostsVoltageWhileChargingAndLessAfterADischarge) {
  for (const auto& form : lawsOf("acceptance")) {
    const Law law = drawn(form);
    const auto tired = heldVoltages(law, {20.0, 20.0, 20.0, 20.0}, 15.0);
    const auto refreshed = heldVoltages(law, {20.0, 20.0, -60.0, 20.0}, 15.0);
    EXPECT_GT(tired.back(), 0.0) << form.id;
    EXPECT_LT(refreshed.back(), tired.back()) << form.id;
  }
}

TEST(Laws, SideReactionsNeedAHighVoltage) {
  for (const auto& form : lawsOf("side_reactions")) {
    const Law law = drawn(form);
    Law::State low = law.rested, high = law.rested;
    LawInstant below, above;
    below.current = above.current = 20.0;
    below.u_x = usual().onset_low_v - 0.01;
    above.u_x = usual().onset_high_v + 0.1;
    for (int n = 0; n < 20000; ++n) {
      low = law.advance(low, below);
      high = law.advance(high, above);
    }
    EXPECT_EQ(law.sideCurrent(low, below), 0.0) << form.id;
    EXPECT_NEAR(law.voltage(low, below), 0.0, 1e-12) << form.id;
    EXPECT_GT(law.sideCurrent(high, above), 0.1) << form.id;
  }
}

TEST(Laws, ASideCurrentPassesTheDoubleLayerByAndNotTheResistance) {
  Law law;
  law.sideCurrent = [](const Law::State&, const LawInstant&) { return 1.0; };
  const Scenario scenario = plainScenario();
  std::vector<double> current(600001, 10.0);
  current[0] = 0.0;
  const double with = controlledCourse(scenario, &law, 1.0, current).voltage.back();
  const double none = controlledCourse(scenario, nullptr, 0.0, current).voltage.back();
  const double half = 0.5 * scenario.battery.beta_per_v;  // of a settled u2 = asinh(i / 2) / half
  EXPECT_NEAR(with - none, (std::asinh(4.5) - std::asinh(5.0)) / half, 1e-5);
}

TEST(Laws, OpenCircuitLawsFollowTheChargeAndNotTheTime) {
  for (const auto& form : lawsOf("open_circuit")) {
    const Law law = drawn(form);
    const auto fast = heldVoltages(law, {40.0, -60.0, 30.0, -10.0, 50.0}, 10.0);
    const auto slow = heldVoltages(law, {20.0, -30.0, 15.0, -5.0, 25.0}, 20.0);
    for (std::size_t k = 0; k < fast.size(); ++k)
      EXPECT_NEAR(fast[k], slow[k], 2e-4) << form.id << " " << k;
    EXPECT_GT(rmsAboutMean(fast), 1e-3) << form.id;
  }
}

TEST(Laws, HysteresisIsNotAFunctionOfTheCharge) {
  for (const char* id : {"sum_of_plays", "preisach_parts"}) {
    const Law law = drawn(lawNamed("open_circuit", id));
    const auto loop = heldVoltages(law, {50.0, -100.0, 50.0, 50.0, -50.0}, 10.0);
    EXPECT_GT(std::abs(loop[2] - loop[4]), 1e-3) << id;  // both at no charge, from below and above
  }
}

TEST(Laws, AnomalousDiffusionAnswersAStepWithAPowerOfTime) {
  Circumstances drive = usual();
  drive.duration = 3600.0;
  Dice dice(3, 1);
  const Law law = lawNamed("acid", "anomalous_diffusion").draw(dice, drive);
  const auto answer = heldVoltages(law, std::vector<double>(128, -20.0), 2.0);
  const double early = std::log(answer[7] / answer[3]) / std::log(2.0);   // 8 to 16 s
  const double late = std::log(answer[63] / answer[31]) / std::log(2.0);  // 64 to 128 s
  EXPECT_GT(early, 0.25);
  EXPECT_LT(early, 0.75);
  EXPECT_NEAR(late, early, 0.12);
}

TEST(Laws, TheSeparatorIsSilentFirst) {
  const auto answer =
      heldVoltages(drawn(lawNamed("acid", "separator_delay")), std::vector<double>(60, 20.0), 5.0);
  EXPECT_LT(answer.front(), 0.5 * answer.back());
  double longest = 0.0;
  for (std::size_t k = 1; k < answer.size(); ++k)
    longest = std::max(longest, answer[k] - answer[k - 1]);
  EXPECT_GT(longest, answer.front());  // the steepest rise comes later, unlike a low pass'
}

TEST(Laws, AgeingBeginsAtNothing) {
  for (const auto& form : lawsOf("ageing")) {
    LawInstant now;
    now.current = 30.0;
    now.u2 = 0.1;
    const Law law = drawn(form);
    EXPECT_NEAR(law.voltage(law.rested, now), 0.0, 1e-9) << form.id;
  }
}

TEST(InstrumentLaws, AtNoStrengthShowTheTruth) {
  const Course truth = drivenCourse(plainScenario(), nullptr, 0.0);
  for (const auto& form : lawsOf("instrument")) {
    Dice dice(2, 1);
    const Law instrument = form.draw(dice, usual());
    const Course same = instrument.shown(truth, 0.0), other = instrument.shown(truth, 1.0);
    EXPECT_EQ(same.current, truth.current) << form.id;
    EXPECT_EQ(same.voltage, truth.voltage) << form.id;
    EXPECT_TRUE(other.current != truth.current || other.voltage != truth.voltage) << form.id;
  }
}

TEST(LawDrives, EveryKindChargesAndDischargesInBothParts) {
  for (const std::string kind : kLawDrives) {
    Scenario scenario = plainScenario(600.0);
    Dice dice(4, 1);
    drawLawDrive(scenario, kind, "", dice);
    const Course course = drivenCourse(scenario, nullptr, 0.0);
    const auto split =
        course.current.begin() + static_cast<long>(kTrainingShare * course.current.size());
    for (const auto& [from, to] :
         {std::pair{course.current.begin(), split}, {split, course.current.end()}}) {
      EXPECT_LT(*std::min_element(from, to), -5.0) << kind;
      EXPECT_GT(*std::max_element(from, to), 5.0) << kind;
    }
  }
  Scenario scenario = plainScenario();
  Dice dice(4, 1);
  EXPECT_THROW(drawLawDrive(scenario, "regatta", "", dice), std::invalid_argument);
}

TEST(LinearBetweenSamples, KeepsAStraightLineAndTheChargeOfAPulse) {
  std::vector<double> line(1001), pulse(2001, 0.0);
  for (std::size_t n = 0; n < line.size(); ++n) line[n] = 0.01 * static_cast<double>(n);
  const auto same = linearBetweenSamples(line, 100);
  for (std::size_t n = 0; n + 100 < same.size(); ++n) EXPECT_NEAR(same[n], line[n], 1e-9);
  std::fill(pulse.begin() + 520, pulse.begin() + 580, 30.0);
  const auto smeared = linearBetweenSamples(pulse, 100);
  EXPECT_NEAR(std::accumulate(smeared.begin(), smeared.end(), 0.0), 60 * 30.0, 0.02 * 60 * 30.0);
}

TEST(ErrorSize, WhatOtherBaseParametersExplainIsNotVisible) {
  Scenario scenario = plainScenario(300.0), other = scenario;
  const std::vector<double> current =
      linearBetweenSamples(drivenCourse(scenario, nullptr, 0.0).current, 100);
  other.battery.cpe2_capacitance_f *= 1.02;
  other.battery.beta_per_v *= 0.98;
  other.battery.r1_charge_ohm *= 1.05;
  other.battery.u0_v += 0.02;
  const BaseAnswer base = baseAnswer(scenario, current, 100),
                   moved = baseAnswer(other, current, 100);
  std::vector<double> error;
  for (std::size_t n = 0; n < base.voltage.size(); ++n)
    error.push_back(moved.voltage[n] - base.voltage[n]);
  const ErrorSize size = errorSize(error, base);
  EXPECT_GT(size.plain.training, 1e-3);
  EXPECT_LT(size.visible.training, 0.03 * size.plain.training);
  EXPECT_LT(size.visible.holdout, 0.05 * size.plain.holdout);
}

TEST(ErrorSize, ACranksShiftIsThatOfItsMinimum) {
  BaseAnswer base;
  for (double current : {-10.0, -150.0, -200.0, -150.0, -10.0, -120.0, 5.0, 5.0}) {
    base.voltage.push_back(12.0 + 0.01 * current);
    base.columns.push_back({1.0, std::max(current, 0.0), std::min(current, 0.0), 0.0, 0.0, 0.0});
  }
  // 20 mV off beside the first minimum, 5 mV at it; 3 mV at the second crank, 50 mV at none.
  const std::vector<double> error{0.05, 0.02, -0.005, 0.02, 0.05, 0.003, 0.05, 0.05};
  EXPECT_NEAR(errorSize(error, base).crank_v, 0.005, 1e-12);
}

TEST(LawScenarios, TheSameOrderGivesTheSameSamplesAndAnotherSeedOthers) {
  for (const char* kind : {kControl, kRecorderControl, kOutOfCatalogue}) {
    const Order order = orderOf({kind, "", ""}, 11);
    const LawScenario once = drawLawScenario(order), again = drawLawScenario(order);
    const LawScenario other = drawLawScenario(orderOf({kind, "", ""}, 12));
    ASSERT_EQ(once.samples.size(), again.samples.size());
    ASSERT_EQ(once.samples.size(), 2400u);
    bool differs = false;
    for (std::size_t n = 0; n < once.samples.size(); ++n) {
      ASSERT_EQ(once.samples[n].voltage, again.samples[n].voltage) << kind;
      ASSERT_EQ(once.samples[n].current, again.samples[n].current) << kind;
      differs |= once.samples[n].voltage != other.samples[n].voltage;
    }
    EXPECT_TRUE(differs) << kind;
  }
}

/// The recorded voltage less the base circuit's under the recorded current [V].
std::vector<double> recordedError(const LawScenario& one) {
  const auto per_sample = static_cast<std::size_t>(std::lround(1.0 / (kStep * *one.order.rate)));
  std::vector<double> current((one.samples.size() - 1) * per_sample + 1), error;
  for (std::size_t n = 0; n < current.size(); ++n) {
    const std::size_t k = n / per_sample, next = std::min(k + 1, one.samples.size() - 1);
    const double share = static_cast<double>(n % per_sample) / static_cast<double>(per_sample);
    current[n] =
        one.samples[k].current + share * (one.samples[next].current - one.samples[k].current);
  }
  const Course base = controlledCourse(one.scenario, nullptr, 0.0, current);
  for (std::size_t k = 0; k < one.samples.size(); ++k)
    error.push_back(one.samples[k].voltage - base.voltage[k * per_sample]);
  return error;
}

TEST(LawScenarios, TheLabelledSizeOfEveryLawIsTheRecordings) {
  for (const ScenarioKind& kind : scenarioKinds()) {
    if (kind.kind != kOutOfCatalogue) continue;
    const LawScenario one = drawLawScenario(orderOf(kind, 21));
    std::vector<double> error = recordedError(one);
    error.resize(static_cast<std::size_t>(kTrainingShare * static_cast<double>(error.size())));
    const double noise = std::hypot(one.voltage_noise.white, one.voltage_step_v / std::sqrt(12.0));
    EXPECT_NEAR(rmsAboutMean(error), std::hypot(one.size.plain.training, noise),
                0.05 * one.size.plain.training + 0.2e-3)
        << kind.id;
    EXPECT_LE(one.size.visible.training, one.size.plain.training * 1.001) << kind.id;
    EXPECT_GE(one.size.visible.training, kVisible.low) << kind.id;
    EXPECT_GE(one.size.visible.training, kMinOverNoise * one.voltage_noise.white) << kind.id;
    EXPECT_LE(one.size.visible.training, 80e-3) << kind.id;
    EXPECT_GE(one.size.visible.holdout, 0.4 * one.size.visible.training) << kind.id;
  }
}

TEST(LawScenarios, AtScaleZeroALawIsTheBaseCircuitWithNoise) {
  std::string mechanism = "-";
  for (const ScenarioKind& kind : scenarioKinds()) {
    if (kind.mechanism == mechanism) continue;  // one of each
    mechanism = kind.mechanism;
    Order order = orderOf(kind, 21);
    order.scale = {0.0};
    const LawScenario one = drawLawScenario(order);
    EXPECT_EQ(one.strength, 0.0) << kind.id;
    EXPECT_LT(one.size.plain.training, 1e-9) << kind.id;
    EXPECT_LT(rmsAboutMean(recordedError(one)), 3e-3) << kind.id;
  }
}

TEST(LawScenarios, AControlIsTheBaseCircuitWithWhiteNoise) {
  const LawScenario one = drawLawScenario(orderOf({kControl}, 31));
  const std::vector<double> error = recordedError(one);
  EXPECT_NEAR(rmsAboutMean(error), one.voltage_noise.white, 0.05 * one.voltage_noise.white);
  double product = 0.0, square = 0.0;
  for (std::size_t n = 1; n < error.size(); ++n) {
    product += error[n] * error[n - 1];
    square += error[n] * error[n];
  }
  EXPECT_LT(std::abs(product / square), 0.06);  // 3 standard errors of 2400 samples
  EXPECT_GE(one.voltage_noise.white, 2e-3);
  EXPECT_LE(one.voltage_noise.white, 5e-3);
}

TEST(LawScenarios, ARecorderLeavesLittleAndNotNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const LawScenario one = drawLawScenario(orderOf({kRecorderControl}, seed));
    EXPECT_LE(one.size.visible.training, kMaxImperfection);
    EXPECT_LE(one.size.crank_v, kMaxCrankImperfection);
    EXPECT_GT(one.size.visible.training, 0.0);
    ASSERT_TRUE(one.recorder);
    EXPECT_NE(one.recorder->voltage.step, 0.0);
  }
}

TEST(LawScenarios, OrdersThatCannotBeAreRefused) {
  const auto refused = [](void (*spoil)(Order&)) {
    Order order = orderOf({kOutOfCatalogue, "", ""}, 1);
    spoil(order);
    EXPECT_THROW(drawLawScenario(order), std::invalid_argument);
  };
  refused([](Order& o) { o.what.kind = "friend"; });
  refused([](Order& o) { o.what.mechanism = "acid", o.what.id = "bent_emf"; });
  refused([](Order& o) { o.rate = 3.0; });
  refused([](Order& o) { o.duration = 10.0; });
  refused([](Order& o) { o.scale = {-1.0}; });
  refused([](Order& o) { o.drive = "regatta"; });
}

}  // namespace
}  // namespace battery_sof_simulator

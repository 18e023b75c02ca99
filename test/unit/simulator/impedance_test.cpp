#include "simulator/impedance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace battery_sof_simulator {
namespace {

using Complex = std::complex<double>;

BatteryEffects withChargeAcceptance() {
  BatteryEffects effects;
  effects.charge_acceptance = true;
  return effects;
}

/// Impedance seen by a small alternating current around zero, in the time domain.
Complex injected(const BatteryEffects& effects, double frequency, double settle, int cycles) {
  const FullBattery battery(BatteryParameters{}, effects, {0.8, 25.0});
  const double w = 2.0 * M_PI * frequency, amplitude = 0.02;
  const long skipped = std::lround(settle / FullBattery::kStep);
  const long counted = std::lround(cycles / frequency / FullBattery::kStep);
  const double rest = battery.voltage(battery.rested());
  BatteryState state = battery.rested();
  Complex voltage = 0.0;
  for (long n = 1; n <= skipped + counted; ++n) {
    const double phase = w * static_cast<double>(n) * FullBattery::kStep;
    state = battery.advance(state, amplitude * std::sin(phase));
    if (n > skipped) voltage += (battery.voltage(state) - rest) * std::polar(1.0, -phase);
  }
  return voltage * 2.0 / static_cast<double>(counted) * Complex(0.0, 1.0) / amplitude;
}

TEST(Impedance, LinearisedModelIsWithinOnePercentOfTheAnalyticExpression) {
  const auto frequencies = logarithmicFrequencies(1e-3, 100.0, 20);
  for (double current : {-10.0, 0.0, 10.0})
    for (double soc : {0.2, 0.9})
      for (double temperature : {-25.0, 25.0, 40.0})
        for (const auto& effects : {BatteryEffects{}, withChargeAcceptance()})
          for (const auto& point : impedance({}, effects, {soc, temperature}, current, frequencies))
            ASSERT_LT(std::abs(point.simulated / point.analytic - 1.0), 0.01)
                << point.frequency << " Hz, " << current << " A, SOC " << soc << ", "
                << temperature;
}

TEST(Impedance, AlternatingCurrentInTheTimeDomainMeetsTheAnalyticExpression) {
  for (const auto& effects : {BatteryEffects{}, withChargeAcceptance()})
    for (double frequency : {0.01, 1.0, 10.0}) {
      const Complex analytic = impedance({}, effects, {0.8, 25.0}, 0.0, {frequency})[0].analytic;
      const Complex measured = injected(effects, frequency, frequency < 0.1 ? 500.0 : 200.0, 4);
      EXPECT_LT(std::abs(measured / analytic - 1.0), 0.01)
          << frequency << " Hz: " << measured << analytic;
    }
}

TEST(Impedance, RealPartIsPositiveEverywhere) {
  for (double current : {-100.0, -10.0, 0.0, 10.0})
    for (const auto& point : impedance({}, withChargeAcceptance(), {0.8, 25.0}, current,
                                       logarithmicFrequencies(1e-3, 1e3, 10)))
      EXPECT_GT(point.simulated.real(), 0.0) << point.frequency << " Hz at " << current << " A";
}

TEST(Impedance, PlainCircuitIsAResistanceAndOneSemicircle) {
  const BatteryParameters p;
  const double w = 2.0 * M_PI * 0.02;
  const Complex z = impedance(p, plainCircuit(), {0.8, 25.0}, 0.0, {0.02})[0].simulated;
  const Complex expected = p.r_ohmic_ohm + p.r1_charge_ohm +
                           1.0 / Complex(p.i0_a * p.beta_per_v, w * p.cpe2_capacitance_f);
  EXPECT_NEAR(std::abs(z - expected), 0.0, 1e-12);
}

TEST(Impedance, RefusesACurrentThatNoChargeCanLastAt) {
  BatteryEffects effects = withChargeAcceptance();
  effects.gassing = GassingLaw::kNone;
  EXPECT_THROW(impedance({}, effects, {0.8, 25.0}, 100.0, {1.0}), std::invalid_argument);
  EXPECT_THROW(impedance({}, effects, {0.8, 25.0}, 0.0, {0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof_simulator

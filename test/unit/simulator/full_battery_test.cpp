#include "simulator/full_battery.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/refusal.hpp"

namespace battery_sof_simulator {
namespace {

/// A minute of everything: rest, charge, pulse, long discharge, reversals; linear ramps of at most
/// 3 kA/s.
double currentAt(double time) {
  const double wanted = time < 1.0    ? 0.0
                        : time < 15.0 ? 40.0
                        : time < 16.0 ? -280.0
                        : time < 30.0 ? -45.0
                        : time < 45.0 ? 60.0 - time
                                      : 25.0 * std::sin(time);
  return wanted;
}

/// Calls `each` with every state of the drive, the current slewing.
BatteryState drive(const FullBattery& battery,
                   const std::function<void(const BatteryState&)>& each) {
  BatteryState state = battery.rested();
  for (int n = 1; n <= 60000; ++n) {
    const double change = currentAt(n * FullBattery::kStep) - state.current;
    state = battery.advance(state, state.current + std::clamp(change, -3.0, 3.0));
    each(state);
  }
  return state;
}

BatteryEffects everything() {
  BatteryEffects effects;
  effects.gassing = GassingLaw::kTafel;
  effects.charge_acceptance = effects.self_heating = true;
  return effects;
}

/// Fig. 3 by the classical Runge-Kutta method, ten times finer.
class PlainCircuit {
 public:
  double voltageAfter(double current_end) {
    constexpr int kParts = 10;
    const double begin = current_;
    for (int k = 0; k < kParts; ++k) {
      const double a = begin + (current_end - begin) * k / kParts;
      const double b = begin + (current_end - begin) * (k + 1) / kParts;
      step(a, b, FullBattery::kStep / kParts);
    }
    current_ = current_end;
    const double r = p_.r_ohmic_ohm + (current_ < 0.0 ? p_.r1_discharge_ohm : p_.r1_charge_ohm);
    return p_.u0_v + r * current_ + u_;
  }

 private:
  double rate(double u, double current) const {
    return (current - 2.0 * p_.i0_a * std::sinh(0.5 * p_.beta_per_v * u)) / p_.cpe2_capacitance_f;
  }
  void step(double a, double b, double h) {
    const double middle = 0.5 * (a + b);
    const double k1 = rate(u_, a), k2 = rate(u_ + 0.5 * h * k1, middle);
    const double k3 = rate(u_ + 0.5 * h * k2, middle), k4 = rate(u_ + h * k3, b);
    u_ += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  BatteryParameters p_;
  double u_ = 0.0, current_ = 0.0;
};

TEST(FullBattery, WithEveryEffectOffItIsThePlainCircuit) {
  const FullBattery battery({}, plainCircuit(), {0.8, 25.0});
  PlainCircuit plain;
  double worst = 0.0;
  drive(battery, [&](const BatteryState& state) {
    worst = std::max(worst, std::abs(battery.voltage(state) - plain.voltageAfter(state.current)));
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(FullBattery, HalvingTheStepChangesTheVoltageByLessThanATenthOfAMillivolt) {
  for (const auto& effects : {BatteryEffects{}, everything()}) {
    std::vector<double> coarse;
    const FullBattery battery({}, effects, {0.8, 20.0}), finer({}, effects, {0.8, 20.0}, 2);
    drive(battery, [&](const BatteryState& state) { coarse.push_back(battery.voltage(state)); });
    std::size_t n = 0;
    double worst = 0.0;
    drive(finer, [&](const BatteryState& state) {
      worst = std::max(worst, std::abs(finer.voltage(state) - coarse[n++]));
    });
    EXPECT_LT(worst, 1e-4);
  }
}

TEST(FullBattery, ChargeInIsChangeOfStateOfChargeAndGassing) {
  const FullBattery battery({}, everything(), {0.8, 20.0});
  EnergyLedger ledger(battery, battery.rested());
  const BatteryState end = drive(battery, [&](const BatteryState& state) { ledger.enter(state); });
  const Balance& b = ledger.balance();
  EXPECT_GT(b.gas_charge, 0.0);
  EXPECT_NEAR(b.main_charge, 3600.0 * 50.0 * (battery.soc(end) - 0.8), 1e-6);
  EXPECT_NEAR(b.chargeError(), 0.0, 1e-7);
}

TEST(FullBattery, EnergyInIsStoredOrLost) {
  for (const auto& effects : {plainCircuit(), BatteryEffects{}, everything()}) {
    const FullBattery battery({}, effects, {0.8, 20.0});
    EnergyLedger ledger(battery, battery.rested());
    drive(battery, [&](const BatteryState& state) { ledger.enter(state); });
    const Balance& b = ledger.balance();
    EXPECT_LT(std::abs(b.energyError()), 1e-6 * b.throughput);
    EXPECT_LT(std::abs(b.energyError()), 1e-4 * b.lost.total());
  }
}

TEST(FullBattery, NoElementGeneratesEnergy) {
  const FullBattery battery({}, everything(), {0.8, 20.0});
  drive(battery, [&](const BatteryState& state) {
    const Losses l = battery.losses(state);
    for (double loss : {l.r_ohmic, l.r1, l.cpe1, l.charge_transfer, l.lead_ion, l.cpe2, l.gassing})
      ASSERT_GE(loss, -1e-12);
    const StoredEnergy s = battery.stored(state);
    for (double stored : {s.inductance, s.cpe1, s.cpe2, s.lead_ion}) ASSERT_GE(stored, -1e-12);
  });
}

TEST(FullBattery, EveryEffectMakesADifference) {
  const FullBattery full({}, everything(), {0.8, 20.0});
  std::vector<double> reference;
  drive(full, [&](const BatteryState& state) { reference.push_back(full.voltage(state)); });
  for (bool BatteryEffects::*effect :
       {&BatteryEffects::inductance, &BatteryEffects::r1_asymmetry, &BatteryEffects::r1_smooth,
        &BatteryEffects::r1_current_dependence, &BatteryEffects::cpe1,
        &BatteryEffects::cpe1_fractional, &BatteryEffects::cpe2_fractional,
        &BatteryEffects::ocv_slope, &BatteryEffects::charge_acceptance,
        &BatteryEffects::self_heating}) {
    BatteryEffects effects = everything();
    effects.*effect = false;
    const FullBattery battery({}, effects, {0.8, 20.0});
    std::size_t n = 0;
    double worst = 0.0;
    drive(battery, [&](const BatteryState& state) {
      worst = std::max(worst, std::abs(battery.voltage(state) - reference[n++]));
    });
    EXPECT_GT(worst, 1e-5);
  }
}

TEST(FullBattery, ColdBatteryDropsFurtherUnderCranking) {
  const FullBattery warm({}, {}, {0.8, 25.0}), cold({}, {}, {0.8, -18.0});
  const BatteryState w = drive(warm, [](const BatteryState&) {});
  const BatteryState c = drive(cold, [](const BatteryState&) {});
  EXPECT_NEAR(atTemperature({}, -18.0).r_ohmic / atTemperature({}, 25.0).r_ohmic, 1.258, 1e-3);
  EXPECT_LT(cold.voltage(cold.advance(c, c.current - 3.0)),
            warm.voltage(warm.advance(w, w.current - 3.0)));
}

TEST(FullBattery, DepletedLeadIonsRaiseTheVoltageOfALongCharge) {
  BatteryEffects limited;
  limited.charge_acceptance = true;
  const FullBattery plain({}, {}, {0.8, 25.0}), battery({}, limited, {0.8, 25.0});
  BatteryState a = plain.rested(), b = battery.rested();
  for (int n = 0; n < 200000; ++n) {
    const double current = std::min(50.0, a.current + 3.0);
    a = plain.advance(a, current);
    b = battery.advance(b, current);
  }
  EXPECT_NEAR(b.lead_ion, 1.0 - 50.0 / 60.0, 0.02);
  EXPECT_GT(battery.voltage(b), plain.voltage(a) + 0.05);
}

TEST(FullBattery, RestedBatteryReadsItsOpenCircuitVoltage) {
  const FullBattery battery({}, {}, {0.7, 25.0});
  BatteryState state = battery.rested();
  for (int n = 0; n < 1000; ++n) state = battery.advance(state, 0.0);
  EXPECT_NEAR(battery.voltage(state), 12.68 - 0.1 * 1.35, 1e-12);
}

TEST(FullBattery, RefusesWrongParametersNamingAllOfThem) {
  BatteryParameters parameters;
  parameters.alpha = 1.5;
  parameters.r_ohmic_ohm = NAN;
  const std::string text = battery_sof::test::refusalOf([&] {
    FullBattery(parameters, {}, {1.7, 25.0});
  });
  for (const char* name : {"alpha", "r_ohmic_ohm", "soc"})
    EXPECT_NE(text.find(name), text.npos) << text;
}

TEST(FullBattery, RefusesAnR1WhoseVoltageFallsWhileItsCurrentRises) {
  BatteryParameters parameters;
  parameters.r1_charge_ohm = 0.05;
  parameters.r1_transition_a = 1.0;
  EXPECT_THROW(FullBattery(parameters, {}, {0.8, 25.0}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof_simulator

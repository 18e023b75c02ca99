#include "simulator/additions.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/full_battery.hpp"
#include "support/refusal.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kStep = FullBattery::kStep;

/// The plain circuit with additions, moved by hand.
class Rig {
 public:
  explicit Rig(const Additions& additions, const BatteryEffects& effects = plainCircuit())
      : battery_({}, effects, {0.8, 25.0}, 1, additions), state_(battery_.rested()) {}

  void hold(double current, double duration) {
    const long steps = std::lround(duration / kStep);
    for (long n = 0; n < steps; ++n) state_ = battery_.advance(state_, current);
  }
  double voltage() const { return battery_.voltage(state_); }
  const BatteryState& state() const { return state_; }
  const FullBattery& battery() const { return battery_; }

 private:
  FullBattery battery_;
  BatteryState state_;
};

/// What an addition changes in the voltage after the same currents.
double addedBy(const Additions& additions, double first, double first_s, double then = 0.0,
               double then_s = 0.0) {
  Rig with(additions), without({});
  for (Rig* rig : {&with, &without}) {
    rig->hold(first, first_s);
    if (then_s > 0.0) rig->hold(then, then_s);
  }
  return with.voltage() - without.voltage();
}

double relaxed(double tau, double time) { return 1.0 - std::exp(-time / tau); }

TEST(Additions, WithAllOffNothingIsOn) { EXPECT_FALSE(anyOn({})); }

TEST(SecondElectrode, SettlesAtItsSteadyOverpotential) {
  Additions a;
  a.second_electrode = true;
  a.electrode3_beta_per_v = 40.0;
  a.electrode3_i0_a = 2.0;
  EXPECT_NEAR(addedBy(a, 30.0, 300.0), 2.0 / 40.0 * std::asinh(30.0 / 4.0), 1e-6);
}

TEST(SecondElectrode, RisesAtFirstAsACapacitorDoes) {
  Additions a;
  a.second_electrode = true;
  a.electrode3_capacitance_f = 3000.0;
  EXPECT_NEAR(addedBy(a, 30.0, 0.1), 30.0 * 0.1 / 3000.0, 2e-5);
}

TEST(SecondElectrode, OfExponentBelowOneRelaxesMoreSlowlyAfterLong) {
  Additions a, b;
  a.second_electrode = b.second_electrode = true;
  b.electrode3_exponent = 0.8;
  EXPECT_GT(addedBy(b, -40.0, 20.0, 0.0, 300.0) / addedBy(a, -40.0, 20.0, 0.0, 300.0), 1.5);
}

TEST(FastArc, FollowsTheCurrentWithItsTimeConstant) {
  Additions a;
  a.fast_arc = true;
  a.fast_arc_ohm = 1e-3;
  a.fast_arc_time_s = 0.2;
  EXPECT_NEAR(addedBy(a, -100.0, 0.3), -0.1 * relaxed(0.2, 0.3), 3e-4);
}

TEST(AcidTransport, IsTheSumOfTwoRelaxations) {
  Additions a;
  a.acid_transport = true;
  const double expected = 40.0 * (2e-3 * relaxed(60.0, 90.0) + 3e-3 * relaxed(600.0, 90.0));
  EXPECT_NEAR(addedBy(a, 40.0, 90.0), expected, 1e-5);
  EXPECT_NEAR(addedBy(a, -40.0, 90.0), -expected, 1e-5);
}

TEST(OcvHysteresis, DependsOnChargeAndStaysAtRest) {
  Additions a;
  a.ocv_hysteresis = true;
  const double expected = 0.02 * (1.0 - std::exp(-40.0 * 60.0 / 3600.0 / 0.25));
  EXPECT_NEAR(addedBy(a, 40.0, 60.0), expected, 1e-5);
  EXPECT_NEAR(addedBy(a, 80.0, 30.0, 0.0, 100.0), expected, 1e-5);
}

TEST(HighRateDepletion, LowersTheVoltageOfALongDischargeOnly) {
  Additions a;
  a.high_rate_depletion = true;
  EXPECT_NEAR(addedBy(a, -100.0, 30.0), 0.15 * std::log(1.0 - 0.25 * relaxed(30.0, 30.0)), 1e-4);
  EXPECT_EQ(addedBy(a, 40.0, 30.0), 0.0);
}

TEST(CoupDeFouet, DipsAndRecoversAfterAFullCharge) {
  Additions a;
  a.coup_de_fouet = true;
  a.coup_nuclei_at_start = 0.0;
  const auto dip = [&](double ah) { return addedBy(a, -36.0, ah * 100.0); };
  EXPECT_NEAR(dip(0.1), -0.1 * std::exp(-0.1 / 0.3) * (1.0 - std::exp(-0.1 / 0.02)), 1e-4);
  EXPECT_LT(dip(0.06), dip(0.01));
  EXPECT_LT(dip(0.06), dip(0.6));
}

TEST(CoupDeFouet, IsGoneSoonAfterChargingBegins) {
  Additions a;
  a.coup_de_fouet = true;
  a.coup_nuclei_at_start = 0.0;
  EXPECT_NEAR(addedBy(a, -36.0, 5.0, 36.0, 10.0), 0.0, 1e-3);
}

TEST(CoupDeFouet, IsAbsentWithNucleiPresent) {
  Additions a;
  a.coup_de_fouet = true;
  EXPECT_NEAR(addedBy(a, -36.0, 20.0), 0.0, 1e-12);
}

TEST(SulphateHistory, DischargeRaisesTheChargeLimitAndTimeTakesItBack) {
  Additions a;
  a.sulphate_history = true;
  AddedVoltages discrepancies(a, kStep);
  AddedState state = discrepancies.settled(0.0);
  for (int n = 0; n < 60000; ++n) state = discrepancies.advance(state, -30.0, -30.0);
  const double rate = 30.0 / (3600.0 * 0.5);
  EXPECT_NEAR(state.sulphate, 1.0 + rate * 1200.0 * relaxed(1200.0, 60.0), 1e-6);
  const double after = state.sulphate;
  for (int n = 0; n < 1200000; ++n) state = discrepancies.advance(state, 0.0, 0.0);
  EXPECT_NEAR(state.sulphate - 1.0, (after - 1.0) * std::exp(-1.0), 1e-6);
}

TEST(SulphateCrystals, AreMadeByDischargeRipenAtRestAndDissolveWhileCharging) {
  Additions a;
  a.sulphate_crystals = true;
  AddedVoltages added(a, kStep);
  AddedState state = added.settled(0.0);
  EXPECT_EQ(added.chargeLimitFactor(state), 1.0);
  for (int n = 0; n < 60000; ++n) state = added.advance(state, -30.0, -30.0);
  const double q = 0.5, made = q / 0.02 * relaxed(1800.0, 60.0) / (60.0 / 1800.0);
  EXPECT_NEAR(state.fresh_ah, q, 1e-9);
  EXPECT_NEAR(state.crystals, made, 1e-3);
  EXPECT_NEAR(added.chargeLimitFactor(state), 1.0 + 120.0 * std::cbrt(made * q * q), 1e-3);
  for (int n = 0; n < 1800000; ++n) state = added.advance(state, 0.0, 0.0);
  EXPECT_NEAR(state.crystals, made * std::exp(-1.0), 1e-3);
  EXPECT_NEAR(state.fresh_ah, q, 1e-9);
  for (int n = 0; n < 90000; ++n) state = added.advance(state, 30.0, 30.0);
  EXPECT_EQ(state.fresh_ah, 0.0);
  EXPECT_EQ(added.chargeLimitFactor(state), 1.0);
}

TEST(SulphateHistory, ChargeAfterADischargeIsTakenAtALowerVoltage) {
  Additions a;
  a.sulphate_history = true;
  BatteryEffects effects = plainCircuit();
  effects.charge_acceptance = true;
  Rig with(a, effects), without({}, effects);
  for (Rig* rig : {&with, &without}) {
    rig->hold(-40.0, 120.0);
    rig->hold(40.0, 40.0);
  }
  EXPECT_LT(with.voltage(), without.voltage() - 1e-3);
}

TEST(ParameterDrift, ChangesTheChosenParameterInProportionToTime) {
  Additions a;
  a.parameter_drift = true;
  a.drift_per_h = 0.5;
  const double share = 0.5 * 36.0 / 3600.0;
  const BatteryParameters p;
  EXPECT_NEAR(addedBy(a, 40.0, 36.0), share * p.r_ohmic_ohm * 40.0, 1e-9);
  a.drifting = DriftingParameter::kR1;
  EXPECT_NEAR(addedBy(a, 40.0, 36.0), share * p.r1_charge_ohm * 40.0, 1e-6);
  a.drifting = DriftingParameter::kU0;
  EXPECT_NEAR(addedBy(a, 40.0, 36.0), share * p.u0_v, 1e-6);
}

TEST(ParameterDrift, OfTheCapacitanceSlowsTheRise) {
  Additions a;
  a.parameter_drift = true;
  a.drifting = DriftingParameter::kCpe2Capacitance;
  a.drift_per_h = 10.0;
  Rig with(a), without({});
  for (Rig* rig : {&with, &without}) {
    rig->hold(0.0, 360.0);
    rig->hold(30.0, 0.5);
  }
  const double u2_with = with.state().cpe2.voltage, u2_without = without.state().cpe2.voltage;
  EXPECT_NEAR(u2_with / u2_without, 0.5, 0.01);
}

TEST(ParasiticLoad, DischargesTheBatteryUnseenBySensorAndStartsSettled) {
  Additions a;
  a.parasitic_load_a = 0.2;
  Rig rig(a);
  const double before = rig.voltage();
  EnergyLedger ledger(rig.battery(), rig.state());
  rig.hold(0.0, 3600.0 / 60.0);
  EXPECT_NEAR(rig.voltage(), before, 1e-9);
  EXPECT_EQ(rig.state().current, 0.0);
  EXPECT_NEAR(rig.state().main_charge, -0.2 * 60.0, 1e-6);
  EXPECT_NEAR(12.68 - before, 2.0 / 22.0 * std::asinh(0.1) + 0.2 * 6.7e-3, 1e-9);
}

TEST(ContactStep, AddsItsResistanceFromItsInstantOn) {
  Additions a;
  a.contact_step = true;
  a.contact_from_s = 5.0;
  EXPECT_EQ(addedBy(a, 40.0, 4.0), 0.0);
  EXPECT_NEAR(addedBy(a, 40.0, 6.0), 40.0 * 5e-4, 1e-9);
}

TEST(MemoryResistance, GrowsWithTheCurrentOfThePast) {
  Additions a;
  a.memory_resistance = true;
  EXPECT_NEAR(addedBy(a, -50.0, 20.0), -50.0 * 1e-4 * 50.0 * relaxed(20.0, 20.0), 1e-4);
}

TEST(StepDiscrepancy, ActsAboveItsThresholdAlone) {
  Additions a;
  a.step_force = true;
  EXPECT_EQ(addedBy(a, -50.0, 1.0), 0.0);
  EXPECT_NEAR(addedBy(a, -80.0, 1.0), -0.1, 1e-12);
  EXPECT_NEAR(addedBy(a, 80.0, 1.0), 0.1, 1e-12);
}

TEST(GatedTone, IsHeardWhileCurrentFlows) {
  Additions a;
  a.gated_tone = true;
  EXPECT_EQ(addedBy(a, 0.0, 10.0), 0.0);
  EXPECT_NEAR(addedBy(a, 20.0, 10.0), 0.02 * relaxed(2.0, 10.0), 1e-9);
}

TEST(CapacitanceFall, LosesItsShareInAnHour) {
  Additions a;
  a.capacitance_fall = true;
  Rig with(a), without({});
  for (Rig* rig : {&with, &without}) {
    rig->hold(0.0, 900.0);
    rig->hold(30.0, 0.2);
  }
  EXPECT_NEAR(without.state().cpe2.voltage / with.state().cpe2.voltage, std::pow(0.4, 0.25), 0.01);
}

TEST(DeadZone, WithinItTheCapacitorKeepsItsCharge) {
  Additions a;
  a.dead_zone = true;
  Rig rig(a);
  rig.hold(10.0, 0.5);
  const double kept = rig.state().cpe2.voltage;
  EXPECT_NEAR(kept, 10.0 * 0.5 / 1000.0, 1e-5);
  rig.hold(0.0, 100.0);
  EXPECT_NEAR(rig.state().cpe2.voltage, kept, 1e-5);
}

TEST(HystereticR, RemembersTheSignOfTheLastLargeCurrent) {
  Additions a;
  a.hysteretic_r = true;
  EXPECT_EQ(addedBy(a, 10.0, 1.0), 0.0);
  EXPECT_NEAR(addedBy(a, 30.0, 1.0, -10.0, 1.0), -0.01, 1e-9);
  EXPECT_NEAR(addedBy(a, -30.0, 1.0, -10.0, 1.0), 0.01, 1e-9);
}

TEST(Additions, EnergyInIsStoredOrLostWithThem) {
  Additions a;
  a.second_electrode = a.acid_transport = a.ocv_hysteresis = a.fast_arc = true;
  a.parasitic_load_a = 0.1;
  Rig rig(a);
  EnergyLedger ledger(rig.battery(), rig.state());
  BatteryState state = rig.state();
  for (int n = 1; n <= 60000; ++n) {
    state = rig.battery().advance(state, 40.0 * std::sin(0.3 * n * kStep));
    ledger.enter(state);
  }
  const Balance& b = ledger.balance();
  EXPECT_LT(std::abs(b.energyError()), 1e-6 * b.throughput);
  EXPECT_NEAR(b.chargeError(), 0.0, 1e-6);
}

TEST(Additions, OutOfBoundsAreRefusedByName) {
  Additions a;
  a.acid_1_time_s = -1.0;
  a.coup_nuclei_at_start = 2.0;
  const std::string text = battery_sof::test::refusalOf([&] {
    FullBattery({}, plainCircuit(), {0.8, 25.0}, 1, a);
  });
  for (const char* name : {"acid_1_time_s", "coup_nuclei_at_start"})
    EXPECT_NE(text.find(name), text.npos) << text;
}

}  // namespace
}  // namespace battery_sof_simulator

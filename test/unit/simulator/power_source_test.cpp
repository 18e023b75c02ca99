#include "simulator/power_source.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/full_battery.hpp"

namespace battery_sof_simulator {
namespace {

BatteryEffects limitedAcceptance() {
  BatteryEffects effects;
  effects.gassing = GassingLaw::kTafel;
  effects.charge_acceptance = true;
  return effects;
}

TEST(PowerSource, VoltageControlledPhaseHoldsTheVoltageWithinTheCurrentLimit) {
  const FullBattery battery({}, limitedAcceptance(), {0.8, 25.0});
  const PowerSource source;
  BatteryState state = battery.rested();
  double held_since = 0.0;
  for (int n = 1; n <= 600000; ++n) {
    const BatteryState next = source.step(battery, state, {90.0, 14.2});
    ASSERT_LE(next.current, 90.0 + 1e-9);
    ASSERT_LE(battery.voltage(next), 14.2 + 2e-6);
    if (next.current < 89.9 && held_since == 0.0 && n > 100) held_since = n * FullBattery::kStep;
    if (held_since > 0.0) {
      ASSERT_NEAR(battery.voltage(next), 14.2, 2e-6) << n;
    }
    state = next;
  }
  EXPECT_GT(held_since, 1.0);
  EXPECT_LT(held_since, 300.0);
  EXPECT_LT(state.current, 61.0);
  EXPECT_GT(state.current, 40.0);
}

TEST(PowerSource, ChargingCurrentFollowsFromTheBattery) {
  const PowerSource source;
  const auto takenAt = [&](double soc) {
    const FullBattery battery({}, {}, {soc, 25.0});
    BatteryState state = battery.rested();
    for (int n = 0; n < 5000; ++n) state = source.step(battery, state, {200.0, 13.4});
    return state.current;
  };
  EXPECT_GT(takenAt(0.6), takenAt(0.8) + 10.0);
}

TEST(PowerSource, ConsumersAreNotLimited) {
  const FullBattery battery({}, {}, {0.8, 25.0});
  BatteryState state = battery.rested();
  for (int n = 0; n < 200; ++n) state = PowerSource().step(battery, state, {-300.0, 10.0});
  EXPECT_EQ(state.current, -300.0);
}

TEST(PowerSource, GeneratorBelowTheBatterysVoltageDeliversNothing) {
  const FullBattery battery({}, {}, {0.8, 25.0});
  BatteryState state = battery.rested();
  for (int n = 0; n < 100; ++n) state = PowerSource().step(battery, state, {50.0, 12.0});
  EXPECT_EQ(state.current, 0.0);
}

TEST(PowerSource, CurrentChangesByAtMostTheSlewRate) {
  const FullBattery battery({}, {}, {0.8, 25.0});
  const PowerSource source(3000.0);
  BatteryState state = battery.rested();
  for (double wanted : {-300.0, 80.0, 0.0, 20.0})
    for (int n = 0; n < 300; ++n) {
      const BatteryState next = source.step(battery, state, {wanted, 14.2});
      ASSERT_LE(std::abs(next.current - state.current), 3.0 + 1e-9);
      state = next;
    }
  EXPECT_EQ(state.current, 20.0);
}

}  // namespace
}  // namespace battery_sof_simulator

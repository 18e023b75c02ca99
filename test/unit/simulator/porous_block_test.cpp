#include "simulator/porous_block.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/simulation.hpp"
#include "support/refusal.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kFaraday = 96485.33212;

PorousState hold(const PorousBlock& block, PorousState state, double current, double duration,
                 double step = PorousBlock::kStep) {
  for (long n = std::lround(duration / step); n > 0; --n) state = block.advance(state, current);
  return state;
}

/// A charge, a crank, a long discharge and a rest.
PorousState drive(const PorousBlock& block) {
  PorousState state = hold(block, block.rested(), 40.0, 10.0);
  state = hold(block, state, -250.0, 1.0);
  state = hold(block, state, -60.0, 10.0);
  return hold(block, state, 0.0, 5.0);
}
constexpr double kDriven = 400.0 - 250.0 - 600.0;  // [As]

/// Charge on an electrode's double layer since rest, in the direction of oxidation [As].
double layerCharge(const PorousParameters& p, const PorousState::Field& now,
                   const PorousState::Field& before, bool positive) {
  const double layer = positive ? p.positive.surface_per_m * p.positive.layer_f_per_m2
                                : p.negative.surface_per_m * p.negative.layer_f_per_m2;
  const double thickness = positive ? p.positive.thickness_m : p.negative.thickness_m;
  return p.area_m2 * thickness * layer * (now - before).mean();
}

PorousParameters limited(double limit) {
  PorousParameters p;
  p.lead_ion = true;
  p.lead_ion_limit_a = limit;
  p.lead_ion_time_s = 5.0;
  return p;
}

TEST(PorousBlock, RestsAtItsOpenCircuitVoltage) {
  const PorousBlock block({}, 0.8);
  const PorousState start = block.rested(), later = hold(block, start, 0.0, 1.0);
  EXPECT_NEAR(block.voltage(start), 12.67, 0.05);
  EXPECT_NEAR(block.voltage(later), block.voltage(start), 1e-9);
}

TEST(PorousBlock, OpenCircuitVoltageRisesByAVoltAndAHalfPerUnitOfCharge) {
  const PorousBlock low({}, 0.7), high({}, 0.9);
  const double slope = (high.voltage(high.rested()) - low.voltage(low.rested())) / 0.2;
  EXPECT_GT(slope, 1.2);
  EXPECT_LT(slope, 1.8);
}

/// The negative plates' double layer against their fast reaction: the fast arc
/// (docs/physics.md#fast_arc).
TEST(PorousBlock, ItsResistanceGrowsWithinTenthsOfASecond) {
  const PorousBlock block({}, 0.8);
  const double rested = block.voltage(block.rested());
  const double early = rested - block.voltage(hold(block, block.rested(), -40.0, 0.02));
  const double late = rested - block.voltage(hold(block, block.rested(), -40.0, 0.3));
  EXPECT_GT(late, 1.15 * early);
}

TEST(PorousBlock, ChargeInIsReactedOrOnTheDoubleLayers) {
  const PorousParameters p;
  const PorousBlock block(p, 0.8);
  const PorousState start = block.rested(), end = drive(block);
  const double negative = layerCharge(p, end.negative, start.negative, false);
  EXPECT_NEAR(end.main_charge - negative, kDriven, 1e-4);
}

TEST(PorousBlock, AcidGainedIsTheChargeReacted) {
  const PorousParameters p;
  const PorousBlock block(p, 0.8);
  const PorousState start = block.rested(), end = drive(block);
  const double at_positive = kDriven - layerCharge(p, end.positive, start.positive, true);
  const double at_negative = kDriven + layerCharge(p, end.negative, start.negative, false);
  const double expected = (1.5 * at_positive - 0.5 * at_negative) / kFaraday;
  EXPECT_NEAR(block.acid(end) - block.acid(start), expected, 1e-7);
}

TEST(PorousBlock, ResistanceAtFirstIsThatOfGridsAndAcid) {
  const PorousBlock block({}, 0.8);
  const PorousState start = block.rested();
  const double drop = block.voltage(start) - block.voltage(block.advance(start, -100.0));
  EXPECT_GT(drop / 100.0, 3.5e-3);
  EXPECT_LT(drop / 100.0, 5.5e-3);
}

TEST(PorousBlock, OverpotentialGrowsLessThanInProportionToTheCurrent) {
  const PorousBlock block({}, 0.8);
  const auto overpotential = [&](double current) {
    const PorousState state = hold(block, block.rested(), current, 20.0);
    return block.voltage(state) - block.voltage(block.rested());
  };
  EXPECT_LT(overpotential(-100.0), -0.6);
  EXPECT_GT(overpotential(-100.0), -1.8);
  EXPECT_GT(overpotential(30.0), 0.2);
  EXPECT_LT(overpotential(60.0), 1.9 * overpotential(30.0));
}

TEST(PorousBlock, AcidKeepsRelaxingAtRest) {
  const PorousBlock block({}, 0.8);
  const PorousState drawn = hold(block, block.rested(), -60.0, 30.0);
  const PorousState soon = hold(block, drawn, 0.0, 40.0), late = hold(block, soon, 0.0, 200.0);
  EXPECT_GT(block.voltage(late), block.voltage(soon) + 1e-3);
  EXPECT_LT(block.voltage(late), block.voltage(block.rested()));
}

TEST(PorousBlock, AFinerGridChangesTheVoltageByLessThanTwoMillivolts) {
  PorousParameters fine;
  fine.cells_per_region = 30;
  const PorousBlock a({}, 0.8), b(fine, 0.8);
  for (double current : {40.0, -250.0})
    EXPECT_NEAR(a.voltage(hold(a, a.rested(), current, 5.0)),
                b.voltage(hold(b, b.rested(), current, 5.0)), 2e-3);
}

TEST(PorousBlock, AHalfAsLongStepChangesTheVoltageByLessThanAMillivolt) {
  const PorousBlock a({}, 0.8), b({}, 0.8, 0.5 * PorousBlock::kStep);
  for (double duration : {0.05, 0.5, 5.0})
    for (double current : {40.0, -250.0})
      EXPECT_NEAR(a.voltage(hold(a, a.rested(), current, duration)),
                  b.voltage(hold(b, b.rested(), current, duration, 0.5 * PorousBlock::kStep)),
                  1e-3);
}

TEST(PorousBlock, LeadIonsDepleteTowardsTheShareOfTheLimitThatIsCharged) {
  const PorousBlock block(limited(60.0), 0.8), free({}, 0.8);
  const PorousState state = hold(block, block.rested(), 40.0, 60.0);
  EXPECT_NEAR(state.lead_ion.mean(), 1.0 - 40.0 / 60.0, 0.05);
  EXPECT_GT(block.voltage(state), free.voltage(hold(free, free.rested(), 40.0, 60.0)) + 0.05);
}

TEST(PorousBlock, WhatTheMainReactionCannotTakeBecomesGas) {
  PorousParameters p = limited(15.0);
  p.gassing = true;
  const PorousBlock block(p, 0.8);
  const PorousState state = hold(block, block.rested(), 18.0, 120.0);
  EXPECT_NEAR(state.gas_current, 3.0, 0.1);
  const double layer = layerCharge(p, state.negative, block.rested().negative, false);
  EXPECT_NEAR(state.main_charge + state.gas_charge - layer, 18.0 * 120.0, 1e-3);
}

TEST(PorousBlock, RefusesWrongParametersNamingAllOfThem) {
  PorousParameters p;
  p.area_m2 = -1.0;
  p.negative.porosity = 2.0;
  const std::string text = battery_sof::test::refusalOf([&] { PorousBlock(p, 0.1); });
  for (const char* name : {"area_m2", "negative_porosity", "soc"})
    EXPECT_NE(text.find(name), text.npos) << text;
}

TEST(PorousSimulation, HoldsTheVoltageLimitAndKeepsTheGrid) {
  Scenario scenario;
  scenario.duration = 20.0;
  scenario.voltage_limit = 13.2;
  scenario.acquisition.voltage_noise = scenario.acquisition.current_noise = {};
  scenario.profile = ListedPhases{{{20.0, 80.0, 80.0}}};
  scenario.porous = PorousParameters{};
  const Simulation simulation = simulate(scenario);
  ASSERT_EQ(simulation.samples.size(), 2000u);
  EXPECT_NEAR(simulation.samples.back().voltage, 13.2, 1e-3);
  EXPECT_LT(simulation.samples.back().current, 80.0);
  EXPECT_GT(simulation.samples.back().current, 5.0);
}

}  // namespace
}  // namespace battery_sof_simulator

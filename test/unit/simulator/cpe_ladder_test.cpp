#include "simulator/cpe_ladder.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/impedance.hpp"

namespace battery_sof_simulator {
namespace {

const double kExponents[] = {0.5, 0.55, 0.65, 0.75, 0.88, 0.95, 1.0};

/// Largest relative error of a ladder's impedance over a band.
double worstError(const Cpe& cpe, double first_hz, double last_hz) {
  const CpeLadder ladder(cpe);
  double worst = 0.0;
  for (double f : logarithmicFrequencies(first_hz, last_hz, 30)) {
    const double w = 2.0 * M_PI * f;
    worst = std::max(worst, std::abs(analyticAdmittance(cpe, w) / ladder.admittance(w) - 1.0));
  }
  return worst;
}

TEST(CpeLadder, ImpedanceIsWithinTwoPerMilleOfTheElementFrom1MilliHertzTo100Hertz) {
  for (double p : kExponents) EXPECT_LT(worstError({800.0, p}, 1e-3, 100.0), 0.002) << "p = " << p;
}

TEST(CpeLadder, ImpedanceIsWithinOnePercentUpTo1KiloHertz) {
  for (double p : kExponents) EXPECT_LT(worstError({800.0, p}, 100.0, 1000.0), 0.01) << "p = " << p;
}

TEST(CpeLadder, ConstantCurrentChargesItAlongThePowerLaw) {
  // u(t) = I t^p / (Q Gamma(1 + p)), from the Laplace transform of (jw)^-p.
  const Cpe cpe{700.0, 0.85};
  const double step = 0.001, current = 40.0;
  const CpeLadder ladder(cpe, step);
  LadderState state = ladder.rested();
  for (int n = 1; n <= 100000; ++n) {
    state = ladder.advance(state, (current + ladder.sourceCurrent(state)) / ladder.conductance());
    if (n != 100 && n != 1000 && n != 10000 && n != 100000) continue;
    const double law =
        current * std::pow(n * step, cpe.exponent) / (cpe.scale * std::tgamma(1.0 + cpe.exponent));
    EXPECT_NEAR(state.voltage / law, 1.0, 0.01) << "at " << n * step << " s";
  }
}

TEST(CpeLadder, ExponentOneIsACapacitor) {
  const CpeLadder ladder({1000.0, 1.0}, 0.01);
  const LadderState state = ladder.advance(ladder.rested(), 20.0 / ladder.conductance());
  EXPECT_NEAR(state.voltage, 20.0 * 0.01 / 1000.0, 1e-15);
  EXPECT_EQ(ladder.dissipation(state), 0.0);
}

TEST(CpeLadder, NeverReturnsMoreEnergyThanItTook) {
  const double step = 0.001;
  const CpeLadder ladder({700.0, 0.7}, step);
  LadderState state = ladder.rested();
  double taken = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double current = 30.0 * std::sin(0.003 * n) + (n > 9000 ? -20.0 : 5.0);
    state = ladder.advance(state, (current + ladder.sourceCurrent(state)) / ladder.conductance());
    taken += step * current * state.voltage;
    ASSERT_GE(taken, ladder.storedEnergy(state) - 1e-9);
    ASSERT_GE(ladder.dissipation(state), 0.0);
  }
}

TEST(CpeLadder, RefusesAnExponentOutsideZeroToOne) {
  EXPECT_THROW(CpeLadder({1.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(CpeLadder({1.0, 1.2}), std::invalid_argument);
  EXPECT_THROW(CpeLadder({-1.0, 0.5}), std::invalid_argument);
  EXPECT_THROW(CpeLadder({NAN, 0.5}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof_simulator

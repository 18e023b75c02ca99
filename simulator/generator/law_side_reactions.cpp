#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kMaxSide = 15.0;  // [A] at strength 1
// [V] above the onset, of the order of a Tafel slope of six cells
constexpr double kWindow = 0.15;

/// What all laws draw: the voltage u_0 + u2 at which the reaction sets in [V].
double onsetOf(Dice& dice, const Circumstances& drive) {
  return dice.between({drive.onset_low_v, drive.onset_high_v});
}

double above(const LawInstant& now, double onset) {
  return std::max(0.0, (now.u_x - onset) / kWindow);
}

/**
 * Oxygen reaches the negative plate through a separator that overcharge dries.
 *
 *     x = (u_x - U)+ / 0.15 V,   i_side = 3 A x^n (1 + 2 m)
 *     dm/dt = x (1 - m) / tau - m^2 / (4 tau)
 *
 * Gas channels open as acid is displaced: Culpin and Peters 1980s; Bernardi and Carpenter,
 * J. Electrochem. Soc. 142 (1995). A power law, as of percolation, not Tafel's exponential.
 */
Law dryingSeparator(Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), power = dice.between({1.3, 2.5}),
               time = dice.logBetween({30.0, 200.0});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double opening = std::min(1.0, above(now, onset)) * (1.0 - x[0]);
    return Law::State{std::max(0.0, x[0] + now.step / time * (opening - 0.25 * x[0] * x[0]))};
  };
  law.passing_by = [=](const Law::State& x, const LawInstant& now) {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset), power) * (1.0 + 2.0 * x[0]));
  };
  return law;
}

/**
 * Gas bubbles cover the plates while the reaction runs.
 *
 *     i_side = 3 A x^1.5 (1 - b),   db/dt = x (1 - b)^2 / tau_1 - b / tau_2
 *     v = R i+ [(1 - b)^-1.5 - 1]
 *
 * Resistance of acid with bubbles after Bruggeman (1935); coverage: Vogt and Balzer, Electrochim.
 * Acta 50 (2005).
 */
Law bubbleCover(Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), covering = dice.logBetween({5.0, 40.0}),
               leaving = dice.logBetween({5.0, 60.0}), resistance = dice.between({0.3e-3, 0.8e-3});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - x[0], rising = std::min(2.0, above(now, onset)) * open * open;
    return Law::State{std::clamp(x[0] + now.step * (rising / covering - x[0] / leaving), 0.0, 0.9)};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return resistance * now.charging() * (std::pow(1.0 - x[0], -1.5) - 1.0);
  };
  law.passing_by = [=](const Law::State& x, const LawInstant& now) {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset), 1.5) * (1.0 - x[0]));
  };
  return law;
}

/**
 * Oxygen builds up pressure and depolarises the negative plate some time later.
 *
 *     i_side = 6 A S(x),   S: smooth step from 0 to 1
 *     dp_1/dt = 4 (i_side / 6 A - p_1) / tau,   dp_k/dt = 4 (p_(k-1) - p_k) / tau, k = 2 to 4
 *     v = -V sqrt(p_4)
 *
 * The way through gas space and film as four stirred vessels in a row (Levenspiel 1962);
 * recombination that lowers the negative's potential: Dietz et al., J. Power Sources 14 (1985).
 */
Law pressureRecombination(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kVessels = 4;
  const double onset = onsetOf(dice, drive), time = dice.logBetween({15.0, 120.0}),
               depth = dice.between({0.005, 0.02});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    Law::State next = x;
    for (std::size_t k = 0; k < kVessels; ++k) {
      const double inflow = k == 0 ? smoothStep(above(now, onset)) : x[k - 1];
      next[k] += now.step * kVessels / time * (inflow - x[k]);
    }
    return next;
  };
  law.added = [=](const Law::State& x, const LawInstant&) {
    return -depth * std::sqrt(std::max(0.0, x[kVessels - 1]));
  };
  law.passing_by = [=](const Law::State&, const LawInstant& now) {
    return 6.0 * smoothStep(above(now, onset));
  };
  return law;
}

/**
 * An impurity that is oxidised at one plate and reduced at the other, as fast as it comes across.
 *
 *     i_side = 12 A S(x) y,   dy/dt = -i_side / Q + (z - y) / tau
 *     dz/dt = (1 - z) / (5 tau) - (z - y) / (3 tau)
 *
 * y, z: the reduced form at the plate and in the acid. Shuttles in lead-acid: Pavlov, Lead-Acid
 * Batteries (2011), ch. 13. Two compartments and a limit by transport.
 */
Law impurityShuttle(Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), charge = dice.logBetween({100.0, 600.0}),
               time = dice.logBetween({20.0, 90.0});
  Law law;
  law.rested = {1.0, 1.0};
  const auto side = [=](const Law::State& x, const LawInstant& now) {
    return 12.0 * smoothStep(above(now, onset)) * x[0];
  };
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double across = (x[1] - x[0]) / time;
    const double plate = x[0] + now.step * (across - side(x, now) / charge);
    const double acid = x[1] + now.step * ((1.0 - x[1]) / (5.0 * time) - across / 3.0);
    return Law::State{std::max(0.0, plate), acid};
  };
  law.passing_by = side;
  return law;
}

}  // namespace

std::vector<LawForm> sideReactionLaws() {
  return {{"side_reactions", "drying_separator", dryingSeparator},
          {"side_reactions", "bubble_cover", bubbleCover},
          {"side_reactions", "pressure_recombination", pressureRecombination},
          {"side_reactions", "impurity_shuttle", impurityShuttle}};
}

}  // namespace battery_sof_simulator

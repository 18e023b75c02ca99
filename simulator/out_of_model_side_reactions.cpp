#include "simulator/out_of_model_force.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kMaxSide = 15.0;  // [A] at strength 1
// [V] above the onset, of the order of a Tafel slope of six cells
constexpr double kWindow = 0.15;

/// What all forms draw: the voltage u_0 + u2 at which the reaction sets in [V].
double onsetOf(Dice& dice, const Circumstances& drive) {
  return dice.between({drive.onset_low_v, drive.onset_high_v});
}

double above(const OutOfModelInstant& now, double onset) {
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
class DryingSeparator : public OutOfModelVoltage {
 public:
  DryingSeparator(Dice& dice, const Circumstances& drive)
      : onset_(onsetOf(dice, drive)),
        power_(dice.between({1.3, 2.5})),
        time_(logBetween(dice, {30.0, 200.0})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double opening = std::min(1.0, above(now, onset_)) * (1.0 - x[0]);
    return {std::max(0.0, x[0] + now.step / time_ * (opening - 0.25 * x[0] * x[0]))};
  }
  double voltage(const State&, const OutOfModelInstant&) const override { return 0.0; }
  double sideCurrent(const State& x, const OutOfModelInstant& now) const override {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset_), power_) * (1.0 + 2.0 * x[0]));
  }

 private:
  double onset_, power_, time_;
};

/**
 * Gas bubbles cover the plates while the reaction runs.
 *
 *     i_side = 3 A x^1.5 (1 - b),   db/dt = x (1 - b)^2 / tau_1 - b / tau_2
 *     v = R i+ [(1 - b)^-1.5 - 1]
 *
 * Resistance of acid with bubbles after Bruggeman (1935); coverage: Vogt and Balzer, Electrochim.
 * Acta 50 (2005).
 */
class BubbleCover : public OutOfModelVoltage {
 public:
  BubbleCover(Dice& dice, const Circumstances& drive)
      : onset_(onsetOf(dice, drive)),
        covering_(logBetween(dice, {5.0, 40.0})),
        leaving_(logBetween(dice, {5.0, 60.0})),
        resistance_(dice.between({0.3e-3, 0.8e-3})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double open = 1.0 - x[0], rising = std::min(2.0, above(now, onset_)) * open * open;
    return {std::clamp(x[0] + now.step * (rising / covering_ - x[0] / leaving_), 0.0, 0.9)};
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    return resistance_ * now.charging() * (std::pow(1.0 - x[0], -1.5) - 1.0);
  }
  double sideCurrent(const State& x, const OutOfModelInstant& now) const override {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset_), 1.5) * (1.0 - x[0]));
  }

 private:
  double onset_, covering_, leaving_, resistance_;
};

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
class PressureRecombination : public OutOfModelVoltage {
 public:
  PressureRecombination(Dice& dice, const Circumstances& drive)
      : onset_(onsetOf(dice, drive)),
        time_(logBetween(dice, {15.0, 120.0})),
        depth_(dice.between({0.005, 0.02})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    State next = x;
    for (std::size_t k = 0; k < kVessels; ++k) {
      const double inflow = k == 0 ? smoothStep(above(now, onset_)) : x[k - 1];
      next[k] += now.step * kVessels / time_ * (inflow - x[k]);
    }
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    return -depth_ * std::sqrt(std::max(0.0, x[kVessels - 1]));
  }
  double sideCurrent(const State&, const OutOfModelInstant& now) const override {
    return 6.0 * smoothStep(above(now, onset_));
  }

 private:
  static constexpr std::size_t kVessels = 4;
  double onset_, time_, depth_;
};

/**
 * An impurity that is oxidised at one plate and reduced at the other, as fast as it comes across.
 *
 *     i_side = 12 A S(x) y,   dy/dt = -i_side / Q + (z - y) / tau,   dz/dt = (1 - z) / (5 tau) - (z
 * - y) / (3 tau)
 *
 * y, z: the reduced form at the plate and in the acid. Shuttles in lead-acid: Pavlov, Lead-Acid
 * Batteries (2011), ch. 13. Two compartments and a limit by transport.
 */
class ImpurityShuttle : public OutOfModelVoltage {
 public:
  ImpurityShuttle(Dice& dice, const Circumstances& drive)
      : onset_(onsetOf(dice, drive)),
        charge_(logBetween(dice, {100.0, 600.0})),
        time_(logBetween(dice, {20.0, 90.0})) {}

  State rested() const override { return {1.0, 1.0}; }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double across = (x[1] - x[0]) / time_;
    const double plate = x[0] + now.step * (across - sideCurrent(x, now) / charge_);
    const double acid = x[1] + now.step * ((1.0 - x[1]) / (5.0 * time_) - across / 3.0);
    return {std::max(0.0, plate), acid};
  }
  double voltage(const State&, const OutOfModelInstant&) const override { return 0.0; }
  double sideCurrent(const State& x, const OutOfModelInstant& now) const override {
    return 12.0 * smoothStep(above(now, onset_)) * x[0];
  }

 private:
  double onset_, charge_, time_;
};

}  // namespace

std::vector<OutOfModelForm> sideReactionForms() {
  const std::string mechanism = "side_reactions";
  return {formOf<DryingSeparator>(mechanism, "drying_separator"),
          formOf<BubbleCover>(mechanism, "bubble_cover"),
          formOf<PressureRecombination>(mechanism, "pressure_recombination"),
          formOf<ImpurityShuttle>(mechanism, "impurity_shuttle")};
}

}  // namespace battery_sof_reference

#include "simulator/out_of_model_force.hpp"

namespace battery_sof_reference {
namespace {

/**
 * Acid in the plates' pores, by Fick's law in fourteen slices; it diffuses faster where it is
 * stronger.
 *
 *     dc/dt = d/dx [ (1 + g (c - 1)) dc/dx ] / tau,  flux at x = 0: i / 100 A,  c = 1 at x = 1
 *     v = V [ (c_0 - 1) + 0.4 (c_0 - 1) |c_0 - 1| ]
 *
 * Charging sets acid free. Diffusion that depends on strength: Sunu, J. Electrochem. Soc. 131
 * (1984); Gu et al. (1997). Begins with the square root of time.
 */
class PoreDiffusion : public OutOfModelVoltage {
 public:
  PoreDiffusion(Dice& dice, const Circumstances& drive)
      : time_(logBetween(dice, {60.0, std::min(1200.0, 0.5 * drive.duration)})),
        faster_(dice.between({0.3, 1.0})) {}

  State rested() const override {
    State state{};
    std::fill_n(state.begin(), kSlices, 1.0);
    return state;
  }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double rate = now.step * kSlices * kSlices / time_;
    double inflow = now.current / 100.0 / kSlices;
    State next = x;
    for (std::size_t k = 0; k < kSlices; ++k) {
      const double after = k + 1 == kSlices ? 1.0 : x[k + 1];
      const double outflow = ease(0.5 * (x[k] + after)) * (x[k] - after);
      next[k] = std::clamp(x[k] + rate * (inflow - outflow), 0.0, 3.0);
      inflow = outflow;
    }
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    const double more = x[0] - 1.0;
    return 0.1 * (more + 0.4 * more * std::abs(more));
  }

 private:
  static constexpr std::size_t kSlices = 14;
  double ease(double c) const { return std::max(0.1, 1.0 + faster_ * (c - 1.0)); }
  double time_, faster_;
};

/**
 * Memory by a power law: after a step of current the voltage goes with t^a.
 *
 *     tau_k dz_k/dt = f(i) - z_k,   v = R sum_k w_k z_k,  w_k ~ tau_k^a,  f(i) = i, charging: b i
 *
 * Twelve times from 1 s to a third of the drive. Anomalous diffusion in a disordered porous body:
 * Bisquert and Compte, J. Electroanal. Chem. 499 (2001).
 */
class AnomalousDiffusion : public OutOfModelVoltage {
 public:
  AnomalousDiffusion(Dice& dice, const Circumstances& drive)
      : charging_share_(dice.between({0.6, 1.0})) {
    const double power = dice.between({0.3, 0.6});
    const double longest = drive.duration * dice.between({0.15, 0.35});
    double sum = 0.0;
    for (std::size_t k = 0; k < kTimes; ++k) {
      time_[k] = std::pow(longest, k / (kTimes - 1.0));
      sum += weight_[k] = std::pow(time_[k], power);
    }
    for (double& weight : weight_) weight /= sum;
  }

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double drawn = now.current > 0.0 ? charging_share_ * now.current : now.current;
    State next = x;
    for (std::size_t k = 0; k < kTimes; ++k) next[k] += now.step / time_[k] * (drawn - x[k]);
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < kTimes; ++k) sum += weight_[k] * x[k];
    return 3e-3 * sum;
  }

 private:
  static constexpr std::size_t kTimes = 12;
  double charging_share_;
  std::array<double, kTimes> time_{}, weight_{};
};

/**
 * Pores that a heavy discharge empties of acid, and a free volume that fills them again.
 *
 *     dp/dt = [0.7 (i)+ - (-i)+] / Q_p + e,   db/dt = -0.2 e + (1 - b) / tau_b
 *     e = p^1.5 (b - p) / tau_p,   p >= 0.04
 *     v = -V (-i)+ / ((-i)+ + 40 A) [ 1 / (p + K) - 1 / (1 + K) ]
 *
 * Exhaustion of pores: Newman and Tiedemann, AIChE J. 21 (1975); tortuosity: Bruggeman (1935).
 */
class PoreExhaustion : public OutOfModelVoltage {
 public:
  PoreExhaustion(Dice& dice, const Circumstances&)
      : charge_(logBetween(dice, {300.0, 1500.0})),
        refilling_(logBetween(dice, {8.0, 50.0})),
        mixing_(logBetween(dice, {100.0, 600.0})),
        half_(dice.between({0.1, 0.5})) {}

  State rested() const override { return {1.0, 1.0}; }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double exchange = std::pow(x[0], 1.5) * (x[1] - x[0]) / refilling_;
    const double made = (0.7 * now.charging() - now.discharging()) / charge_;
    return {std::clamp(x[0] + now.step * (made + exchange), 0.04, 1.5),
            x[1] + now.step * ((1.0 - x[1]) / mixing_ - 0.2 * exchange)};
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    return -0.03 * saturated(now.discharging() / 40.0) *
           (1.0 / (x[0] + half_) - 1.0 / (1.0 + half_));
  }

 private:
  double charge_, refilling_, mixing_, half_;
};

/**
 * Acid made in one plate is felt by the other after its way through the separator.
 *
 *     dz_1/dt = n (i - z_1) / d,   dz_k/dt = n (z_(k-1) - z_k) / d, k = 2 to n = 10
 *     v = R z_n / (1 + |z_n| / 80 A)
 *
 * A delay with spread, as vessels in a row (Levenspiel 1962).
 */
class SeparatorDelay : public OutOfModelVoltage {
 public:
  SeparatorDelay(Dice& dice, const Circumstances&) : delay_(logBetween(dice, {12.0, 90.0})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    State next = x;
    for (std::size_t k = 0; k < kVessels; ++k)
      next[k] += now.step * kVessels / delay_ * ((k == 0 ? now.current : x[k - 1]) - x[k]);
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    const double late = x[kVessels - 1];
    return 1.5e-3 * late / (1.0 + std::abs(late) / 80.0);
  }

 private:
  static constexpr std::size_t kVessels = 10;
  double delay_;
};

}  // namespace

std::vector<OutOfModelForm> acidForms() {
  const std::string mechanism = "acid";
  return {formOf<PoreDiffusion>(mechanism, "pore_diffusion"),
          formOf<AnomalousDiffusion>(mechanism, "anomalous_diffusion"),
          formOf<PoreExhaustion>(mechanism, "pore_exhaustion"),
          formOf<SeparatorDelay>(mechanism, "separator_delay")};
}

}  // namespace battery_sof_reference

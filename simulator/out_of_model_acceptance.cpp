#include "simulator/out_of_model_force.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kUsualCharge = 30.0;  // [A]
constexpr double kShown = 0.02;        // [V] at strength 1

/**
 * Fine and coarse sulphate crystals; charge dissolves both, each by its surface.
 *
 *     a_f = (S_f / S_0)^(2/3),  a_g = 0.3 (S_g / S_0)^(2/3)
 *     dS_f/dt = (-i)+ - (i)+ a_f / (a_f + a_g) - S_f^2 / (S_0 tau)
 *     dS_g/dt = S_f^2 / (S_0 tau) - (i)+ a_g / (a_f + a_g)
 *     v = V (i+ / 30 A)^m / (a_0 + a_f + a_g)
 *
 * Surface to the power 2/3 of the volume; small crystals merge by pairs (Smoluchowski 1916).
 * Crystals and charge acceptance: Kirchev et al., J. Power Sources 145 (2005); Thele et al. (2006).
 */
class CrystalPopulation : public OutOfModelVoltage {
 public:
  CrystalPopulation(Dice& dice, const Circumstances&)
      : stock_(logBetween(dice, {150.0, 1200.0})),
        merging_(logBetween(dice, {60.0, 600.0})),
        free_(dice.between({0.15, 0.4})),
        power_(dice.between({0.5, 0.8})) {}

  State rested() const override { return {0.3 * stock_, stock_}; }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double fine = fineSurface(x), coarse = coarseSurface(x), all = fine + coarse + 1e-9;
    const double merged = x[0] * x[0] / (stock_ * merging_);
    State next = x;
    next[0] += now.step * (now.discharging() - now.charging() * fine / all - merged);
    next[1] += now.step * (merged - now.charging() * coarse / all);
    next[0] = std::max(next[0], 0.0);
    next[1] = std::clamp(next[1], 0.0, 3.0 * stock_);
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    const double surface = free_ + fineSurface(x) + coarseSurface(x);
    return kShown * std::pow(now.charging() / kUsualCharge, power_) / surface;
  }

 private:
  double fineSurface(const State& x) const { return std::cbrt(x[0] * x[0] / (stock_ * stock_)); }
  double coarseSurface(const State& x) const {
    return 0.3 * std::cbrt(x[1] * x[1] / (stock_ * stock_));
  }
  double stock_, merging_, free_, power_;
};

/**
 * Dissolved lead in a layer before the electrode, by Fick's law in ten slices.
 *
 *     dc/dt = d2c/dx2 / tau,  flux at x = 0: [a (-i)+ - (i)+] / i_L,  c = 1 at x = 1
 *     v = V i+ / (i+ + 20 A) (1 - c_0) / (c_0 + K),   c_0 = c(0), 0 to 1.5
 *
 * Depletes with the square root of time (Sand 1901); the cost of depletion saturates.
 */
class DiffusionLayer : public OutOfModelVoltage {
 public:
  DiffusionLayer(Dice& dice, const Circumstances&)
      : time_(logBetween(dice, {30.0, 300.0})),
        limit_(dice.between({15.0, 45.0})),
        returned_(dice.between({0.5, 1.0})),
        half_(dice.between({0.1, 0.4})) {}

  State rested() const override {
    State state{};
    std::fill_n(state.begin(), kSlices, 1.0);
    return state;
  }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double rate = now.step * kSlices * kSlices / time_;
    const double inflow = (returned_ * now.discharging() - now.charging()) / limit_;
    State next = x;
    for (std::size_t k = 0; k < kSlices; ++k) {
      const double before = k == 0 ? x[0] + inflow / kSlices : x[k - 1];
      const double after = k + 1 == kSlices ? 1.0 : x[k + 1];
      next[k] = std::clamp(x[k] + rate * (before - 2.0 * x[k] + after), 0.0, 1.5);
    }
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    return 2.0 * kShown * saturated(now.charging() / 20.0) * (1.0 - x[0]) / (x[0] + half_);
  }

 private:
  static constexpr std::size_t kSlices = 10;
  double time_, limit_, returned_, half_;
};

/**
 * What a discharge has just left is easy to charge back; the rest is behind a gate.
 *
 *     dP/dt = (-i)+ - (i)+ P / (P + P_h) - P^2 / (P_h tau)
 *     v = V i+ / (i+ + i_h) / (1 + (P / P_h)^n)
 *
 * Short-term history of charge acceptance: Budde-Meiwes et al., J. Power Sources 207 (2012); gate
 * after Hill (1910); the freshness is lost by a second-order law, slower than any exponential.
 */
class FreshnessGate : public OutOfModelVoltage {
 public:
  FreshnessGate(Dice& dice, const Circumstances&)
      : half_(logBetween(dice, {80.0, 500.0})),
        time_(logBetween(dice, {60.0, 900.0})),
        knee_(dice.between({5.0, 25.0})),
        order_(dice.between({2.0, 4.0})) {}

  State rested() const override { return {half_}; }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double taken = now.charging() * saturated(x[0] / half_);
    const double lost = x[0] * x[0] / (half_ * time_);
    return {std::max(0.0, x[0] + now.step * (now.discharging() - taken - lost))};
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    return 2.0 * kShown * saturated(now.charging() / knee_) /
           (1.0 + std::pow(x[0] / half_, order_));
  }

 private:
  double half_, time_, knee_, order_;
};

/**
 * Sites that charging fills and time empties, of times spread over three decades; discharge
 * empties all of them at once.
 *
 *     tau_k dz_k/dt = (i)+ - z_k (1 + (-i)+ / i_r),   Z = sum_k w_k z_k / 20 A,  w_k ~ tau_k^-g
 *     v = V Z / sqrt(1 + Z^2)
 *
 * Power law of memory from spread times (Schweidler 1907; Scher and Montroll 1975).
 */
class SpreadRefill : public OutOfModelVoltage {
 public:
  SpreadRefill(Dice& dice, const Circumstances& drive)
      : undoing_(dice.between({2.0, 15.0})), shortest_(dice.between({1.0, 4.0})) {
    const double power = dice.between({-0.3, 0.3});
    const double longest = std::min(1500.0, 0.4 * drive.duration);
    double sum = 0.0;
    for (std::size_t k = 0; k < kSites; ++k) {
      time_[k] = shortest_ * std::pow(longest / shortest_, k / (kSites - 1.0));
      sum += weight_[k] = std::pow(time_[k], -power);
    }
    for (double& weight : weight_) weight /= sum;
  }

  State advance(const State& x, const OutOfModelInstant& now) const override {
    State next = x;
    for (std::size_t k = 0; k < kSites; ++k)
      next[k] +=
          now.step / time_[k] * (now.charging() - x[k] * (1.0 + now.discharging() / undoing_));
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < kSites; ++k) sum += weight_[k] * x[k];
    return 2.0 * kShown * (sum / 20.0) / std::hypot(1.0, sum / 20.0);
  }

 private:
  static constexpr std::size_t kSites = 9;
  double undoing_, shortest_;
  std::array<double, kSites> time_{}, weight_{};
};

}  // namespace

std::vector<OutOfModelForm> acceptanceForms() {
  const std::string mechanism = "acceptance";
  return {formOf<CrystalPopulation>(mechanism, "crystal_population"),
          formOf<DiffusionLayer>(mechanism, "diffusion_layer"),
          formOf<FreshnessGate>(mechanism, "freshness_gate"),
          formOf<SpreadRefill>(mechanism, "spread_refill")};
}

}  // namespace battery_sof_reference

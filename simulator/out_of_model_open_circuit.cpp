#include "simulator/out_of_model_force.hpp"

namespace battery_sof_reference {
namespace {

constexpr double kSecondsPerHour = 3600.0;

/// Of the charge over a drive [As], at least what an hour's 0.1 A gives.
double spanOf(const Circumstances& drive) {
  return std::max(360.0, drive.highest_as - drive.lowest_as);
}

/**
 * An open-circuit voltage of charge with a bend that no straight line or parabola follows.
 *
 *     y = (q - q_0) / span,   v = V y (y^2 + 0.001)^((p - 1) / 2),   p 0.45 to 0.7 or 1.6 to 2.2
 *
 * EMF over acid strength rises unevenly (Bode, Lead-Acid Batteries, 1977), more so where some
 * active mass is used up first.
 */
class BentEmf : public OutOfModelVoltage {
 public:
  BentEmf(Dice& dice, const Circumstances& drive)
      : centre_(drive.lowest_as + dice.between({0.25, 0.75}) * spanOf(drive)),
        span_(spanOf(drive)),
        power_(dice.share() < 0.5 ? dice.between({0.45, 0.7}) : dice.between({1.6, 2.2})) {}

  State advance(const State& x, const OutOfModelInstant&) const override { return x; }
  double voltage(const State&, const OutOfModelInstant& now) const override {
    return 0.06 * (bend(now.charge) - bend(0.0));
  }

 private:
  double bend(double charge) const {
    const double y = (charge - centre_) / span_;
    return y * std::pow(y * y + 1e-3, 0.5 * (power_ - 1.0));
  }
  double centre_, span_, power_;
};

/**
 * Hysteresis of charge as a sum of plays, each of which follows only after its own width.
 *
 *     y_k <- clamp(y_k, q - w_k, q + w_k),   v = V sum_k a_k (y_k - y_k(0)) / span,  a_k ~ w_k^-0.5
 *
 * Prandtl's and Ishlinskii's operator (Krasnosel'skii and Pokrovskii 1989), as used for batteries'
 * open-circuit voltage; it depends on the path, not on time, and forgets smaller loops.
 */
class SumOfPlays : public OutOfModelVoltage {
 public:
  SumOfPlays(Dice& dice, const Circumstances& drive) : span_(spanOf(drive)) {
    const double widest = dice.between({0.25, 0.45}) * span_;
    for (std::size_t k = 0; k < kPlays; ++k)
      width_[k] = widest * std::pow(0.02, 1.0 - k / (kPlays - 1.0));
  }

  State advance(const State& x, const OutOfModelInstant& now) const override {
    State next = x;
    for (std::size_t k = 0; k < kPlays; ++k)
      next[k] = std::clamp(x[k], now.charge - width_[k], now.charge + width_[k]);
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < kPlays; ++k) sum += x[k] / std::sqrt(width_[k] * span_);
    return 0.015 * sum;
  }

 private:
  static constexpr std::size_t kPlays = 12;
  double span_;
  std::array<double, kPlays> width_{};
};

/**
 * Many small parts of the active mass that switch at charges of their own, back later than forth.
 *
 *     dh_k = 2 dq / w while charging above a_k, or while discharging below b_k < a_k;  -1 <= h_k <=
 * 1 v = V sum_k h_k / 16
 *
 * Preisach (1935); Mayergoyz, Mathematical Models of Hysteresis (1991).
 */
class PreisachParts : public OutOfModelVoltage {
 public:
  PreisachParts(Dice& dice, const Circumstances& drive) : width_(0.15 * spanOf(drive)) {
    const double lag = dice.between({0.15, 0.4}) * spanOf(drive);
    for (std::size_t k = 0; k < kParts; ++k) {
      const double middle = drive.lowest_as + spanOf(drive) * (k + dice.share()) / kParts;
      const double half = lag * dice.share();
      above_[k] = middle + half;
      below_[k] = middle - half;
    }
  }

  State rested() const override {
    State state{};
    for (std::size_t k = 0; k < kParts; ++k)
      state[k] = 0.5 * (above_[k] + below_[k]) < 0.0 ? 1 : -1;
    return state;
  }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double moved = 2.0 * now.current * now.step / width_;
    State next = x;
    for (std::size_t k = 0; k < kParts; ++k) {
      const bool switching = moved > 0.0 ? now.charge > above_[k] : now.charge < below_[k];
      if (switching) next[k] = std::clamp(x[k] + moved, -1.0, 1.0);
    }
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < kParts; ++k) sum += x[k];
    return 0.06 * sum / kParts;
  }

 private:
  static constexpr std::size_t kParts = 16;
  double width_;
  std::array<double, kParts> above_{}, below_{};
};

/**
 * A dip when a discharge begins after charging, deeper the more was charged.
 *
 *     dx/dt = (-i)+ - (i)+ x / Q_x,   dA/dt = (i)+ (1 - A)^2 / Q_e - (-i)+ A^2 / Q_n
 *     v = -V A 2 y / (1 + y^2),   y = x / Q_x
 *
 * x: discharged since the turn. New crystals need an oversaturation that falls as they grow (coup
 * de fouet: Bernardi and others; Delaille et al., J. Power Sources 158 (2006)); rational, not
 * exponential.
 */
class NucleationDip : public OutOfModelVoltage {
 public:
  NucleationDip(Dice& dice, const Circumstances&)
      : rise_(logBetween(dice, {0.02, 0.12}) * kSecondsPerHour),
        building_(logBetween(dice, {0.1, 0.5}) * kSecondsPerHour),
        erasing_(logBetween(dice, {0.1, 0.5}) * kSecondsPerHour) {}

  State rested() const override { return {0.0, 0.5}; }
  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double open = 1.0 - x[1];
    const double out = now.discharging() - now.charging() * x[0] / rise_;
    const double ready =
        now.charging() * open * open / building_ - now.discharging() * x[1] * x[1] / erasing_;
    return {std::max(0.0, x[0] + now.step * out), std::clamp(x[1] + now.step * ready, 0.0, 1.0)};
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    const double y = x[0] / rise_;
    return -0.05 * x[1] * 2.0 * y / (1.0 + y * y);
  }

 private:
  double rise_, building_, erasing_;
};

}  // namespace

std::vector<OutOfModelForm> openCircuitForms() {
  const std::string mechanism = "open_circuit";
  return {formOf<BentEmf>(mechanism, "bent_emf"), formOf<SumOfPlays>(mechanism, "sum_of_plays"),
          formOf<PreisachParts>(mechanism, "preisach_parts"),
          formOf<NucleationDip>(mechanism, "nucleation_dip")};
}

}  // namespace battery_sof_reference

#include "simulator/out_of_model_force.hpp"

#include "simulator/pi.hpp"

namespace battery_sof_reference {
namespace {

/// Shortest time that a recording still shows [s]: two samples, at least a twentieth of a second.
double shortestShown(const Circumstances& drive) {
  return std::max(0.05, 2.0 / drive.sample_rate_hz);
}

/**
 * A depressed arc: resistance beside a constant phase element, by its spread of times.
 *
 *     Z = R / (1 + (j w tau_0)^a),   v = R sum_k g_k z_k,   tau_k dz_k/dt = i - z_k
 *     g(ln tau) = sin((1 - a) pi) / (2 pi (cosh(a ln(tau / tau_0)) - cos((1 - a) pi)))
 *
 * Cole and Cole, J. Chem. Phys. 9 (1941). Thirteen times, three a decade.
 */
class DepressedArc : public OutOfModelVoltage {
 public:
  DepressedArc(Dice& dice, const Circumstances& drive) {
    const double power = dice.between({0.5, 0.75});
    const double centre = std::max(logBetween(dice, {0.3, 8.0}), 2.0 * shortestShown(drive));
    double sum = 0.0;
    for (std::size_t k = 0; k < kTimes; ++k) {
      const double decades = (static_cast<double>(k) - 0.5 * (kTimes - 1)) / 3.0;
      time_[k] = std::max(0.02, centre * std::pow(10.0, decades));
      const double spread = std::cosh(power * std::log(10.0) * decades);
      sum += weight_[k] = std::sin((1.0 - power) * kPi) / (spread - std::cos((1.0 - power) * kPi));
    }
    for (double& weight : weight_) weight /= sum;
  }

  State advance(const State& x, const OutOfModelInstant& now) const override {
    State next = x;
    for (std::size_t k = 0; k < kTimes; ++k) next[k] += now.step / time_[k] * (now.current - x[k]);
    return next;
  }
  double voltage(const State& x, const OutOfModelInstant&) const override {
    double sum = 0.0;
    for (std::size_t k = 0; k < kTimes; ++k) sum += weight_[k] * x[k];
    return 1.5e-3 * sum;
  }

 private:
  static constexpr std::size_t kTimes = 13;
  std::array<double, kTimes> time_{}, weight_{};
};

/**
 * A film that conducts by the charge brought into it, so that its voltage goes with a root of the
 * current.
 *
 *     v = V sgn(i) [ (|i| / i_f + 0.01)^m - 0.01^m ],   m 0.35 to 0.6
 *
 * Space-charge-limited current (Mott and Gurney 1940: m = 1/2), oxide films on lead: Pavlov (2011).
 */
class ConductingFilm : public OutOfModelVoltage {
 public:
  ConductingFilm(Dice& dice, const Circumstances&)
      : scale_(logBetween(dice, {8.0, 60.0})), power_(dice.between({0.35, 0.6})) {}

  State advance(const State& x, const OutOfModelInstant&) const override { return x; }
  double voltage(const State&, const OutOfModelInstant& now) const override {
    const double size = std::pow(std::abs(now.current) / scale_ + kFloor, power_);
    return std::copysign(0.05 * (size - std::pow(kFloor, power_)), now.current);
  }

 private:
  static constexpr double kFloor = 0.01;
  double scale_, power_;
};

/**
 * Something adsorbed that the current moves to and fro between empty and full, and that pairs of
 * it relax.
 *
 *     dh/dt = i / Q (1 - h sgn i) - h |h| / tau,   v = V h
 *
 * Pseudocapacitance with few sites (Conway 1999); relaxation of second order falls as 1/t.
 */
class AdsorbedSites : public OutOfModelVoltage {
 public:
  AdsorbedSites(Dice& dice, const Circumstances& drive)
      : charge_(logBetween(dice, {30.0, 300.0})),
        time_(std::max(logBetween(dice, {3.0, 60.0}), 4.0 * shortestShown(drive))) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double open = 1.0 - (now.current > 0.0 ? x[0] : -x[0]);
    const double rate = now.current / charge_ * open - x[0] * std::abs(x[0]) / time_;
    return {std::clamp(x[0] + now.step * rate, -1.0, 1.0)};
  }
  double voltage(const State& x, const OutOfModelInstant&) const override { return 0.05 * x[0]; }

 private:
  double charge_, time_;
};

/**
 * Another electrode whose current goes with the square of its voltage.
 *
 *     dy/dt = (i - 40 A y |y|^(n - 1)) / Q,   v = V y,   n 1.7 to 3
 *
 * A power law between ohmic and Tafel kinetics, as of a surface with a spread of barriers.
 */
class PowerElectrode : public OutOfModelVoltage {
 public:
  PowerElectrode(Dice& dice, const Circumstances& drive)
      : charge_(std::max(logBetween(dice, {20.0, 500.0}), 40.0 * shortestShown(drive))),
        power_(dice.between({1.7, 3.0})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double back = 40.0 * x[0] * std::pow(std::abs(x[0]), power_ - 1.0);
    return {x[0] + now.step * (now.current - back) / charge_};
  }
  double voltage(const State& x, const OutOfModelInstant&) const override { return 0.05 * x[0]; }

 private:
  double charge_, power_;
};

}  // namespace

std::vector<OutOfModelForm> structureForms() {
  const std::string mechanism = "structure";
  return {formOf<DepressedArc>(mechanism, "depressed_arc"),
          formOf<ConductingFilm>(mechanism, "conducting_film"),
          formOf<AdsorbedSites>(mechanism, "adsorbed_sites"),
          formOf<PowerElectrode>(mechanism, "power_electrode")};
}

}  // namespace battery_sof_reference

#include "simulator/out_of_model_force.hpp"

namespace battery_sof_reference {
namespace {

/**
 * A resistance that grows with a power of time.
 *
 *     v = R i (t / T)^p,   p 0.4 to 0.7 or 1.7 to 2.5,  T: the drive's length
 *
 * Layers grow so: p = 1/2 by diffusion through them, above 1 once they crack (Lander 1956,
 * corrosion of lead grids).
 */
class GrowingLayer : public OutOfModelVoltage {
 public:
  GrowingLayer(Dice& dice, const Circumstances& drive)
      : length_(drive.duration),
        power_(dice.share() < 0.5 ? dice.between({0.4, 0.7}) : dice.between({1.7, 2.5})) {}

  State advance(const State& x, const OutOfModelInstant&) const override { return x; }
  double voltage(const State&, const OutOfModelInstant& now) const override {
    return 2e-3 * now.current * std::pow(now.time / length_, power_);
  }

 private:
  double length_, power_;
};

/**
 * The block warms inside first; warm acid and plates conduct better.
 *
 *     C_1 dT_1/dt = 8 mOhm i^2 - g (T_1 - T_2),   C_2 dT_2/dt = g (T_1 - T_2) - h T_2
 *     v = -R i [ 1 - (1 + T_1 / 20 K)^-m ]
 *
 * Two bodies, the inside and the case; a power law near the measured 0.5 to 1 % a kelvin of acid
 * (Bode 1977), amplified by the strength.
 */
class WarmingInside : public OutOfModelVoltage {
 public:
  WarmingInside(Dice& dice, const Circumstances&)
      : inside_(logBetween(dice, {500.0, 4000.0})),
        case_(logBetween(dice, {2000.0, 8000.0})),
        across_(dice.between({2.0, 20.0})),
        outwards_(dice.between({1.0, 5.0})),
        power_(dice.between({1.0, 3.0})) {}

  State advance(const State& x, const OutOfModelInstant& now) const override {
    const double heat = 8e-3 * now.current * now.current, flow = across_ * (x[0] - x[1]);
    return {x[0] + now.step * (heat - flow) / inside_,
            x[1] + now.step * (flow - outwards_ * x[1]) / case_};
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    return -5e-3 * now.current * (1.0 - std::pow(1.0 + std::max(0.0, x[0]) / 20.0, -power_));
  }

 private:
  double inside_, case_, across_, outwards_, power_;
};

/**
 * Contacts inside the plates that work loose one after the other with the charge put through.
 *
 *     v = R i sum_k S((Q - Q_k) / W_k) / 3,   Q: integral of |i|,  S: smooth step,  k = 1 to 3
 *
 * Softening and shedding with throughput (Ruetschi, J. Power Sources 127 (2004)): a threshold each.
 */
class LooseningContacts : public OutOfModelVoltage {
 public:
  LooseningContacts(Dice& dice, const Circumstances& drive) {
    for (std::size_t k = 0; k < kContacts; ++k) {
      from_[k] = drive.throughput_as * (static_cast<double>(k) + 0.7 * dice.share()) / kContacts;
      width_[k] = drive.throughput_as * dice.between({0.1, 0.3});
    }
  }

  State advance(const State& x, const OutOfModelInstant& now) const override {
    return {x[0] + now.step * std::abs(now.current)};
  }
  double voltage(const State& x, const OutOfModelInstant& now) const override {
    double loose = 0.0;
    for (std::size_t k = 0; k < kContacts; ++k) loose += smoothStep((x[0] - from_[k]) / width_[k]);
    return 2e-3 * now.current * loose / kContacts;
  }

 private:
  static constexpr std::size_t kContacts = 3;
  std::array<double, kContacts> from_{}, width_{};
};

/**
 * Active surface that is lost by and by: the overpotential grows.
 *
 *     v = 0.4 u2 y^n / (1 + y^n),   y = t / T,  T 0.5 to 1.2 of the drive's length, n 1.5 to 3
 *
 * Loss of a limited stock by an S-shaped law (Avrami 1939), rational here.
 */
class FadingSurface : public OutOfModelVoltage {
 public:
  FadingSurface(Dice& dice, const Circumstances& drive)
      : time_(drive.duration * dice.between({0.5, 1.2})), order_(dice.between({1.5, 3.0})) {}

  State advance(const State& x, const OutOfModelInstant&) const override { return x; }
  double voltage(const State&, const OutOfModelInstant& now) const override {
    return 0.4 * now.u2 * saturated(std::pow(now.time / time_, order_));
  }

 private:
  double time_, order_;
};

}  // namespace

std::vector<OutOfModelForm> ageingForms() {
  const std::string mechanism = "ageing";
  return {formOf<GrowingLayer>(mechanism, "growing_layer"),
          formOf<WarmingInside>(mechanism, "warming_inside"),
          formOf<LooseningContacts>(mechanism, "loosening_contacts"),
          formOf<FadingSurface>(mechanism, "fading_surface")};
}

const std::vector<OutOfModelForm>& outOfModelForms() {
  static const std::vector<OutOfModelForm> all = [] {
    std::vector<OutOfModelForm> forms;
    for (const auto& mechanism : {acceptanceForms(), sideReactionForms(), acidForms(),
                                  openCircuitForms(), structureForms(), ageingForms()})
      forms.insert(forms.end(), mechanism.begin(), mechanism.end());
    return forms;
  }();
  return all;
}

}  // namespace battery_sof_reference

#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
namespace {

/**
 * A resistance that grows with a power of time.
 *
 *     v = R i (t / T)^p,   p 0.4 to 0.7 or 1.7 to 2.5,  T: the drive's length
 *
 * Layers grow so: p = 1/2 by diffusion through them, above 1 once they crack (Lander 1956,
 * corrosion of lead grids).
 */
Law growingLayer(Dice& dice, const Circumstances& drive) {
  const double length = drive.duration,
               power = dice.share() < 0.5 ? dice.between({0.4, 0.7}) : dice.between({1.7, 2.5});
  Law law;
  law.added = [=](const Law::State&, const LawInstant& now) {
    return 2e-3 * now.current * std::pow(now.time / length, power);
  };
  return law;
}

/**
 * The block warms inside first; warm acid and plates conduct better.
 *
 *     C_1 dT_1/dt = 8 mOhm i^2 - g (T_1 - T_2),   C_2 dT_2/dt = g (T_1 - T_2) - h T_2
 *     v = -R i [ 1 - (1 + T_1 / 20 K)^-m ]
 *
 * Two bodies, the inside and the case; a power law near the measured 0.5 to 1 % a kelvin of acid
 * (Bode 1977), amplified by the strength.
 */
Law warmingInside(Dice& dice, const Circumstances&) {
  const double inside = dice.logBetween({500.0, 4000.0}),
               outside = dice.logBetween({2000.0, 8000.0});
  const double across = dice.between({2.0, 20.0}), outwards = dice.between({1.0, 5.0}),
               power = dice.between({1.0, 3.0});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double heat = 8e-3 * now.current * now.current, flow = across * (x[0] - x[1]);
    return Law::State{x[0] + now.step * (heat - flow) / inside,
                      x[1] + now.step * (flow - outwards * x[1]) / outside};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return -5e-3 * now.current * (1.0 - std::pow(1.0 + std::max(0.0, x[0]) / 20.0, -power));
  };
  return law;
}

/**
 * Contacts inside the plates that work loose one after the other with the charge put through.
 *
 *     v = R i sum_k S((Q - Q_k) / W_k) / 3,   Q: integral of |i|,  S: smooth step,  k = 1 to 3
 *
 * Softening and shedding with throughput (Ruetschi, J. Power Sources 127 (2004)): a threshold each.
 */
Law looseningContacts(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kContacts = 3;
  std::array<double, kContacts> from{}, width{};
  for (std::size_t k = 0; k < kContacts; ++k) {
    from[k] = drive.throughput_as * (static_cast<double>(k) + 0.7 * dice.share()) / kContacts;
    width[k] = drive.throughput_as * dice.between({0.1, 0.3});
  }
  Law law;
  law.moved = [](const Law::State& x, const LawInstant& now) {
    return Law::State{x[0] + now.step * std::abs(now.current)};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    double loose = 0.0;
    for (std::size_t k = 0; k < kContacts; ++k) loose += smoothStep((x[0] - from[k]) / width[k]);
    return 2e-3 * now.current * loose / kContacts;
  };
  return law;
}

/**
 * Active surface that is lost by and by: the overpotential grows.
 *
 *     v = 0.4 u2 y^n / (1 + y^n),   y = t / T,  T 0.5 to 1.2 of the drive's length, n 1.5 to 3
 *
 * Loss of a limited stock by an S-shaped law (Avrami 1939), rational here.
 */
Law fadingSurface(Dice& dice, const Circumstances& drive) {
  const double time = drive.duration * dice.between({0.5, 1.2}), order = dice.between({1.5, 3.0});
  Law law;
  law.added = [=](const Law::State&, const LawInstant& now) {
    return 0.4 * now.u2 * saturated(std::pow(now.time / time, order));
  };
  return law;
}

}  // namespace

std::vector<LawForm> ageingLaws() {
  return {{"ageing", "growing_layer", growingLayer},
          {"ageing", "warming_inside", warmingInside},
          {"ageing", "loosening_contacts", looseningContacts},
          {"ageing", "fading_surface", fadingSurface}};
}

}  // namespace battery_sof_simulator

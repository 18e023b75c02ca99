#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
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
Law poreDiffusion(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kSlices = 14;
  const double time = dice.logBetween({60.0, std::min(1200.0, 0.5 * drive.duration)}),
               faster = dice.between({0.3, 1.0});
  Law law;
  std::fill_n(law.rested.begin(), kSlices, 1.0);
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double rate = now.step * kSlices * kSlices / time;
    double inflow = now.current / 100.0 / kSlices;
    Law::State next = x;
    for (std::size_t k = 0; k < kSlices; ++k) {
      const double after = k + 1 == kSlices ? 1.0 : x[k + 1];
      const double ease = std::max(0.1, 1.0 + faster * (0.5 * (x[k] + after) - 1.0));
      const double outflow = ease * (x[k] - after);
      next[k] = std::clamp(x[k] + rate * (inflow - outflow), 0.0, 3.0);
      inflow = outflow;
    }
    return next;
  };
  law.added = [](const Law::State& x, const LawInstant&) {
    const double more = x[0] - 1.0;
    return 0.1 * (more + 0.4 * more * std::abs(more));
  };
  return law;
}

/**
 * Memory by a power law: after a step of current the voltage goes with t^a.
 *
 *     tau_k dz_k/dt = f(i) - z_k,   v = R sum_k w_k z_k,  w_k ~ tau_k^a,  f(i) = i, charging: b i
 *
 * Twelve times from 1 s to a third of the drive. Anomalous diffusion in a disordered porous body:
 * Bisquert and Compte, J. Electroanal. Chem. 499 (2001).
 */
Law anomalousDiffusion(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kTimes = 12;
  const double charging_share = dice.between({0.6, 1.0}), power = dice.between({0.3, 0.6});
  const double longest = drive.duration * dice.between({0.15, 0.35});
  Memories<kTimes> memories;
  for (std::size_t k = 0; k < kTimes; ++k) {
    memories.time[k] = std::pow(longest, k / (kTimes - 1.0));
    memories.weight[k] = std::pow(memories.time[k], power);
  }
  memories.normalise();
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    return memories.advance(x, now.step,
                            now.current > 0.0 ? charging_share * now.current : now.current);
  };
  law.added = [=](const Law::State& x, const LawInstant&) { return 3e-3 * memories.mean(x); };
  return law;
}

/**
 * Pores that a heavy discharge empties of acid, and a free volume that fills them again.
 *
 *     dp/dt = [0.7 (i)+ - (-i)+] / Q_p + e,   db/dt = -0.2 e + (1 - b) / tau_b
 *     e = p^1.5 (b - p) / tau_p,   p >= 0.04
 *     v = -V (-i)+ / ((-i)+ + 40 A) [ 1 / (p + K) - 1 / (1 + K) ]
 *
 * Exhaustion of pores: Newman and Tiedemann, AIChE J. 21 (1975); tortuosity: Bruggeman (1935).
 */
Law poreExhaustion(Dice& dice, const Circumstances&) {
  const double charge = dice.logBetween({300.0, 1500.0}), refilling = dice.logBetween({8.0, 50.0}),
               mixing = dice.logBetween({100.0, 600.0}), half = dice.between({0.1, 0.5});
  Law law;
  law.rested = {1.0, 1.0};
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double exchange = std::pow(x[0], 1.5) * (x[1] - x[0]) / refilling;
    const double made = (0.7 * now.charging() - now.discharging()) / charge;
    return Law::State{std::clamp(x[0] + now.step * (made + exchange), 0.04, 1.5),
                      x[1] + now.step * ((1.0 - x[1]) / mixing - 0.2 * exchange)};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return -0.03 * saturated(now.discharging() / 40.0) * (1.0 / (x[0] + half) - 1.0 / (1.0 + half));
  };
  return law;
}

/**
 * Acid made in one plate is felt by the other after its way through the separator.
 *
 *     dz_1/dt = n (i - z_1) / d,   dz_k/dt = n (z_(k-1) - z_k) / d, k = 2 to n = 10
 *     v = R z_n / (1 + |z_n| / 80 A)
 *
 * A delay with spread, as vessels in a row (Levenspiel 1962).
 */
Law separatorDelay(Dice& dice, const Circumstances&) {
  static constexpr std::size_t kVessels = 10;
  const double delay = dice.logBetween({12.0, 90.0});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    Law::State next = x;
    for (std::size_t k = 0; k < kVessels; ++k)
      next[k] += now.step * kVessels / delay * ((k == 0 ? now.current : x[k - 1]) - x[k]);
    return next;
  };
  law.added = [](const Law::State& x, const LawInstant&) {
    const double late = x[kVessels - 1];
    return 1.5e-3 * late / (1.0 + std::abs(late) / 80.0);
  };
  return law;
}

}  // namespace

std::vector<LawForm> acidLaws() {
  return {{"acid", "pore_diffusion", poreDiffusion},
          {"acid", "anomalous_diffusion", anomalousDiffusion},
          {"acid", "pore_exhaustion", poreExhaustion},
          {"acid", "separator_delay", separatorDelay}};
}

}  // namespace battery_sof_simulator

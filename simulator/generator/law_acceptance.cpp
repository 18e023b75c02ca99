#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
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
Law crystalPopulation(Dice& dice, const Circumstances&) {
  const double stock = dice.logBetween({150.0, 1200.0}), merging = dice.logBetween({60.0, 600.0}),
               free = dice.between({0.15, 0.4}), power = dice.between({0.5, 0.8});
  const auto surface = [=](double sulphate) {
    return std::cbrt(sulphate * sulphate / (stock * stock));
  };
  Law law;
  law.rested = {0.3 * stock, stock};
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double fine = surface(x[0]), coarse = 0.3 * surface(x[1]), all = fine + coarse + 1e-9;
    const double merged = x[0] * x[0] / (stock * merging);
    const double fine_next =
        x[0] + now.step * (now.discharging() - now.charging() * fine / all - merged);
    const double coarse_next = x[1] + now.step * (merged - now.charging() * coarse / all);
    return Law::State{std::max(fine_next, 0.0), std::clamp(coarse_next, 0.0, 3.0 * stock)};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return kShown * std::pow(now.charging() / kUsualCharge, power) /
           (free + surface(x[0]) + 0.3 * surface(x[1]));
  };
  return law;
}

/**
 * Dissolved lead in a layer before the electrode, by Fick's law in ten slices.
 *
 *     dc/dt = d2c/dx2 / tau,  flux at x = 0: [a (-i)+ - (i)+] / i_L,  c = 1 at x = 1
 *     v = V i+ / (i+ + 20 A) (1 - c_0) / (c_0 + K),   c_0 = c(0), 0 to 1.5
 *
 * Depletes with the square root of time (Sand 1901); the cost of depletion saturates.
 */
Law diffusionLayer(Dice& dice, const Circumstances&) {
  static constexpr std::size_t kSlices = 10;
  const double time = dice.logBetween({30.0, 300.0}), limit = dice.between({15.0, 45.0}),
               returned = dice.between({0.5, 1.0}), half = dice.between({0.1, 0.4});
  Law law;
  std::fill_n(law.rested.begin(), kSlices, 1.0);
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double rate = now.step * kSlices * kSlices / time;
    const double inflow = (returned * now.discharging() - now.charging()) / limit;
    Law::State next = x;
    for (std::size_t k = 0; k < kSlices; ++k) {
      const double before = k == 0 ? x[0] + inflow / kSlices : x[k - 1];
      const double after = k + 1 == kSlices ? 1.0 : x[k + 1];
      next[k] = std::clamp(x[k] + rate * (before - 2.0 * x[k] + after), 0.0, 1.5);
    }
    return next;
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return 2.0 * kShown * saturated(now.charging() / 20.0) * (1.0 - x[0]) / (x[0] + half);
  };
  return law;
}

/**
 * What a discharge has just left is easy to charge back; the rest is behind a gate.
 *
 *     dP/dt = (-i)+ - (i)+ P / (P + P_h) - P^2 / (P_h tau)
 *     v = V i+ / (i+ + i_h) / (1 + (P / P_h)^n)
 *
 * Short-term history of charge acceptance: Budde-Meiwes et al., J. Power Sources 207 (2012); gate
 * after Hill (1910); the freshness is lost by a second-order law, slower than any exponential.
 */
Law freshnessGate(Dice& dice, const Circumstances&) {
  const double half = dice.logBetween({80.0, 500.0}), time = dice.logBetween({60.0, 900.0}),
               knee = dice.between({5.0, 25.0}), order = dice.between({2.0, 4.0});
  Law law;
  law.rested = {half};
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double taken = now.charging() * saturated(x[0] / half);
    const double lost = x[0] * x[0] / (half * time);
    return Law::State{std::max(0.0, x[0] + now.step * (now.discharging() - taken - lost))};
  };
  law.added = [=](const Law::State& x, const LawInstant& now) {
    return 2.0 * kShown * saturated(now.charging() / knee) / (1.0 + std::pow(x[0] / half, order));
  };
  return law;
}

/**
 * Sites that charging fills and time empties, of times spread over three decades; discharge
 * empties all of them at once.
 *
 *     tau_k dz_k/dt = (i)+ - z_k (1 + (-i)+ / i_r),   Z = sum_k w_k z_k / 20 A,  w_k ~ tau_k^-g
 *     v = V Z / sqrt(1 + Z^2)
 *
 * Power law of memory from spread times (Schweidler 1907; Scher and Montroll 1975).
 */
Law spreadRefill(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kSites = 9;
  const double undoing = dice.between({2.0, 15.0}), shortest = dice.between({1.0, 4.0}),
               power = dice.between({-0.3, 0.3});
  const double longest = std::min(1500.0, 0.4 * drive.duration);
  Memories<kSites> sites;
  for (std::size_t k = 0; k < kSites; ++k) {
    sites.time[k] = shortest * std::pow(longest / shortest, k / (kSites - 1.0));
    sites.weight[k] = std::pow(sites.time[k], -power);
  }
  sites.normalise();
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    return sites.advance(x, now.step, now.charging(), 1.0 + now.discharging() / undoing);
  };
  law.added = [=](const Law::State& x, const LawInstant&) {
    const double filled = sites.mean(x) / 20.0;
    return 2.0 * kShown * filled / std::hypot(1.0, filled);
  };
  return law;
}

}  // namespace

std::vector<LawForm> acceptanceLaws() {
  return {{"acceptance", "crystal_population", crystalPopulation},
          {"acceptance", "diffusion_layer", diffusionLayer},
          {"acceptance", "freshness_gate", freshnessGate},
          {"acceptance", "spread_refill", spreadRefill}};
}

}  // namespace battery_sof_simulator

#include "simulator/generator/law.hpp"

namespace battery_sof_simulator {
namespace {

constexpr double kUsualCharge = 30.0;  // [A]
constexpr double kShown = 0.02;        // [V] at strength 1

/// Fine and coarse sulphate crystals; charge dissolves both, each by its surface.
///     a_f = (S_f / S_0)^(2/3),  a_g = 0.3 (S_g / S_0)^(2/3)
///     dS_f/dt = (-i)+ - (i)+ a_f / (a_f + a_g) - S_f^2 / (S_0 tau)
///     dS_g/dt = S_f^2 / (S_0 tau) - (i)+ a_g / (a_f + a_g)
///     v = V (i+ / 30 A)^m / (a_0 + a_f + a_g)
/// Surface to the power 2/3 of the volume; small crystals merge by pairs (Smoluchowski 1916).
/// Crystals in charging: Kirchev et al., J. Power Sources 145 (2005); Thele et al. (2006).
void crystalPopulation(Law& law, Dice& dice, const Circumstances&) {
  const double stock = dice.logBetween({150.0, 1200.0}), merging = dice.logBetween({60.0, 600.0}),
               free = dice.between({0.15, 0.4}), power = dice.between({0.5, 0.8});
  const auto surface = [=](double sulphate) {
    return std::cbrt(sulphate * sulphate / (stock * stock));
  };
  law.rested = {0.3 * stock, stock};
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double fine = surface(x[0]), coarse = 0.3 * surface(x[1]), all = fine + coarse + 1e-9;
    const double merged = x[0] * x[0] / (stock * merging);
    const double fine_next =
        x[0] + now.step * (now.discharging() - now.charging() * fine / all - merged);
    const double coarse_next = x[1] + now.step * (merged - now.charging() * coarse / all);
    return Law::State{std::max(fine_next, 0.0), std::clamp(coarse_next, 0.0, 3.0 * stock)};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return kShown * std::pow(now.charging() / kUsualCharge, power) /
           (free + surface(x[0]) + 0.3 * surface(x[1]));
  };
}

/// Dissolved lead in a layer before the electrode, by Fick's law in ten slices.
///     dc/dt = d2c/dx2 / tau,  flux at x = 0: [a (-i)+ - (i)+] / i_L,  c = 1 at x = 1
///     v = V i+ / (i+ + 20 A) (1 - c_0) / (c_0 + K),   c_0 = c(0), 0 to 1.5
/// Depletes with the square root of time (Sand 1901); the cost of depletion saturates.
void diffusionLayer(Law& law, Dice& dice, const Circumstances&) {
  static constexpr std::size_t kSlices = 10;
  const double time = dice.logBetween({30.0, 300.0}), limit = dice.between({15.0, 45.0}),
               returned = dice.between({0.5, 1.0}), half = dice.between({0.1, 0.4});
  std::fill_n(law.rested.begin(), kSlices, 1.0);
  law.advance = [=](const Law::State& x, const LawInstant& now) {
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
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return 2.0 * kShown * saturated(now.charging() / 20.0) * (1.0 - x[0]) / (x[0] + half);
  };
}

/// What a discharge has just left is easy to charge back; the rest is behind a gate.
///     dP/dt = (-i)+ - (i)+ P / (P + P_h) - P^2 / (P_h tau)
///     v = V i+ / (i+ + i_h) / (1 + (P / P_h)^n)
/// Short-term history of charge acceptance: Budde-Meiwes et al., J. Power Sources 207 (2012); gate
/// after Hill (1910); the freshness is lost by a second-order law, slower than any exponential.
void freshnessGate(Law& law, Dice& dice, const Circumstances&) {
  const double half = dice.logBetween({80.0, 500.0}), time = dice.logBetween({60.0, 900.0}),
               knee = dice.between({5.0, 25.0}), order = dice.between({2.0, 4.0});
  law.rested = {half};
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double taken = now.charging() * saturated(x[0] / half);
    const double lost = x[0] * x[0] / (half * time);
    return Law::State{std::max(0.0, x[0] + now.step * (now.discharging() - taken - lost))};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return 2.0 * kShown * saturated(now.charging() / knee) / (1.0 + std::pow(x[0] / half, order));
  };
}

/// Sites that charging fills and time empties, spread over three decades; discharge empties all.
///     tau_k dz_k/dt = (i)+ - z_k (1 + (-i)+ / i_r),   Z = sum_k w_k z_k / 20 A,  w_k ~ tau_k^-g
///     v = V Z / sqrt(1 + Z^2)
/// Power law of memory from spread times (Schweidler 1907; Scher and Montroll 1975).
void spreadRefill(Law& law, Dice& dice, const Circumstances& drive) {
  const double undoing = dice.between({2.0, 15.0}), shortest = dice.between({1.0, 4.0}),
               power = dice.between({-0.3, 0.3});
  const double longest = std::min(1500.0, 0.4 * drive.duration);
  const auto sites = Memories<9>::powerLaw(shortest, longest, -power);
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    return sites.advance(x, now.step, now.charging(), 1.0 + now.discharging() / undoing);
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) {
    const double filled = sites.mean(x) / 20.0;
    return 2.0 * kShown * filled / std::hypot(1.0, filled);
  };
}

constexpr double kMaxSide = 15.0;  // [A] at strength 1
// [V] above the onset, of the order of a Tafel slope of six cells
constexpr double kWindow = 0.15;

/// What side reactions draw: the voltage u_0 + u2 at which the reaction sets in [V].
double onsetOf(Dice& dice, const Circumstances& drive) {
  return dice.between({drive.onset_low_v, drive.onset_high_v});
}

/// Stirred vessels in a row (Levenspiel 1962), a step on. @param rate of each, times the step.
template <std::size_t count>
Law::State throughVessels(const Law::State& x, double rate, double inflow) {
  Law::State next = x;
  for (std::size_t k = 0; k < count; ++k) next[k] += rate * ((k == 0 ? inflow : x[k - 1]) - x[k]);
  return next;
}

double above(const LawInstant& now, double onset) {
  return std::max(0.0, (now.u_x - onset) / kWindow);
}

/// Oxygen reaches the negative plate through a separator that overcharge dries.
///     x = (u_x - U)+ / 0.15 V,   i_side = 3 A x^n (1 + 2 m)
///     dm/dt = x (1 - m) / tau - m^2 / (4 tau)
/// Gas channels open as acid is displaced: Culpin and Peters 1980s; Bernardi and Carpenter, J.
/// Electrochem. Soc. 142 (1995). A power law, as of percolation, not Tafel's exponential.
void dryingSeparator(Law& law, Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), power = dice.between({1.3, 2.5}),
               time = dice.logBetween({30.0, 200.0});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double opening = std::min(1.0, above(now, onset)) * (1.0 - x[0]);
    return Law::State{std::max(0.0, x[0] + now.step / time * (opening - 0.25 * x[0] * x[0]))};
  };
  law.sideCurrent = [=](const Law::State& x, const LawInstant& now) {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset), power) * (1.0 + 2.0 * x[0]));
  };
}

/// Gas bubbles cover the plates while the reaction runs.
///     i_side = 3 A x^1.5 (1 - b),   db/dt = x (1 - b)^2 / tau_1 - b / tau_2
///     v = R i+ [(1 - b)^-1.5 - 1]
/// Acid with bubbles: Bruggeman (1935); coverage: Vogt and Balzer, Electrochim. Acta 50 (2005).
void bubbleCover(Law& law, Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), covering = dice.logBetween({5.0, 40.0}),
               leaving = dice.logBetween({5.0, 60.0}), resistance = dice.between({0.3e-3, 0.8e-3});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - x[0], rising = std::min(2.0, above(now, onset)) * open * open;
    return Law::State{std::clamp(x[0] + now.step * (rising / covering - x[0] / leaving), 0.0, 0.9)};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return resistance * now.charging() * (std::pow(1.0 - x[0], -1.5) - 1.0);
  };
  law.sideCurrent = [=](const Law::State& x, const LawInstant& now) {
    return std::min(kMaxSide, 3.0 * std::pow(above(now, onset), 1.5) * (1.0 - x[0]));
  };
}

/// Oxygen builds up pressure and depolarises the negative plate some time later.
///     i_side = 6 A S(x),   S: smooth step from 0 to 1
///     dp_1/dt = 4 (i_side / 6 A - p_1) / tau,   dp_k/dt = 4 (p_(k-1) - p_k) / tau, k = 2 to 4
///     v = -V sqrt(p_4)
/// The way through gas space and film as four stirred vessels in a row (Levenspiel 1962);
/// recombination that lowers the negative's potential: Dietz et al., J. Power Sources 14 (1985).
void pressureRecombination(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kVessels = 4;
  const double onset = onsetOf(dice, drive), time = dice.logBetween({15.0, 120.0}),
               depth = dice.between({0.005, 0.02});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    return throughVessels<kVessels>(x, now.step * kVessels / time, smoothStep(above(now, onset)));
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) {
    return -depth * std::sqrt(std::max(0.0, x[kVessels - 1]));
  };
  law.sideCurrent = [=](const Law::State&, const LawInstant& now) {
    return 6.0 * smoothStep(above(now, onset));
  };
}

/// An impurity that is oxidised at one plate and reduced at the other, as fast as it comes across.
///     i_side = 12 A S(x) y,   dy/dt = -i_side / Q + (z - y) / tau
///     dz/dt = (1 - z) / (5 tau) - (z - y) / (3 tau)
/// y, z: the reduced form at the plate and in the acid. Shuttles in lead-acid: Pavlov, Lead-Acid
/// Batteries (2011), ch. 13. Two compartments and a limit by transport.
void impurityShuttle(Law& law, Dice& dice, const Circumstances& drive) {
  const double onset = onsetOf(dice, drive), charge = dice.logBetween({100.0, 600.0}),
               time = dice.logBetween({20.0, 90.0});
  law.rested = {1.0, 1.0};
  const auto side = [=](const Law::State& x, const LawInstant& now) {
    return 12.0 * smoothStep(above(now, onset)) * x[0];
  };
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double across = (x[1] - x[0]) / time;
    const double plate = x[0] + now.step * (across - side(x, now) / charge);
    const double acid = x[1] + now.step * ((1.0 - x[1]) / (5.0 * time) - across / 3.0);
    return Law::State{std::max(0.0, plate), acid};
  };
  law.sideCurrent = side;
}

/// Acid in the plates' pores, by Fick's law in fourteen slices; strong acid diffuses faster.
///     dc/dt = d/dx [ (1 + g (c - 1)) dc/dx ] / tau,  flux at x = 0: i / 100 A,  c = 1 at x = 1
///     v = V [ (c_0 - 1) + 0.4 (c_0 - 1) |c_0 - 1| ]
/// Charging sets acid free. Diffusion that depends on strength: Sunu, J. Electrochem. Soc. 131
/// (1984); Gu et al. (1997). Begins with the square root of time.
void poreDiffusion(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kSlices = 14;
  const double time = dice.logBetween({60.0, std::min(1200.0, 0.5 * drive.duration)}),
               faster = dice.between({0.3, 1.0});
  std::fill_n(law.rested.begin(), kSlices, 1.0);
  law.advance = [=](const Law::State& x, const LawInstant& now) {
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
  law.voltage = [](const Law::State& x, const LawInstant&) {
    const double more = x[0] - 1.0;
    return 0.1 * (more + 0.4 * more * std::abs(more));
  };
}

/// Memory by a power law: after a step of current the voltage goes with t^a.
///     tau_k dz_k/dt = f(i) - z_k,   v = R sum_k w_k z_k,  w_k ~ tau_k^a,  f(i) = i, charging: b i
/// Twelve times from 1 s to a third of the drive. Anomalous diffusion in a disordered porous body:
/// Bisquert and Compte, J. Electroanal. Chem. 499 (2001).
void anomalousDiffusion(Law& law, Dice& dice, const Circumstances& drive) {
  const double charging_share = dice.between({0.6, 1.0}), power = dice.between({0.3, 0.6});
  const double longest = drive.duration * dice.between({0.15, 0.35});
  const auto memories = Memories<12>::powerLaw(1.0, longest, power);
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    return memories.advance(x, now.step,
                            now.current > 0.0 ? charging_share * now.current : now.current);
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) { return 3e-3 * memories.mean(x); };
}

/// Pores that a heavy discharge empties of acid, and a free volume that fills them again.
///     dp/dt = [0.7 (i)+ - (-i)+] / Q_p + e,   db/dt = -0.2 e + (1 - b) / tau_b
///     e = p^1.5 (b - p) / tau_p,   p >= 0.04
///     v = -V (-i)+ / ((-i)+ + 40 A) [ 1 / (p + K) - 1 / (1 + K) ]
/// Exhaustion of pores: Newman and Tiedemann, AIChE J. 21 (1975); tortuosity: Bruggeman (1935).
void poreExhaustion(Law& law, Dice& dice, const Circumstances&) {
  const double charge = dice.logBetween({300.0, 1500.0}), refilling = dice.logBetween({8.0, 50.0}),
               mixing = dice.logBetween({100.0, 600.0}), half = dice.between({0.1, 0.5});
  law.rested = {1.0, 1.0};
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double exchange = std::pow(x[0], 1.5) * (x[1] - x[0]) / refilling;
    const double made = (0.7 * now.charging() - now.discharging()) / charge;
    return Law::State{std::clamp(x[0] + now.step * (made + exchange), 0.04, 1.5),
                      x[1] + now.step * ((1.0 - x[1]) / mixing - 0.2 * exchange)};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return -0.03 * saturated(now.discharging() / 40.0) * (1.0 / (x[0] + half) - 1.0 / (1.0 + half));
  };
}

/// Acid made in one plate is felt by the other after its way through the separator.
///     dz_1/dt = n (i - z_1) / d,   dz_k/dt = n (z_(k-1) - z_k) / d, k = 2 to n = 10
///     v = R z_n / (1 + |z_n| / 80 A)
/// A delay with spread, as vessels in a row (Levenspiel 1962).
void separatorDelay(Law& law, Dice& dice, const Circumstances&) {
  static constexpr std::size_t kVessels = 10;
  const double delay = dice.logBetween({12.0, 90.0});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    return throughVessels<kVessels>(x, now.step * kVessels / delay, now.current);
  };
  law.voltage = [](const Law::State& x, const LawInstant&) {
    const double late = x[kVessels - 1];
    return 1.5e-3 * late / (1.0 + std::abs(late) / 80.0);
  };
}

/// Of the charge over a drive [As], at least what an hour's 0.1 A gives.
double spanOf(const Circumstances& drive) {
  return std::max(360.0, drive.highest_as - drive.lowest_as);
}

/// An open-circuit voltage of charge with a bend that no straight line or parabola follows.
///     y = (q - q_0) / span,   v = V y (y^2 + 0.001)^((p - 1) / 2),   p 0.45 to 0.7 or 1.6 to 2.2
/// EMF over acid strength rises unevenly (Bode 1977), more so where some active mass is used up.
void bentEmf(Law& law, Dice& dice, const Circumstances& drive) {
  const double centre = drive.lowest_as + dice.between({0.25, 0.75}) * spanOf(drive),
               span = spanOf(drive),
               power = dice.share() < 0.5 ? dice.between({0.45, 0.7}) : dice.between({1.6, 2.2});
  const auto bend = [=](double charge) {
    const double y = (charge - centre) / span;
    return y * std::pow(y * y + 1e-3, 0.5 * (power - 1.0));
  };
  law.voltage = [=](const Law::State&, const LawInstant& now) {
    return 0.06 * (bend(now.charge) - bend(0.0));
  };
}

/// Hysteresis of charge as a sum of plays, each of which follows only after its own width.
///     y_k <- clamp(y_k, q - w_k, q + w_k),  v = V sum_k a_k (y_k - y_k(0)) / span,  a_k ~ w_k^-0.5
/// Prandtl's and Ishlinskii's operator (Krasnosel'skii and Pokrovskii 1989), as used for batteries'
/// open-circuit voltage; it depends on the path, not on time, and forgets smaller loops.
void sumOfPlays(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kPlays = 12;
  const double span = spanOf(drive), widest = dice.between({0.25, 0.45}) * span;
  std::array<double, kPlays> width{};
  for (std::size_t k = 0; k < kPlays; ++k)
    width[k] = widest * std::pow(0.02, 1.0 - k / (kPlays - 1.0));
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    Law::State next = x;
    for (std::size_t k = 0; k < kPlays; ++k)
      next[k] = std::clamp(x[k], now.charge - width[k], now.charge + width[k]);
    return next;
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kPlays; ++k) sum += x[k] / std::sqrt(width[k] * span);
    return 0.015 * sum;
  };
}

/// Many small parts of the active mass that switch at charges of their own, back later than forth.
///     dh_k = 2 dq / w while charging above a_k, or while discharging below b_k < a_k
///     v = V sum_k h_k / 16,  -1 <= h_k <= 1
/// Preisach (1935); Mayergoyz, Mathematical Models of Hysteresis (1991).
void preisachParts(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kParts = 16;
  const double width = 0.15 * spanOf(drive), lag = dice.between({0.15, 0.4}) * spanOf(drive);
  std::array<double, kParts> above{}, below{};
  for (std::size_t k = 0; k < kParts; ++k) {
    const double middle = drive.lowest_as + spanOf(drive) * (k + dice.share()) / kParts;
    const double half = lag * dice.share();
    above[k] = middle + half;
    below[k] = middle - half;
    law.rested[k] = 0.5 * (above[k] + below[k]) < 0.0 ? 1 : -1;
  }
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double moved = 2.0 * now.current * now.step / width;
    Law::State next = x;
    for (std::size_t k = 0; k < kParts; ++k) {
      const bool switching = moved > 0.0 ? now.charge > above[k] : now.charge < below[k];
      if (switching) next[k] = std::clamp(x[k] + moved, -1.0, 1.0);
    }
    return next;
  };
  law.voltage = [](const Law::State& x, const LawInstant&) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kParts; ++k) sum += x[k];
    return 0.06 * sum / kParts;
  };
}

/// A dip when a discharge begins after charging, deeper the more was charged.
///     dx/dt = (-i)+ - (i)+ x / Q_x,   dA/dt = (i)+ (1 - A)^2 / Q_e - (-i)+ A^2 / Q_n
///     v = -V A 2 y / (1 + y^2),   y = x / Q_x
/// x: discharged since the turn. New crystals need an oversaturation that falls as they grow (coup
/// de fouet: Bernardi and others; Delaille et al., J. Power Sources 158 (2006)); rational, not
/// exponential.
void nucleationDip(Law& law, Dice& dice, const Circumstances&) {
  const double rise = dice.logBetween({0.02, 0.12}) * kSecondsPerHour,
               building = dice.logBetween({0.1, 0.5}) * kSecondsPerHour,
               erasing = dice.logBetween({0.1, 0.5}) * kSecondsPerHour;
  law.rested = {0.0, 0.5};
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - x[1];
    const double out = now.discharging() - now.charging() * x[0] / rise;
    const double ready =
        now.charging() * open * open / building - now.discharging() * x[1] * x[1] / erasing;
    return Law::State{std::max(0.0, x[0] + now.step * out),
                      std::clamp(x[1] + now.step * ready, 0.0, 1.0)};
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) {
    const double y = x[0] / rise;
    return -0.05 * x[1] * 2.0 * y / (1.0 + y * y);
  };
}

}  // namespace

std::vector<LawForm> chemistryLaws() {
  return {{"acceptance", "crystal_population", crystalPopulation},
          {"acceptance", "diffusion_layer", diffusionLayer},
          {"acceptance", "freshness_gate", freshnessGate},
          {"acceptance", "spread_refill", spreadRefill},
          {"side_reactions", "drying_separator", dryingSeparator},
          {"side_reactions", "bubble_cover", bubbleCover},
          {"side_reactions", "pressure_recombination", pressureRecombination},
          {"side_reactions", "impurity_shuttle", impurityShuttle},
          {"acid", "pore_diffusion", poreDiffusion},
          {"acid", "anomalous_diffusion", anomalousDiffusion},
          {"acid", "pore_exhaustion", poreExhaustion},
          {"acid", "separator_delay", separatorDelay},
          {"open_circuit", "bent_emf", bentEmf},
          {"open_circuit", "sum_of_plays", sumOfPlays},
          {"open_circuit", "preisach_parts", preisachParts},
          {"open_circuit", "nucleation_dip", nucleationDip}};
}

}  // namespace battery_sof_simulator

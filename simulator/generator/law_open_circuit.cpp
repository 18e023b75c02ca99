#include "simulator/generator/law.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

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
Law bentEmf(Dice& dice, const Circumstances& drive) {
  const double centre = drive.lowest_as + dice.between({0.25, 0.75}) * spanOf(drive),
               span = spanOf(drive),
               power = dice.share() < 0.5 ? dice.between({0.45, 0.7}) : dice.between({1.6, 2.2});
  const auto bend = [=](double charge) {
    const double y = (charge - centre) / span;
    return y * std::pow(y * y + 1e-3, 0.5 * (power - 1.0));
  };
  Law law;
  law.added = [=](const Law::State&, const LawInstant& now) {
    return 0.06 * (bend(now.charge) - bend(0.0));
  };
  return law;
}

/**
 * Hysteresis of charge as a sum of plays, each of which follows only after its own width.
 *
 *     y_k <- clamp(y_k, q - w_k, q + w_k),   v = V sum_k a_k (y_k - y_k(0)) / span,  a_k ~ w_k^-0.5
 *
 * Prandtl's and Ishlinskii's operator (Krasnosel'skii and Pokrovskii 1989), as used for batteries'
 * open-circuit voltage; it depends on the path, not on time, and forgets smaller loops.
 */
Law sumOfPlays(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kPlays = 12;
  const double span = spanOf(drive), widest = dice.between({0.25, 0.45}) * span;
  std::array<double, kPlays> width{};
  for (std::size_t k = 0; k < kPlays; ++k)
    width[k] = widest * std::pow(0.02, 1.0 - k / (kPlays - 1.0));
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    Law::State next = x;
    for (std::size_t k = 0; k < kPlays; ++k)
      next[k] = std::clamp(x[k], now.charge - width[k], now.charge + width[k]);
    return next;
  };
  law.added = [=](const Law::State& x, const LawInstant&) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kPlays; ++k) sum += x[k] / std::sqrt(width[k] * span);
    return 0.015 * sum;
  };
  return law;
}

/**
 * Many small parts of the active mass that switch at charges of their own, back later than forth.
 *
 *     dh_k = 2 dq / w while charging above a_k, or while discharging below b_k < a_k;  -1 <= h_k <= 1
 *     v = V sum_k h_k / 16
 *
 * Preisach (1935); Mayergoyz, Mathematical Models of Hysteresis (1991).
 */
Law preisachParts(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kParts = 16;
  const double width = 0.15 * spanOf(drive), lag = dice.between({0.15, 0.4}) * spanOf(drive);
  std::array<double, kParts> above{}, below{};
  Law law;
  for (std::size_t k = 0; k < kParts; ++k) {
    const double middle = drive.lowest_as + spanOf(drive) * (k + dice.share()) / kParts;
    const double half = lag * dice.share();
    above[k] = middle + half;
    below[k] = middle - half;
    law.rested[k] = 0.5 * (above[k] + below[k]) < 0.0 ? 1 : -1;
  }
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double moved = 2.0 * now.current * now.step / width;
    Law::State next = x;
    for (std::size_t k = 0; k < kParts; ++k) {
      const bool switching = moved > 0.0 ? now.charge > above[k] : now.charge < below[k];
      if (switching) next[k] = std::clamp(x[k] + moved, -1.0, 1.0);
    }
    return next;
  };
  law.added = [](const Law::State& x, const LawInstant&) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kParts; ++k) sum += x[k];
    return 0.06 * sum / kParts;
  };
  return law;
}

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
Law nucleationDip(Dice& dice, const Circumstances&) {
  const double rise = dice.logBetween({0.02, 0.12}) * kSecondsPerHour,
               building = dice.logBetween({0.1, 0.5}) * kSecondsPerHour,
               erasing = dice.logBetween({0.1, 0.5}) * kSecondsPerHour;
  Law law;
  law.rested = {0.0, 0.5};
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - x[1];
    const double out = now.discharging() - now.charging() * x[0] / rise;
    const double ready =
        now.charging() * open * open / building - now.discharging() * x[1] * x[1] / erasing;
    return Law::State{std::max(0.0, x[0] + now.step * out),
                      std::clamp(x[1] + now.step * ready, 0.0, 1.0)};
  };
  law.added = [=](const Law::State& x, const LawInstant&) {
    const double y = x[0] / rise;
    return -0.05 * x[1] * 2.0 * y / (1.0 + y * y);
  };
  return law;
}

}  // namespace

std::vector<LawForm> openCircuitLaws() {
  return {{"open_circuit", "bent_emf", bentEmf},
          {"open_circuit", "sum_of_plays", sumOfPlays},
          {"open_circuit", "preisach_parts", preisachParts},
          {"open_circuit", "nucleation_dip", nucleationDip}};
}

}  // namespace battery_sof_simulator

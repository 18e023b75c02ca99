#include "simulator/generator/law.hpp"
#include "simulator/units.hpp"

namespace battery_sof_simulator {
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
Law depressedArc(Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kTimes = 13;
  const double power = dice.between({0.5, 0.75}),
               centre = std::max(dice.logBetween({0.3, 8.0}), 2.0 * shortestShown(drive));
  Memories<kTimes> memories;
  for (std::size_t k = 0; k < kTimes; ++k) {
    const double decades = (static_cast<double>(k) - 0.5 * (kTimes - 1)) / 3.0;
    memories.time[k] = std::max(0.02, centre * std::pow(10.0, decades));
    const double spread = std::cosh(power * std::log(10.0) * decades);
    memories.weight[k] = std::sin((1.0 - power) * kPi) / (spread - std::cos((1.0 - power) * kPi));
  }
  memories.normalise();
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    return memories.advance(x, now.step, now.current);
  };
  law.added = [=](const Law::State& x, const LawInstant&) { return 1.5e-3 * memories.mean(x); };
  return law;
}

/**
 * A film that conducts by the charge brought into it, so that its voltage goes with a root of the
 * current.
 *
 *     v = V sgn(i) [ (|i| / i_f + 0.01)^m - 0.01^m ],   m 0.35 to 0.6
 *
 * Space-charge-limited current (Mott and Gurney 1940: m = 1/2), oxide films on lead: Pavlov (2011).
 */
Law conductingFilm(Dice& dice, const Circumstances&) {
  static constexpr double kFloor = 0.01;
  const double scale = dice.logBetween({8.0, 60.0}), power = dice.between({0.35, 0.6});
  Law law;
  law.added = [=](const Law::State&, const LawInstant& now) {
    const double size = std::pow(std::abs(now.current) / scale + kFloor, power);
    return std::copysign(0.05 * (size - std::pow(kFloor, power)), now.current);
  };
  return law;
}

/**
 * Something adsorbed that the current moves to and fro between empty and full, and that pairs of
 * it relax.
 *
 *     dh/dt = i / Q (1 - h sgn i) - h |h| / tau,   v = V h
 *
 * Pseudocapacitance with few sites (Conway 1999); relaxation of second order falls as 1/t.
 */
Law adsorbedSites(Dice& dice, const Circumstances& drive) {
  const double charge = dice.logBetween({30.0, 300.0}),
               time = std::max(dice.logBetween({3.0, 60.0}), 4.0 * shortestShown(drive));
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - (now.current > 0.0 ? x[0] : -x[0]);
    const double rate = now.current / charge * open - x[0] * std::abs(x[0]) / time;
    return Law::State{std::clamp(x[0] + now.step * rate, -1.0, 1.0)};
  };
  law.added = [](const Law::State& x, const LawInstant&) { return 0.05 * x[0]; };
  return law;
}

/**
 * Another electrode whose current goes with the square of its voltage.
 *
 *     dy/dt = (i - 40 A y |y|^(n - 1)) / Q,   v = V y,   n 1.7 to 3
 *
 * A power law between ohmic and Tafel kinetics, as of a surface with a spread of barriers.
 */
Law powerElectrode(Dice& dice, const Circumstances& drive) {
  const double charge = std::max(dice.logBetween({20.0, 500.0}), 40.0 * shortestShown(drive)),
               power = dice.between({1.7, 3.0});
  Law law;
  law.moved = [=](const Law::State& x, const LawInstant& now) {
    const double back = 40.0 * x[0] * std::pow(std::abs(x[0]), power - 1.0);
    return Law::State{x[0] + now.step * (now.current - back) / charge};
  };
  law.added = [](const Law::State& x, const LawInstant&) { return 0.05 * x[0]; };
  return law;
}

}  // namespace

std::vector<LawForm> structureLaws() {
  return {{"structure", "depressed_arc", depressedArc},
          {"structure", "conducting_film", conductingFilm},
          {"structure", "adsorbed_sites", adsorbedSites},
          {"structure", "power_electrode", powerElectrode}};
}

}  // namespace battery_sof_simulator

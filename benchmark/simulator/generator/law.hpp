#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "simulator/dice.hpp"

namespace battery_sof_simulator {

/// True current and voltage every FullBattery::kStep; entry 0 stands at the start.
struct Course {
  std::vector<double> current;  ///< [A]
  std::vector<double> voltage;  ///< [V]
};

/// What a law may read at one instant; current positive into the battery.
struct LawInstant {
  double time = 0.0;     ///< since the start [s]
  double step = 1e-3;    ///< of the integration [s]
  double current = 0.0;  ///< at the terminals [A]
  double u2 = 0.0;       ///< overpotential of the base circuit's double layer [V]
  double u_x = 0.0;      ///< u_0 + u2, what side reactions see [V]
  double charge = 0.0;   ///< taken up since the start [As]

  double charging() const { return std::max(current, 0.0); }      ///< [A]
  double discharging() const { return std::max(-current, 0.0); }  ///< [A]
};

/// An out-of-catalogue law: physics beside the base circuit, or an instrument, in no catalogue.
///     u = u_base(i - s i_side) + s v,     s: strength, 0 takes all of it away
/// Physics knows its own states only. At strength 1 it moves the voltage by some 10 mV on a usual
/// drive. States are moved on in steps of a millisecond, so explicit steps do. An instrument turns
/// a true course into the shown one; at strength 0 it shows the truth, at 1 its law's error.
struct Law {
  static constexpr std::size_t kMaxStates = 20;
  using State = std::array<double, kMaxStates>;
  using Reading = std::function<double(const State&, const LawInstant&)>;

  State rested{};
  /// the state a step later
  std::function<State(const State&, const LawInstant&)> advance =
      [](const State& x, const LawInstant&) { return x; };
  Reading voltage = [](const State&, const LawInstant&) { return 0.0; };  ///< v [V]
  Reading sideCurrent = voltage;  ///< i_side [A], >= 0: passes the double layer's reaction by
  /// of an instrument, empty otherwise
  std::function<Course(const Course& truth, double strength)> shown;
  /// beyond, its constants would be absurd
  double max_strength = 4.0;
};

/// What is known of a drive before a law is drawn for it.
struct Circumstances {
  double duration = 1200.0;      ///< [s]
  double sample_rate_hz = 10.0;  ///< of the recording
  double onset_low_v = 13.2;     ///< u_0 + u2 that 40 % of the charging time lies below [V]
  double onset_high_v = 13.4;    ///< the same for 75 % [V]
  double lowest_as = -1000.0;    ///< of the charge since the start [As]
  double highest_as = 1000.0;    ///< of the charge since the start [As]
  double throughput_as = 1e4;    ///< integral of |i| over the drive [As]
};

/// What a law is called, where it belongs, and how one of it is drawn.
struct LawForm {
  std::string mechanism, id;
  void (*make)(Law&, Dice&, const Circumstances&);

  Law draw(Dice& dice, const Circumstances& drive) const {
    Law law;
    make(law, dice, drive);
    return law;
  }
};

/// Laws of acceptance, side reactions, acid and the open-circuit voltage; with those of structure,
/// ageing and instruments all of them, those of a mechanism together (docs/validation.md).
std::vector<LawForm> chemistryLaws();
const std::vector<LawForm>& lawForms();

/// @throws std::invalid_argument when there is no such law.
const LawForm& lawNamed(const std::string& mechanism, const std::string& id);

/// 0 below 0, 1 above 1, between them 3x^2 - 2x^3: a threshold without a kink.
inline double smoothStep(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * (3.0 - 2.0 * y);
}

/// x / (1 + x) for x >= 0: kinetics that saturate (Michaelis and Menten 1913).
inline double saturated(double x) { return x / (1.0 + x); }

/// First-order memories of several times, whose weights add up to 1 once normalised.
template <std::size_t count>
struct Memories {
  std::array<double, count> time{}, weight{};  ///< [s], [1]

  void normalise() {
    double sum = 0.0;
    for (double one : weight) sum += one;
    for (double& one : weight) one /= sum;
  }
  /// Times evenly spread in the logarithm, weights by a power of them.
  static Memories powerLaw(double shortest, double longest, double power) {
    Memories all;
    for (std::size_t k = 0; k < count; ++k) {
      all.time[k] = shortest * std::pow(longest / shortest, k / (count - 1.0));
      all.weight[k] = std::pow(all.time[k], power);
    }
    all.normalise();
    return all;
  }
  double mean(const Law::State& x) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < count; ++k) sum += weight[k] * x[k];
    return sum;
  }
  /// Every memory a step on towards a value. @param undoing what its own value counts.
  Law::State advance(const Law::State& x, double step, double value, double undoing = 1.0) const {
    Law::State next = x;
    for (std::size_t k = 0; k < count; ++k) next[k] += step / time[k] * (value - x[k] * undoing);
    return next;
  }
};

}  // namespace battery_sof_simulator

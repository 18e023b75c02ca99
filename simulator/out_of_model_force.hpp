#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "simulator/dice.hpp"

namespace battery_sof_reference {

/// What an out-of-model case's law may read at one instant; current positive into the battery.
struct OutOfModelInstant {
  double time = 0.0;     ///< since the start [s]
  double step = 1e-3;    ///< of the integration [s]
  double current = 0.0;  ///< at the terminals [A]
  double u2 = 0.0;       ///< overpotential of the base circuit's double layer [V]
  double u_x = 0.0;      ///< u_0 + u2, what side reactions see [V]
  double charge = 0.0;   ///< taken up since the start [As]

  double charging() const { return std::max(current, 0.0); }      ///< [A]
  double discharging() const { return std::max(-current, 0.0); }  ///< [A]
};

/**
 * @brief A piece of physics beside the base circuit, of a form that no catalogue of effects has.
 *
 *     u = u_base(i - s i_side) + s v,     s: strength, 0 takes all of it away
 *
 * A force knows its own states only. At strength 1 it moves the voltage by some 10 mV on a usual
 * drive. States are moved on in steps of a millisecond, so explicit steps do.
 */
class OutOfModelVoltage {
 public:
  static constexpr std::size_t kMaxStates = 20;
  using State = std::array<double, kMaxStates>;

  virtual ~OutOfModelVoltage() = default;
  virtual State rested() const { return State{}; }
  virtual State advance(const State& before, const OutOfModelInstant& now) const = 0;
  virtual double voltage(const State& state, const OutOfModelInstant& now) const = 0;  ///< v [V]
  /// @return i_side [A], >= 0: what passes the double layer's reaction by.
  virtual double sideCurrent(const State&, const OutOfModelInstant&) const { return 0.0; }
};

/// What is known of a drive before a force is drawn for it.
struct Circumstances {
  double duration = 1200.0;      ///< [s]
  double sample_rate_hz = 10.0;  ///< of the recording
  double onset_low_v = 13.2;     ///< u_0 + u2 that 40 % of the charging time lies below [V]
  double onset_high_v = 13.4;    ///< the same for 75 % [V]
  double lowest_as = -1000.0;    ///< of the charge since the start [As]
  double highest_as = 1000.0;    ///< of the charge since the start [As]
  double throughput_as = 1e4;    ///< integral of |i| over the drive [As]
};

/// A mechanism's form: what it is called, and how one of it is drawn.
struct OutOfModelForm {
  std::string mechanism, id;
  std::function<std::unique_ptr<OutOfModelVoltage>(Dice&, const Circumstances&)> draw;
};

/// Forms of one mechanism each (`draw_out_of_model --list`; docs/validation.md).
std::vector<OutOfModelForm> acceptanceForms();
std::vector<OutOfModelForm> sideReactionForms();
std::vector<OutOfModelForm> acidForms();
std::vector<OutOfModelForm> openCircuitForms();
std::vector<OutOfModelForm> structureForms();
std::vector<OutOfModelForm> ageingForms();

/// All of them. Instruments' forms are not forces; they are in stranger_instrument.hpp.
const std::vector<OutOfModelForm>& outOfModelForms();

/// A number of a range of positive ends, uniform in its logarithm.
inline double logBetween(Dice& dice, const Range& range) {
  return range.low * std::pow(range.high / range.low, dice.share());
}

/// 0 below 0, 1 above 1, between them 3x^2 - 2x^3: a threshold without a kink.
inline double smoothStep(double x) {
  const double y = std::clamp(x, 0.0, 1.0);
  return y * y * (3.0 - 2.0 * y);
}

/// x / (1 + x) for x >= 0: kinetics that saturate (Michaelis and Menten 1913).
inline double saturated(double x) { return x / (1.0 + x); }

/// A form whose class has a constructor Law(Dice&, const Circumstances&).
template <typename Law>
OutOfModelForm formOf(const std::string& mechanism, const std::string& id) {
  return {mechanism, id,
          [](Dice& dice, const Circumstances& drive) -> std::unique_ptr<OutOfModelVoltage> {
            return std::make_unique<Law>(dice, drive);
          }};
}

}  // namespace battery_sof_reference

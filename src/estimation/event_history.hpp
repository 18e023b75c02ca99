#pragma once

#include <cstddef>
#include <vector>

namespace battery_sof {

/// A past crank, and what was to be expected of the current that flowed.
struct PastCrank {
  double time = 0.0;      ///< [s], of the minimum
  double current = 0.0;   ///< [A], lowest
  double minimum = 0.0;   ///< [V], lowest, as the sensor showed it
  double modelled = 0.0;  ///< [V], lowest by the equations
};

/// The beginning of a past charge, and what was to be expected at the voltage that stood.
struct PastCharge {
  double time = 0.0;           ///< [s], of its first sample
  double duration = 0.0;       ///< [s], over which currents are means: 10 or 60
  double voltage = 0.0;        ///< [V], mean
  double first_voltage = 0.0;  ///< [V], at its first sample
  double measured = 0.0;       ///< [A], mean
  /// [A], mean by the equations and what was estimated without this charge
  double modelled = 0.0;
};

/// Events of the battery's own past that a model was compared with: what corrects it, and what
/// supports it.
struct EventHistory {
  static constexpr std::size_t kMost = 40;  ///< of each kind are kept, the newest

  std::vector<PastCrank> cranks;    ///< in order of time
  std::vector<PastCharge> charges;  ///< in order of time

  void add(const PastCrank& crank);
  void add(const PastCharge& charge);
  void moveBy(double moved);  ///< puts every event onto a clock that jumped. @param moved [s]
};

}  // namespace battery_sof

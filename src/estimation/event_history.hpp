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

/// The voltage of a past stop 10 s after a load took over, and what was to be expected before it.
struct PastStop {
  static constexpr double kAge = 10.0;  ///< [s]

  double time = 0.0;      ///< [s], of its beginning
  double current = 0.0;   ///< [A], when it was compared
  double measured = 0.0;  ///< [V]
  double modelled = 0.0;  ///< [V], by the equations and what was estimated without this stop
};

/// Whether a current is that of a stop: a load draws it that no charger helps out with, and it is no
/// crank's. @param min_current [A], below it a load controls the current (ControlModeRule).
bool isStopLoad(double current, double min_current);

/// What a model misses of the voltage in a stop.
struct StopLevel {
  double mean = 0.0;      ///< [V]
  double variance = 0.0;  ///< [V^2], of the next stop's
};

/// Events of the battery's own past that a model was compared with: what corrects it, and what
/// supports it.
struct EventHistory {
  static constexpr std::size_t kMost = 40;  ///< of each kind are kept, the newest

  std::vector<PastCrank> cranks;    ///< in order of time
  std::vector<PastCharge> charges;  ///< in order of time
  std::vector<PastStop> stops;      ///< in order of time

  void add(const PastCrank& crank);
  void add(const PastCharge& charge);
  void add(const PastStop& stop);
  void moveBy(double moved);  ///< puts every event onto a clock that jumped. @param moved [s]

  /**
   * @brief What the next stop's level will be: a random walk from stop to stop, seen with noise.
   *
   *     level_k = level_k-1 + N(0, q^2),   measured - modelled = level_k + N(0, r^2)
   *
   * @param usual_error [V], what the model misses of a voltage: the level's before the first stop.
   */
  StopLevel nextStop(double usual_error) const;
};

}  // namespace battery_sof

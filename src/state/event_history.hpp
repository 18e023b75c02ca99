#pragma once

#include <cstddef>
#include <vector>

namespace battery_sof {

/// An event of the battery's own past, and what was to be expected of it.
struct PastEvent {
  enum class Kind { kCrank, kCharge, kStop };
  static constexpr double kStopAge = 10.0;  ///< [s], of a stop when its voltage is compared

  Kind kind = Kind::kCrank;
  double time = 0.0;      ///< [s], of a crank's minimum; else of the beginning
  double duration = 0.0;  ///< [s], a charge's, over which it is averaged; a stop's so far; else 0
  double current = 0.0;   ///< [A], a crank's lowest; a stop's when it was compared
  double voltage = 0.0;   ///< [V], of a charge: mean
  double first_voltage = 0.0;  ///< [V], of a charge: at its first sample
  /// [V], of a crank the lowest, as the sensor showed it, of a stop the last; [A], of a charge: mean
  double measured = 0.0;
  /// the same by the equations; of a charge and a stop with what was estimated without this one
  double modelled = 0.0;

  /// What it is reported by: a crank's lowest current [A], a charge's mean voltage [V].
  double stimulus() const { return kind == Kind::kCharge ? voltage : current; }
};

/// What a model misses of the voltage in a stop.
struct StopLevel {
  double mean = 0.0;      ///< [V]
  double variance = 0.0;  ///< [V^2], of the next stop's
};

/// Events of the battery's own past that a model was compared with: what corrects it, and what
/// supports it.
struct EventHistory {
  static constexpr std::size_t kMost = 40;  ///< of each kind are kept, the newest

  std::vector<PastEvent> cranks, charges, stops;  ///< each in order of time

  void add(const PastEvent& event);
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

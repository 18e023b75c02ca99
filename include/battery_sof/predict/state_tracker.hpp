#pragma once

#include "battery_sof/identify/error_tracker.hpp"

namespace battery_sof {

/**
 * @brief Follows the model's state from sample to sample between identifications.
 *
 * One step a sample, with the derivatives of uncertainSimulationOf(); constant memory. Across a gap the battery is taken to rest
 * (driving_current.hpp).
 */
class StateTracker {
 public:
  /// Starts from the model's saved state. @param max_gap [s], longest interval that is joined.
  StateTracker(const FittedModel& model, double max_gap);

  /// Moves on to a sample later than the last one. @throws std::invalid_argument when time does not
  /// increase.
  void advance(double time, double current);
  /// Takes in the voltage measured at the last sample: what the model misses is followed (ErrorTracker).
  void observe(double voltage);
  /// Widths of intervals, as past events ask for.
  void setScales(const IntervalScale& crank, const IntervalScale& charge);

  /// @return terminal voltage the model expects at the last sample [V].
  double expectedVoltage() const;

  /// @return the model with state and covariance moved to the last sample.
  FittedModel modelNow() const;

  const ModelState& state() const { return state_; }

  /// The running simulation, for a query to go on from.
  const Simulation& simulation() const { return simulation_; }

 private:
  FittedModel model_;
  Simulation simulation_;
  ModelState state_;
  ErrorTracker errors_;
  double error_time_;  // [s], of the last voltage taken in
  double max_gap_;
  bool needs_trace_;  // an effect may ask for the current a little earlier or later than the sample
  CurrentTrace trace_;
};

/**
 * @brief Where the state must stand for the model to read the measured voltage (paper, eq. 5).
 *
 *     u_c2 = u - u_dc - r(i) i - voltages of the effects
 *
 * The effects' states stay where they are. The state's covariance follows from the parameters' and the fit's own error.
 */
void setStateFromVoltage(FittedModel& model, double time, double current, double voltage);

}  // namespace battery_sof

#pragma once

#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/identify/follower.hpp"

namespace battery_sof {

/**
 * @brief Follows the model's state from sample to sample between identifications.
 *
 * One step a sample, with the derivatives of uncertainSimulationOf(); constant memory. Across a gap the battery is taken to rest
 * (driving_current.hpp). Where the model's source imposes the voltage (SourceWatch), that drives, and the error is the current's.
 */
class StateTracker {
 public:
  /// Starts from the model's saved state. @param max_gap [s], longest interval that is joined.
  StateTracker(const FittedModel& model, double max_gap);

  /// Moves on to a sample later than the last one, driven by what is imposed there, and takes the other quantity in: what the
  /// model misses of a voltage is followed (ErrorTracker). @throws std::invalid_argument when time does not increase.
  void follow(double time, double current, double voltage);
  /// Widths of intervals, as past events ask for.
  void setScales(const IntervalScale& crank, const IntervalScale& charge);

  /// The last sample as the model followed it.
  const FollowedSample& last() const { return last_; }
  /// @return measured less expected at the last sample [V]; where the voltage drives, the current's error through 10 mOhm.
  double error() const { return error_; }

  /// @return the model with state and covariance moved to the last sample.
  FittedModel modelNow() const;

  const ModelState& state() const { return state_; }

  /// What a slow sampling saw of the discharge under way.
  const MissedCrank& missed() const { return missed_; }
  /// An event passed: what it teaches goes along with the model.
  template <typename Event>
  void learnFrom(const Event& event) {
    model_.experience.add(event);
  }

  /// The running simulation, for a query to go on from.
  const Simulation& simulation() const { return follower_.simulation(); }

 private:
  FittedModel model_;
  Follower follower_;
  std::optional<SourceWatch> watch_;
  MissedCrank missed_;
  FollowedSample last_;
  double error_ = 0.0;  // [V]
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

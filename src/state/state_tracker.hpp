#pragma once

#include <cmath>

#include "state/posterior.hpp"
#include "state/state_estimator.hpp"

namespace battery_sof {

/// A settled sample as the model followed it.
struct SettledSample : FollowedSample {
  double time = 0.0;      ///< [s]
  double measured = 0.0;  ///< [V], put right
  /// measured less expected [V]; where the voltage is the input, the current's error through 10 mOhm
  double error = 0.0;
};

/**
 * @brief Follows the model's state from sample to sample between identifications.
 *
 * One step a sample, with the derivatives of uncertainSimulationOf(); constant memory. Across a gap
 * the battery is taken to rest (heldCurrent()). Where the model's source controls the voltage
 * (ControlModeDetector), that is the input, and the error is the current's.
 *
 * A slow voltage channel is put right as in the fit (VoltageRepair): a sample is settled once the
 * sample after the one that shows its voltage is there, which is voltage_lag + 1 samples later.
 * Until then the state goes on from the settled one to the newest sample with the last voltage
 * there is, as carryState() does at the end of a recording, and is taken again with every sample.
 * Without a source every sample is settled at once.
 */
class StateTracker {
 public:
  /// Starts from the model's saved state. @param max_gap [s], longest interval that is joined.
  /// @param follows_errors false: what the model misses of a voltage is not forecast.
  StateTracker(const FittedModel& model, double max_gap, bool follows_errors = true);

  /// Shows the samples up to the state's, right at the beginning: the past that a source is judged
  /// by, 300 s as in inputsOf().
  void lookBack(const Series& series);

  /// Moves on to a sample later than the last one, driven by what is controlled there, and takes
  /// the other quantity in: what the model misses of a voltage is followed (ResidualFilter).
  /// @return whether a sample was settled. @throws std::invalid_argument when time does not
  /// increase.
  bool follow(double time, double current, double voltage);
  /// From here on a settled sample in 0.1 s moves parameters and state, until a window is fitted.
  void learn() {
    learns_ = true;
    settled_.errors() = ResidualFilter(model_, false);
  }
  bool learns() const { return learns_; }
  /// [standard deviations], see Surprise.
  double surprise() const { return surprise_.largest; }
  /// What the caller knows of the model and its window does not say: recording, duration of the fit,
  /// and what an earlier window saw (carryCranks()).
  void setKnown(const FittedModel& model);

  /// The last settled sample; none before the first.
  const std::optional<SettledSample>& last() const { return last_; }
  /// [V], of the last settled sample; 0 before the first.
  double error() const { return last_ ? last_->error : 0.0; }

  /// The model where it began, or where a sample moved its parameters last (learn()).
  const FittedModel& model() const { return model_; }
  /// @return the model with state and covariance moved to the newest sample.
  FittedModel modelNow() const { return modelAt(here()); }
  /// @return the same moved to the last settled sample.
  FittedModel modelSettled() const { return modelAt(settled_); }

  /// At the newest sample; without the memories of residual regression and residual filter, which modelNow()
  /// has.
  const LiveState& state() const { return here().state(); }
  /// Whether a voltage may be the input of the model.
  bool hasSource() const { return watch_.has_value(); }
  double minCurrent() const { return model_.fit.source->min_current; }  ///< [A], of that source
  /// Whether the newest sample's voltage is controlled and is the input of the model.
  bool isVoltageControlled() const { return voltage_controlled_; }

  /// Adds an event that passed to those that correct answers.
  void updateFrom(const PastEvent& event) {
    EventHistory& past = model_.intervals.event_history;
    past.add(event);
    settled_.errors().setNextStop(past.nextStop(model_.fit.scores.rmse));
  }
  /// What past events ask of answers; it goes along with the model.
  const IntervalLearning& intervals() const { return model_.intervals; }
  IntervalLearning& intervals() { return model_.intervals; }

 private:
  const StateEstimator& here() const { return ahead_ ? *ahead_ : settled_; }
  FittedModel modelAt(const StateEstimator& estimator) const;
  InputSample sampleAfter(const StateEstimator& estimator, std::size_t n) const;
  void settleOldest();
  /// Takes the settled sample into parameters and state. @return what the model still misses of it
  /// [V], [A]; none where nothing was taken in.
  std::optional<double> learnFromSettled(const InputSample& sample, const FollowedSample& followed);
  Innovation innovationOf(const InputSample& sample, const FollowedSample& followed) const;
  void lookAhead();

  FittedModel model_;
  double max_gap_;
  bool follows_errors_;
  StateEstimator settled_;
  std::optional<StateEstimator> ahead_;  // at the newest sample, where that is not settled
  std::optional<ControlModeDetector> watch_;
  bool voltage_controlled_ = false, learns_ = false;
  Surprise surprise_;
  double learnt_until_ = -HUGE_VAL, cranked_ = -HUGE_VAL;  // [s]
  // As they came: the last settled sample, if there is one, and those that wait.
  Series recent_;
  std::vector<char> controlled_;
  std::size_t settled_count_ = 0;  // at recent_'s beginning
  std::optional<SettledSample> last_;
  // an effect may ask for the current a little earlier or later than the sample
  bool needs_trace_;
  CurrentTrace trace_;
};

/**
 * @brief Where the state must be for the model to give the measured voltage (paper, eq. 5).
 *
 *     u_c2 = u - u_dc - r(i) i - voltages of the effects
 *
 * The effects' states stay where they are. The state's covariance follows from the parameters' and
 * the fit's own error.
 */
void setStateFromVoltage(FittedModel& model, double time, double current, double voltage);

}  // namespace battery_sof

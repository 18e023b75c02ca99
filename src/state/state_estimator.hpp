#pragma once

#include "state/fitted_model.hpp"
#include "state/residual_filter.hpp"

namespace battery_sof {

/// One sample as a model followed it.
struct FollowedSample {
  bool voltage_controlled = false;
  double voltage = 0.0;                ///< [V], modelled; measured where it is the input
  double current = 0.0;                ///< [A], modelled; measured where it is the input
  double physics_error = 0.0;          ///< [A] or [V], measured less what the equations say
  double regression_correction = 0.0;  ///< [A] or [V], what ResidualRegression adds to them
  double variance = 0.0;    ///< [A^2] or [V^2], by the parameters and the state; 0 without tangents
  Eigen::VectorXd columns;  ///< of ResidualRegression
};

/**
 * @brief A model's state, moved from sample to sample in the operating mode of each: equations,
 * residual regression, discrepancy and their memories, and what the model misses (ResidualFilter).
 *
 * The one way to follow samples, live and over a recording. Copyable: a copy is a snapshot to go
 * back to or to look ahead with. Where the model has a source, what a slow sampling missed of a
 * crank is known here (MissedCrank).
 */
class StateEstimator {
 public:
  /// From the model's saved state; between stops (ResidualFilter::expectStop()). @param uncertain
  /// carries the covariance's directions along.
  explicit StateEstimator(const FittedModel& model, bool uncertain = true);

  /// @return the step from the state to a sample. @param max_gap [s], longest interval that is
  /// joined.
  InputStep stepTo(double time, double current, double max_gap) const {
    return inputStep(state_.time, state_.current, time, current, max_gap);
  }
  /// Moves to a sample, driven by what is controlled there.
  FollowedSample predict(InputSample sample);
  /// Takes in what the model misses of the sample it moved to. @param error [V], measured - modelled;
  /// not looked at where the voltage is the input.
  void update(const InputSample& sample, double error) { errors_.follow(sample, error); }
  /// Both.
  FollowedSample follow(const InputSample& sample);

  /// Puts state, covariance and memories into the model it was begun with.
  void saveTo(FittedModel& model) const;

  /// Without discrepancy and residual, which saveTo() has.
  const LiveState& state() const { return state_; }
  ResidualFilter& errors() { return errors_; }
  const Simulation& simulation() const { return simulation_; }

 private:
  Simulation simulation_;
  ResidualRegression residual_regression_;
  LiveState state_;
  ResidualFilter errors_;
  bool has_source_;
};

/// @return a stretch of a recording as a model is driven through it: by the voltage where its
/// source controls that.
InputSequence inputsOf(const Fit& fit, const Series& series, IndexRange range);

}  // namespace battery_sof

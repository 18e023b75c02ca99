#pragma once

#include "battery_sof/series.hpp"
#include "model/input_sequence.hpp"
#include "recording/events.hpp"
#include "state/fitted_model.hpp"
#include "state/present_error.hpp"

namespace battery_sof {

/// What turns a current's error into that of a voltage [Ohm]: r_charge's magnitude.
inline constexpr double kOhmsOfCurrentError = 0.01;

/**
 * @brief Follows what a model misses, sample by sample, and says what it will miss later.
 *
 *     u_b - u_m = d + a + w   (NoiseModel),   forecast after h:  d + a exp(-h / ar_time)
 *
 * The walk d is what stays (a state of charge that moved), the AR part a what passes. Without a
 * noise model nothing is forecast. Constant memory; across a gap it waits.
 *
 * Where a charger controls the model's voltage, d is the level of stops alone (isStopLoad()), a is
 * zero: between stops what past ones say (EventHistory::nextStop()), in a stop the mean of its own
 * samples, which forgets within ten seconds. What a crank misses says nothing of it.
 *
 * What is missed at the load that flows is followed in addition (PresentErrorFilter).
 *
 *     1 / p <- 1 / p + w,   w = duration / (s^2 T),   p >= (20 mV)^2,   s = 50 mV,   T = 5 s
 *     level <- level + max(p w, 1 - exp(-duration / 8 s)) (error - level)
 */
class ResidualFilter {
 public:
  /// Begins with the model's saved residual state. @param follows_stops false: cranks and all other
  /// samples count alike.
  explicit ResidualFilter(const FittedModel& model, bool follows_stops = true);
  /// Begins between stops, where a charger controls the model's voltage.
  void expectStop();
  /// Past stops say something else now.
  void setNextStop(const ErrorForecast& level) { next_stop_ = level; }

  /// Moves on to a sample. @param error [V], measured - modelled; not looked at where the voltage is
  /// the input.  @param physics_error [V], the same of the equations alone, which answers use.
  void follow(const InputSample& sample, double error, double physics_error);
  /// Takes in the error of a sample. @param duration [s] since the sample before.  @param error
  /// [V], measured - modelled.
  void update(double duration, double error);
  /// Lets time pass without a sample.
  void wait(double duration);

  /// @param ahead [s] from the last sample.
  ErrorForecast forecast(double ahead) const;
  /// For an event that is unlike the driving before it, as a crank is: d is kept, a is not carried
  /// into it and its square counts as variance (docs/decisions/0004-residual-carried-forward.md).
  /// The level of stops is not a crank's, whose past events hold their own: the mean is zero then.
  ErrorForecast forecastThrough(double ahead) const;
  ResidualState residualState() const;

 private:
  void setLevel(const ErrorForecast& level);
  void updateInStop(double duration, double error);

  std::optional<NoiseModel> noise_;
  NoiseFilter<double> filter_;
  double drift_, colored_;
  std::optional<double> min_current_;  // [A], of a charger's rule
  ErrorForecast next_stop_;
  bool in_stop_ = false;
  PresentErrorFilter present_;
  EventLimits limits_;
};

/**
 * @brief Fits the noise model of a fit's residual over its window, and starts the residual
 * state from it.
 *
 * On averages of at least 0.1 s (docs/physics.md#noise-of-a-residual), where the current is the
 * input; elsewhere it waits. Leaves the model as it is when the window has fewer than 30 of them.
 * @param range the window that was fitted; the model's state stands at its last sample.
 */
void fitErrors(FittedModel& model, const Series& series, IndexRange range);

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
 * residual regression, discrepancy model and their memories, and what the model misses
 * (ResidualFilter).
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
  /// not looked at where the voltage is the input.  @param physics_error the same of the equations
  /// alone.
  void update(const InputSample& sample, double error, double physics_error) {
    errors_.follow(sample, error, physics_error);
  }
  /// Both.
  FollowedSample follow(const InputSample& sample);

  /// Puts state, covariance and memories into the model it was begun with.
  void saveTo(FittedModel& model) const;

  /// Without the memories of residual regression and residual filter, which saveTo() has.
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

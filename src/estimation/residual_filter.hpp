#pragma once

#include "battery_sof/series.hpp"
#include "estimation/fitted_model.hpp"
#include "estimation/noise_filter.hpp"

namespace battery_sof {

/// What turns a current's error into that of a voltage [Ohm]: r_charge's magnitude.
inline constexpr double kOhmsOfCurrentError = 0.01;

/// What a model will miss some time ahead.
struct ErrorForecast {
  double mean = 0.0;      ///< measured minus modelled voltage [V]
  double variance = 0.0;  ///< [V^2]
};

/**
 * @brief Follows what a model misses, sample by sample, and says what it will miss later.
 *
 *     u_b - u_m = d + a + w   (NoiseModel),   forecast after h:  d + a exp(-h / ar_time)
 *
 * The walk d is what stays (a state of charge that moved), the AR part a what passes. Without a
 * noise model nothing is forecast. Constant memory; across a gap it waits.
 */
class ResidualFilter {
 public:
  /// Begins with the model's saved discrepancy.
  explicit ResidualFilter(const FittedModel& model);

  /// Takes in the error of a sample. @param duration [s] since the sample before.  @param error
  /// [V], measured - modelled.
  void update(double duration, double error);
  /// Lets time pass without a sample.
  void wait(double duration);

  /// @param ahead [s] from the last sample.
  ErrorForecast forecast(double ahead) const;
  /// For an event that is unlike the driving before it, as a crank is: d is kept, a is not carried
  /// into it and its square counts as variance (docs/decisions/0004-residual-carried-forward.md).
  ErrorForecast forecastThrough(double ahead) const;
  ResidualState residualState() const;

 private:
  std::optional<NoiseModel> noise_;
  NoiseFilter<double> filter_;
  double drift_, colored_;
};

/**
 * @brief Fits the noise model of a fit's residual over its window, and starts the discrepancy from
 * it.
 *
 * On averages of at least 0.1 s (docs/physics.md#noise-of-a-residual), where the current is the
 * input; elsewhere it waits. Leaves the model as it is when the window has fewer than 30 of them.
 * @param range the window that was fitted; the model's state stands at its last sample.
 */
void fitErrors(FittedModel& model, const Series& series, IndexRange range);

}  // namespace battery_sof

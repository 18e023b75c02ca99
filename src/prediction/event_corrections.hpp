#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "battery_sof/queries.hpp"
#include "state/fitted_model.hpp"

namespace battery_sof {

/// @return a voltage of one block, of a row of them [V].
inline Interval ofSeries(const Interval& of_one, double series_blocks) {
  return {series_blocks * of_one.value, series_blocks * of_one.lower, series_blocks * of_one.upper};
}

/// An event that passed, and what a model expected of it: one frozen before it, of the current or
/// the voltage that really stood, or one that runs through a recording.
struct EventComparison : PastEvent {
  Interval expected;  ///< of measured; a crank's bounds each have their own minimum
  std::optional<Interval> baseline = std::nullopt;  ///< of measured, by the window's predictor
  double absError() const { return std::abs(measured - expected.value); }
};

/// @return what the baseline predictors expect of a crank or a charge.
std::optional<Interval> expectedBy(const BaselinePredictor& baseline, const PastEvent& event);

/// @return what was compared of one block, of a row of them.
EventComparison ofSeries(EventComparison of_one, double series_blocks);

/// 95 % quantile of the standard normal distribution: half-width of a 90 % interval in standard
/// deviations.
inline constexpr double kNinetyPercent = 1.6448536269514722;

/// @return the 90 % interval of a normal number. @param factor on its width.
inline Interval ninetyPercent(double value, double std, double factor = 1.0) {
  const double half = kNinetyPercent * factor * std;
  return {value, value - half, value + half};
}

/// What the current of a crank is: asked for, or what the sensor shows of it.
enum class CurrentMeaning { kAsked, kShown };

/**
 * @brief A crank's lowest voltage, the equations' corrected by past cranks.
 *
 *     u_1 = u_m + w_1' f(i),   u_2 = line(i) + w_2' f(i),   f = [1, (i + 200 A) / 100 A]
 *     u = (u_1 + u_2) / 2 with four past cranks or more, else u_1
 *
 * w by ridge regression (penalty 0.3) on what equations and the baseline line missed of past cranks
 * that were measured whole. The interval is that of leaving each of them out, at least three; the
 * equations' own otherwise.
 *
 * Where the sensor's range ends (ExcitedRange::sensor_min_current, or two past cranks that end
 * alike), what it shows is a bound: this current or more. At that end the past cranks that ended
 * there answer (f = [1, 0]): for a current as the sensor shows it they alone, from three on, and for one
 * that is asked for, which may be exactly this, with an interval that holds theirs and that of exactly
 * this current. Cranks cut off say nothing of others, but where they stayed above what the
 * equations make of the bound.
 *
 * @param current  lowest of the crank [A].   @param modelled [V], by the equations, with its interval.
 */
Interval correctCrankPrediction(const FittedModel& model, double current, const Interval& modelled,
                                CurrentMeaning meaning = CurrentMeaning::kAsked);

/// The beginning of a charge as a source holds it.
struct ChargeBeginning {
  double voltage = 0.0;        ///< [V], mean
  double first_voltage = 0.0;  ///< [V], at its first sample
  double duration = 0.0;       ///< [s]
};

/**
 * @brief Mean current of a charge's beginning, from model and past charges by what each missed so
 * far.
 *
 *     i_1 = w i_m + (1 - w) median,   w = a^-1 / (a^-1 + b^-1)
 *     i_2 = i_m + c' [1, 2 (u_mean - 13 V), 2 (u_first - 13 V), i_m / 10 A - 1]
 *     i = (i_1 + i_2) / 2 with four past charges or more, i_1 with three, else i_m
 *
 * a, b [A]: median errors over the past charges of that duration, of the model and of the median of
 * the others; c by ridge regression (penalty 3) on what the model missed of them, errors beyond
 * twice their median by magnitude. Past charges count that lasted up to twice or down to half as
 * long at a mean voltage within 0.5 V. The interval is that of past errors of the same kind, each
 * charge left out.
 *
 * @param modelled [A], of the model, with its interval.
 */
Interval correctChargePrediction(const FittedModel& model, const ChargeBeginning& charge,
                                 const Interval& modelled);

/// What past charges say of a model's answer at a voltage and over a duration.
struct ChargeEvidence {
  static constexpr int kLeast = 3;  ///< charges that can support

  int charges = 0;            ///< that lasted alike, at a voltage within 0.3 V
  double median_error = 0.0;  ///< [A], of the model
  double typical = 0.0;       ///< [A], median current
  /// three or more, median error at most a quarter of the typical current or 1 A
  bool is_supported = false;
};

ChargeEvidence chargeEvidence(const EventHistory& event_history, double voltage, double duration);

/// @return the median voltage [V] of past charges; none without any.
std::optional<double> usualVoltage(const std::vector<PastEvent>& charges);

}  // namespace battery_sof

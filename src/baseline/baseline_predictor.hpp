#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "battery_sof/queries.hpp"
#include "battery_sof/series.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// y = intercept + slope x by least squares, and the errors it leaves.
struct BaselineLine {
  double intercept = 0.0;
  double slope = 0.0;
  double std = 0.0;     ///< of the residuals
  Bounds error;         ///< 5 % and 95 % quantile of measured - predicted
  double centre = 0.0;  ///< mean of x
  double spread = 0.0;  ///< standard deviation of x; 0 of a level line
  std::size_t samples = 0;
  double at(double x) const { return intercept + slope * x; }

  /// The bounds of the error, times sqrt(1 + (x - centre)^2 / (samples spread^2)): far
  /// from the samples the slope's own error counts (as if errors were independent; they are not, so
  /// these bounds are still narrow there).
  Interval around(double x) const;
};

/// Median current over the time since a discharge ended, in steps of equal length.
struct BaselinePhase {
  double step = 1.0;  ///< [s]
  /// [A]; of ages from k - 1/2 to k + 1/2 steps; ends where fewer than half of the charges go on
  std::vector<double> current;
  double std = 0.0;  ///< [A], as in BaselineLine
  Bounds error;      ///< [A], the same
  std::size_t charges = 0;
};

/// What a number was in past events.
struct BaselineHistory {
  double median = 0.0, last = 0.0;
  Bounds error;  ///< 5 % and 95 % quantile of value - median; Student's t below twenty events
  std::size_t events = 0;
};

/// A crank as the recording shows it.
struct BaselineCrank {
  double current = 0.0;  ///< [A], the lowest
  double minimum = 0.0;  ///< [V], the lowest
};

/// Lowest voltage of a crank: v = intercept + slope i.
struct BaselineCranks {
  BaselineCrank last, median;
  double intercept = 0.0;  ///< [V], moved to where recent cranks were: each weighs 0.8 of the next,
                           ///< the line as much as the last one
  double slope = 0.0;      ///< [Ohm], of voltage_from_current; 0 without it
  Bounds error;            ///< [V], of each crank's error when predicted from those before
  std::size_t events = 0;
};

/**
 * @brief Predictions without physics: lines, medians and last events of a window. Every figure of a
 * model is compared with these.
 *
 * Default-constructed it knows nothing. Each part is there only when the window held what it is
 * made of.
 */
struct BaselinePredictor {
  std::optional<BaselineLine> current_from_voltage;  ///< [A], over samples with controlled voltage
  std::optional<BaselineLine> voltage_from_current;  ///< [V], over samples with controlled current
  std::optional<BaselinePhase> phase;
  std::optional<BaselineCranks> cranks;
  std::optional<BaselineHistory> charge_10s,
      charge_60s;  ///< [A], mean current of a charge's first 10 s and 60 s
};

/**
 * @brief Takes the baseline predictors from a window.
 *
 * Lines need five samples; a line over equal abscissae is level. Cranks are those of detectCranks.
 * Bounds of fewer than twenty errors are Student's, of a single charge those of
 * current_from_voltage.
 *
 * @param voltage_controlled one a sample of series.
 * @throws std::invalid_argument when the mask's size differs from the series' or the window lies
 * outside it.
 */
BaselinePredictor fitBaseline(const Series& series, IndexRange window,
                              const std::vector<char>& voltage_controlled,
                              const EventLimits& limits = {});

/// @return fitBaseline() of a window in which no voltage is controlled: v(i) and cranks.
BaselinePredictor fitBaselineDrivenByCurrent(const Series& series, IndexRange window,
                                             const EventLimits& limits = {});

/// A prediction in the mixed direction, one value a sample of a range, with bounds for nine in ten.
struct MixedPrediction {
  /// [A]; empty when no current is predicted; bounds may be empty
  std::vector<double> current, current_lower, current_upper;
  std::vector<double> voltage, voltage_lower, voltage_upper;  ///< [V], the same
  PredictedVoltage voltages() const { return {voltage, voltage_lower, voltage_upper}; }
};

/**
 * @brief The current as if every voltage were controlled, the voltage as if every current were; the
 * mask says which one counts.
 *
 * From the beginning of a charge (chargeBeginnings) until the voltage is no longer controlled the
 * current is that of the median phase as far as that goes, else the line's.
 * @throws std::invalid_argument as fitBaseline.
 */
MixedPrediction predictBaseline(const BaselinePredictor& baseline, const Series& series,
                                IndexRange range, const std::vector<char>& voltage_controlled);

/// @param current lowest current of the crank [A], negative.   @return lowest voltage [V]; v(i)
/// where no crank is known, none without a line.
std::optional<Interval> baselineCrankMinimum(const BaselinePredictor& baseline, double current);

/**
 * @brief Mean current of a charge that follows a discharge: the median phase as far as it goes,
 * i(v) beyond it or where there is none.
 *
 * Bounds are those of past charges over 10 s or 60 s, whichever is nearer in ln(duration).
 * @param voltage held by the source [V].   @param duration [s], > 0.
 * @return [A]; none when neither phase nor line is known.
 * @throws std::invalid_argument for a duration that is not above 0.
 */
std::optional<Interval> baselineChargeCurrent(const BaselinePredictor& baseline, double voltage,
                                              double duration);

}  // namespace battery_sof

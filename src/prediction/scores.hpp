#pragma once

#include <optional>
#include <stdexcept>
#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/fit_quality.hpp"
#include "prediction/event_corrections.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// A prediction in the mixed direction with what a crank's correction starts from.
struct FollowedPrediction : MixedPrediction {
  /// one a sample of the range; the input is as measured and has no width
  std::vector<char> voltage_controlled;
  std::vector<double> equations_voltage;  ///< [V], of the equations alone
};

/// @return the model with the current as its input throughout: without source, lag of the voltage
/// and residual regression.
FittedModel drivenByCurrent(FittedModel model);

/**
 * @brief Runs a model over a recording and returns what it expects in a range of it: the current
 * where its source controls the voltage, the voltage elsewhere, with 90 % intervals.
 *
 * In the recording it was fitted to (same time and current at the end of its window), the model
 * runs on from the state it ended with. Otherwise, or for a range before that, it runs from the
 * first sample, whose state is taken from the first second's voltage (paper, eq. 5, median), so
 * inside a later range nothing is used but its inputs. Across gaps the battery is taken to rest.
 *
 * What the model misses by itself grows with its age (modelAge()). The error of a voltage walks as its
 * noise model says. Of a current no noise is fitted: its mean square over the window's duration W is
 * taken for a walk's, sigma^2 (1 + age / W).
 */
FollowedPrediction predictSeries(const FittedModel& model, const Series& series, IndexRange range);

/// How old a model is at a recording's times.
struct ModelAge {
  bool is_known = true;          ///< whether the recording is on the model's clock
  double from = 0.0;             ///< [s], end of the model's window
  double at(double time) const;  ///< [s], 0 before it was made
};

/// The recording is on the model's clock where it holds the sample at which the model's state stands,
/// or where both count from 1970. On another one times are taken as they stand.
ModelAge modelAge(const FittedModel& model, const Series& series);

/// How cranks were predicted.
struct CrankScores {
  std::vector<EventComparison> cranks;
  std::optional<double> crank_mean_abs_error;  ///< [V], of the answers; none without cranks
  /// [V], RMS error of the equations alone, without corrections by past cranks: what a fit reports
  /// of its own window (FitScores::crank_error_std); none without cranks
  std::optional<double> crank_equations_rms;
};

/// How a prediction compares with what was measured.
struct PredictionScores : CrankScores {
  FitWindow window;
  std::optional<double> q_dyn_percent;
  double rmse = 0.0;         ///< [V]
  double max_abs = 0.0;      ///< [V]
  double coverage_90 = 0.0;  ///< share of samples inside their 90 % interval [0, 1]
};

/// @param range, predicted as given to and returned by predictSeries().
PredictionScores scorePrediction(const Series& series, IndexRange range,
                                 const PredictedVoltage& predicted, const EventLimits& limits = {});

/// How a prediction in the mixed direction compares with what was measured.
struct MixedScores {
  std::optional<double> share_percent;          ///< both quantities together
  std::optional<double> current_share_percent;  ///< where the voltage is controlled
  std::optional<double> voltage_share_percent;  ///< where the current is controlled
  std::optional<double> current_rmse;           ///< [A], where the voltage is controlled
  /// the first 10 and 60 s of each, in the order of time; bounds are means of bounds, the value
  /// itself where none are given
  std::vector<EventComparison> charges;
};

/**
 * @brief Scores in the mixed direction: each sample by the quantity that is not controlled there.
 *
 *     share = 1 - RMS error / spread,  the explained variation; spread: standard deviation measured
 *     combined = 1 - sqrt((sum e_i^2 / spread_i^2 + sum e_v^2 / spread_v^2) / n)
 *
 * A quantity with fewer than six samples has no share and adds no error to the combined one.
 * Charges are those of chargeBeginnings and beginningOfCharge: nine in ten samples of the first 10
 * s (60 s) have a controlled voltage; the others count as predicted exactly.
 *
 * @param voltage_controlled one a sample of series (ControlModes::voltage_controlled).
 * @return numbers that a quantity without prediction, or without spread, would enter are none.
 * @throws std::invalid_argument when sizes do not fit, or range is empty or outside the series.
 */
MixedScores scoreMixed(const Series& series, IndexRange range,
                       const std::vector<char>& voltage_controlled,
                       const MixedPrediction& predicted);

/// How a predictor did in the direction that was controlled, sample by sample and event by event.
struct BothWaysScores : CrankScores {
  MixedScores mixed;
};

/**
 * @brief Scores a model that followed a range: samples as predicted, cranks and charges as a query
 * answers them, compared with the cranks and charges of the model's window
 * (correctCrankPrediction(), correctChargePrediction()).
 */
BothWaysScores scoreBothWays(const FittedModel& model, const Series& series, IndexRange range,
                             const FollowedPrediction& predicted);

/// The same of the baseline predictors of a model's window. @param voltage_controlled one a sample
/// of the range.
BothWaysScores scoreBaseline(const BaselinePredictor& baseline, const Series& series,
                             IndexRange range, const std::vector<char>& voltage_controlled,
                             const EventLimits& limits = {});

/// The inputs of a model along a recording.
enum class PredictionMode {
  kAsFitted,  ///< both, where the model was fitted so; else the current
  kMixed,     ///< the voltage where a source controls it, else the current
  kCurrent,   ///< the current throughout
};

/// PredictionMode::kMixed was asked where no source is seen.
class NoSource : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Scores of a prediction in every operating mode, with those of the baseline.
struct PredictionReport {
  /// as the paper has it; its cranks are those of both_ways where that is
  PredictionScores from_current;
  std::optional<BothWaysScores> both_ways;  ///< none when the current is the input throughout
  BothWaysScores baseline;
  /// of the baseline line; none without one
  std::optional<PredictionScores> baseline_from_current;
  /// [s], from the end of the model's window to the end of the range, 0 inside the window; none on
  /// another clock (modelAge())
  std::optional<double> model_age;
  /// cranks that draw more than the model's window reaches (kCurrentReach): extrapolations, which no
  /// answer would call valid
  std::size_t cranks_beyond_window = 0;
  double largest_discharge = 0.0;  ///< [A], of the model's window, <= 0
};

/// A model's course through a range of a recording, and how well it did.
struct RangePrediction {
  FollowedPrediction course;  ///< one entry a sample of the range
  PredictionReport report;
};

/**
 * @brief Runs a model through a range of a recording and scores it.
 *
 * A model fitted without a source takes, for PredictionMode::kMixed, the one that is seen in the
 * series.
 * @param series at the rate to predict at, see atDesignRate().
 * @throws NoSource; the message says why none is seen.
 */
RangePrediction predictRange(FittedModel model, const Series& series, IndexRange range,
                             PredictionMode mode = PredictionMode::kAsFitted);

}  // namespace battery_sof

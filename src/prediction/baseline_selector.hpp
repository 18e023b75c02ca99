#pragma once

#include <deque>
#include <optional>
#include <string>

#include "baseline/baseline_predictor.hpp"
#include "prediction/charge_acceptance.hpp"
#include "prediction/cranking.hpp"
#include "prediction/event_comparison.hpp"

namespace battery_sof {

/// Mean magnitudes of errors [V] or [A] over the events that a contest remembers.
struct BaselineScore {
  int events = 0;
  double model_error = 0.0, baseline_error = 0.0;
  bool baseline_selected = false;
};

/// What a question needs to know of a contest.
struct BaselineSelection {
  BaselineScore score;
  IntervalCalibration scale;             ///< of the baseline predictor's intervals
  double least = 0.0, most = 0.0;        ///< of PastEvent::stimulus()
  double shortest = 0.0, longest = 0.0;  ///< [s], durations
};

/**
 * @brief A model compared with the baseline predictor of its window over one kind of event: which
 * one answers.
 *
 * Each event is expected by both before it is compared. The last 20 events count, and all of the
 * last 15 min. The baseline predictor answers from when at least 5 events were compared and the
 * model's mean error is more than 1.05 times its own, until it is no longer the larger one. So the
 * answers' error over what is remembered exceeds the baseline predictor's by little more than 5 %.
 */
class BaselineSelector {
 public:
  static constexpr std::size_t kEvents = 20;
  static constexpr double kSpan = 900.0;  ///< [s]
  static constexpr int kMinEvents = 5;
  static constexpr double kTolerated = 1.05;

  /// Takes in an event with the baseline predictor's interval as it comes, and decides again.
  /// @return the baseline interval, scaled as events before
  /// this one asked for.
  Interval add(const EventComparison& event);
  /// The clock jumped. @param moved [s], by how much.
  void moveBy(double moved);

  bool isBaselineSelected() const { return baseline_selected_; }
  BaselineScore score() const;
  BaselineSelection selection() const;

 private:
  std::deque<EventComparison> events_;
  IntervalCalibration calibration_;
  bool baseline_selected_ = false;
};

/// All kinds of question.
struct BaselineSelections {
  BaselineSelection cranks, charges, long_charges;
};

/**
 * @brief A model's answer, or the baseline predictor's in its place where that one has been better
 * at such events.
 *
 * Such a crank: of at most 1.25 times the largest current that was compared, after a stop of at
 * most 15 min. Such a charge: at a voltage within 0.5 V of those compared, half to twice as long.
 * Code and validity stay the model's.
 *
 * @param answer with numbers, else it is returned as it is.
 * @param blocks of the row that query and answer are of; predictor and standing are of one
 * (FittedModel::series_blocks).
 */
CrankingAnswer betterOf(CrankingAnswer answer, const CrankingQuery& query,
                        const BaselinePredictor& baseline, const BaselineSelection& selection,
                        double series_blocks = 1.0);
ChargeAcceptanceAnswer betterOf(ChargeAcceptanceAnswer answer, const ChargeAcceptanceQuery& query,
                                const BaselinePredictor& baseline,
                                const BaselineSelection& selection, double series_blocks = 1.0);

/// The predictor behind baselineCrankMinimum() and baselineChargeCurrent(), in words.
std::string baselineCrankName(const BaselinePredictor& baseline);
std::string baselineChargeName(const BaselinePredictor& baseline);

}  // namespace battery_sof

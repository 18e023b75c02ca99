#pragma once

#include <optional>

#include "estimation/fitted_model.hpp"
#include "prediction/answer.hpp"
#include "prediction/sample_stream.hpp"
#include "prediction/state_tracker.hpp"
#include "recording/events.hpp"

namespace battery_sof {

/// A finished crank: what was measured, and what the model expected of the current that really
/// flowed.
struct CrankComparison {
  double time = 0.0;              ///< [s], of the measured minimum
  double current = 0.0;           ///< [A], of largest magnitude, negative
  double measured_minimum = 0.0;  ///< [V]
  /// [V], each bound's own minimum over the crank
  Interval expected_minimum;
  double modelled_minimum = 0.0;  ///< [V], without the correction by past cranks
  /// [V], by the window's baseline predictor; see BaselineSelector
  std::optional<Interval> baseline_minimum = std::nullopt;
  /// a question before it was answered by that one
  bool baseline_answered = false;
};

/**
 * @brief Finds cranks as they pass, by the definition of detectEvents(), and compares the model
 * with them.
 *
 * The model is frozen at the last sample before the crank and run over the crank's own current.
 */
class CrankWatch {
 public:
  explicit CrankWatch(const EventLimits& limits) : limits_(limits) {}

  /**
   * @param before the tracker as it stood before this sample.   @param max_gap [s], a longer
   * interval ends nothing: what was collected is dropped.
   * @return the comparison when this sample ends a crank.
   */
  std::optional<CrankComparison> add(const StreamSample& sample, const StateTracker& before,
                                     double max_gap);

  void reset() { model_.reset(); }

 private:
  std::optional<CrankComparison> finish() const;

  EventLimits limits_;
  std::optional<FittedModel> model_;  // set while the current is at crank level
  Series crank_;
};

}  // namespace battery_sof

#pragma once

#include <optional>
#include <vector>

#include "estimation/event_history.hpp"
#include "prediction/answer.hpp"

namespace battery_sof {

/// An event that passed, and what the model frozen before it expected of the current or the voltage
/// that really stood.
struct EventComparison : PastEvent {
  Interval expected;  ///< of measured; a crank's bounds each have their own minimum
  /// by the window's baseline predictor; see BaselineSelector
  std::optional<Interval> baseline = std::nullopt;
  bool baseline_answered = false;  ///< a question before it was answered by that one

  /// By the one that answered questions then.
  const Interval& answered() const { return baseline_answered ? *baseline : expected; }
};

/// What ended with a sample and was compared with the model's expectation.
struct SessionEvents {
  std::vector<EventComparison> cranks, charges, stops;
};

}  // namespace battery_sof

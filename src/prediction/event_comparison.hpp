#pragma once

#include <optional>
#include <vector>

#include "prediction/answer.hpp"
#include "state/event_history.hpp"

namespace battery_sof {

/// An event that passed, and what the model frozen before it expected of the current or the voltage
/// that really stood.
struct EventComparison : PastEvent {
  Interval expected;  ///< of measured; a crank's bounds each have their own minimum
  std::optional<Interval> baseline = std::nullopt;  ///< of measured, by the window's predictor
};

/// What ended with a sample and was compared with the model's expectation.
struct SessionEvents {
  std::vector<EventComparison> cranks, charges, stops;
};

}  // namespace battery_sof

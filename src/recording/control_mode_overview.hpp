#pragma once

#include <string>
#include <vector>

#include "recording/control_mode.hpp"

namespace battery_sof {

/// Samples of one judgement.
struct ControlModeTotals {
  std::string reason;  ///< what the judgement rests on
  ControlMode mode = ControlMode::kCurrent;
  std::size_t stretches = 0, samples = 0;
};

/// A stretch of time, from a sample to another.
struct ControlledTime {
  double from = 0.0, to = 0.0;  ///< [s]
};

/// Operating mode in a recording, as a reader needs it; times in place of indices.
struct ControlModeOverview {
  bool seen = false;                      ///< something charges the battery
  double share = 0.0;                     ///< of the samples whose voltage is controlled [0, 1]
  std::string summary;                    ///< one or two sentences
  std::vector<ControlModeTotals> totals;  ///< one a reason, in alphabetical order
  std::vector<ControlledTime> voltage_controlled;  ///< in order; see overviewOf()
};

/// @return "voltage" or "current".
std::string toString(ControlMode controlled);

/// @return the source's stretches by reason, in alphabetical order.
std::vector<ControlModeTotals> totalsOf(const ControlModes& source);

/**
 * @brief The whole of a source's judgement without its samples.
 *
 * voltage_controlled: each stretch from its first sample to the first one behind it, or to its last
 * one before a gap and at the end. Neighbours of one judgement for different reasons are one.
 *
 * @param series the one that the source was found in.
 * @throws std::invalid_argument when source and series differ in length.
 */
ControlModeOverview overviewOf(const ControlModes& source, const Series& series);

}  // namespace battery_sof

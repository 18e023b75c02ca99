#pragma once

#include <string>
#include <vector>

#include "battery_sof/recording/source.hpp"

namespace battery_sof {

/// Samples of one judgement.
struct ImposedTotals {
  std::string reason;  ///< what the judgement rests on
  Imposed imposed = Imposed::kCurrent;
  std::size_t stretches = 0, samples = 0;
};

/// A stretch of time, from a sample to another.
struct ImposedTime {
  double from = 0.0, to = 0.0;  ///< [s]
};

/// Who imposes what in a recording, as a reader needs it; times in place of indices.
struct SourceOverview {
  bool seen = false;                         ///< something charges the battery
  double share = 0.0;                        ///< of the samples whose voltage is imposed [0, 1]
  std::string summary;                       ///< one or two sentences
  std::vector<ImposedTotals> totals;         ///< one a reason, in alphabetical order
  std::vector<ImposedTime> voltage_imposed;  ///< in order; see overviewOf()
};

/// @return "voltage" or "current".
std::string describe(Imposed imposed);

/// @return the source's stretches by reason, in alphabetical order.
std::vector<ImposedTotals> totalsOf(const Source& source);

/**
 * @brief The whole of a source's judgement without its samples.
 *
 * voltage_imposed: each stretch from its first sample to the first one behind it, or to its last one before a gap and at the
 * end. Neighbours of one judgement for different reasons are one.
 *
 * @param series the one that the source was found in.
 * @throws std::invalid_argument when source and series differ in length.
 */
SourceOverview overviewOf(const Source& source, const Series& series);

}  // namespace battery_sof

#pragma once

#include <vector>

#include "estimation/identification.hpp"

namespace battery_sof {

/// A window as identify() fits it.
struct FitWindowRows {
  Series sound;              ///< the series with its voltage channel put right (VoltageRepair)
  std::vector<char> masked;  ///< one a sample of the series, 1: costs nothing
  InputSequence inputs;      ///< of the range, each row with what controls it
};

/// @param options without a source: the current is the input throughout.
FitWindowRows fitWindow(const Series& series, IndexRange range, const IdentifyOptions& options);

/// Whether the options' source controls the voltage anywhere in a range.
bool isVoltageControlled(const IdentifyOptions& options, IndexRange range);

/// What a residual costs in identify(): with a source errors in both variables, else eq. 3's
/// weights; with the priors of the options.
FitCost fitCost(const IdentifyOptions& options);

/// @return where a search in a larger composition begins: a nested optimum with the new parameters
/// at their magnitudes. A second start has the circuit's parameters at their magnitudes, too, where an
/// added effect gives them another meaning, and so other magnitudes, or where they stood at a bound
/// without it.
std::vector<CompositionPoint> startsInLarger(const BatteryModel& nested,
                                             const CompositionPoint& point,
                                             const BatteryModel& larger);

}  // namespace battery_sof

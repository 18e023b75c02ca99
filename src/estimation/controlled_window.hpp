#pragma once

#include <vector>

#include "estimation/identification.hpp"

namespace battery_sof {

/// A window as it is fitted where a source controls the voltage.
struct ControlledWindow {
  Series sound;              ///< the series with its voltage channel put right (VoltageRepair)
  std::vector<char> masked;  ///< one a sample of the series, 1: costs nothing
  InputSequence inputs;      ///< of the range, each row with what controls it
};

/// @param options with a source.
ControlledWindow controlledWindow(const Series& series, IndexRange range,
                                  const IdentifyOptions& options);

/// What a residual costs there: errors in both variables, with the priors of the options.
FitCost controlledCost(const IdentifyOptions& options);

/// @return a nested optimum in a larger composition, its new parameters at their magnitudes.
CompositionPoint withNewAtMagnitudes(const BatteryModel& nested, const CompositionPoint& point,
                                     const BatteryModel& larger);

}  // namespace battery_sof

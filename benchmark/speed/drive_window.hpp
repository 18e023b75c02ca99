#pragma once

#include <vector>

#include "battery_sof/series.hpp"
#include "estimation/base_normal_equations.hpp"

namespace battery_sof_bench {

/// What every contender is given.
struct DriveWindow {
  battery_sof::Series series;                                     ///< 240 s at 100 Hz
  double max_gap = 0.0;                                           ///< [s], gapThreshold(series)
  std::vector<battery_sof::BaseNormalEquations::Sample> samples;  ///< with the weights of eq. 3
  battery_sof::IndexRange range() const { return {0, series.size()}; }
};

/**
 * @brief The most suitable four minutes of 15 minutes of city driving, simulated by the independent
 * reference (seed 1).
 * @throws std::runtime_error when they hold no crank or not four minutes: eq. 3's weights would not
 * be exercised.
 */
DriveWindow simulatedWindow();

}  // namespace battery_sof_bench

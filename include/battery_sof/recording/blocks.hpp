#pragma once

#include <algorithm>
#include <cmath>

namespace battery_sof {

/**
 * @brief How many 12 V blocks in a row a voltage is that of: 1 for 12 V, 2 for 24 V, 4 for 48 V; never below 1.
 *
 * Limits in volts are those of one block; errors and voltages of a row of n blocks are n times as large.
 * @param voltage of a battery at rest [V]: 11.3 to 13.2 V a block are counted right up to four blocks.
 */
inline double blocksInSeries(double voltage) {
  constexpr double kRestOfBlock = 12.5;  // [V], between a full and a half empty one
  return std::max(1.0, std::round(voltage / kRestOfBlock));
}

}  // namespace battery_sof
